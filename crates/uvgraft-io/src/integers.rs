//! Lists of integers as tools for meshes write them: NumPy's NPY arrays and plain text.

mod npy;
mod text;

use crate::numpy::NpyArray;

/// Why bytes were refused as a list of integers. Lines and entries count from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IntegersError {
    /// Several arrays in one file, of which one is the map.
    #[error("must be a single array, got an .npz archive: save the array you need as .npy")]
    Archive,
    /// A word that is no integer, in a text file.
    #[error("line {line}: must be an integer, got `{found}`")]
    NotInteger {
        /// Which line.
        line: usize,
        /// What was found, shortened.
        found: String,
    },
    /// A number with a point or an exponent, in a text file.
    #[error(
        "line {line}: must be an integer, got floating-point `{found}`; with numpy.savetxt, use \
         fmt=\"%d\""
    )]
    Float {
        /// Which line.
        line: usize,
        /// What was found, shortened.
        found: String,
    },
    /// An integer beyond 64 bits.
    #[error("entry {entry}: must be a signed 64-bit integer, got {found}")]
    OutOfRange {
        /// Which entry of the list.
        entry: usize,
        /// What was found, shortened.
        found: String,
    },
    /// A comma without a value before it, in a text file: skipping it would shift all others.
    #[error("line {line}: comma without an integer before it")]
    MissingValue {
        /// Which line.
        line: usize,
    },
    /// An NPY file of a version that does not exist yet.
    #[error("NPY format version must be 1.0, 2.0 or 3.0, got {major}.{minor}")]
    NpyVersion {
        /// First number of the version.
        major: u8,
        /// Second number of the version.
        minor: u8,
    },
    /// The file ends in the middle of its NPY header.
    #[error("truncated NPY file: header must have {wanted} bytes, got {found}")]
    NpyCutShort {
        /// Bytes that the header claims, with what comes before it.
        wanted: u64,
        /// Bytes in the file.
        found: usize,
    },
    /// The header is not a Python dictionary of the three entries that describe an array.
    #[error("NPY header: must have {wanted}, got `{found}`")]
    NpyHeader {
        /// Where it goes wrong, shortened.
        found: String,
        /// What should stand there.
        wanted: &'static str,
    },
    /// An array of something else than integers.
    #[error(
        "NPY array must have dtype {wanted}, got {found}; if it holds vertex indices, convert it \
         with .astype(\"int64\")"
    )]
    NpyDtype {
        /// The dtype as the header has it, shortened.
        found: String,
        /// The dtypes that are read.
        wanted: &'static str,
    },
    /// An array that is not a list, or only a single number.
    #[error("NPY array must have shape (N,), (N, 1) or (1, N), got {found}")]
    NpyShape {
        /// The shape as the header has it, shortened.
        found: String,
    },
    /// Fewer or more values than the shape claims. Checked before anything is allocated.
    #[error("NPY array must have {wanted} bytes after the header, got {found}")]
    NpyLength {
        /// Bytes that the shape and the dtype ask for.
        wanted: u128,
        /// Bytes after the header.
        found: usize,
    },
}

/// What a list holds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum List {
    Integers(Vec<i64>),
    /// An NPY array of bools.
    Mask(Vec<bool>),
}

/// Reads a list of integers, which may be empty.
///
/// The bytes tell the format:
/// - NPY, by its magic: signed or unsigned integers of 8 to 64 bits and either byte order, in an
///   array of which at most one axis is longer than 1.
/// - Text, otherwise: integers separated by blanks, line ends or commas; `#` starts a comment.
///
/// # Errors
/// [`IntegersError`]; among others for floating-point values, even whole ones, for bytes missing or
/// left over, and for NPZ archives.
pub(crate) fn parse(bytes: &[u8]) -> Result<Vec<i64>, IntegersError> {
    if let Some(array) = NpyArray::parse(bytes) {
        npy::integers(&array?)
    } else if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        Err(IntegersError::Archive)
    } else {
        text::parse(bytes)
    }
}

/// As [`parse`], and NPY arrays of bools.
pub(crate) fn parse_or_mask(bytes: &[u8]) -> Result<List, IntegersError> {
    match NpyArray::parse(bytes) {
        Some(array) => npy::integers_or_mask(&array?),
        None => parse(bytes).map(List::Integers),
    }
}
