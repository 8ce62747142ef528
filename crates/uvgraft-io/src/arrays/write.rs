//! Writes arrays as NumPy's NPZ.
//!
//! Source: `numpy.savez`: a ZIP archive, here of stored entries, with an NPY file for each array.

use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::named::Held;
use super::named::NamedArrays;
use super::numeric::Numbers;
use super::numeric::NumericArray;
use crate::numpy::write_header;
use crate::output::write_atomically;

/// Writes arrays as an NPZ archive for `numpy.load`: 32-bit floats as `<f4`, 64-bit ones as `<f8`,
/// integers as `<i8`, strings as arrays without axes. Values that were skipped when reading are not
/// written. Equal arrays give equal bytes.
///
/// # Errors
/// Those of `out`.
pub fn write_npz(arrays: &NamedArrays, out: impl Write + Seek) -> io::Result<()> {
    let mut archive = ZipWriter::new(out);
    for (name, held) in arrays.entries() {
        if matches!(held, Held::Unusable(_) | Held::Skipped) {
            continue;
        }
        archive.start_file(format!("{name}.npy"), stored_entry())?;
        // Values are written one by one.
        let mut entry = BufWriter::new(&mut archive);
        match held {
            Held::Array(array) => write_array(array, &mut entry)?,
            Held::Text(text) => write_text(text, &mut entry)?,
            Held::Unusable(_) | Held::Skipped => {}
        }
        entry.flush()?;
    }
    archive.finish()?.flush()
}

/// Writes arrays as an NPZ archive to a file; see [`write_npz`].
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub fn save_npz(arrays: &NamedArrays, path: &Path) -> io::Result<()> {
    write_atomically(path, |out| write_npz(arrays, out))
}

fn write_array(array: &NumericArray, out: &mut impl Write) -> io::Result<()> {
    match array.numbers() {
        Numbers::F32(values) => {
            write_header("<f4", array.shape(), out)?;
            values.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
        }
        Numbers::F64(values) => {
            write_header("<f8", array.shape(), out)?;
            values.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
        }
        Numbers::I64(values) => {
            write_header("<i8", array.shape(), out)?;
            values.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
        }
    }
}

/// The options of an archive's entries.
pub(crate) fn stored_entry() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true)
}

/// Writes a string as an NPY array without axes.
pub(crate) fn write_text(text: &str, out: &mut impl Write) -> io::Result<()> {
    write_header(&format!("<U{}", text.chars().count()), &[], out)?;
    text.chars().try_for_each(|character| out.write_all(&u32::from(character).to_le_bytes()))
}
