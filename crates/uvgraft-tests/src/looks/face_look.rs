//! The appearance of painted faces.

use super::skin::Dye;
use super::{Color, SkinTone};

/// The colour of hair and brows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HairColor {
    /// Nearly black.
    Black,
    /// Chestnut.
    Brown,
    /// As light as fair skin.
    Blond,
    /// White and dark hairs mixed.
    Grey,
    /// No hair on the skull; black brows.
    Bald,
}

impl HairColor {
    pub(super) fn color(self) -> Color {
        match self {
            Self::Black | Self::Bald => [0.085, 0.075, 0.075],
            Self::Brown => [0.27, 0.175, 0.115],
            Self::Blond => [0.66, 0.51, 0.33],
            Self::Grey => [0.55, 0.545, 0.54],
        }
    }
}

/// The hair below the nose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beard {
    /// None.
    Shaved,
    /// Dark dots; labelled as skin.
    Stubble,
    /// A full beard; labelled as hair.
    Full,
}

/// The cloth around the neck.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collar {
    /// The colours of the cloth.
    pub dye: Dye,
    /// The height: 0 for a crew neck, 1 for a polo neck.
    pub height: f32,
    /// How unevenly the upper edge runs: its amplitude in centimetres.
    pub unevenness: f32,
}

impl Collar {
    /// A crew neck of one colour.
    pub const fn plain(color: Color) -> Self {
        Self { dye: Dye::Plain(color), height: 0.0, unevenness: 0.15 }
    }

    /// The same collar with another height and unevenness.
    #[must_use]
    pub const fn cut(self, height: f32, unevenness: f32) -> Self {
        Self { height, unevenness, ..self }
    }
}

/// The appearance of a painted face, and the conditions of its capture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceLook {
    /// The name in tables.
    pub name: &'static str,
    /// The complexion.
    pub skin: SkinTone,
    /// Hair and brows.
    pub hair: HairColor,
    /// Whether hair falls over the forehead.
    pub fringe: bool,
    /// What grows below the nose.
    pub beard: Beard,
    /// Whether the face wears glasses.
    pub glasses: bool,
    /// The cloth around the neck.
    pub collar: Option<Collar>,
    /// How much darker the neck is than the face: 0 for ambient occlusion alone.
    pub neck_shade: f32,
    /// Change of the baked light from the right ear to the left, in stops.
    pub light_ramp: f32,
    /// Seed of all noise.
    pub seed: u32,
}
