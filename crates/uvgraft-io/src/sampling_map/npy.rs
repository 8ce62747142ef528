//! Sampling maps as NPY arrays of positions.

use std::io::{self, Write};
use std::path::Path;

use uvgraft::SamplingMap;

use super::for_each_texel;
use crate::numpy::write_header;
use uvgraft_files::output::write_atomically;

/// Writes a map as an NPY array, version 1.0: `[height, width, 2]` of `<f4`, the source's (u, v) at
/// the centre of each texel.
///
/// Rows go from the top down, and (0, 0) is the top left corner of the source. Both are NaN at
/// texels that are not covered; the gutter of the map is covered. Single precision is accurate to
/// 2⁻¹² texels of a 4096² source.
///
/// Only one row is held in memory.
///
/// # Errors
/// Those of `out`.
pub fn write_npy(map: &SamplingMap, out: &mut impl Write) -> io::Result<()> {
    /// Bytes of a texel.
    const TEXEL: usize = 2 * size_of::<f32>();
    let [width, height] = [map.size().width, map.size().height].map(|side| side as usize);
    write_header("<f4", &[height, width, 2], out)?;
    let nowhere = f32::NAN.to_le_bytes().repeat(2 * width);
    let mut bytes = nowhere.clone();
    for row in 0..map.size().height {
        bytes.copy_from_slice(&nowhere);
        for_each_texel(map, row, |x, [u, v], _| {
            let (to_u, to_v) = bytes[x * TEXEL..][..TEXEL].split_at_mut(TEXEL / 2);
            to_u.copy_from_slice(&(u as f32).to_le_bytes());
            to_v.copy_from_slice(&(v as f32).to_le_bytes());
        });
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// Writes a map to an NPY file atomically; see [`write_npy`].
///
/// # Errors
/// Those of creating, writing and renaming the file; an existing file is then unchanged.
pub fn save_npy(map: &SamplingMap, path: impl AsRef<Path>) -> io::Result<()> {
    write_atomically(path.as_ref(), |out| write_npy(map, out))
}
