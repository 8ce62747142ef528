//! Arrays by name, the form in which body models and motions are published: NumPy's NPZ archives,
//! and Python pickles of a dict.
//!
//! Pickles are parsed, never run; see [`crate::pickle`]. Torch files are read in the same form; see
//! [`crate::torch`].

pub(crate) mod archive;
pub(crate) mod collect;
pub(crate) mod error;
pub(crate) mod named;
pub(crate) mod npy;
mod npz;
pub(crate) mod numeric;
mod parse;
mod partial;
mod pieces;
mod sparse;
mod sparse_matrix;
mod write;

pub(crate) use self::error::listed;
pub use self::error::{
    ArraysError, MAX_DENSE_NUMBERS, MAX_FILE_BYTES, MAX_NAMES, MAX_NUMBERS, MAX_REPEATED_NUMBERS,
    MAX_UNPACKED_BYTES,
};
pub use self::named::NamedArrays;
pub use self::numeric::NumericArray;
pub use self::parse::{parse, parse_npy, read};
pub use self::partial::{ArrayFile, ArraySelection};
pub use self::sparse_matrix::{MAX_SPARSE_ELEMENTS, MAX_SPARSE_SIDE, SparseMatrix};
pub use self::write::{save_npz, save_npz_compressed, write_npz, write_npz_compressed};
pub(crate) use self::write::{stored_entry, write_text};
