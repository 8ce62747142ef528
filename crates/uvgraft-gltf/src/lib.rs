//! Avatars as glTF: written as GLB and VRM ([`glb`]), brought within a platform's limits ([`preset`]), and scenes
//! read from any maker's GLB, VRM and glTF files ([`scene`]).
//!
//! Writing and reading share the GLB container and nothing else, so a file that we wrote is read back by
//! other code than made it.
//!
//! With the feature `threads` (default) work is done on the caller's rayon pool, as
//! [`uvgraft::threads`] says; results are the same without it.

pub mod container;
pub mod glb;
pub mod preset;
pub mod scene;
