//! What is read: files, or bytes in memory; whole and within a limit, with the name in errors.

use std::borrow::Cow;
use std::fmt;
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file, or the bytes of one that is in memory already.
///
/// Every reader takes anything that converts into it: a path of any kind, or an `Input`.
#[derive(Clone, PartialEq, Eq, Hash)]
pub enum Input {
    /// A file of this path.
    File(PathBuf),
    /// The content of a file.
    Bytes {
        /// Stands for the path in messages, and where the extension of a file matters.
        name: PathBuf,
        /// All of its bytes.
        bytes: Arc<[u8]>,
    },
}

impl Input {
    /// The content of a file, which messages call `name`.
    pub fn bytes(name: impl Into<PathBuf>, bytes: impl Into<Arc<[u8]>>) -> Self {
        Self::Bytes { name: name.into(), bytes: bytes.into() }
    }

    /// The path, or the name that stands for it.
    pub fn name(&self) -> &Path {
        match self {
            Self::File(path) | Self::Bytes { name: path, .. } => path,
        }
    }

    /// The path, if it is a file.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Bytes { .. } => None,
        }
    }

    /// All bytes, at most `max` of them.
    ///
    /// # Errors
    /// The system's, for a file that cannot be read; and for more bytes, of which none are read.
    pub fn read(&self, max: u64) -> io::Result<Cow<'_, [u8]>> {
        match self {
            Self::File(path) => read_at_most(path, max).map(Cow::Owned),
            Self::Bytes { bytes, .. } if bytes.len() as u64 > max => {
                let found = bytes.len();
                Err(io::Error::other(format!("must have at most {max} bytes, got {found}")))
            }
            Self::Bytes { bytes, .. } => Ok(Cow::Borrowed(bytes)),
        }
    }

    /// Reads at most `max` bytes and parses them.
    ///
    /// # Errors
    /// [`ReadError`], with the name.
    pub fn parse<T, E: std::error::Error>(
        &self,
        max: u64,
        parse: impl FnOnce(&[u8]) -> Result<T, E>,
    ) -> Result<T, ReadError<E>> {
        let path = || self.name().to_path_buf();
        let bytes = self.read(max).map_err(|reason| ReadError::Io { path: path(), reason })?;
        parse(&bytes).map_err(|reason| ReadError::Content { path: path(), reason })
    }
}

impl<P: AsRef<Path>> From<P> for Input {
    fn from(path: P) -> Self {
        Self::File(path.as_ref().to_path_buf())
    }
}

impl From<&Input> for Input {
    fn from(input: &Input) -> Self {
        input.clone()
    }
}

/// The name, as messages show it.
impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.name().display().fmt(f)
    }
}

/// Without the bytes, which may be millions.
impl fmt::Debug for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => f.debug_tuple("File").field(path).finish(),
            Self::Bytes { name, bytes } => {
                f.debug_struct("Bytes").field("name", name).field("len", &bytes.len()).finish()
            }
        }
    }
}

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

/// A file that another file refers to, by a path within its folder: where it is, and its length in bytes.
///
/// Nothing is opened, so that a pipe cannot make the reader wait.
///
/// - `folder`: the folder of the file that refers to it; may be empty for the current one.
/// - `relative`: without `..`.
///
/// # Errors
/// The system's; also for what is no regular file, and for links to what is not in the folder or below.
pub fn find_within(folder: &Path, relative: &Path) -> io::Result<(PathBuf, u64)> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let path = folder.join(relative);
    let meta = path.metadata()?;
    if !meta.is_file() {
        let found = if meta.is_dir() { "folder" } else { "pipe or a device" };
        return Err(io::Error::other(format!("must be a file, but is a {found}")));
    }
    let found = path.canonicalize()?;
    if !found.starts_with(here.canonicalize()?) {
        let reason = "must be in the folder of the file that refers to it, or below, but is a link to a file elsewhere";
        return Err(io::Error::other(reason));
    }
    Ok((found, meta.len()))
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

/// The bytes of a file, or an error if there are more than `max`. The size reported by the system
/// is only a hint: a pipe has none, and a file may grow.
fn read_at_most(path: &Path, max: u64) -> io::Result<Vec<u8>> {
    let (file, meta) = open(path)?;
    read_rest(file, meta.len(), max)
}

