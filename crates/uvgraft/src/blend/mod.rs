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
mod stretch;
mod tone;
mod toning;
mod undercoat;

use compose::Finish;
pub use cut::CutMesh;
pub use selection::{Ground, Growth, RegionError, Selection, Side};
pub use toning::{Toning, ToningError};
use undercoat::{Skin, Undercoat};

use std::sync::Arc;

use crate::color::Encoding;
use crate::filter::Filter;
use crate::formats::Averaging;
use crate::map::{MapOptions, SamplingMap};
use crate::skin::SkinModel;
use crate::texture::{Channels, Depth, Texels, Texture, TextureError};
use field::{Slope, slopes};
use harmonic::Harmonic;
use rim::Rim;
use tone::Matrix;
use toning::Recolor;

/// How a texture becomes one with the base.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct BlendOptions {
    /// Over which length along the surface the base gives way to the texture, inwards from the rim, in
    /// the target mesh's unit. What is negative or NaN is 0.
    pub feather: f64,
    /// Whether a membrane takes the tone of one side along the rim to the other.
    pub membrane: bool,
    /// Whether one side's skin gets the mean and the covariance of the other's.
    pub match_skin: bool,
    /// Which side the tone is taken from.
    pub tone: Tone,
    /// Texels beyond the islands in which a base's skin changes too: as many as its own gutter has.
    pub gutter_px: u32,
}

impl BlendOptions {
    /// The same with a feather of this length.
    #[must_use]
    pub const fn feather(self, feather: f64) -> Self {
        Self { feather, ..self }
    }

    /// The same with a membrane.
    #[must_use]
    pub const fn membrane(self) -> Self {
        Self { membrane: true, ..self }
    }

    /// The same, with one side's skin matched to the other's.
    #[must_use]
    pub const fn match_skin(self) -> Self {
        Self { match_skin: true, ..self }
    }

    /// The same with the tone taken from this side.
    #[must_use]
    pub const fn tone(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }

    /// The same for a base whose own gutter is so wide.
    #[must_use]
    pub const fn gutter_px(self, gutter_px: u32) -> Self {
        Self { gutter_px, ..self }
    }

    /// Whether colours of the base are looked at before anything is laid over it.
    pub const fn needs_colors(&self) -> bool {
        self.membrane || self.match_skin
    }
}

impl Default for BlendOptions {
    /// A hard border, and no colour changed.
    fn default() -> Self {
        let gutter_px = MapOptions::default().gutter_px;
        Self { feather: 0.0, membrane: false, match_skin: false, tone: Tone::Base, gutter_px }
    }
}

/// Which side the tone is taken from; the other one gives way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Tone {
    /// The texture takes on the tone that the base has.
    Base,
    /// The base's skin takes on the tone that the texture has.
    Source,
}

/// A blend of one region: distances, and the factorised membrane. Made once, used for any number of
/// textures of any size.
#[derive(Debug, Clone)]
pub struct Blend {
    ground: Ground,
    options: BlendOptions,
    touched: Vec<bool>,
    /// Signed distance of each point from the rim, within what the feather needs.
    inside: Vec<f32>,
    measure: Option<Measure>,
    /// What is skin in the base, if it is not to be estimated.
    skin: Option<Texture>,
}

/// What a tone is found with.
#[derive(Debug, Clone)]
struct Measure {
    rim: Rim,
    harmonic: Option<Harmonic>,
}

/// A blend at the texels of one map.
#[derive(Debug)]
pub(crate) struct BlendMap {
    blend: Arc<Blend>,
    /// For each patch of the map, the signed distance from the rim.
    inside: Vec<[Slope; 1]>,
    /// All of the target's layout, if the base changes too.
    layout: Option<SamplingMap>,
    /// How far each texel is skin.
    skin: Option<Vec<u8>>,
}

/// A toning at the texels of one map. Clones share it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gains(Option<Arc<ToneGains>>);

#[derive(Debug)]
struct ToneGains {
    /// Of the texture.
    source: Option<Recoloring>,
    /// Of the base, and what looks like skin in it.
    base: Option<(Recoloring, Option<SkinModel>)>,
}

/// Another tone for the texels of a map.
#[derive(Debug)]
struct Recoloring {
    matrix: Option<Matrix>,
    /// For each patch, the gains of red, green and blue; empty for none.
    gains: Vec<[Slope; 3]>,
}

impl Blend {
    /// Prepares the blend of what is selected and linked.
    ///
    /// # Errors
    /// [`RegionError::Empty`] if that is nothing.
    pub fn new(selection: &Selection, options: BlendOptions) -> Result<Self, RegionError> {
        let ground = selection.ground().clone();
        let linked = ground.linked();
        let selection = selection.within(&linked)?;
        // Far beyond any mesh, and so that 32 bits hold it.
        let feather = if options.feather > 0.0 { options.feather.min(1e30) } else { 0.0 };
        let options = BlendOptions { feather, ..options };
        let touched = ground.touched(&selection);
        if !touched.contains(&true) {
            let cuts_only =
                !ground.touched(&linked).contains(&true) && ground.pair().piece_count() > 0;
            return Err(RegionError::Empty(if cuts_only {
                "it is made of whole triangles, and pieces fill only parts of them"
            } else {
                "no linked triangle is left in it"
            }));
        }
        // Farther points are as good as endless; a triangle's corners must be told apart up to there.
        let limit = options.feather + ground.longest_edge();
        let inside = ground.signed_distances(&selection, limit);
        let measure = options.needs_colors().then(|| {
            let rim = Rim::new(&ground, &touched, &inside, options.feather);
            let harmonic = options.membrane.then(|| match options.tone {
                Tone::Base => Harmonic::new(ground.surface(), &touched, &rim.points),
                Tone::Source => {
                    Harmonic::new(ground.surface(), &vec![true; touched.len()], &rim.points)
                }
            });
            Measure { rim, harmonic }
        });
        let inside = inside.into_iter().map(|inside| inside.clamp(-limit, limit) as f32).collect();
        Ok(Self { ground, options, touched, inside, measure, skin: None })
    }

