//! Files of arrays by name, in any supported format.

use super::archive::ArchiveInMemory;
use super::collect::Collector;
use super::error::{ArraysError, MAX_FILE_BYTES, MAX_UNPACKED_BYTES, foreign_file};
use super::named::NamedArrays;
use super::npz;
use super::numeric::NumericArray;
use crate::pickle;
use uvgraft_files::input::{Input, ReadError};

/// Reads arrays by name. The format is detected from the content:
/// - NPZ: a ZIP archive of NPY files, stored or deflated.
/// - A torch file: a ZIP archive with a `data.pkl`; see [`crate::torch::parse`].
/// - Otherwise a pickle of any protocol: a dict of arrays. SciPy's sparse matrices become dense,
///   and chumpy's arrays become plain ones.
///
/// Values may be integers, bools, or floats of 16 to 64 bits, of either byte order and in C or
/// Fortran order. Single numbers become arrays without axes, lists of numbers or of arrays of one
/// shape become arrays, and the keys of a nested dict are appended to its name with a dot.
/// Everything else is skipped, with a reason that [`NamedArrays::require`] reports.
///
/// # Errors
/// [`ArraysError`] for damaged files, for pickles that are not plain data, and beyond the limits of
/// this module.
pub fn parse(bytes: &[u8]) -> Result<NamedArrays, ArraysError> {
    parse_within(bytes, MAX_UNPACKED_BYTES)
}

/// Reads the numeric array of an NPY file. Its name in errors is `array`.
///
/// # Errors
/// [`ArraysError`] for a damaged file, for anything but numbers, and beyond [`MAX_NUMBERS`].
///
/// [`MAX_NUMBERS`]: super::MAX_NUMBERS
pub fn parse_npy(bytes: &[u8]) -> Result<NumericArray, ArraysError> {
    const NAME: &str = "array";
    let mut collector = Collector::new(None, bytes.len());
    npz::add(NAME, bytes, &mut collector)?;
    let mut arrays = collector.finish();
    arrays.require(NAME)?;
    arrays.take(NAME).ok_or_else(|| ArraysError::array(NAME, "is not numeric"))
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
        _ if bytes.starts_with(crate::numpy::MAGIC) => foreign("a single NPY array"),
        _ if bytes.starts_with(crate::torch::OLD_MAGIC) => Err(crate::torch::old()),
        // The possible first bytes of a pickle: its protocol, a mark, an empty dict or list, or a
        // name.
        [0x80 | b'(' | b'}' | b']' | b'c', ..] => {
            let pickle = pickle::parse(bytes)?;
            Collector::new(None, bytes.len()).collect(pickle.root())
        }
        _ => foreign(&foreign_file(bytes)),
    }
}

/// Reads arrays by name from a file, regardless of its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(input: impl Into<Input>) -> Result<NamedArrays, ReadError<ArraysError>> {
    input.into().parse(MAX_FILE_BYTES, parse)
}
