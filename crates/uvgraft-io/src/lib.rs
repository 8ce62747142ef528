//! Readers and writers of files: meshes (OBJ, PLY, SMPL-family models), vertex maps, lists and
//! groups, tables of correspondences, pair files, sampling maps as arrays, arrays by name
//! (NPZ, pickles, torch files), FATE's textures, tracked videos of heads, networks that find faces,
//! and LPIPS weights (feature `lpips`).
//!
//! Every reader takes bytes, with a path helper on top; every writer goes through [`output`](uvgraft_files::output), which
//! leaves either the old or the new file, never a partial one.

#![forbid(unsafe_code)]

pub mod arrays;
mod beginning;
pub mod correspondence_table;
pub mod fate;
pub mod integers;
pub mod model_mesh;
mod numpy;
pub mod obj;
pub mod pair_file;
pub mod pickle;
pub mod ply;
pub mod sampling_map;
pub mod textured;
pub mod torch;
pub mod tracking;
pub mod vertex_groups;
pub mod vertex_list;
pub mod vertex_map;

pub use self::beginning::beginning;
