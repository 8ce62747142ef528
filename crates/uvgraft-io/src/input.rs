//! Reads whole files within a limit, with the path in errors.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Why a file could not be read. `E` is the error of its content.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError<E: std::error::Error + 'static> {
    /// The file could not be opened or read.
    #[error("{}: {reason}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// The system's error.
        reason: io::Error,
    },
    /// The content was rejected.
    #[error("{}: {reason}", path.display())]
    Content {
        /// Which file.
        path: PathBuf,
        /// Why.
        reason: E,
    },
}

impl<E: std::error::Error> ReadError<E> {
    /// The same error with another error of the content.
    pub fn map_content<F: std::error::Error>(self, map: impl FnOnce(E) -> F) -> ReadError<F> {
        match self {
            Self::Io { path, reason } => ReadError::Io { path, reason },
            Self::Content { path, reason } => ReadError::Content { path, reason: map(reason) },
        }
    }
}

/// How a file of an unexpected format begins, as the end of an error message.
///
/// - `start`: the first few bytes, or all if there are fewer.
pub fn beginning(start: &[u8]) -> String {
    if start.is_empty() {
        "the file is empty".to_owned()
    } else {
        format!("starts with \"{}\"", start.escape_ascii())
    }
}

/// Reads a file of at most `max` bytes and parses it.
///
/// # Errors
/// [`ReadError`], also for a larger file, which is not read.
pub fn read_file<T, E: std::error::Error>(
    path: &Path,
    max: u64,
    parse: impl FnOnce(&[u8]) -> Result<T, E>,
) -> Result<T, ReadError<E>> {
    let bytes = read_at_most(path, max)
        .map_err(|reason| ReadError::Io { path: path.to_path_buf(), reason })?;
    parse(&bytes).map_err(|reason| ReadError::Content { path: path.to_path_buf(), reason })
}

/// The bytes of a file, or an error if there are more than `max`. The size reported by the system
/// is only a hint: a pipe has none, and a file may grow.
pub(crate) fn read_at_most(path: &Path, max: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let meta = file.metadata()?;
    if meta.is_dir() {
        return Err(io::Error::other("must be a file, but is a folder"));
    }
    let too_large =
        |size: u64| io::Error::other(format!("must have at most {max} bytes, got {size} or more"));
    if meta.len() > max {
        return Err(too_large(meta.len()));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(meta.len()).unwrap_or(usize::MAX).saturating_add(1))?;
    file.take(max + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max { Err(too_large(bytes.len() as u64)) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_file_and_keeps_the_bound() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("five");
        std::fs::write(&path, b"12345").unwrap();
        let length = |max| {
            read_file::<_, io::Error>(&path, max, |bytes| Ok(bytes.len()))
                .map_err(|error| error.to_string())
        };
        assert_eq!(length(5), Ok(5));
        let refused = length(4).unwrap_err();
        assert!(refused.contains("five") && refused.contains("got 5 or more"), "{refused}");
        let missing = read_file::<(), io::Error>(&folder.path().join("none"), 9, |_| Ok(()));
        assert!(missing.unwrap_err().to_string().contains("none"));
        let folder = read_file::<(), io::Error>(folder.path(), 9, |_| Ok(()));
        assert!(folder.unwrap_err().to_string().contains("folder"));
    }
}
