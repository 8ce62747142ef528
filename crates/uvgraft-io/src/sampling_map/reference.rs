//! The NPZ of the reference implementation: Song et al., "Fast Texture Transfer for XR Avatars via
//! Barycentric UV Conversion", arXiv 2508.19518, code of August 2025.
//!
//! It loads `uv_grid` (float32, `[1, height, width, 2]`) and `pix_to_face` (int64, `[height,
//! width]`), passes the former to `grid_sample(texture, uv_grid, mode='bilinear',
//! align_corners=True)` as it is, and keeps the base where the latter is negative.

use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use uvgraft::{SamplingMap, Size};
use zip::ZipWriter;

use super::for_each_texel;
use crate::arrays::{stored_entry, write_text};
use crate::numpy::write_header;
use uvgraft_files::output::write_atomically;

/// How a position u of 0 to 1 is stored for `grid_sample`, which with `align_corners=True` takes −1
/// and 1 for the *centres* of the first and the last texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convention {
    /// `2u − 1`, as the reference implementation computes it: −1 and 1 are the *edges* of the
    /// texture. With its `align_corners=True` samples are up to half a texel off.
    Reference,
    /// `2 (u·W − ½) / (W − 1) − 1` for a source of this size, whose width is W: exact with
    /// `align_corners=True`, for textures of that size only.
    Exact(Size),
}

impl Convention {
    /// The name in files and options.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Exact(_) => "exact",
        }
    }

    /// The stored value of a position.
    fn grid_from_uv(self, uv: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Reference => uv.map(|value| 2.0 * value - 1.0),
            Self::Exact(size) => {
                scaled(size, |axis, count| 2.0 * (uv[axis] * count - 0.5) / (count - 1.0) - 1.0)
            }
        }
    }

    /// The position of a stored value.
    pub(super) fn uv_from_grid(self, grid: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Reference => grid.map(|value| 0.5 * (value + 1.0)),
            Self::Exact(size) => {
                scaled(size, |axis, count| (0.5 * (grid[axis] + 1.0) * (count - 1.0) + 0.5) / count)
            }
        }
    }
}

/// A coordinate for each axis; with a single texel on an axis, all positions are its centre.
fn scaled(size: Size, coordinate: impl Fn(usize, f64) -> f64) -> [f64; 2] {
    let counts = [size.width, size.height].map(|count| f64::from(count.max(1)));
    [0, 1].map(|axis| if counts[axis] > 1.0 { coordinate(axis, counts[axis]) } else { 0.0 })
}

/// Writes a map as the reference implementation's NPZ.
///
/// - `uv_grid`: `[1, height, width, 2]` of `<f4`, positions as `convention` says, rows from the top
///   down; 0 at texels that are not covered.
/// - `pix_to_face`: `[height, width]` of `<i8`, the target triangle of each texel, or −1. Texels of
///   the gutter have the triangle that they continue. The reference implementation numbers only
///   linked triangles, and uses no more than the sign.
/// - `convention`: its name, and for [`Convention::Exact`] `source_size`, `[2]` of `<i8`: width and
///   height. The reference implementation ignores both; [`read`](super::read) needs them.
///
/// Only one row is held in memory.
///
/// # Errors
/// Those of `out`.
pub fn write_npz(
    map: &SamplingMap,
    convention: Convention,
    out: impl Write + Seek,
) -> io::Result<()> {
    let [width, height] = [map.size().width, map.size().height].map(|side| side as usize);
    let mut archive = ZipWriter::new(out);
    archive.start_file("uv_grid.npy", stored_entry())?;
    let mut entry = BufWriter::new(&mut archive);
    write_header("<f4", &[1, height, width, 2], &mut entry)?;
    let mut grid = vec![[0.0_f32; 2]; width];
    for row in 0..map.size().height {
        grid.fill([0.0; 2]);
        for_each_texel(map, row, |x, uv, _| {
            grid[x] = convention.grid_from_uv(uv).map(|value| value as f32);
        });
        grid.iter().flatten().try_for_each(|value| entry.write_all(&value.to_le_bytes()))?;
    }
    entry.flush()?;
    drop(entry);

    archive.start_file("pix_to_face.npy", stored_entry())?;
    let mut entry = BufWriter::new(&mut archive);
    write_header("<i8", &[height, width], &mut entry)?;
    let mut faces = vec![-1_i64; width];
    for row in 0..map.size().height {
        faces.fill(-1);
        for_each_texel(map, row, |x, _, face| faces[x] = face.into());
        faces.iter().try_for_each(|face| entry.write_all(&face.to_le_bytes()))?;
    }
    entry.flush()?;
    drop(entry);

    archive.start_file("convention.npy", stored_entry())?;
    write_text(convention.name(), &mut archive)?;
    if let Convention::Exact(size) = convention {
        archive.start_file("source_size.npy", stored_entry())?;
        write_header("<i8", &[2], &mut archive)?;
        for side in [size.width, size.height] {
            archive.write_all(&i64::from(side).to_le_bytes())?;
        }
    }
    archive.finish()?.flush()
}

/// Writes a map to an NPZ file atomically; see [`write_npz`].
///
/// # Errors
/// Those of creating, writing and renaming the file; an existing file is then unchanged.
pub fn save_npz(
    map: &SamplingMap,
    convention: Convention,
    path: impl AsRef<Path>,
) -> io::Result<()> {
    write_atomically(path.as_ref(), |out| write_npz(map, convention, out))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conventions_by_hand() {
        let exact = Convention::Exact(Size::new(4, 1));
        assert_eq!(Convention::Reference.grid_from_uv([0.25, 1.0]), [-0.5, 1.0]);
        // The centres of the first and the last of four texels.
        assert_eq!(exact.grid_from_uv([0.125, 0.3]), [-1.0, 0.0]);
        assert_eq!(exact.grid_from_uv([0.875, 0.3]), [1.0, 0.0]);
        for convention in [Convention::Reference, Convention::Exact(Size::new(512, 300))] {
            let uv = convention.uv_from_grid(convention.grid_from_uv([0.7, -2.3]));
            assert!((uv[0] - 0.7).abs() < 1e-14 && (uv[1] + 2.3).abs() < 1e-14, "{uv:?}");
        }
    }
}
