//! Why a file of arrays was refused, and how much of one is read at most.

use crate::obj::shown;
use crate::pickle::PickleError;

/// A larger file is refused by [`read`](super::read) before it is loaded. The largest body models take some
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

/// Why something is no array.
#[derive(Debug)]
pub(crate) enum Unread {
    /// It is sound, and something else: it is left out, for that reason.
    LeftOut(String),
    /// It is damaged, and so is the file.
    Broken(String),
    /// It is too much.
    Refused(ArraysError),
}

impl ArraysError {
    pub(crate) fn array(name: &str, problem: impl Into<String>) -> Self {
        Self::Array { name: shown(name.as_bytes()), problem: problem.into() }
    }
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
