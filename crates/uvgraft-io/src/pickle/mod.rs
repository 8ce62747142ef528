//! Python pickles, as far as they are data: numbers, texts, containers, NumPy arrays, and what SciPy's
//! sparse matrices, chumpy's arrays and torch's tensors consist of.
//!
//! A pickle is a program for a small machine that may call whatever Python can import. Here the
//! program builds plain values and calls nothing: each name that it asks for is looked up in a short
//! list (`globals.rs`), and one that is not there ends the reading. Protocols 0 to 5 are read.
//!
//! Memory stays in proportion to the pickle: lengths are checked against the bytes at hand, texts
//! and arrays borrow from them, the number of instructions has a limit, and a value that is referred
//! to many times is held once. Nothing here recurses, so depth costs nothing.
//!
//! Source: the instructions' descriptions in Python's `pickletools`.

mod array;
mod class;
mod globals;
mod machine;
mod scan;
#[cfg(test)]
mod tests;
mod value;

pub use crate::numpy::{Dtype, NumberKind};
pub use array::Array;
pub use class::{Class, Made, StorageKind};
pub use value::{Pickle, Value};

/// As many instructions as a pickle may have. Files of arrays have some thousands.
pub const MOST_INSTRUCTIONS: usize = 1 << 20;

/// Why a pickle was refused. Places count bytes from the start.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PickleError {
    /// It asks for something of Python that is not plain data.
    #[error("refused: the pickle imports {name}, but only plain data may be loaded")]
    Refused {
        /// Module and name, shortened.
        name: String,
    },
    /// The bytes end too early.
    #[error("truncated pickle: byte {at} must be followed by {needed} bytes, got {left}")]
    Truncated {
        /// Where.
        at: usize,
        /// How many bytes must follow.
        needed: u64,
        /// How many follow.
        left: usize,
    },
    /// An instruction that does not exist, or that plain data does not need.
    #[error("byte {at} of the pickle: unsupported instruction 0x{found:02x}")]
    Instruction {
        /// Where.
        at: usize,
        /// Which.
        found: u8,
    },
    /// An instruction that does not fit what came before it.
    #[error("byte {at} of the pickle: {problem}")]
    Malformed {
        /// Where the instruction starts.
        at: usize,
        /// What was found, and what was wanted.
        problem: String,
    },
    /// More work than any file of arrays takes.
    #[error("pickle must have at most {most} {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The limit.
        most: usize,
    },
    /// Something follows the end.
    #[error("unexpected {count} bytes after the end of the pickle")]
    Trailing {
        /// How many bytes.
        count: usize,
    },
}

/// Reads a pickle; texts and arrays borrow from its bytes.
///
/// # Errors
/// [`PickleError`]; nothing that a pickle holds is ever run.
pub fn parse(bytes: &[u8]) -> Result<Pickle<'_>, PickleError> {
    machine::run(bytes, false)
}

/// As [`parse`], for pickles that refer to what lies outside of them; see [`Value::persistent`].
///
/// # Errors
/// As [`parse`].
pub fn parse_with_outside(bytes: &[u8]) -> Result<Pickle<'_>, PickleError> {
    machine::run(bytes, true)
}
