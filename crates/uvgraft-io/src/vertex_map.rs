//! Vertex maps: for each vertex of a source mesh, the vertex of a target mesh that it is.
//!
//! Read from NumPy's NPY arrays and from plain text, written as NPY.

mod npy;
mod text;

use std::path::Path;

use crate::input::{ReadError, read_file};
use crate::npy::MAGIC;

pub use self::npy::{save_npy, write_npy};

/// A larger file is refused by [`read`] before it is loaded.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Why the bytes of a vertex map were refused. Lines and entries count from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VertexMapError {
    /// There is no vertex in the map.
    #[error("the vertex map is empty, wanted an integer for each source vertex")]
    Empty,
    /// Several arrays in one file, of which one is the map.
    #[error("found an .npz archive, wanted one array: extract the one you mean as .npy")]
    Archive,
    /// A word that is no integer, in a text file.
    #[error("line {line}: found `{found}`, wanted an integer")]
    NotInteger {
        /// Which line.
        line: usize,
        /// What was found, shortened.
        found: String,
    },
    /// A number with a point or an exponent, in a text file.
    #[error(
        "line {line}: found floating-point `{found}`, wanted an integer; \
         numpy.savetxt writes those with fmt=\"%d\""
    )]
    Float {
        /// Which line.
        line: usize,
        /// What was found, shortened.
        found: String,
    },
    /// An integer beyond 64 bits.
    #[error("entry {entry}: found {found}, wanted a signed 64-bit integer")]
    OutOfRange {
        /// Which entry of the map.
        entry: usize,
        /// What was found, shortened.
        found: String,
    },
    /// A comma without a value before it, in a text file: skipping it would shift all others.
    #[error("line {line}: found a comma with no integer before it")]
    MissingValue {
        /// Which line.
        line: usize,
    },
    /// An NPY file of a version that does not exist yet.
    #[error("NPY format version {major}.{minor} is not known, wanted 1.0, 2.0 or 3.0")]
    NpyVersion {
        /// First number of the version.
        major: u8,
        /// Second number of the version.
        minor: u8,
    },
    /// The file ends in the middle of its NPY header.
    #[error("NPY file cut short: header needs {wanted} bytes, file has {found}")]
    NpyCutShort {
        /// Bytes that the header claims, with what comes before it.
        wanted: u64,
        /// Bytes in the file.
        found: usize,
    },
    /// The header is not a Python dictionary of the three entries that describe an array.
    #[error("NPY header: found `{found}`, wanted {wanted}")]
    NpyHeader {
        /// Where it goes wrong, shortened.
        found: String,
        /// What should stand there.
        wanted: &'static str,
    },
    /// An array of something else than integers.
    #[error(
        "NPY array has dtype {found}, wanted integers (i1 to i8 or u1 to u8); \
         convert it with .astype(\"int64\") if it holds vertex numbers"
    )]
    NpyDtype {
        /// The dtype as the header has it, shortened.
        found: String,
    },
    /// An array that is not a list, or only a single number.
    #[error("NPY array has shape {found}, wanted (N,), (N, 1) or (1, N)")]
    NpyShape {
        /// The shape as the header has it, shortened.
        found: String,
    },
    /// Fewer or more values than the shape claims. Checked before anything is allocated.
    #[error("NPY array needs {wanted} bytes after the header, found {found}")]
    NpyLength {
        /// Bytes that the shape and the dtype ask for.
        wanted: u128,
        /// Bytes after the header.
        found: usize,
    },
}

/// Reads a vertex map: `[source vertices]` of target vertex ids from 0, -1 for "has none".
///
/// The bytes tell the format:
/// - NPY, by its magic: signed or unsigned integers of 8 to 64 bits and either byte order, in an
///   array of which at most one axis is longer than 1.
/// - Text, otherwise: integers separated by blanks, line ends or commas; `#` starts a comment.
///
/// Only the form is checked: whether the ids exist is for the meshes to say.
///
/// # Errors
/// [`VertexMapError`]; among others for floating-point values, even whole ones, for bytes missing or
/// left over, and for NPZ archives.
pub fn parse(bytes: &[u8]) -> Result<Vec<i64>, VertexMapError> {
    let ids = if let Some(rest) = bytes.strip_prefix(MAGIC) {
        npy::parse(rest)?
    } else if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        return Err(VertexMapError::Archive);
    } else {
        text::parse(bytes)?
    };
    if ids.is_empty() { Err(VertexMapError::Empty) } else { Ok(ids) }
}

/// Reads a vertex map from a file, whatever its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is refused by
/// [`parse`]. Each names the file.
pub fn read(path: &Path) -> Result<Vec<i64>, ReadError<VertexMapError>> {
    read_file(path, MAX_FILE_BYTES, parse)
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
        assert_eq!(parse(b"PK\x03\x04rest"), Err(VertexMapError::Archive));
        let empty: [&[u8]; 4] = [b"", b" \n", b"# ids\n", b"\xef\xbb\xbf"];
        for bytes in empty {
            assert_eq!(parse(bytes), Err(VertexMapError::Empty));
        }
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
        assert!(error.contains("ids.npy: line 2: found floating-point `1.5`, wanted"), "{error}");
        let error = read(folder.path()).unwrap_err();
        assert!(matches!(error, ReadError::Io { .. }), "{error}");
    }
}
