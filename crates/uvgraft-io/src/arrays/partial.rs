//! Partial reading of large files: only the requested arrays, and only their requested columns.
//!
//! The members of an NPZ are decoded as they are read, in chunks of 256 KiB, so that memory holds
//! no more than what was requested. A pickle must be read as a whole.

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use super::archive::Archive;
use super::error::{ArraysError, MAX_FILE_BYTES, MAX_UNPACKED_BYTES, Unread};
use super::named::Held;
use super::named::NamedArrays;
use super::npy;
use super::npz;
use super::parse::parse;
use super::pieces::{decode, unreadable};
use crate::numpy::MAGIC;
use uvgraft_files::input::{Input, ReadError};

/// Which part of an array is requested.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ArraySelection {
    /// Nothing: only its name is known.
    Nothing,
    /// All of it.
    All,
    /// These ranges of its last axis, ascending and disjoint. Indices beyond its length are
    /// ignored.
    Columns(Vec<Range<usize>>),
}

/// A file of arrays by name that can be read in part.
pub struct ArrayFile {
    name: PathBuf,
    content: Source,
}

enum Source {
    Zip(Archive<Box<dyn Zipped>>),
    /// The remaining arrays of a file that had to be read as a whole.
    Whole(NamedArrays),
}

/// A file, or bytes in memory.
trait Zipped: Read + Seek + Send + Sync {}

impl<T: Read + Seek + Send + Sync> Zipped for T {}

/// Maximum length of an NPY header that is read without its array.
const MAX_HEADER: u64 = 1 << 20;

impl ArrayFile {
    /// Opens a file; the formats are those of [`parse`].
    ///
    /// # Errors
    /// [`ReadError`] as [`read`](super::read).
    pub fn open(input: impl Into<Input>) -> Result<Self, ReadError<ArraysError>> {
        let input = input.into();
        let name = || input.name().to_path_buf();
        let zipped = zipped(&input).map_err(|reason| ReadError::Io { path: name(), reason })?;
        if let Some(zipped) = zipped {
            let archive = Archive::new(zipped, MAX_UNPACKED_BYTES)
                .map_err(|reason| ReadError::Content { path: name(), reason })?;
            if crate::torch::pickle_of(&archive).is_none() {
                return Ok(Self { name: name(), content: Source::Zip(archive) });
            }
        }
        let content = Source::Whole(input.parse(MAX_FILE_BYTES, parse)?);
        Ok(Self { name: name(), content })
    }

    /// Reads some of the arrays. Floats of 64 bits are rounded to 32. For files that had to be read
    /// as a whole, requested arrays are moved out.
    ///
    /// - `wanted`: the requested part of an array by its name and the lengths of its axes. Strings
    ///   have no axes.
    ///
    /// # Errors
    /// [`ReadError`] as [`read`](super::read); arrays that are not requested are not checked.
    pub fn read(
        &mut self,
        mut wanted: impl FnMut(&str, &[usize]) -> ArraySelection,
    ) -> Result<NamedArrays, ReadError<ArraysError>> {
        let found = match &mut self.content {
            Source::Zip(archive) => from_archive(archive, &mut wanted),
            Source::Whole(arrays) => from_memory(arrays, &mut wanted),
        };
        found.map_err(|reason| ReadError::Content { path: self.name.clone(), reason })
    }
}

/// What looks like a ZIP archive that can be read in part; `None` if it must be read as a whole.
fn zipped(input: &Input) -> io::Result<Option<Box<dyn Zipped>>> {
    let path = match input {
        Input::File(path) => path,
        Input::Bytes { bytes, .. } => {
            let is_zip = bytes.starts_with(b"PK") && bytes.len() as u64 <= MAX_FILE_BYTES;
            return Ok(is_zip.then(|| Box::new(Cursor::new(Arc::clone(bytes))) as Box<dyn Zipped>));
        }
    };
    let mut file = File::open(path)?;
    let metadata = file.metadata()?;
    // A pipe cannot be read twice, and the size limit is checked in one place.
    if !metadata.is_file() || metadata.len() > MAX_FILE_BYTES {
        return Ok(None);
    }
    let mut start = [0; 2];
    let is_zip = file.read(&mut start)? == 2 && start == *b"PK";
    Ok(is_zip.then(|| Box::new(BufReader::new(file)) as Box<dyn Zipped>))
}

