//! Shared by faces and bodies: skin, cloth, and relighting.

use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::easing::{bell, mix, smoothstep};
use uvgraft::{Channels, Encoding, Texels, Texture};

use super::noise::{Point, fractal, noise};
use super::{LayoutSpots, Painted};

/// sRGB unless stated otherwise; 1.0 is full intensity.
pub type Color = [f32; 3];

/// A complexion: the mean sRGB colour of skin in even light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinTone(pub Color);

impl SkinTone {
    /// Porcelain.
    pub const VERY_LIGHT: Self = Self([0.90, 0.775, 0.715]);
    /// Light, a little pink.
    pub const LIGHT: Self = Self([0.84, 0.665, 0.575]);
    /// Tanned.
    pub const MEDIUM: Self = Self([0.76, 0.575, 0.455]);
    /// Yellowish.
    pub const OLIVE: Self = Self([0.69, 0.56, 0.42]);
    /// Sunburnt.
    pub const REDDISH: Self = Self([0.82, 0.545, 0.475]);
    /// Brown.
    pub const BROWN: Self = Self([0.55, 0.385, 0.285]);
    /// Dark brown.
    pub const DARK: Self = Self([0.40, 0.265, 0.195]);
    /// Nearly black.
    pub const VERY_DARK: Self = Self([0.245, 0.165, 0.13]);
    /// A fictional complexion.
    pub const BLUE: Self = Self([0.30, 0.46, 0.72]);
    /// A greyscale capture.
    pub const GREY: Self = Self([0.62, 0.62, 0.62]);

    pub(super) fn is_grey(self) -> bool {
        self.0[0] == self.0[1] && self.0[1] == self.0[2]
    }

    /// Linear light of skin at a point: tone over centimetres, blotches, pores.
    ///
    /// - `flush`: blood supply relative to the mean, negative for less.
    pub(super) fn at(self, p: Point, flush: f32, seed: u32) -> Color {
        let tone = fractal(p, 4.5, seed + 21);
        let blotches = fractal(p, 1.1, seed + 31);
        let pores = noise(p.map(|value| value * 6.0), seed + 41);
        let light = 1.0 + 0.06 * tone + 0.05 * blotches + 0.05 * pores;
        let flush = flush + 0.22 * tone + 0.16 * blotches;
        // Blood absorbs green and blue; less of it shows in dark skin.
        let depth = 0.6 + 0.4 * self.0[0];
        let gain = [1.0 + 0.05 * flush, 1.0 - 0.30 * flush * depth, 1.0 - 0.26 * flush * depth];
        let gain = if self.is_grey() { [1.0 - 0.12 * flush; 3] } else { gain };
        [0, 1, 2].map(|k| linear_from_srgb(self.0[k]) * gain[k] * light)
    }
}

pub(super) fn linear(color: Color) -> Color {
    color.map(linear_from_srgb)
}

pub(super) fn scaled(color: Color, factor: f32) -> Color {
    color.map(|value| value * factor)
}

pub(super) fn blend(a: Color, b: Color, share: f32) -> Color {
    [0, 1, 2].map(|k| mix(a[k], b[k], share))
}

/// The colours of a cloth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dye {
    /// One colour.
    Plain(Color),
    /// Two colours, in stripes of a centimetre.
    Striped(Color, Color),
}

/// Linear light of cloth, with weave, folds and wear.
pub(super) fn cloth(dye: Dye, p: Point, normal: [f32; 3], seed: u32) -> Color {
    let around = p[0].atan2(p[2] + 9.0) * 9.0;
    let color = match dye {
        Dye::Plain(color) => linear(color),
        Dye::Striped(a, b) => {
            let t = (p[1] + 0.15 * noise(p, seed)).rem_euclid(2.0);
            let share = smoothstep(0.0, 0.12, t) * smoothstep(1.0, 0.88, t);
            blend(linear(a), linear(b), share)
        }
    };
    let weave = (around * 21.0).sin() * (p[1] * 21.0).sin();
    let folds = fractal([around * 0.35, p[1] * 0.11, p[2] * 0.1], 1.0, seed + 3);
    let crease = smoothstep(0.12, 0.0, (folds - 0.1).abs());
    let light = 0.90 + 0.10 * normal[1] + 0.18 * folds - 0.12 * crease
        + 0.04 * weave
        + 0.05 * noise(p.map(|value| value * 4.0), seed + 5);
    scaled(color, light.max(0.1))
}

/// The same texture with its linear light multiplied: a capture with another white balance or
/// exposure.
///
/// - `gain`: factors of linear red, green and blue.
pub fn recolored(painted: &Painted, gain: Color) -> Painted {
    multiplied(painted, |_| gain)
}

/// The same texture in light that increases along a direction.
///
/// - `stops`: change of exposure from one side of the layout's mesh to the other.
/// - `direction`: direction of increasing light, in the mesh's axes.
pub fn ramped(painted: &Painted, layout: &LayoutSpots, direction: [f32; 3], stops: f32) -> Painted {
    let along = |p: [f32; 3]| (0..3).map(|k| p[k] * direction[k]).sum::<f32>();
    let values = || layout.spots().iter().flatten().map(|spot| along(spot.position));
    let (low, high) = (values().fold(f32::MAX, f32::min), values().fold(f32::MIN, f32::max));
    multiplied(painted, |at| {
        let t = layout.spots()[at].map_or(0.5, |spot| (along(spot.position) - low) / (high - low));
        [((t - 0.5) * stops).exp2(); 3]
    })
}

fn multiplied(painted: &Painted, gain: impl Fn(usize) -> Color) -> Painted {
    let size = painted.texture.size();
    let texel = |at: usize, k: usize| {
        let (x, y) = (at % size.width as usize, at / size.width as usize);
        linear_from_srgb(painted.texture.get(x as u32, y as u32, k))
    };
    let values = (0..size.texels())
        .flat_map(|at| {
            let gain = gain(at);
            [0, 1, 2].map(|k| {
                let value = srgb_from_linear(texel(at, k) * gain[k]);
                (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
            })
        })
        .collect();
    let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values))
        .expect("as many values as texels");
    Painted { texture, truth: painted.truth.clone() }
}

/// Coverage of sparse hairs on skin, such as on arms, from 0 to 1.
pub(super) fn sparse_hairs(p: Point, along: [f32; 2], density: f32, seed: u32) -> f32 {
    let curl = 0.5 * noise(p.map(|value| value * 0.6), seed);
    let strand = noise([along[0] * 7.0 + curl * 6.0, along[1] * 1.1 + curl, 0.0], seed + 1);
    let finer = noise([along[0] * 15.0 + curl * 9.0, along[1] * 1.6, 4.0], seed + 2);
    let patch = 0.75 + 0.25 * fractal(p, 5.0, seed + 3);
    let edge = 1.0 - 1.15 * density * patch;
    bell((strand * 0.6 + finer * 0.4).max(edge - 0.3).min(edge) - edge, 0.14)
        * smoothstep(0.0, 0.2, density)
}
