//! How a texture that is laid over another becomes one with it, on the mesh rather than in the image.
//!
//! The border of what is transferred runs over the surface and crosses UV islands as it likes, so
//! distances and corrections of colour live at the points of the mesh and are interpolated over its
//! triangles:
//!
//! - a [`Selection`] says which part of the surface is transferred;
//! - the **feather** lets the base show through near the selection's rim, by the distance along the
//!   surface;
//! - the **membrane** extends the ratio of the two sides' colours along the rim harmonically over the
//!   surface, so that one side takes on the other's tone there (after P. Pérez et al., "Poisson image
//!   editing", 2003, on a mesh and with ratios for differences).

mod compose;
mod cut;
mod field;
mod geodesic;
mod harmonic;
mod painted;
mod rim;
mod sample;
mod selection;
pub mod skin;
pub mod statistics;
mod stretch;
mod tone;
mod toning;
mod undercoat;

pub(crate) use compose::Finish;
pub use cut::CutMesh;
pub use selection::{Ground, Growth, RegionError, Selection, Side};
pub use toning::{Toning, ToningError};
pub(crate) use undercoat::{Skin, Undercoat};

use crate::color::Encoding;
use crate::filter::Filter;
use crate::map::{MapOptions, SamplingMap};
use crate::texture::{Channels, Depth, Texels, Texture, TextureError};
use field::{Slope, slopes};
use harmonic::Harmonic;
use rim::Rim;
use toning::Recolor;

/// How a texture becomes one with the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlendOptions {
    /// Over which length along the surface the base gives way to the texture, inwards from the rim, in
    /// the target mesh's unit. What is negative or no number is 0.
    pub feather: f64,
    /// Whether a membrane takes the tone of one side along the rim to the other.
    pub membrane: bool,
    /// Whether one side's skin gets the mean and the covariance of the other's.
    pub match_skin: bool,
    /// Which side the tone is taken from.
    pub tone: Tone,
    /// Whether a mask says what is skin in the base, by [`BlendMap::with_skin`]; else it is estimated.
    pub skin_mask: bool,
    /// Texels beyond the islands in which a base's skin changes too: as many as its own gutter has.
    pub gutter_px: u32,
}

impl Default for BlendOptions {
    /// A hard border, and no colour changed.
    fn default() -> Self {
        let gutter_px = MapOptions::default().gutter_px;
        Self {
            feather: 0.0,
            membrane: false,
            match_skin: false,
            tone: Tone::Base,
            skin_mask: false,
            gutter_px,
        }
    }
}

/// Which side the tone is taken from; the other one gives way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// The texture takes on the tone that the base has.
    Base,
    /// The base's skin takes on the tone that the texture has.
    Source,
}

/// A blend of one region: distances, and the factorised membrane. Made once, used for any number of
/// textures of any size.
#[derive(Debug, Clone)]
pub struct Blend<'a> {
    ground: &'a Ground<'a>,
    options: BlendOptions,
    touched: Vec<bool>,
    /// Signed distance of each point from the rim, within what the feather needs.
    inside: Vec<f32>,
    measure: Option<Measure>,
}

/// What a tone is found with.
#[derive(Debug, Clone)]
struct Measure {
    rim: Rim,
    harmonic: Option<Harmonic>,
}

/// A blend at the texels of one map.
#[derive(Debug, Clone)]
pub struct BlendMap<'a> {
    blend: &'a Blend<'a>,
    /// For each patch of the map, the signed distance from the rim.
    inside: Vec<[Slope; 1]>,
    /// All of the target's layout, if the base changes too.
    layout: Option<SamplingMap>,
    /// How far each texel is skin.
    skin: Option<Vec<u8>>,
}

impl<'a> Blend<'a> {
    /// Prepares the blend of what is selected and linked.
    ///
    /// # Errors
    /// [`RegionError::Empty`] if that is nothing.
    pub fn new(
        ground: &'a Ground<'a>,
        selection: &Selection,
        options: BlendOptions,
    ) -> Result<Self, RegionError> {
        let selection = selection.within(&ground.linked(), ground);
        // Far beyond any mesh, and so that 32 bits hold it.
        let feather = if options.feather > 0.0 { options.feather.min(1e30) } else { 0.0 };
        let options = BlendOptions { feather, ..options };
        let touched = ground.touched(&selection);
        if !touched.contains(&true) {
            return Err(RegionError::Empty("no linked triangle is left in it"));
        }
        // Farther points are as good as endless; a triangle's corners must be told apart up to there.
        let limit = options.feather + ground.longest_edge();
        let inside = ground.signed_distances(&selection, limit);
        let measure = (options.membrane || options.match_skin).then(|| {
            let rim = Rim::new(ground, &touched, &inside, options.feather);
            let harmonic = options.membrane.then(|| match options.tone {
                Tone::Base => Harmonic::new(&ground.surface, &touched, &rim.points),
                Tone::Source => {
                    Harmonic::new(&ground.surface, &vec![true; touched.len()], &rim.points)
                }
            });
            Measure { rim, harmonic }
        });
        let inside = inside.into_iter().map(|inside| inside.clamp(-limit, limit) as f32).collect();
        Ok(Self { ground, options, touched, inside, measure })
    }

