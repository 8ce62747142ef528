//! Avatars as glTF: writing them as GLB and VRM ([`glb`]), fitting them to a platform's limits
//! ([`preset`]), and reading scenes from GLB, VRM and glTF files of any origin ([`scene`]).
//!
//! Writer and reader share only the GLB container, so reading back a file that we wrote exercises
//! code independent of the code that wrote it.
//!
//! With the feature `threads` (default), work runs on the caller's rayon pool, see
//! [`uvgraft::threads`]; results are the same without it.

pub mod container;
pub mod glb;
pub mod preset;
pub mod scene;
