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

pub(crate) use compose::Finish;
pub use selection::{Ground, Growth, RegionError, Selection, Side};

use crate::color::Encoding;
use crate::map::SamplingMap;
use crate::texture::{Channels, Texels, Texture};
use field::{Slope, slopes};
use harmonic::Harmonic;
use rim::{Difference, Rim};
use tone::GAINS;

/// How a texture becomes one with the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlendOptions {
    /// Over which length along the surface the base gives way to the texture, inwards from the rim, in
    /// the target mesh's unit.
    pub feather: f64,
    /// Which side takes on the other's tone, by a membrane.
    pub membrane: Option<Tone>,
}

/// Which side gives way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// The texture takes on the tone that the base has at the rim.
    Base,
    /// The base's skin takes on the tone that the texture has at the rim.
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
    membrane: Option<Membrane>,
}

#[derive(Debug, Clone)]
struct Membrane {
    rim: Rim,
    harmonic: Harmonic,
}

/// A blend at the texels of one map.
#[derive(Debug, Clone)]
pub struct BlendMap<'a> {
    blend: &'a Blend<'a>,
    /// For each patch of the map, the signed distance from the rim.
    inside: Vec<[Slope; 1]>,
}

/// What a blend does to the colours of one texture.
#[derive(Debug, Clone)]
pub struct Toning {
    /// The gains of red, green and blue at each point, for the texture.
    gains: Vec<[f32; 3]>,
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
        let touched = ground.touched(&selection);
        if !touched.contains(&true) {
            return Err(RegionError::Empty("nothing of it is linked"));
        }
        // Farther points are as good as endless; a triangle's corners must be told apart up to there.
        let limit = options.feather + ground.longest_edge();
        let inside = ground.signed_distances(&selection, limit);
        let membrane = options.membrane.map(|_| {
            let rim = Rim::new(ground, &touched, &inside, options.feather);
            let harmonic = Harmonic::new(&ground.surface, &touched, &rim.points);
            Membrane { rim, harmonic }
        });
        let inside = inside.into_iter().map(|inside| inside.clamp(-limit, limit) as f32).collect();
        Ok(Self { ground, options, touched, inside, membrane })
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
        BlendMap { blend: self, inside }
    }

    /// Finds what the membrane does to the colours of a texture on a base. Nothing without a membrane,
    /// or where either has no colours beside the rim.
    ///
    /// - `encoding`: in which values are laid over: ratios are between values of that kind.
    pub fn toning(&self, source: &Texture, base: &Texture, encoding: Encoding) -> Option<Toning> {
        let Membrane { rim, harmonic } = self.membrane.as_ref()?;
        if encoding == Encoding::Data {
            return None;
        }
        let (source, base) = (rim.source(source, encoding), rim.base(base, encoding));
        let Difference { log_gains, .. } = rim.difference(&source, &base)?;
        let bounds = GAINS.map(f32::ln);
        let gains_of =
            |logs: [f64; 3]| logs.map(|log| (log as f32).clamp(bounds[0], bounds[1]).exp());
        let extended = harmonic.extend(&log_gains);
        let mut gains: Vec<[f32; 3]> =
            extended.into_iter().map(|logs| logs.map_or([1.0; 3], gains_of)).collect();
        for (&point, &logs) in rim.points.iter().zip(&log_gains) {
            gains[point as usize] = gains_of(logs);
        }
        Some(Toning { gains })
    }
}

impl BlendMap<'_> {
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
        let ground = self.blend.ground;
        let gains = toning.map_or_else(Vec::new, |toning| {
            slopes(map, ground.mesh(), &ground.surface, |_, point| toning.gains[point as usize])
        });
        Finish {
            map,
            inside: &self.inside,
            feather: self.blend.options.feather as f32,
            gains,
            matrix: None,
        }
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
