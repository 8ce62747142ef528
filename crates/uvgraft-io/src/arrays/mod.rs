//! Arrays by name, as body models and motions are published: NumPy's NPZ archives, and Python pickles
//! of a dict.
//!
//! Pickles are read, never run; see [`crate::pickle`]. Torch's files give the same; see
//! [`crate::torch`].

pub(crate) mod archive;
pub(crate) mod collect;
pub(crate) mod error;
pub(crate) mod named;
mod npy;
mod npz;
pub(crate) mod numeric;
mod parse;
mod partial;
mod pieces;
mod sparse;
mod write;

pub use self::error::{
    ArraysError, MAX_FILE_BYTES, MOST_DENSE_NUMBERS, MOST_NAMES, MOST_NUMBERS, MOST_UNPACKED_BYTES,
};
pub use self::named::NamedArrays;
pub use self::numeric::NumericArray;
pub use self::parse::{parse, read};
pub use self::partial::{ArrayFile, ArraySelection};
pub use self::write::{save_npz, write_npz};
