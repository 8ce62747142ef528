//! Errors of devices and of what runs on them.

use uvgraft::{PlanError, Size, TexelFormat};

/// Why a device cannot be used, or why it failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no graphics processor, or no driver for it.
    #[error("no graphics processor was found ({0})")]
    NoAdapter(String),
    /// There is an adapter, but it gives no device.
    #[error("the graphics processor {adapter} cannot be used: {reason}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What its driver says.
        reason: String,
    },
    /// The transfer is more than sampling.
    #[error("not on a graphics processor: {0}")]
    Plan(#[from] PlanError),
    /// A texture does not have the size that the transfer was made for.
    #[error("the {what} must be {wanted}, got {found}")]
    Size {
        /// `"texture"` or `"base"`.
        what: &'static str,
        /// The texture's size.
        found: Size,
        /// The size that the transfer was made for.
        wanted: Size,
    },
    /// A texture and a base on the device have different formats.
    #[error("the texture must have the format of the base, {base:?}, got {texture:?}")]
    Formats {
        /// The texture's format.
        texture: TexelFormat,
        /// The base's format.
        base: TexelFormat,
    },
    /// A texture or a map has more layers or texels than the device allows.
    #[error("{what} of {size} is too large for the graphics processor")]
    TooLarge {
        /// `"a texture"` or `"a map"`.
        what: &'static str,
        /// Its size.
        size: Size,
    },
    /// The device's memory is used up.
    #[error("the graphics processor's memory is used up")]
    Memory,
    /// The device failed or was lost.
    #[error("the graphics processor failed: {0}")]
    Device(String),
}
