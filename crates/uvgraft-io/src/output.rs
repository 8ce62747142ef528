//! Outputs that are never half written: a temporary file beside the target, then a rename.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A file that appears at its path when it is committed. Dropped before, it leaves whatever was
/// there.
///
/// A symbolic link is followed, so that the file it names is replaced and the link stays; a file
/// that is replaced hands its permissions on.
#[derive(Debug)]
pub struct AtomicFile {
    file: NamedTempFile,
    target: PathBuf,
}

impl AtomicFile {
    /// Makes an empty temporary file beside `path`.
    ///
    /// # Errors
    /// What the system gives.
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = followed(path);
        let mut builder = tempfile::Builder::new();
        let builder = builder.prefix(".uvgraft-").suffix(".tmp");
        // Temporary files are private by default; an output is as public as the umask allows.
        #[cfg(unix)]
        let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
        let file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
        if let Ok(replaced) = target.metadata() {
            file.as_file().set_permissions(replaced.permissions())?;
        }
        Ok(Self { file, target })
    }

    /// With a buffer for small writes.
    pub fn buffered(self) -> BufWriter<Self> {
        BufWriter::with_capacity(1 << 20, self)
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// What the system gives; the place is unchanged then.
    pub fn commit(self) -> io::Result<()> {
        self.file.persist(&self.target).map_err(|error| error.error)?;
        Ok(())
    }
}

// Through the file itself, which keeps the temporary name out of error messages.
impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file_mut().flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.as_file_mut().seek(to)
    }
}

/// Writes a file through `fill`. A crash, an error or a kill leaves whatever was at `path` before;
/// see [`AtomicFile`].
///
/// # Errors
/// What creating, filling or renaming the temporary file gives; `path` is unchanged then.
pub fn write_atomically<E: From<io::Error>>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<AtomicFile>) -> Result<(), E>,
) -> Result<(), E> {
    let mut writer = AtomicFile::create(path)?.buffered();
    fill(&mut writer)?;
    writer.into_inner().map_err(io::IntoInnerError::into_error)?.commit()?;
    Ok(())
}

/// Where links lead, whether or not there is a file at the end.
fn followed(path: &Path) -> PathBuf {
    /// As many as Linux follows.
    const MOST_LINKS: usize = 40;
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = path.read_link() else { break };
        path = path.parent().unwrap_or(Path::new("")).join(next);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_litter() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        write_atomically::<io::Error>(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "disk full");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        symlink("file", &link).unwrap();
        // At first the link leads to nothing.
        for content in [b"old", b"new"] {
            write_atomically::<io::Error>(&link, |out| out.write_all(content)).unwrap();
            assert!(link.symlink_metadata().unwrap().is_symlink());
            assert_eq!(std::fs::read(&file).unwrap(), content);
            std::fs::set_permissions(&file, PermissionsExt::from_mode(0o640)).unwrap();
        }
        write_atomically::<io::Error>(&file, |out| out.write_all(b"last")).unwrap();
        assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o640);
    }
}
