//! Errors of array files, and the limits of reading them.

use uvgraft::listing;

use crate::obj::shown;
use crate::pickle::PickleError;

/// Larger files are rejected by [`read`](super::read) before they are loaded. The largest body
/// models have about 300 MB.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Maximum total size of an archive's unpacked entries, in bytes.
pub const MAX_UNPACKED_BYTES: u64 = 1 << 30;

/// Maximum total number of values in a file.
pub const MAX_NUMBERS: usize = 1 << 27;

/// Maximum number of values beyond one for each byte of the file, unpacked: a pickle may contain one array
/// under many names, a torch file may repeat values with a stride of 0, and sparse matrices become dense.
/// All joint regressors of a body model have about 600 thousand. As many as these take 16 MiB, and twice that
/// while they are read.
pub const MAX_REPEATED_NUMBERS: usize = 1 << 21;

/// Maximum number of values of a sparse matrix made dense: its shape is only a claim. Joint
/// regressors have about 600 thousand.
pub const MAX_DENSE_NUMBERS: usize = MAX_REPEATED_NUMBERS;

/// Maximum number of names in a file.
pub const MAX_NAMES: usize = 1 << 14;

/// What a file of a foreign format is, for [`ArraysError::Foreign`].
pub(crate) fn foreign_file(bytes: &[u8]) -> String {
    match bytes {
        [] => "an empty file".to_owned(),
        _ => format!("a file that starts with `{}`", shown(bytes)),
    }
}

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
    /// A pickle that is not plain data, or damaged.
    #[error(transparent)]
    Pickle(#[from] PickleError),
    /// The pickle does not hold arrays.
    #[error("the pickle must hold a dict of arrays by name, got {found}")]
    NotADict {
        /// What it holds.
        found: String,
    },
    /// The archive is damaged, or uses an unsupported compression.
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
        /// What is wrong with it.
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
    /// Two arrays have the same name.
    #[error("duplicate array name `{name}`")]
    Duplicate {
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
    /// The value of the name is not a supported array.
    #[error("array `{name}` cannot be used: {reason}")]
    Unusable {
        /// The requested name.
        name: String,
        /// Why.
        reason: String,
    },
}

/// Why a value was not read as an array.
#[derive(Debug)]
pub(crate) enum Unread {
    /// It is valid, but not an array: it is skipped, for this reason.
    Unusable(String),
    /// It is damaged, and so is the file.
    Broken(String),
    /// It exceeds a limit.
    Refused(ArraysError),
}

impl Unread {
    pub(crate) fn broken(problem: impl Into<String>) -> Self {
        Self::Broken(problem.into())
    }

    /// The error for an array that cannot be skipped.
    pub(crate) fn into_error(self, name: &str) -> ArraysError {
        match self {
            Self::Unusable(problem) | Self::Broken(problem) => ArraysError::array(name, problem),
            Self::Refused(error) => error,
        }
    }
}

impl ArraysError {
    pub(crate) fn array(name: &str, problem: impl Into<String>) -> Self {
        Self::Array { name: shown(name.as_bytes()), problem: problem.into() }
    }
}

/// Names for a message, printable.
pub(crate) fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    listing::listed(names.iter().map(|name| format!("`{}`", shown(name.as_bytes()))))
}
