//! Sampling maps in the formats of other tools, one file for each:
//!
//! | format | content | read |
//! |---|---|---|
//! | [NPY](write_npy) | source position of each texel | yes |
//! | [NPZ](write_npz) | the file of the reference implementation (Song et al., arXiv 2508.19518) | yes |
//! | [EXR](write_st_map) | ST map, as compositors use it (feature `exr`) | yes |
//! | [CSR](write_csr) | the transfer as a sparse matrix of SciPy, filter and padding included | |
//!
//! [`read`] detects the format from the content.

mod csr;
mod error;
mod npy;
mod read;
mod reference;
#[cfg(feature = "exr")]
mod st_map;

use uvgraft::SamplingMap;

pub use self::csr::{CsrError, MAX_NONZEROS, save_csr, write_csr};
pub use self::error::MapFileError;
pub use self::npy::{save_npy, write_npy};
pub use self::read::{MAX_FILE_BYTES, parse, read};
pub use self::reference::{Convention, save_npz, write_npz};
#[cfg(feature = "exr")]
pub use self::st_map::{save_st_map, write_st_map};

/// Calls `visit` for each covered texel of a row with its column, its source position (u, v) and
/// its target face.
fn for_each_texel(map: &SamplingMap, row: u32, mut visit: impl FnMut(usize, [f64; 2], u32)) {
    for run in map.row(row) {
        let patch = &map.patches()[run.patch as usize];
        for x in run.x..run.x + run.len {
            let centre = [f64::from(x) + 0.5, f64::from(row) + 0.5];
            visit(x as usize, patch.src_uv_from_tgt_px.at(centre), patch.face);
        }
    }
}