/// Opens a file, or a pipe, but no folder; with what the system tells about it.
///
/// # Errors
/// The system's, and for a folder.
pub fn open(path: &Path) -> io::Result<(File, Metadata)> {
    let file = File::open(path)?;
    let meta = file.metadata()?;
    if meta.is_dir() {
        return Err(io::Error::other("must be a file, but is a folder"));
    }
    Ok((file, meta))
}

/// All bytes of an open file, or an error if there are more than `max`.
///
/// - `len`: its size as reported by the system.
///
/// # Errors
/// The system's, and for more bytes.
pub fn read_rest(file: File, len: u64, max: u64) -> io::Result<Vec<u8>> {
    let too_large =
        |size: u64| io::Error::other(format!("must have at most {max} bytes, got {size} or more"));
    if len > max {
        return Err(too_large(len));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(len).unwrap_or(usize::MAX).saturating_add(1))?;
    file.take(max + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max { Err(too_large(bytes.len() as u64)) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_read_as_files_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("five");
        std::fs::write(&path, b"12345").unwrap();
        for input in [Input::from(&path), Input::bytes("five", *b"12345")] {
            let all = |bytes: &[u8]| Ok::<_, io::Error>(bytes.to_vec());
            assert_eq!(input.parse(5, all).unwrap(), b"12345");
            let refused = input.parse(4, all).unwrap_err().to_string();
            assert!(refused.contains("five") && refused.contains("at most 4 bytes"), "{refused}");
        }
        assert_eq!(Input::from("a/b.png").path(), Some(Path::new("a/b.png")));
        assert_eq!(format!("{:?}", Input::bytes("x", [7; 99])), "Bytes { name: \"x\", len: 99 }");
    }

    #[cfg(unix)]
    #[test]
    fn what_files_refer_to_is_a_file_in_their_folder() {
        use std::os::unix::fs::symlink;
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("model");
        std::fs::create_dir_all(folder.join("below")).unwrap();
        for name in ["below/inner", "../outer"] {
            std::fs::write(folder.join(name), b"12345").unwrap();
        }
        symlink("below/inner", folder.join("to_inner")).unwrap();
        symlink("../outer", folder.join("to_outer")).unwrap();
        symlink("..", folder.join("up")).unwrap();
        symlink("/dev/null", folder.join("to_device")).unwrap();
        // A folder may be reached by a link itself.
        symlink("model", outer.path().join("linked")).unwrap();
        for folder in [folder, outer.path().join("linked")] {
            let found = |name: &str| {
                let found = find_within(&folder, Path::new(name));
                found.map(|(_, length)| length).map_err(|error| error.to_string())
            };
            assert_eq!((found("below/inner"), found("to_inner")), (Ok(5), Ok(5)));
            for (name, reason) in [
                ("to_outer", "a link to a file elsewhere"),
                ("up/outer", "a link to a file elsewhere"),
                ("to_device", "a pipe or a device"),
                ("below", "a folder"),
            ] {
                assert!(found(name).unwrap_err().ends_with(reason), "{name}: {:?}", found(name));
            }
            assert!(found("none").is_err());
        }
    }

    #[test]
    fn names_the_file_and_keeps_the_bound() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("five");
        std::fs::write(&path, b"12345").unwrap();
        let length = |max| {
            let length = |bytes: &[u8]| Ok::<_, io::Error>(bytes.len());
            Input::from(&path).parse(max, length).map_err(|error| error.to_string())
        };
        assert_eq!(length(5), Ok(5));
        let refused = length(4).unwrap_err();
        assert!(refused.contains("five") && refused.contains("got 5 or more"), "{refused}");
        let nothing = |_: &[u8]| Ok::<_, io::Error>(());
        let missing = Input::from(folder.path().join("none")).parse(9, nothing);
        assert!(missing.unwrap_err().to_string().contains("none"));
        let folder = Input::from(folder.path()).parse(9, nothing);
        assert!(folder.unwrap_err().to_string().contains("folder"));
    }
}