    /// The same with a mask of what is skin in the base: white for all, black for none. It is brought to
    /// the base's size.
    #[must_use]
    pub fn with_skin(self, mask: Texture) -> Self {
        Self { skin: Some(mask), ..self }
    }

    /// What it is made on.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// How it was asked for.
    pub fn options(&self) -> &BlendOptions {
        &self.options
    }

    /// Which triangles of the target are transferred, wholly or in part.
    pub fn touched(&self) -> &[bool] {
        &self.touched
    }
}

impl BlendMap {
    /// A blend at the texels of a map of the same pair and direction.
    ///
    /// # Errors
    /// [`TextureError`] if there is no memory for a mask of skin at the map's size.
    pub fn new(blend: Arc<Blend>, map: &SamplingMap) -> Result<Self, TextureError> {
        assert_eq!(map.direction(), blend.ground.direction());
        let value = |face: u32, point: u32| {
            // What is not in the region is beyond its rim, even where all its corners are on it.
            [if blend.touched[face as usize] {
                blend.inside[point as usize]
            } else {
                f32::NEG_INFINITY
            }]
        };
        let inside = slopes(map, blend.ground.mesh(), blend.ground.surface(), value);
        let changes_base = blend.measure.is_some() && blend.options.tone == Tone::Source;
        let layout = changes_base.then(|| {
            let options = MapOptions::with_gutter(blend.options.gutter_px);
            SamplingMap::of_layout(blend.ground.mesh(), map.size(), &options)
        });
        let skin = match &blend.skin {
            None => None,
            Some(mask) => {
                let mask = mask.clone().with_encoding(Encoding::Data);
                let mask = mask.resized(map.size(), Filter::Bilinear, Averaging::Encoded)?;
                match mask.converted(Channels::Grey, Depth::U8).into_texels() {
                    Texels::U8(values) => Some(values),
                    Texels::U16(_) | Texels::F32(_) => None,
                }
            }
        };
        Ok(Self { blend, inside, layout, skin })
    }

    /// How the texels of its map are laid over a base.
    ///
    /// - `normals`: whether values are encoded normals.
    ///
    /// # Panics
    /// If it is the blend of another map.
    pub fn finish<'b>(
        &'b self,
        map: &'b SamplingMap,
        gains: &'b Gains,
        normals: bool,
    ) -> Finish<'b> {
        assert_eq!(map.patches().len(), self.inside.len(), "the blend is one of another map");
        let recoloring = gains.0.as_ref().and_then(|gains| gains.source.as_ref());
        Finish {
            map,
            inside: &self.inside,
            feather: self.blend.options.feather as f32,
            gains: recoloring.map_or(&[], |recoloring| &recoloring.gains),
            matrix: recoloring.and_then(|recoloring| recoloring.matrix),
            normals,
        }
    }

    /// What is done to the base first, where that changes.
    pub fn undercoat<'b>(&'b self, gains: &'b Gains) -> Option<Undercoat<'b>> {
        let (Recoloring { matrix, gains }, model) = gains.0.as_ref()?.base.as_ref()?;
        let skin = match (&self.skin, model) {
            (Some(mask), _) => Skin::Mask(mask),
            (None, Some(model)) => Skin::Model(*model),
            (None, None) => return None,
        };
        Some(Undercoat { map: self.layout.as_ref()?, gains, matrix: *matrix, skin })
    }

    /// A toning at the texels of its map.
    ///
    /// # Errors
    /// [`ToningError::Ground`] if it is another ground's.
    pub fn gains(&self, map: &SamplingMap, toning: &Toning) -> Result<Gains, ToningError> {
        if !self.blend.ground.is_like(&toning.ground) {
            return Err(ToningError::Ground);
        }
        let source = toning.source.as_ref().map(|recolor| self.recoloring(map, recolor));
        let base = toning.base.as_ref().and_then(|(recolor, model)| {
            Some((self.recoloring(self.layout.as_ref()?, recolor), *model))
        });
        Ok(Gains(Some(Arc::new(ToneGains { source, base }))))
    }

    fn recoloring(&self, map: &SamplingMap, recolor: &Recolor) -> Recoloring {
        let Recolor { matrix, gains } = recolor;
        let ground = &self.blend.ground;
        let gains = if gains.is_empty() {
            Vec::new()
        } else {
            slopes(map, ground.mesh(), ground.surface(), |_, point| gains[point as usize])
        };
        Recoloring { matrix: *matrix, gains }
    }

    /// How much of the texture there is at each texel, as an 8-bit grey texture: white where it is all,
    /// black where it is nothing. The gutter is black.
    pub fn weights(&self, map: &SamplingMap) -> Texture {
        let size = map.size();
        let white = vec![255_u8; size.texels()];
        let mut values = vec![0; size.texels()];
        self.finish(map, &Gains::default(), false).lay(
            Channels::Grey,
            false,
            0,
            &white,
            &mut values,
        );
        if let Texels::U8(mask) = map.mask().texels() {
            values.iter_mut().zip(mask).for_each(|(value, &mask)| *value &= mask);
        }
        Texture::new(size, Channels::Grey, Encoding::Data, Texels::U8(values))
            .expect("a map's size is that of a texture")
    }
}
