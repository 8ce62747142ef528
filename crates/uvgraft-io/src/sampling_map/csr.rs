//! Transfers as sparse matrices, for `scipy.sparse.load_npz`.
//!
//! Source: `scipy.sparse.save_npz` of a CSR matrix: an NPZ with `format`, `shape`, `data`, `indices`
//! and `indptr`.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::Path;

use uvgraft::Operator;
use zip::ZipWriter;

use crate::arrays::stored_entry;
use crate::numpy::write_header;
use uvgraft_files::output::write_atomically;

/// Maximum number of entries of a matrix: a file of 8 GiB, and within 32-bit indices, as are the
/// numbers of texels.
pub const MAX_NONZEROS: u64 = 1 << 30;

/// Texels whose entries are held in memory at once, rounded to whole rows: some 10 MB in most maps.
const TEXELS_AT_ONCE: u32 = 1 << 15;

/// Why a matrix was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CsrError {
    /// The file could not be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// More entries than [`MAX_NONZEROS`].
    #[error(
        "the matrix must have at most {MAX_NONZEROS} non-zero entries, got more; use a smaller size \
         or a filter that reads fewer texels"
    )]
    TooMany,
}

/// Writes a transfer as a CSR matrix `H` of `[target texels, source texels]`, both row-major:
/// `H @ texture.reshape(-1, channels)` is what the transfer samples. Returns the number of entries.
///
/// - `data` (`<f4`), `indices` (`<i4`, ascending within rows) and `indptr` (`<i4`).
/// - The filter, averaging where textures are minified, and the padding of the source's islands are
///   part of it; rounding to the depth of a texture, and clamping to its range, are not.
/// - Rows of texels that the map does not reach are empty.
///
/// Entries are spooled to temporary files, so only a few rows are held in memory.
///
/// - `folder`: where temporary files are created; they take as much space as the result.
///
/// # Errors
/// [`CsrError`].
pub fn write_csr(
    operator: &Operator,
    folder: &Path,
    out: impl Write + Seek,
) -> Result<u64, CsrError> {
    let spooled = Spooled::new(operator, folder)?;
    let (target, source) = (operator.target_size(), operator.source_size());
    let count = spooled.count as usize;
    let mut archive = ZipWriter::new(out);
    start(&mut archive, "format", "|S3", &[])?;
    archive.write_all(b"csr")?;
    start(&mut archive, "shape", "<i8", &[2])?;
    for texels in [target.texels(), source.texels()] {
        archive.write_all(&(texels as i64).to_le_bytes())?;
    }
    start(&mut archive, "indptr", "<i4", &[target.texels() + 1])?;
    archive.write_all(&0_i32.to_le_bytes())?;
    io::copy(&mut rewound(spooled.ends)?, &mut archive)?;
    start(&mut archive, "indices", "<i4", &[count])?;
    io::copy(&mut rewound(spooled.columns)?, &mut archive)?;
    start(&mut archive, "data", "<f4", &[count])?;
    io::copy(&mut rewound(spooled.values)?, &mut archive)?;
    archive.finish().map_err(io::Error::from)?.flush()?;
    Ok(spooled.count)
}

/// Starts the array of a name.
fn start(
    archive: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    descr: &str,
    shape: &[usize],
) -> io::Result<()> {
    archive.start_file(format!("{name}.npy"), stored_entry())?;
    write_header(descr, shape, archive)
}

/// Writes a matrix to an NPZ file atomically; see [`write_csr`].
///
/// # Errors
/// [`CsrError`]; an existing file is then unchanged.
pub fn save_csr(operator: &Operator, path: impl AsRef<Path>) -> Result<u64, CsrError> {
    let path = path.as_ref();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut count = 0;
    write_atomically(path, |out| {
        count = write_csr(operator, folder.unwrap_or(Path::new(".")), out)?;
        Ok::<(), CsrError>(())
    })?;
    Ok(count)
}

/// The arrays of a matrix in temporary files, because their length is stated before their values.
struct Spooled {
    count: u64,
    /// For each row, the end of its entries.
    ends: BufWriter<File>,
    columns: BufWriter<File>,
    values: BufWriter<File>,
}

impl Spooled {
    fn new(operator: &Operator, folder: &Path) -> Result<Self, CsrError> {
        let spool = || tempfile::tempfile_in(folder).map(BufWriter::new);
        let mut spooled = Self { count: 0, ends: spool()?, columns: spool()?, values: spool()? };
        let size = operator.target_size();
        let matrix = operator.matrix();
        let step = (TEXELS_AT_ONCE / size.width).max(1);
        for first in (0..size.height).step_by(step as usize) {
            let rows = matrix.rows(first..(first + step).min(size.height));
            if spooled.count + rows.columns.len() as u64 > MAX_NONZEROS {
                return Err(CsrError::TooMany);
            }
            // Below the limit all numbers fit 31 bits.
            let before = spooled.count as u32;
            for end in &rows.ends {
                spooled.ends.write_all(&(before + *end as u32).to_le_bytes())?;
            }
            for column in &rows.columns {
                spooled.columns.write_all(&column.to_le_bytes())?;
            }
            for value in &rows.values {
                spooled.values.write_all(&value.to_le_bytes())?;
            }
            spooled.count += rows.columns.len() as u64;
        }
        Ok(spooled)
    }
}

/// A temporary file from its beginning.
fn rewound(file: BufWriter<File>) -> io::Result<impl Read> {
    let mut file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.rewind()?;
    Ok(BufReader::with_capacity(1 << 18, file))
}