fn from_memory(
    arrays: &mut NamedArrays,
    wanted: &mut dyn FnMut(&str, &[usize]) -> ArraySelection,
) -> Result<NamedArrays, ArraysError> {
    let (mut found, mut left) = (NamedArrays::new(), NamedArrays::new());
    for (name, held) in std::mem::take(arrays).into_entries() {
        let how = match &held {
            Held::Array(array) => wanted(&name, array.shape()),
            _ => wanted(&name, &[]),
        };
        match (how, held) {
            (ArraySelection::Nothing, held) => {
                found.hold(name.clone(), Held::Skipped);
                left.hold(name, held);
            }
            (ArraySelection::Columns(columns), Held::Array(array)) => {
                let array = array.narrowed().with_columns(&columns);
                found.hold(name.clone(), array.map_or(Held::Skipped, Held::Array));
                left.hold(name, Held::Skipped);
            }
            (_, held) => {
                let held = match held {
                    Held::Array(array) => Held::Array(array.narrowed()),
                    held => held,
                };
                found.hold(name.clone(), held);
                left.hold(name, Held::Skipped);
            }
        }
    }
    *arrays = left;
    Ok(found)
}

fn from_archive(
    archive: &mut Archive<Box<dyn Zipped>>,
    wanted: &mut dyn FnMut(&str, &[usize]) -> ArraySelection,
) -> Result<NamedArrays, ArraysError> {
    npz::each(archive, |archive, index, name, collector| {
        let found = archive.stream(index, |entry, size| {
            let mut header = Vec::new();
            read_header(entry, &mut header)?;
            let Some(described) = npy::describe(&header)? else {
                // Strings and objects are small, and always read as a whole.
                return Ok(if wanted(name, &[]) == ArraySelection::Nothing {
                    EntryContent::Held(Held::Skipped)
                } else {
                    entry.read_to_end(&mut header).map_err(|error| unreadable(&error))?;
                    EntryContent::Bytes(header)
                });
            };
            let columns = match wanted(name, &described.shape) {
                ArraySelection::Nothing => return Ok(EntryContent::Held(Held::Skipped)),
                ArraySelection::All => None,
                ArraySelection::Columns(columns) => Some(columns),
            };
            let values = size.saturating_sub(header.len() as u64);
            if described.bytes() != usize::try_from(values).ok() {
                return Err(described.other_size(values));
            }
            decode(entry, &described, columns.as_deref(), |count| collector.spend(count))
                .map(|array| EntryContent::Held(Held::Array(array)))
        })?;
        match found {
            Ok(EntryContent::Held(held)) => collector.hold(name, held),
            Ok(EntryContent::Bytes(bytes)) => npz::add(name, &bytes, collector)?,
            Err(unread) => collector.unread(name, unread)?,
        }
        Ok(())
    })
}

enum EntryContent {
    Held(Held),
    /// A whole NPY file.
    Bytes(Vec<u8>),
}

