//! A bench for the appearance of faces on bodies: painted faces and bodies with a known label
//! (skin, hair, cloth and so on) for every texel, and measures of what a transfer makes of them.
//!
//! Colours and labels are functions of the position on the mesh, relative to given landmarks. The
//! truth comes from the painters alone, never from the code under test.

pub mod bodies;
pub mod face_look;
pub mod faces;
mod features;
pub mod frame;
mod lab;
mod layout;
pub mod measure;
mod noise;
mod skin;
pub mod subjects;
#[cfg(test)]
mod tests;

use uvgraft::{Channels, Encoding, Size, Texels, Texture};

pub use bodies::{BodyLook, Clothing};
pub use face_look::{Beard, Collar, FaceLook, HairColor};
pub use frame::{BodyFrame, HeadFrame};
pub use lab::{lab_from_srgb, mean_color};
pub use layout::{LayoutSpots, Spot};
pub use skin::{Color, Dye, SkinTone, ramped, recolored};

/// What a texel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum Label {
    /// Not judged: texels outside the layout, glasses, the inside of the eye sockets.
    #[default]
    Other,
    /// Skin, stubble included.
    Skin,
    /// Hair of the head, and full beards.
    Hair,
    /// Eyebrows.
    Brow,
    /// Lips.
    Lip,
    /// Eyeballs.
    Eye,
    /// The inside of the mouth, with teeth.
    Mouth,
    /// Collars and clothes.
    Cloth,
}

impl Label {
    /// All labels, in ascending order of their values.
    pub const ALL: [Self; 8] = [
        Self::Other,
        Self::Skin,
        Self::Hair,
        Self::Brow,
        Self::Lip,
        Self::Eye,
        Self::Mouth,
        Self::Cloth,
    ];
}

/// A label for each texel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labels {
    /// Size of the labelled texture.
    pub size: Size,
    /// `[height * width]`, row-major.
    pub of_texels: Vec<Label>,
}

impl Labels {
    /// Number of texels with a label.
    pub fn count(&self, label: Label) -> usize {
        self.of_texels.iter().filter(|&&found| found == label).count()
    }

    /// As an 8-bit data texture of the labels' values.
    pub fn texture(&self) -> Texture {
        let values = self.of_texels.iter().map(|&label| label as u8).collect();
        Texture::new(self.size, Channels::Grey, Encoding::Data, Texels::U8(values))
            .expect("as many values as texels")
    }

    /// The inverse of [`Labels::texture`]; unknown values become [`Label::Other`].
    pub fn from_texture(texture: &Texture) -> Self {
        let label = |value: f32| {
            let number = (value * 255.0).round() as usize;
            Label::ALL.get(number).copied().unwrap_or_default()
        };
        let size = texture.size();
        let of_texels = (0..size.height)
            .flat_map(|y| (0..size.width).map(move |x| label(texture.get(x, y, 0))))
            .collect();
        Self { size, of_texels }
    }

    /// The texels of a label without any other label within `margin` texels, along rows, columns
    /// and diagonals (erosion by a square).
    pub fn well_inside(&self, label: Label, margin: u32) -> Vec<bool> {
        let (width, height) = (self.size.width as i32, self.size.height as i32);
        let margin = margin as i32;
        let mut rows = vec![false; self.of_texels.len()];
        let is = |x: i32, y: i32| {
            (0..width).contains(&x)
                && (0..height).contains(&y)
                && self.of_texels[(y * width + x) as usize] == label
        };
        for y in 0..height {
            for x in 0..width {
                rows[(y * width + x) as usize] = (-margin..=margin).all(|d| is(x + d, y));
            }
        }
        let in_rows = |x: i32, y: i32| (0..height).contains(&y) && rows[(y * width + x) as usize];
        (0..width * height)
            .map(|at| (-margin..=margin).all(|d| in_rows(at % width, at / width + d)))
            .collect()
    }
}

/// A texture and the true labels of its texels.
#[derive(Debug, Clone)]
pub struct Painted {
    /// 8-bit sRGB.
    pub texture: Texture,
    /// The labels that were painted.
    pub truth: Labels,
}
