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
pub use class::Made;
pub use error::{MOST_INSTRUCTIONS, PickleError};
pub use node::{Class, StorageKind};
pub use value::{Pickle, Value};

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