/// Reads everything before the values, including the magic.
fn read_header(entry: &mut dyn Read, header: &mut Vec<u8>) -> Result<(), Unread> {
    let mut more = |header: &mut Vec<u8>, count: u64| -> Result<(), Unread> {
        let before = header.len() as u64;
        let read = (&mut *entry).take(count).read_to_end(header);
        let read = read.map_err(|error| unreadable(&error))? as u64;
        if read < count {
            let problem = format!(
                "truncated: header must have {} bytes, got {}",
                before + count,
                before + read
            );
            return Err(Unread::Broken(problem));
        }
        Ok(())
    };
    more(header, MAGIC.len() as u64 + 4)?;
    let length = match header[MAGIC.len()..] {
        [1, _, a, b] => u64::from(u16::from_le_bytes([a, b])),
        [_, _, a, b] => {
            more(header, 2)?;
            let [.., c, d] = header[..] else { return Ok(()) };
            u64::from(u32::from_le_bytes([a, b, c, d]))
        }
        _ => return Ok(()),
    };
    if length > MAX_HEADER {
        let problem = format!("header must have at most {MAX_HEADER} bytes, got {length}");
        return Err(Unread::Broken(problem));
    }
    more(header, length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrays::{NumericArray, save_npz};

    /// A file with a table of 64-bit floats, one of integers and a string.
    fn file(name: &str) -> (tempfile::TempDir, PathBuf) {
        let mut arrays = NamedArrays::new();
        let values = (0..300_000).map(f64::from).collect();
        arrays.insert("wide", NumericArray::new_f64(vec![500, 3, 200], values).unwrap());
        arrays.insert("few", NumericArray::new_i64(vec![2, 2], vec![1, 2, 3, 4]).unwrap());
        arrays.insert_text("gender", "male");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        save_npz(&arrays, &path).unwrap();
        (folder, path)
    }

    #[test]
    fn only_what_is_asked_for_is_read() {
        let (_folder, path) = file("a.npz");
        only_what_is_asked_for(&path.clone().into());
        only_what_is_asked_for(&Input::bytes("a.npz", std::fs::read(&path).unwrap()));
    }

    fn only_what_is_asked_for(input: &Input) {
        let mut file = ArrayFile::open(input).unwrap();
        let mut shapes = Vec::new();
        let some = file.read(|name, shape| {
            shapes.push((name.to_owned(), shape.to_vec()));
            if name == "wide" {
                ArraySelection::Columns(vec![0..2, 150..151, 199..400])
            } else {
                ArraySelection::Nothing
            }
        });
        let some = some.unwrap();
        assert_eq!(shapes[0], ("wide".to_owned(), vec![500, 3, 200]));
        let wide = some.get("wide").unwrap();
        assert_eq!(wide.shape(), [500, 3, 4]);
        assert_eq!(wide.f32s()[..8], [0.0, 1.0, 150.0, 199.0, 200.0, 201.0, 350.0, 399.0]);
        assert_eq!(wide.f32s()[5999], 299_999.0);
        assert!(some.get("few").is_none() && some.text("gender").is_none());
        // Requested again, for the rest.
        let rest =
            file.read(
                |name, _| {
                    if name == "wide" { ArraySelection::Nothing } else { ArraySelection::All }
                },
            );
        let rest = rest.unwrap();
        assert_eq!(rest.get("few").unwrap().integers().unwrap(), [1, 2, 3, 4]);
        assert_eq!(rest.text("gender"), Some("male"));
        let why = rest.require("wide").unwrap_err().to_string();
        assert_eq!(why, "array `wide` cannot be used: it was not requested");
    }

    #[test]
    fn all_of_it_is_what_reading_the_whole_file_gives() {
        let (_folder, path) = file("a.npz");
        let all = ArrayFile::open(&path).unwrap().read(|_, _| ArraySelection::All).unwrap();
        let whole = super::super::read(&path).unwrap();
        for name in ["wide", "few"] {
            let (a, b) = (all.get(name).unwrap(), whole.get(name).unwrap());
            assert_eq!((a.shape(), a.f32s()), (b.shape(), b.f32s()), "{name}");
        }
    }

    #[test]
    fn damage_is_met_where_it_is_read() {
        let (_folder, path) = file("a.npz");
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[100_000] ^= 1;
        std::fs::write(&path, &bytes).unwrap();
        let mut file = ArrayFile::open(&path).unwrap();
        let error = file.read(|_, _| ArraySelection::All).unwrap_err().to_string();
        assert!(error.contains("a.npz: array `wide.npy`"), "{error}");
        let few = |name: &str, _: &[usize]| {
            if name == "few" { ArraySelection::All } else { ArraySelection::Nothing }
        };
        assert!(file.read(few).unwrap().get("few").is_some());
        bytes.truncate(bytes.len() / 2);
        std::fs::write(&path, &bytes).unwrap();
        let error = ArrayFile::open(&path).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("archive: truncated or damaged"), "{error}");
    }
}
