//! Filters as options name them.

use clap::ValueEnum;
use uvgraft::Filter;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FilterName {
    /// One texel, never blended; for labels
    Nearest,
    /// Two texels an axis; never brighter or darker than the source
    Bilinear,
    /// Four texels an axis; sharp, overshoots a little at hard edges
    CatmullRom,
    /// Six texels an axis; keeps most of a photograph there and back, overshoots at hard edges
    Lanczos3,
}

impl From<FilterName> for Filter {
    fn from(name: FilterName) -> Self {
        match name {
            FilterName::Nearest => Self::Nearest,
            FilterName::Bilinear => Self::Bilinear,
            FilterName::CatmullRom => Self::CatmullRom,
            FilterName::Lanczos3 => Self::Lanczos3,
        }
    }
}
