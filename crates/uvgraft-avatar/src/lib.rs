//! Rigged avatars: skeletons, skins and morphs ([`rig`]), body models of the SMPL family
//! ([`body`]), facial expressions ([`face`]), recorded motions ([`motion`]), and what captures
//! lack: [`eyes`] and a [`mouth`].
//!
//! With the feature `threads` (default) work runs on the caller's rayon pool, as described in
//! [`uvgraft::threads`]; results are the same without it.

#![forbid(unsafe_code)]

pub mod atlas;
mod avatar;
pub mod body;
#[cfg(test)]
mod example;
pub mod eyes;
pub mod face;
pub mod motion;
pub mod mouth;
pub mod normals;
pub mod paint;
pub mod ray;
pub mod rig;

pub use avatar::Avatar;
