//! Readers and writers of files: meshes (OBJ, PLY, SMPL-family models), vertex maps, lists and
//! groups, tables of correspondences, images, pair files, sampling maps as arrays, arrays by name
//! (NPZ, pickles, torch files), FATE's textures, tracked videos of heads, networks that find faces,
//! and LPIPS weights (feature `lpips`).
//!
//! Every reader takes bytes, with a path helper on top; every writer goes through [`output`], which
//! leaves either the old or the new file, never a partial one.
//!
//! With the feature `threads` (default) PNGs are compressed on the caller's rayon pool, as
//! described in [`uvgraft::threads`]; the bytes are the same without it.

#![forbid(unsafe_code)]

pub mod arrays;
pub mod checksum;
pub mod correspondence_table;
pub mod face_networks;
pub mod fate;
pub mod image;
pub mod input;
pub mod integers;
#[cfg(feature = "lpips")]
pub mod lpips_weights;
pub mod model_mesh;
mod numpy;
pub mod obj;
pub mod output;
pub mod pair_file;
pub mod pickle;
pub mod ply;
pub mod sampling_map;
pub mod textured;
pub mod tflite;
pub mod torch;
pub mod tracking;
pub mod vertex_groups;
pub mod vertex_list;
pub mod vertex_map;
