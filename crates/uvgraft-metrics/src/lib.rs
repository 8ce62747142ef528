//! How alike two textures are.
//!
//! Every metric takes two [`Colors`] of one size and, where only a part counts, a [`Mask`].
//!
//! | | better | identical | feature |
//! |---|---|---|---|
//! | [`l1`] | lower | 0 | |
//! | [`psnr`] | higher | infinity | |
//! | [`ssim`], [`ssim_uniform`] | higher | 1 | |
//! | `ssimulacra2` | higher | 100 | `ssimulacra2` |
//! | `flip` | lower | 0 | `flip` |
//! | `lpips` | lower | 0 | `lpips`, and weights |
//!
//! [`seams`] measures how visible seams and rims are in one texture, and [`baseline`] has the methods that were
//! used before, to compare with. How different two colours are is [`uvgraft::color::delta_e`].
//!
//! Results do not depend on the number of threads.

#![forbid(unsafe_code)]

pub mod baseline;
mod colors;
mod difference;
#[cfg(feature = "flip")]
mod flip;
mod l1;
#[cfg(feature = "lpips")]
pub mod lpips;
mod mask;
mod psnr;
pub mod seams;
mod ssim;
#[cfg(feature = "ssimulacra2")]
mod ssimulacra2;
#[cfg(test)]
mod testing;

use uvgraft::Size;

pub use colors::Colors;
#[cfg(feature = "flip")]
pub use flip::{PIXELS_PER_DEGREE, flip};
pub use l1::l1;
pub use mask::Mask;
pub use psnr::psnr;
pub use ssim::{ssim, ssim_uniform};
#[cfg(feature = "ssimulacra2")]
pub use ssimulacra2::ssimulacra2;

/// Why two textures were not compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MetricError {
    /// Something has another size than the first texture.
    #[error("the {what} must have the size of the first texture, {wanted}, got {found}")]
    Size {
        /// `"second texture"` or `"mask"`.
        what: &'static str,
        /// Its size.
        found: Size,
        /// The first texture's size.
        wanted: Size,
    },
    /// The mask selects no texel that the metric could use.
    #[error("the mask selects no texel{0}")]
    EmptyMask(
        /// Empty, or where the metric does not look.
        &'static str,
    ),
    /// A texture, or what a mask cuts out of it, is too small for a metric.
    #[error("{metric} needs at least {least} texels a side, got {found}")]
    TooSmall {
        /// The metric.
        metric: &'static str,
        /// The shortest side that it takes.
        least: u32,
        /// The size that there is.
        found: Size,
    },
    /// A value so far from what a display shows that a metric's own numbers would overflow.
    #[error("texel ({x}, {y}) exceeds the range of {metric}, from -{most} to {most}")]
    OutOfRange {
        /// The metric.
        metric: &'static str,
        /// The largest value that it takes, and the least with a minus; white is 1.
        most: u32,
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
    /// A value that is no number, or infinite.
    #[error("texel ({x}, {y}) is NaN or infinite")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
}

/// Checks that two textures and a mask have one size.
pub(crate) fn same_size(a: &Colors, b: &Colors, mask: Option<&Mask>) -> Result<(), MetricError> {
    let wanted = a.size();
    let others = [("second texture", Some(b.size())), ("mask", mask.map(Mask::size))];
    for (what, found) in others {
        if let Some(found) = found.filter(|&found| found != wanted) {
            return Err(MetricError::Size { what, found, wanted });
        }
    }
    Ok(())
}
