//! Carries textures on a graphics processor: the same runs, positions and weights as on the CPU, over
//! Vulkan, Metal, DirectX 12 or WebGPU.
//!
//! All values of opaque 8-bit textures are computed in whole numbers, as on the CPU. Where floats are
//! involved (alpha, 16 bits, means of several samples), a graphics processor may round differently, so
//! results are within one level of those of [`Graft::apply`](uvgraft::Graft::apply); colours of
//! texels that become fully transparent may be any.
//!
//! It pays for textures that stay on the device: several transfers in a row, or a renderer that shows
//! the result. From file to file most of the time is spent on compressing and decompressing, and
//! uploads and downloads eat up what sampling would save.
//!
//! ```
//! # #[cfg(feature = "wgpu")] {
//! use uvgraft::{Graft, Texture};
//! use uvgraft_gpu::{Adapters, Gpu};
//!
//! /// On the device if there is one, else on the CPU.
//! fn transfer(graft: &Graft, face: &Texture, base: &Texture) -> Result<Texture, Box<dyn std::error::Error>> {
//!     match Gpu::new(Adapters::Hardware) {
//!         Ok(gpu) => Ok(gpu.transfer(graft)?.apply_texture(face, base)?),
//!         Err(error) => {
//!             eprintln!("{error}; the CPU is used");
//!             Ok(graft.apply(face, base)?)
//!         }
//!     }
//! }
//! # }
//! ```
//!
//! Everything is behind the feature `wgpu`, which is off by default.

#![cfg(feature = "wgpu")]

mod bands;
mod device;
mod error;
mod kernels;
mod padding;
#[cfg(test)]
mod tests;
mod texture;
mod transfer;

pub use device::{Adapters, Gpu};
pub use error::GpuError;
pub use texture::DeviceTexture;
pub use transfer::Transfer;
