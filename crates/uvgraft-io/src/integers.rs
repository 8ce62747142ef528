//! Lists of integers as written by mesh tools: NPY arrays and plain text.

mod npy;
mod text;

use crate::numpy::{HeaderError, NpyArray};

/// Why bytes were rejected as a list of integers. Lines and entries count from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IntegersError {
    /// An archive of several arrays.
    #[error("must be a single array, got an .npz archive: save the array you need as .npy")]
    Archive,
    /// A word in a text file is not an integer.
    #[error("line {line}: must be an integer, got `{found}`")]
    NotInteger {
        /// Which line.
        line: usize,
        /// What was found, shortened.
        found: String,
    },
    /// A number in a text file has a point or an exponent.
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
    /// An integer exceeds 64 bits.
    #[error("entry {entry}: must be a signed 64-bit integer, got {found}")]
    OutOfRange {
        /// Which entry of the list.
        entry: usize,
        /// What was found, shortened.
        found: String,
    },
    /// A comma without a value before it in a text file; skipping it would shift all other values.
    #[error("line {line}: comma without an integer before it")]
    MissingValue {
        /// Which line.
        line: usize,
    },
    /// The header of an NPY array is damaged, or of an unknown version.
    #[error(transparent)]
    NpyHeader(#[from] HeaderError),
    /// The array does not hold integers.
    #[error(
        "NPY array must have dtype {wanted}, got {found}; if it holds vertex indices, convert it \
         with .astype(\"int64\")"
    )]
    NpyDtype {
        /// The dtype in the header, shortened.
        found: String,
        /// The supported dtypes.
        wanted: &'static str,
    },
    /// The array is neither a list nor a single number.
    #[error("NPY array must have shape (N,), (N, 1) or (1, N), got {found}")]
    NpyShape {
        /// The shape in the header, shortened.
        found: String,
    },
    /// The number of values does not match the shape. Checked before anything is allocated.
    #[error("NPY array must have {wanted} bytes after the header, got {found}")]
    NpyLength {
        /// Bytes required by the shape and the dtype.
        wanted: u128,
        /// Bytes after the header.
        found: usize,
    },
}

/// The content of a list.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum List {
    Integers(Vec<i64>),
    /// An NPY array of bools.
    Mask(Vec<bool>),
}

/// Reads a list of integers, which may be empty.
///
/// The format is detected from the content:
/// - NPY, by its magic: signed or unsigned integers of 8 to 64 bits and either byte order, in an
///   array of which at most one axis is longer than 1.
/// - Otherwise text: integers separated by whitespace or commas; `#` starts a comment.
///
/// # Errors
/// [`IntegersError`]; among others for floating-point values, even integral ones, for missing or
/// excess bytes, and for NPZ archives.
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
