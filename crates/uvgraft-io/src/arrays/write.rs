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
use crate::numpy::order::first_axis_fastest;
use crate::numpy::{write_header, write_ordered_header};
use uvgraft_files::output::write_atomically;

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
pub fn save_npz(arrays: &NamedArrays, path: impl AsRef<Path>) -> io::Result<()> {
    write_atomically(path.as_ref(), |out| write_npz(arrays, out))
}

/// Writes arrays as a compressed NPZ archive, as `numpy.savez_compressed` does: as [`write_npz`],
/// but deflated, with integers in the narrowest signed type that holds them all, and in Fortran
/// order, in which the components of a model compress best. Values and shapes are the same when
/// read back.
///
/// # Errors
/// Those of `out`.
pub fn write_npz_compressed(arrays: &NamedArrays, out: impl Write + Seek) -> io::Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(9));
    let mut archive = ZipWriter::new(out);
    for (name, held) in arrays.entries() {
        let mut bytes = Vec::new();
        match held {
            Held::Array(array) => write_compact(array, &mut bytes)?,
            Held::Text(text) => write_text(text, &mut bytes)?,
            Held::Unusable(_) | Held::Skipped => continue,
        }
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(&bytes)?;
    }
    archive.finish()?.flush()
}

/// Writes arrays as a compressed NPZ archive to a file; see [`write_npz_compressed`].
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub fn save_npz_compressed(arrays: &NamedArrays, path: impl AsRef<Path>) -> io::Result<()> {
    write_atomically(path.as_ref(), |out| write_npz_compressed(arrays, out))
}

fn write_compact(array: &NumericArray, out: &mut Vec<u8>) -> io::Result<()> {
    let shape = array.shape();
    match array.numbers() {
        Numbers::F32(values) => {
            write_ordered_header("<f4", shape, true, out)?;
            out.extend(first_axis_fastest(values, shape).iter().flat_map(|v| v.to_le_bytes()));
        }
        Numbers::F64(values) => {
            write_ordered_header("<f8", shape, true, out)?;
            out.extend(first_axis_fastest(values, shape).iter().flat_map(|v| v.to_le_bytes()));
        }
        Numbers::I64(values) => {
            let fits = |bits: u32| values.iter().all(|value| value >> (bits - 1) == value >> 63);
            let width = [1, 2, 4].into_iter().find(|width| fits(8 * width)).unwrap_or(8);
            let descr = if width == 1 { "|i1".to_owned() } else { format!("<i{width}") };
            write_ordered_header(&descr, shape, true, out)?;
            for value in first_axis_fastest(values, shape) {
                out.extend_from_slice(&value.to_le_bytes()[..width as usize]);
            }
        }
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::arrays::parse;

    #[test]
    fn compressed_archives_hold_the_same_values() {
        let mut arrays = NamedArrays::new();
        let floats: Vec<f32> = (0..24).map(|value| value as f32 / 7.0).collect();
        arrays.insert("floats", NumericArray::new_f32(vec![2, 3, 4], floats).unwrap());
        arrays.insert("double", NumericArray::new_f64(vec![], vec![0.1]).unwrap());
        arrays.insert_text("text", "äöü");
        for (name, most) in
            [("i1", 127), ("i2", -129), ("i4", 40_000), ("i8", 1 << 40), ("least", -128)]
        {
            let values = vec![0, most, -1, 3, 4, 5];
            arrays.insert(name, NumericArray::new_i64(vec![3, 2], values).unwrap());
        }
        let written = |arrays: &NamedArrays| {
            let mut file = Cursor::new(Vec::new());
            write_npz_compressed(arrays, &mut file).unwrap();
            file.into_inner()
        };
        let bytes = written(&arrays);
        assert_eq!(parse(&bytes).unwrap(), arrays);
        assert_eq!(bytes, written(&arrays));
        // A million zeros take next to nothing.
        arrays
            .insert("zeros", NumericArray::new_f32(vec![1_000_000], vec![0.0; 1_000_000]).unwrap());
        assert!(written(&arrays).len() < bytes.len() + 6_000);
    }
}