    /// Which triangles of the target are transferred, wholly or in part.
    pub fn touched(&self) -> &[bool] {
        &self.touched
    }

    /// The blend at the texels of a map.
    ///
    /// # Panics
    /// If the map is of another pair or direction.
    pub fn on(&'a self, map: &SamplingMap) -> BlendMap<'a> {
        assert_eq!(map.direction(), self.ground.direction());
        let value = |face: u32, point: u32| {
            // What is not in the region is beyond its rim, even where all its corners are on it.
            [if self.touched[face as usize] {
                self.inside[point as usize]
            } else {
                f32::NEG_INFINITY
            }]
        };
        let inside = slopes(map, self.ground.mesh(), &self.ground.surface, value);
        let layout = (self.measure.is_some() && self.options.tone == Tone::Source).then(|| {
            let options = MapOptions { gutter_px: self.options.gutter_px, ..MapOptions::default() };
            SamplingMap::of_layout(self.ground.mesh(), map.size(), &options)
        });
        BlendMap { blend: self, inside, layout, skin: None }
    }
}

impl BlendMap<'_> {
    /// The same with a mask of what is skin in the base: white for all, black for none. It is brought to
    /// the map's size.
    ///
    /// # Errors
    /// [`TextureError`] if there is no memory for that.
    pub fn with_skin(self, mask: Texture, map: &SamplingMap) -> Result<Self, TextureError> {
        let mask =
            mask.with_encoding(Encoding::Data).resized(map.size(), Filter::Bilinear, false)?;
        let skin = match mask.converted(Channels::Grey, Depth::U8).into_texels() {
            Texels::U8(values) => Some(values),
            Texels::U16(_) | Texels::F32(_) => None,
        };
        Ok(Self { skin, ..self })
    }

    /// How the texels of its map are laid over a base, with a toning if there is one.
    ///
    /// # Panics
    /// If it is the blend of another map.
    pub(crate) fn finish<'b>(
        &'b self,
        map: &'b SamplingMap,
        toning: Option<&Toning>,
    ) -> Finish<'b> {
        assert_eq!(map.patches().len(), self.inside.len(), "the blend is one of another map");
        let recolor = toning.and_then(|toning| toning.source.as_ref());
        Finish {
            map,
            inside: &self.inside,
            feather: self.blend.options.feather as f32,
            gains: self.gains(map, recolor),
            matrix: recolor.and_then(|recolor| recolor.matrix),
            normals: false,
        }
    }

    /// What is done to the base first, with a toning that changes it.
    pub(crate) fn undercoat(&self, toning: Option<&Toning>) -> Option<Undercoat<'_>> {
        let (recolor, model) = toning?.base.as_ref()?;
        let map = self.layout.as_ref()?;
        let gains = self.gains(map, Some(recolor));
        let skin = match (&self.skin, model) {
            (Some(mask), _) => Skin::Mask(mask),
            (None, Some(model)) => Skin::Model(*model),
            (None, None) => return None,
        };
        Some(Undercoat { map, gains, matrix: recolor.matrix, skin })
    }

    /// The gains of each patch of a map.
    fn gains(&self, map: &SamplingMap, recolor: Option<&Recolor>) -> Vec<[Slope; 3]> {
        let Some(Recolor { gains, .. }) = recolor.filter(|recolor| !recolor.gains.is_empty())
        else {
            return Vec::new();
        };
        let ground = self.blend.ground;
        slopes(map, ground.mesh(), &ground.surface, |_, point| gains[point as usize])
    }

    /// How much of the texture there is at each texel, as an 8-bit grey texture: white where it is all,
    /// black where it is nothing. The gutter is black.
    ///
    /// # Panics
    /// If it is the blend of another map.
    pub fn weights(&self, map: &SamplingMap) -> Texture {
        let size = map.size();
        let white = vec![255_u8; size.texels()];
        let mut values = vec![0; size.texels()];
        self.finish(map, None).lay(Channels::Grey, false, 0, &white, &mut values);
        if let Texels::U8(mask) = map.mask().texels() {
            values.iter_mut().zip(mask).for_each(|(value, &mask)| *value &= mask);
        }
        Texture::new(size, Channels::Grey, Encoding::Data, Texels::U8(values))
            .expect("a map's size is that of a texture")
    }
}
