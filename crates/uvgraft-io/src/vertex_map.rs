//! Vertex maps: for each vertex of a source mesh, the corresponding vertex of a target mesh.
//!
//! Read from NPY arrays and from plain text, written as NPY.

use std::io::{self, Write};
use std::path::Path;

use crate::integers::{self, IntegersError};
use crate::numpy::write_header;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_files::output::write_atomically;

/// Larger files are rejected by [`read`] before they are loaded.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Why the bytes of a vertex map were rejected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum VertexMapError {
    /// The map is empty.
    #[error("vertex map must have an integer for each source vertex, got an empty file")]
    Empty,
    /// It is not a list of integers.
    #[error(transparent)]
    Integers(#[from] IntegersError),
}

/// Reads a vertex map: `[source vertices]` of 0-based target vertex indices, -1 for none.
///
/// The format is detected from the content:
/// - NPY, by its magic: signed or unsigned integers of 8 to 64 bits and either byte order, in an
///   array of which at most one axis is longer than 1.
/// - Otherwise text: integers separated by whitespace or commas; `#` starts a comment.
///
/// Only the format is checked: whether the vertices exist depends on the meshes.
///
/// # Errors
/// [`VertexMapError`]; among others for floating-point values, even integral ones, for missing or
/// excess bytes, and for NPZ archives.
pub fn parse(bytes: &[u8]) -> Result<Vec<i64>, VertexMapError> {
    let ids = integers::parse(bytes)?;
    if ids.is_empty() { Err(VertexMapError::Empty) } else { Ok(ids) }
}

/// Reads a vertex map from a file, regardless of its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(input: impl Into<Input>) -> Result<Vec<i64>, ReadError<VertexMapError>> {
    input.into().parse(MAX_FILE_BYTES, parse)
}

/// Writes a vertex map as an NPY array, version 1.0: `[source vertices]` of `<i8`.
///
/// # Errors
/// Those of `out`.
pub fn write_npy(ids: &[u32], out: &mut impl Write) -> io::Result<()> {
    write_header("<i8", &[ids.len()], out)?;
    for &id in ids {
        out.write_all(&i64::from(id).to_le_bytes())?;
    }
    Ok(())
}

/// Writes a vertex map to an NPY file atomically; see [`write_npy`].
///
/// # Errors
/// Those of creating, writing and renaming the file; an existing file is then unchanged.
pub fn save_npy(ids: &[u32], path: impl AsRef<Path>) -> io::Result<()> {
    write_atomically(path.as_ref(), |out| write_npy(ids, out))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_tell_the_format() {
        let mut npy = Vec::new();
        write_npy(&[7, 0], &mut npy).unwrap();
        assert_eq!(parse(&npy).unwrap(), [7, 0]);
        assert_eq!(parse(b"7 0").unwrap(), [7, 0]);
        assert_eq!(parse(b"PK\x03\x04rest"), Err(VertexMapError::Integers(IntegersError::Archive)));
        let empty: [&[u8]; 4] = [b"", b" \n", b"# ids\n", b"\xef\xbb\xbf"];
        for bytes in empty {
            assert_eq!(parse(bytes), Err(VertexMapError::Empty));
        }
    }

    #[test]
    fn writes_what_numpy_writes() {
        let mut bytes = Vec::new();
        write_npy(&[10_000, 0, u32::MAX], &mut bytes).unwrap();
        let header =
            b"\x93NUMPY\x01\0\x76\0{'descr': '<i8', 'fortran_order': False, 'shape': (3,), }";
        assert_eq!(bytes[..header.len()], header[..]);
        assert_eq!(bytes[header.len()..127], vec![b' '; 127 - header.len()]);
        assert_eq!(bytes[127..144], *b"\n\x10\x27\0\0\0\0\0\0\0\0\0\0\0\0\0\0");
        assert_eq!(bytes[144..], *b"\xff\xff\xff\xff\0\0\0\0");
        assert_eq!(parse(&bytes).unwrap(), [10_000, 0, 4_294_967_295]);
    }

    #[test]
    fn no_bytes_make_it_panic() {
        const TEXT: &[u8] = b"# map\n1, 2, -1\r\n10 20\t30\n";
        const PIECES: [&[u8]; 14] = [
            b",",
            b"\n",
            b"#",
            b"-",
            b"9",
            b"(",
            b")",
            b"'",
            b"}",
            b"\\",
            b"\0",
            b"\xff",
            b"[[[[",
            b"99999999999999999999",
        ];
        let mut npy = Vec::new();
        write_npy(&[1, 2, 3], &mut npy).unwrap();
        let mut random = fastrand::Rng::with_seed(2);
        let mut accepted = [0; 2];
        for round in 0..40_000 {
            let mut bytes = [TEXT, &npy][round % 2].to_vec();
            for _ in 0..random.usize(1..3) {
                let at = random.usize(0..bytes.len());
                let end = random.usize(at..=bytes.len().min(at + 4));
                match random.u32(0..4) {
                    0 => bytes[at] = random.u8(..),
                    1 => drop(bytes.drain(at..end)),
                    2 => bytes.truncate(at.max(1)),
                    _ => drop(bytes.splice(at..end, random.choice(PIECES).unwrap().to_vec())),
                }
                if bytes.is_empty() {
                    break;
                }
            }
            accepted[round % 2] += usize::from(parse(&bytes).is_ok());
        }
        for accepted in accepted {
            let both_ways = (1_000..19_000).contains(&accepted);
            assert!(both_ways, "{accepted} accepted: not a test of both ways");
        }
        for _ in 0..10_000 {
            let noise: Vec<u8> = (0..random.usize(0..100)).map(|_| random.u8(..)).collect();
            let _ = parse(&noise);
            let _ = parse(&[&npy[..random.usize(6..=npy.len())], &noise].concat());
        }
    }

    #[test]
    fn files_are_named_in_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ids.npy");
        save_npy(&[3, 1, 2], &path).unwrap();
        assert_eq!(read(&path).unwrap(), [3, 1, 2]);
        std::fs::write(&path, "3\n1.5\n").unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(
            error.contains("ids.npy: line 2: must be an integer, got floating-point `1.5`"),
            "{error}"
        );
        let error = read(folder.path()).unwrap_err();
        assert!(matches!(error, ReadError::Io { .. }), "{error}");
    }
}
