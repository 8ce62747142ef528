//! Similarity of two textures.
//!
//! Every metric takes two [`Colors`] of equal size and, to compare only a part, a [`Mask`].
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
//! [`Metric`] names them for programs that let users choose.
//!
//! [`seams`] measures the visibility of seams and region boundaries in one texture. [`baseline`]
//! has earlier transfer methods for comparison. For the difference of two colours see
//! [`uvgraft::color::delta_e`].
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
#[cfg(feature = "lpips")]
pub mod lpips_weights;
mod mask;
mod metric;
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
pub use metric::{Measure, Metric};
pub use psnr::psnr;
pub use ssim::{ssim, ssim_uniform};
#[cfg(feature = "ssimulacra2")]
pub use ssimulacra2::ssimulacra2;

/// Why two textures could not be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MetricError {
    /// A texture or mask differs in size from the first texture.
    #[error("the {what} must have the size of the first texture, {wanted}, got {found}")]
    Size {
        /// `"second texture"` or `"mask"`.
        what: &'static str,
        /// Its size.
        found: Size,
        /// The first texture's size.
        wanted: Size,
    },
    /// The mask selects no texel that the metric can use.
    #[error("the mask selects no texel{0}")]
    EmptyMask(
        /// Empty, or the restriction that the metric adds.
        &'static str,
    ),
    /// A texture, or the part that a mask selects, is too small for the metric.
    #[error("{metric} needs images of at least {least} texels per side, got {found}")]
    TooSmall {
        /// The metric.
        metric: &'static str,
        /// The shortest side that the metric accepts.
        least: u32,
        /// The actual size.
        found: Size,
    },
    /// A value so far outside the displayable range that the metric would overflow.
    #[error("texel ({x}, {y}) is outside the range of {metric}, -{most} to {most}")]
    OutOfRange {
        /// The metric.
        metric: &'static str,
        /// The largest magnitude that the metric accepts; white is 1.
        most: u32,
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
    /// A value is NaN or infinite.
    #[error("texel ({x}, {y}) is NaN or infinite")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
}

/// Checks that two textures and a mask have the same size.
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
