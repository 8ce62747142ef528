//! Owners of shared texels as option values.

use clap::ValueEnum;
use uvgraft::Prefer;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PreferName {
    /// The island whose faces come first in the mesh
    First,
    /// The island on the person's left (largest x)
    Left,
    /// The island on the person's right (smallest x)
    Right,
}

impl From<PreferName> for Prefer {
    fn from(name: PreferName) -> Self {
        match name {
            PreferName::First => Self::First,
            PreferName::Left => Self::Left,
            PreferName::Right => Self::Right,
        }
    }
}
