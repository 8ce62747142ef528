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

/// A larger file is refused by [`read`] before it is loaded. The largest body models take some
/// 300 MB.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// As many bytes as the entries of an archive may have together when they are unpacked.
pub const MOST_UNPACKED_BYTES: u64 = 1 << 30;

/// As many numbers as all arrays of a file may have together. A pickle holds one array for any number
/// of names, and a torch file repeats its numbers by a stride of 0, so the bytes of the file are no
/// bound.
pub const MOST_NUMBERS: usize = 1 << 27;

/// As many numbers as a sparse matrix may have when it is made dense: its size is a claim. Joint
/// regressors have some 600 thousand.
pub const MOST_DENSE_NUMBERS: usize = 1 << 24;

/// As many names as a file may have.
pub const MOST_NAMES: usize = 1 << 14;

/// Names in an error that lists them.
const MOST_LISTED: usize = 64;

/// Why a file of arrays was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArraysError {
    /// Another kind of file.
    #[error("must be {wanted}, got {found}")]
    Foreign {
        /// What it looks like.
        found: String,
        /// What was wanted.
        wanted: &'static str,
    },
    /// A pickle that is not plain data, or damaged.
    #[error(transparent)]
    Pickle(#[from] PickleError),
    /// A pickle of something else than arrays.
    #[error("the pickle must hold a dict of arrays by name, got {found}")]
    NoDict {
        /// What was pickled.
        found: String,
    },
    /// An archive that is damaged, or packed in another way.
    #[error("archive: {problem}")]
    Archive {
        /// What is wrong.
        problem: String,
    },
    /// An array that is damaged.
    #[error("array `{name}`: {problem}")]
    Array {
        /// Its name, shortened.
        name: String,
        /// What was found, and what was wanted.
        problem: String,
    },
    /// More than any model or motion has.
    #[error("must have at most {most} {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The limit.
        most: u64,
    },
    /// Two arrays of one name.
    #[error("duplicate array name `{name}`")]
    Twice {
        /// The name, shortened.
        name: String,
    },
    /// There is no array of that name.
    #[error("no array `{name}`; the file has {}", listed(names))]
    Missing {
        /// The name that was asked for.
        name: String,
        /// The names that there are.
        names: Vec<String>,
    },
    /// What the file has under that name is no array that is read.
    #[error("array `{name}` cannot be used: {reason}")]
    LeftOut {
        /// The name that was asked for.
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

/// Reads arrays by name. The bytes tell the format:
/// - NPZ: a ZIP archive of NPY files, stored or deflated.
/// - A torch file: a ZIP archive with a `data.pkl`; see [`crate::torch::parse`].
/// - A pickle of any protocol, otherwise: a dict of arrays. Sparse matrices of SciPy become dense,
///   and arrays of chumpy become plain ones.
///
/// Numbers may be integers, bools, or floats of 16 to 64 bits, of either byte order and in C or
/// Fortran order; single numbers become arrays without axes, lists of numbers or of arrays of one
/// shape become arrays, and the keys of a dict in a dict follow its name and a dot. What is none of
/// these is left out, with a reason that [`NamedArrays::require`] tells.
///
/// # Errors
/// [`ArraysError`] for damaged files, for pickles that ask for anything but plain data, and beyond
/// the limits of this module.
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
        _ if bytes.starts_with(crate::numpy::MAGIC) => foreign("a single NPY array"),
        _ if bytes.starts_with(crate::torch::OLD_MAGIC) => Err(crate::torch::old()),
        // What a pickle begins with: its protocol, a mark, an empty dict or list, or a name.
        [0x80 | b'(' | b'}' | b']' | b'c', ..] => {
            let pickle = pickle::parse(bytes)?;
            Collector::new(None).collect(pickle.root())
        }
        _ => foreign(&format!("a file that starts with `{}`", shown(bytes))),
    }
}

/// Reads arrays by name from a file, whatever its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is refused by
/// [`parse`]. Each names the file.
pub fn read(path: &Path) -> Result<NamedArrays, ReadError<ArraysError>> {
    read_file(path, MAX_FILE_BYTES, parse)
}

/// Names for a message: printable, and not more than one can read.
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
