//! Paths as files state them.

use std::io;
use std::path::{Component, Path, PathBuf};

use super::error::{ReadTrackingError, TrackingError};
use crate::obj::shown;
use uvgraft_files::input::ReadError;

/// What stated paths may reach. They are compared as written; links are the user's own and are
/// followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reach {
    /// The folder itself.
    Folder,
    /// Also the folders beside it: data sets that VHAP combines state `../OTHER/images/FILE`.
    Siblings,
}

/// The path that a file in `folder` states.
///
/// # Errors
/// [`TrackingError::Path`] for absolute paths, and for those that leave the reach.
pub(super) fn stated(
    folder: &Path,
    (frame, name): (usize, &'static str),
    path: &str,
    reach: Reach,
) -> Result<PathBuf, TrackingError> {
    let (within, mut above) = match reach {
        Reach::Folder => ("the folder", 0_usize),
        Reach::Siblings => ("the folder and those beside it", 1),
    };
    let refused = || {
        let found = shown(path.as_bytes());
        TrackingError::Path { frame, name, within, found }
    };
    let mut found = folder.to_owned();
    let mut parts = 0;
    for component in Path::new(path).components() {
        match component {
            Component::CurDir => {}
            Component::Normal(part) => {
                found.push(part);
                above += 1;
                parts += 1;
            }
            Component::ParentDir => {
                above = above.checked_sub(1).ok_or_else(refused)?;
                found.push(component);
            }
            Component::RootDir | Component::Prefix(_) => return Err(refused()),
        }
    }
    if parts == 0 { Err(refused()) } else { Ok(found) }
}

/// The path of an image, which must exist.
pub(super) fn existing(path: PathBuf) -> Result<PathBuf, ReadTrackingError> {
    match std::fs::metadata(&path) {
        Ok(meta) if meta.is_file() => Ok(path),
        Ok(_) => Err(ReadError::Io { path, reason: io::Error::other("must be a file") }),
        Err(reason) => Err(ReadError::Io { path, reason }),
    }
}

/// A path if there is such a file.
pub(super) fn optional(path: PathBuf) -> Option<PathBuf> {
    path.is_file().then_some(path)
}

/// The files of a folder with an extension, sorted by name.
///
/// # Errors
/// If the folder cannot be read.
pub(super) fn files_with(
    folder: &Path,
    extension: &str,
) -> Result<Vec<PathBuf>, ReadTrackingError> {
    let read = || -> io::Result<Vec<PathBuf>> {
        let mut found = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.extension().is_some_and(|found| found == extension) && path.is_file() {
                found.push(path);
            }
        }
        found.sort();
        Ok(found)
    };
    read().map_err(|reason| ReadError::Io { path: folder.to_owned(), reason })
}

/// The number that a file's name consists of, or ends in: 17 of `00017.png` and of `frame_17.png`.
pub(super) fn number(path: &Path) -> Option<u32> {
    let stem = path.file_stem()?.to_str()?;
    let start = stem
        .rfind(|character: char| !character.is_ascii_digit())
        .map_or(0, |at| at + stem[at..].chars().next().map_or(1, char::len_utf8));
    stem[start..].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_within_their_reach() {
        let at = |path: &str, reach| {
            stated(Path::new("data"), (3, "file_path"), path, reach)
                .map(|path| path.to_string_lossy().into_owned())
                .map_err(|error| error.to_string())
        };
        for reach in [Reach::Folder, Reach::Siblings] {
            assert_eq!(at("./images/1.png", reach), Ok("data/images/1.png".to_owned()));
            for outside in ["/etc/passwd", "../../x.png", "a/../../../x.png", "", ".", ".."] {
                assert!(at(outside, reach).is_err(), "{outside}");
            }
        }
        let sibling = "../other/images/1.png";
        assert_eq!(at(sibling, Reach::Siblings), Ok("data/../other/images/1.png".to_owned()));
        assert_eq!(at("a/../b.png", Reach::Folder), Ok("data/a/../b.png".to_owned()));
        assert_eq!(
            at(sibling, Reach::Folder).unwrap_err(),
            "frame 3: `file_path` must be a relative path within the folder, got \
             `../other/images/1.png`"
        );
    }

    #[test]
    fn numbers_of_names() {
        let number = |name: &str| number(Path::new(name));
        assert_eq!(number("a/00017.png"), Some(17));
        assert_eq!(number("frame_7.frame"), Some(7));
        assert_eq!(number("é3.png"), Some(3));
        assert_eq!(number("99999999999.png"), None);
        assert_eq!((number("1a.png"), number("")), (None, None));
    }
}
