//! Writes tensors in torch's format.

use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::arrays::named::NamedArrays;
use uvgraft_files::output::write_atomically;

/// Writes the arrays as a dict of 32-bit float tensors for `torch.load`, also with `weights_only`;
/// strings are not written.
///
/// # Errors
/// Those of `out`, and names or shapes beyond 32 bits.
pub fn write_pth(arrays: &NamedArrays, out: impl Write + Seek) -> io::Result<()> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut archive = ZipWriter::new(out);
    let tensors: Vec<(&str, &crate::arrays::NumericArray)> =
        arrays.names().filter_map(|name| Some((name, arrays.get(name)?))).collect();
    archive.start_file("archive/data.pkl", options)?;
    let mut pickle = b"\x80\x02}".to_vec();
    for (key, &(name, array)) in tensors.iter().enumerate() {
        text(name, &mut pickle)?;
        pickle.extend(b"ctorch._utils\n_rebuild_tensor_v2\n((");
        text("storage", &mut pickle)?;
        pickle.extend(b"ctorch\nFloatStorage\n");
        text(&key.to_string(), &mut pickle)?;
        text("cpu", &mut pickle)?;
        let mut strides = Vec::with_capacity(array.shape().len());
        let count = array.shape().iter().rev().fold(1, |count, &length| {
            strides.push(count);
            count * length
        });
        strides.reverse();
        number(count, &mut pickle)?;
        pickle.extend(b"tQK\0");
        for sizes in [array.shape(), &strides] {
            pickle.push(b'(');
            sizes.iter().try_for_each(|&size| number(size, &mut pickle))?;
            pickle.push(b't');
        }
        pickle.extend(b"\x89ccollections\nOrderedDict\n)RtRs");
    }
    pickle.push(b'.');
    archive.write_all(&pickle)?;
    archive.start_file("archive/byteorder", options)?;
    archive.write_all(b"little")?;
    for (key, (_, array)) in tensors.iter().enumerate() {
        archive.start_file(format!("archive/data/{key}"), options)?;
        // Values are written one by one.
        let mut entry = BufWriter::new(&mut archive);
        array.f32s().iter().try_for_each(|value| entry.write_all(&value.to_le_bytes()))?;
        entry.flush()?;
    }
    archive.start_file("archive/version", options)?;
    archive.write_all(b"3\n")?;
    archive.finish()?.flush()
}

/// Writes the arrays as tensors to a file; see [`write_pth`].
///
/// # Errors
/// As [`write_pth`]; an existing file is then unchanged.
pub fn save_pth(arrays: &NamedArrays, path: impl AsRef<Path>) -> io::Result<()> {
    write_atomically(path.as_ref(), |out| write_pth(arrays, out))
}

fn text(text: &str, pickle: &mut Vec<u8>) -> io::Result<()> {
    let length = u32::try_from(text.len()).map_err(io::Error::other)?;
    pickle.push(b'X');
    pickle.extend(length.to_le_bytes());
    pickle.extend(text.as_bytes());
    Ok(())
}

fn number(number: usize, pickle: &mut Vec<u8>) -> io::Result<()> {
    let number = i32::try_from(number).map_err(io::Error::other)?;
    pickle.push(b'J');
    pickle.extend(number.to_le_bytes());
    Ok(())
}
