//! The metrics by their names, for programs that let users choose among them.

#[cfg(feature = "serde")]
use uvgraft::Choice;
use uvgraft::choices;
use uvgraft::texture::Size;

#[cfg(feature = "lpips")]
use crate::lpips::LpipsNetwork;
use crate::{Colors, Mask, MetricError};

/// A metric of two textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Metric {
    /// [`l1`](crate::l1).
    L1,
    /// [`psnr`](crate::psnr).
    Psnr,
    /// [`ssim`](crate::ssim).
    Ssim,
    /// [`ssim_uniform`](crate::ssim_uniform).
    SsimUniform,
    /// SSIMULACRA 2, with the feature of that name.
    Ssimulacra2,
    /// FLIP, with the feature of that name.
    Flip,
    /// LPIPS by AlexNet, with the feature `lpips`.
    LpipsAlex,
    /// LPIPS by VGG, with the feature `lpips`. It takes minutes on large textures.
    LpipsVgg,
}

// In the order of tables.
choices!(Metric {
    L1 => "l1", "Mean absolute difference";
    Psnr => "psnr", "Peak signal-to-noise ratio, in decibels";
    Ssim => "ssim", "Structural similarity, with a Gaussian window";
    SsimUniform => "ssim-uniform", "Structural similarity, with a uniform window";
    Ssimulacra2 => "ssimulacra2", "SSIMULACRA 2";
    Flip => "flip", "FLIP";
    LpipsAlex => "lpips-alex", "LPIPS with AlexNet";
    LpipsVgg => "lpips-vgg", "LPIPS with VGG, which takes minutes on large textures";
});

/// A function that computes a metric.
pub type Measure = fn(&Colors, &Colors, Option<&Mask>) -> Result<f64, MetricError>;

impl Metric {
    /// Its title in tables.
    pub const fn title(self) -> &'static str {
        match self {
            Self::L1 => "L1",
            Self::Psnr => "PSNR (dB)",
            Self::Ssim => "SSIM",
            Self::SsimUniform => "SSIM, uniform",
            Self::Ssimulacra2 => "SSIMULACRA 2",
            Self::Flip => "FLIP",
            Self::LpipsAlex => "LPIPS, AlexNet",
            Self::LpipsVgg => "LPIPS, VGG",
        }
    }

    /// Whether a higher value is better.
    pub const fn higher_is_better(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim | Self::SsimUniform | Self::Ssimulacra2)
    }

    /// Decimal places that are significant.
    pub const fn decimals(self) -> usize {
        match self {
            Self::Psnr | Self::Ssimulacra2 => 2,
            _ => 5,
        }
    }

    /// Whether it takes minutes on large textures, so that it should run only if named.
    pub const fn is_slow(self) -> bool {
        matches!(self, Self::LpipsVgg)
    }

    /// Memory that computing it takes at most beside the colours, in bytes: measured at 4096² and 8192², with a
    /// margin of a third.
    ///
    /// - `of_levels`: whether both textures have 8 bits and no alpha.
    pub fn scratch_bytes(self, size: Size, of_levels: bool) -> u64 {
        let texels = size.texels() as u64;
        let width = size.width as u64;
        match self {
            // Rows and tiles, hardly more than the stack of a thread.
            Self::L1 | Self::Psnr | Self::Ssim | Self::SsimUniform => 0,
            // Pictures of its own, as it was given them and in linear light.
            Self::Ssimulacra2 if of_levels => texels * 26,
            Self::Ssimulacra2 => texels * 100,
            // Blocks of rows, one for each thread.
            Self::Flip => (width << 14) * uvgraft::threads::count() as u64,
            // Strips of the networks' maps.
            Self::LpipsAlex => width << 14,
            Self::LpipsVgg => width << 17,
        }
    }

    /// The function that computes it; `None` for LPIPS, which needs a network, and for metrics that
    /// this build lacks.
    pub const fn measure(self) -> Option<Measure> {
        match self {
            Self::L1 => Some(crate::l1),
            Self::Psnr => Some(crate::psnr),
            Self::Ssim => Some(crate::ssim),
            Self::SsimUniform => Some(crate::ssim_uniform),
            #[cfg(feature = "ssimulacra2")]
            Self::Ssimulacra2 => Some(crate::ssimulacra2),
            #[cfg(feature = "flip")]
            Self::Flip => Some(crate::flip),
            _ => None,
        }
    }

    /// The network of LPIPS.
    #[cfg(feature = "lpips")]
    pub const fn network(self) -> Option<LpipsNetwork> {
        match self {
            Self::LpipsAlex => Some(LpipsNetwork::Alex),
            Self::LpipsVgg => Some(LpipsNetwork::Vgg),
            _ => None,
        }
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Metric {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name())
    }
}
