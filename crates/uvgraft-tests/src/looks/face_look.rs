//! What painted faces may look like.

use super::skin::Dye;
use super::{Color, SkinTone};

/// The colour of hair and brows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HairColor {
    /// Nearly no colour, with blue gloss.
    Black,
    /// Chestnut.
    Brown,
    /// As light as light skin.
    Blond,
    /// White and dark hairs.
    Grey,
    /// None on the skull; brows are black.
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

/// What grows below the nose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beard {
    /// Nothing.
    Shaved,
    /// Dark dots; counts as skin.
    Stubble,
    /// A full beard; counts as hair.
    Full,
}

/// The cloth at the neck.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collar {
    /// How it is dyed.
    pub dye: Dye,
    /// How high it reaches: 0 for a crew neck, 1 for a polo neck.
    pub height: f32,
    /// How far its upper edge goes up and down, in centimetres.
    pub unevenness: f32,
}

impl Collar {
    /// A crew neck of one colour.
    pub const fn plain(color: Color) -> Self {
        Self { dye: Dye::Plain(color), height: 0.0, unevenness: 0.15 }
    }

    /// The same with another height and unevenness.
    #[must_use]
    pub const fn cut(self, height: f32, unevenness: f32) -> Self {
        Self { height, unevenness, ..self }
    }
}

/// Who is painted, and how they were captured.
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
    /// Whether there are glasses.
    pub glasses: bool,
    /// The cloth at the neck.
    pub collar: Option<Collar>,
    /// How much darker the neck is than the face: 0 for what only ambient light does.
    pub neck_shade: f32,
    /// How many times baked light doubles from the right ear to the left.
    pub light_ramp: f32,
    /// Of all noise.
    pub seed: u32,
}
