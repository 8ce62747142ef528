//! Interpolation filters as option values.

use clap::ValueEnum;
use uvgraft::Filter;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FilterName {
    /// Nearest texel, never blended; for label maps
    Nearest,
    /// 2 x 2 texels; never overshoots
    Bilinear,
    /// 4 x 4 texels; sharp, overshoots slightly at hard edges
    CatmullRom,
    /// 6 x 6 texels; keeps the most detail, overshoots at hard edges
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
