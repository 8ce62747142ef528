//! Arrays by name, as body models and motions are published: NumPy's NPZ archives, and Python pickles
//! of a dict.
//!
//! Pickles are read, never run; see [`crate::pickle`]. Torch's files give the same; see
//! [`crate::torch`].

mod archive;
mod collect;
mod named;
mod npy;
mod npz;
mod numeric;
mod partial;
mod pieces;
mod sparse;
mod write;

use std::path::Path;

pub(crate) use self::archive::ArchiveInMemory;
pub(crate) use self::collect::{Collector, Outside, Unread};
pub use self::named::NamedArrays;
pub use self::numeric::NumericArray;
pub use self::partial::{ArrayFile, ArraySelection};
pub use self::write::{save_npz, write_npz};
use crate::input::{ReadError, read_file};
use crate::obj::shown;
use crate::pickle::{self, PickleError};

/// Larger files are rejected by [`read`] before they are loaded. The largest body models have about
/// 300 MB.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Maximum total size of the uncompressed entries of an archive.
pub const MOST_UNPACKED_BYTES: u64 = 1 << 30;

/// Maximum total number of values in a file. A pickle may contain one array under many names, and a
/// torch file may repeat values with a stride of 0, so the size of the file is no bound.
pub const MOST_NUMBERS: usize = 1 << 27;

/// Maximum number of values of a sparse matrix made dense, whose shape is only a claim. Joint
/// regressors have about 600 thousand.
pub const MOST_DENSE_NUMBERS: usize = 1 << 24;

/// Maximum number of names in a file.
pub const MOST_NAMES: usize = 1 << 14;

/// Maximum number of names listed in an error.
const MOST_LISTED: usize = 64;

/// Why a file of arrays was rejected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArraysError {
    /// The file has another format.
    #[error("must be {wanted}, got {found}")]
    Foreign {
        /// What it appears to be.
        found: String,
        /// What it must be.
        wanted: &'static str,
    },
    /// The pickle is damaged, or not plain data.
    #[error(transparent)]
    Pickle(#[from] PickleError),
    /// The pickle does not hold arrays.
    #[error("the pickle must hold a dict of arrays by name, got {found}")]
    NoDict {
        /// What it holds.
        found: String,
    },
    /// The archive is damaged, or uses another compression method.
    #[error("archive: {problem}")]
    Archive {
        /// What is wrong.
        problem: String,
    },
    /// An array is damaged.
    #[error("array `{name}`: {problem}")]
    Array {
        /// Its name, shortened.
        name: String,
        /// What it must be, and what it is.
        problem: String,
    },
    /// More than any model or motion needs.
    #[error("must have at most {most} {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The limit.
        most: u64,
    },
    /// Two arrays have the same name.
    #[error("duplicate array name `{name}`")]
    Twice {
        /// The name, shortened.
        name: String,
    },
    /// No array has the name.
    #[error("no array `{name}`; the file has {}", listed(names))]
    Missing {
        /// The requested name.
        name: String,
        /// The names in the file.
        names: Vec<String>,
    },
    /// The name refers to something other than a supported array.
    #[error("array `{name}` cannot be used: {reason}")]
    LeftOut {
        /// The requested name.
        name: String,
        /// Why.
        reason: String,
    },
}

impl ArraysError {
    pub(crate) fn array(name: &str, problem: impl Into<String>) -> Self {
        Self::Array { name: shown(name.as_bytes()), problem: problem.into() }
    }
}

/// Reads arrays by name. The format is detected from the content:
/// - NPZ: a ZIP archive of NPY files, stored or deflated.
/// - A torch file: a ZIP archive with a `data.pkl`; see [`crate::torch::parse`].
/// - Otherwise a pickle of any protocol: a dict of arrays. Sparse matrices of SciPy become dense,
///   and chumpy arrays become plain ones.
///
/// Values may be integers, bools, or floats of 16 to 64 bits, of either byte order and in C or
/// Fortran order. Scalars become arrays without axes, lists of numbers or of arrays of one shape
/// become arrays, and the keys of nested dicts are joined by dots. Anything else is skipped, with a
/// reason that [`NamedArrays::require`] reports.
///
/// # Errors
/// [`ArraysError`] for damaged files, for pickles that are not plain data, and beyond the limits of
/// this module.
pub fn parse(bytes: &[u8]) -> Result<NamedArrays, ArraysError> {
    parse_within(bytes, MOST_UNPACKED_BYTES)
}

fn parse_within(bytes: &[u8], most_unpacked: u64) -> Result<NamedArrays, ArraysError> {
    const WANTED: &str = "an NPZ archive or a pickle of arrays by name";
    let foreign =
        |found: &str| Err(ArraysError::Foreign { found: found.to_owned(), wanted: WANTED });
    match bytes {
        [b'P', b'K', ..] => {
            let mut archive = ArchiveInMemory::open(bytes, most_unpacked)?;
            if crate::torch::pickle_of(&archive).is_some() {
                return crate::torch::from_archive(&mut archive);
            }
            npz::read(&mut archive)
        }
        [] => foreign("an empty file"),
        _ if bytes.starts_with(crate::npy::MAGIC) => foreign("a single NPY array"),
        _ if bytes.starts_with(crate::torch::OLD_MAGIC) => Err(crate::torch::old()),
        // The first byte of a pickle: its protocol, a mark, an empty dict or list, or a name.
        [0x80 | b'(' | b'}' | b']' | b'c', ..] => {
            let pickle = pickle::parse(bytes)?;
            Collector::new(None).collect(pickle.root())
        }
        _ => foreign(&format!("a file that starts with `{}`", shown(bytes))),
    }
}

/// Reads arrays by name from a file, regardless of its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(path: &Path) -> Result<NamedArrays, ReadError<ArraysError>> {
    read_file(path, MAX_FILE_BYTES, parse)
}

/// Names for a message: printable, and not too many.
fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let mut text: Vec<String> = names
        .iter()
        .take(MOST_LISTED)
        .map(|name| format!("`{}`", shown(name.as_bytes())))
        .collect();
    if names.len() > MOST_LISTED {
        text.push(format!("{} more", names.len() - MOST_LISTED));
    }
    text.join(", ")
}
