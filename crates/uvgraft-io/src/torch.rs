//! Torch files: a ZIP archive with a pickle of tensors, and a file for each storage of values.
//!
//! The pickle is parsed, never run; see [`crate::pickle`].
//!
//! Source: `torch.save` since version 1.6: `NAME/data.pkl` refers to `NAME/data/KEY` by persistent
//! identifiers `("storage", class, KEY, device, count)`; `NAME/byteorder` is `little` or `big`.

mod tensor;
mod write;

use std::io::{Read, Seek};

use self::tensor::Storages;
pub use self::write::{save_pth, write_pth};
use crate::arrays::archive::{Archive, ArchiveInMemory};
use crate::arrays::collect::Collector;
use crate::arrays::error::{ArraysError, MAX_FILE_BYTES, MAX_UNPACKED_BYTES, foreign_file};
use crate::arrays::named::NamedArrays;
use crate::obj::shown;
use crate::pickle;
use uvgraft_files::input::{Input, ReadError};

const WANTED: &str = "a torch.save file of tensors";

/// The start of files from before version 1.6: a pickle of one large number.
pub(crate) const OLD_MAGIC: &[u8] = b"\x80\x02\x8a\x0al\xfc\x9cF\xf9 j\xa8P\x19.";

fn foreign(found: &str) -> ArraysError {
    ArraysError::Foreign { found: found.to_owned(), wanted: WANTED }
}

pub(crate) fn old() -> ArraysError {
    foreign(
        "a torch file from before version 1.6 (to convert it, load it in Python and save it again)",
    )
}

/// Reads the tensors of a file written by `torch.save`: those of a dict by name, those of nested
/// dicts with names joined by dots, a single tensor under an empty name. Floats of 16 bits become
/// 32-bit ones. Numbers and strings of the dict are read too; see [`crate::arrays::parse`].
///
/// # Errors
/// [`ArraysError`] for damaged files, for pickles that are not tensors and plain data, for
/// TorchScript and for files from before version 1.6.
pub fn parse(bytes: &[u8]) -> Result<NamedArrays, ArraysError> {
    if bytes.starts_with(OLD_MAGIC) {
        return Err(old());
    }
    if !bytes.starts_with(b"PK") {
        return Err(foreign(&foreign_file(bytes)));
    }
    from_archive(&mut ArchiveInMemory::open(bytes, MAX_UNPACKED_BYTES)?)
}

/// Reads the tensors of a file; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(input: impl Into<Input>) -> Result<NamedArrays, ReadError<ArraysError>> {
    input.into().parse(MAX_FILE_BYTES, parse)
}

/// The entry of an archive that is the pickle, if any.
pub(crate) fn pickle_of<R: Read + Seek>(archive: &Archive<R>) -> Option<usize> {
    let is_pickle = |name: &String| name == "data.pkl" || name.ends_with("/data.pkl");
    archive.names().iter().position(is_pickle)
}

pub(crate) fn from_archive(archive: &mut ArchiveInMemory<'_>) -> Result<NamedArrays, ArraysError> {
    let Some(index) = pickle_of(archive) else {
        return Err(foreign("an archive without data.pkl"));
    };
    let folder = archive.names()[index].strip_suffix("data.pkl").unwrap_or_default().to_owned();
    let code = [format!("{folder}constants.pkl"), format!("{folder}code/")];
    if archive.names().iter().any(|name| *name == code[0] || name.starts_with(&code[1])) {
        return Err(foreign("a TorchScript program"));
    }
    let order = format!("{folder}byteorder");
    let big_endian = match archive.names().iter().position(|name| *name == order) {
        // Before version 2.1 there was none, and values had the byte order of the machine.
        None => false,
        Some(index) => match &archive.read(index)?[..] {
            b"little" => false,
            b"big" => true,
            found => {
                let found = format!("byte order must be little or big, got `{}`", shown(found));
                return Err(ArraysError::array("byteorder", found));
            }
        },
    };
    let (bytes, unpacked) = (archive.read(index)?, archive.unpacked());
    let pickle = pickle::parse_with_outside(&bytes)?;
    let mut storages = Storages::new(archive, &folder, big_endian);
    Collector::new(Some(&mut storages), unpacked).collect(pickle.root())
}
