//! Whose texels are shown where islands share them, as options name it.

use clap::ValueEnum;
use uvgraft::Prefer;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PreferName {
    /// The one whose faces come first in the mesh
    First,
    /// The one to the left of the person, where x is greatest
    Left,
    /// The one to the right of the person, where x is least
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
