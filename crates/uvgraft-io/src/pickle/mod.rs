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
mod calls;
mod class;
mod error;
mod globals;
mod machine;
mod node;
mod scan;
#[cfg(test)]
mod tests;
mod value;

pub use crate::numpy::{Dtype, NumberKind};
pub use array::Array;
pub use class::Object;
pub use error::{MAX_INSTRUCTIONS, PickleError};
pub use node::{Class, StorageKind};
pub use value::{Pickle, Value};

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
