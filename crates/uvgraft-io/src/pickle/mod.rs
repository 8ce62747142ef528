//! Python pickles, as far as they are plain data: numbers, strings, containers, NumPy arrays, and
//! the constituents of SciPy's sparse matrices, chumpy arrays and torch tensors.
//!
//! A pickle is a program for a small machine that may call anything Python can import. Here the
//! program creates plain values and calls nothing: each imported name is looked up in a short list
//! (`globals.rs`), and an unknown one is an error. Protocols 0 to 5 are supported.
//!
//! Memory stays proportional to the pickle: lengths are checked against the available bytes,
//! strings and arrays borrow from them, the number of instructions is limited, and a value that is
//! referenced many times is stored once. Nothing here is recursive, so depth costs nothing.
//!
//! Source: the descriptions of instructions in Python's `pickletools`.

mod array;
mod class;
mod globals;
mod machine;
mod scan;
#[cfg(test)]
mod tests;
pub(crate) mod texts;
mod value;

pub(crate) use array::last_axis_fastest;
pub use array::{Array, Dtype, NumberKind};
pub use class::{Class, Made, StorageKind};
pub use value::{Pickle, Value};

/// Maximum number of instructions. Files of arrays have some thousands.
pub const MOST_INSTRUCTIONS: usize = 1 << 20;

/// Why a pickle was rejected. Positions count bytes from the start.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PickleError {
    /// It imports something that is not plain data.
    #[error("refused: the pickle imports {name}, but only plain data may be loaded")]
    Refused {
        /// Module and name, shortened.
        name: String,
    },
    /// The pickle is truncated.
    #[error("truncated pickle: byte {at} must be followed by {needed} bytes, got {left}")]
    Truncated {
        /// Where.
        at: usize,
        /// Bytes needed.
        needed: u64,
        /// Bytes left.
        left: usize,
    },
    /// An unknown instruction, or one that plain data does not need.
    #[error("byte {at} of the pickle: unsupported instruction 0x{found:02x}")]
    Instruction {
        /// Where.
        at: usize,
        /// Which.
        found: u8,
    },
    /// An instruction that does not fit the state of the machine.
    #[error("byte {at} of the pickle: {problem}")]
    Malformed {
        /// Start of the instruction.
        at: usize,
        /// What is wrong.
        problem: String,
    },
    /// More work than any file of arrays needs.
    #[error("pickle must have at most {most} {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The limit.
        most: usize,
    },
    /// Data follows the end.
    #[error("unexpected {count} bytes after the end of the pickle")]
    Trailing {
        /// How many bytes.
        count: usize,
    },
}

/// Reads a pickle; strings and arrays borrow from its bytes.
///
/// # Errors
/// [`PickleError`]; nothing in a pickle is ever run.
pub fn parse(bytes: &[u8]) -> Result<Pickle<'_>, PickleError> {
    machine::run(bytes, false)
}

/// As [`parse`], for pickles with persistent identifiers; see [`Value::persistent`].
///
/// # Errors
/// As [`parse`].
pub fn parse_with_outside(bytes: &[u8]) -> Result<Pickle<'_>, PickleError> {
    machine::run(bytes, true)
}
