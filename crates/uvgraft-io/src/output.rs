//! Outputs that are never half written: a temporary file beside the target, then a rename.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempDir};

/// A file that appears at its path when it is committed. Dropped before, it leaves whatever was
/// there.
///
/// A symbolic link is followed, so that the file it names is replaced and the link stays; a file
/// that is replaced hands its permissions on.
#[derive(Debug)]
pub struct AtomicFile {
    /// `None` once it is put in its place.
    file: Option<NamedTempFile>,
    target: PathBuf,
}

/// Temporary files of this process, so that they can be removed when it is told to stop.
///
/// Files are made, renamed and removed under this lock: whoever holds it sees none half way.
static UNFINISHED: Mutex<Unfinished> =
    Mutex::new(Unfinished { paths: Vec::new(), folders: Vec::new(), is_abandoned: false });

struct Unfinished {
    paths: Vec<PathBuf>,
    folders: Vec<PathBuf>,
    is_abandoned: bool,
}

/// A list of paths is as good after a panic as before.
fn unfinished() -> MutexGuard<'static, Unfinished> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Unfinished {
    fn check(&self) -> io::Result<()> {
        if self.is_abandoned {
            return Err(io::Error::new(io::ErrorKind::Interrupted, "outputs were abandoned"));
        }
        Ok(())
    }
}

/// Removes the temporary files of all outputs in the making and all temporary folders, and lets no
/// output begin or take its place from now on: for a process that is about to end.
pub fn abandon_unfinished() {
    let mut unfinished = unfinished();
    unfinished.is_abandoned = true;
    for path in unfinished.paths.drain(..) {
        // There is nobody left to tell.
        let _ = std::fs::remove_file(path);
    }
    for folder in unfinished.folders.drain(..) {
        /// A file that is made meanwhile keeps its folder from being removed, but not again: there
        /// are few of them.
        const TRIES: usize = 16;
        let _ = (0..TRIES).find(|_| std::fs::remove_dir_all(&folder).is_ok());
    }
}

/// A folder for files that nobody needs after this process, in the system's place for them. It goes
/// when this is dropped, or by [`abandon_unfinished`].
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
}

impl TemporaryFolder {
    /// Makes an empty folder.
    ///
    /// # Errors
    /// What the system gives, or [`io::ErrorKind::Interrupted`] after [`abandon_unfinished`].
    pub fn create() -> io::Result<Self> {
        let mut unfinished = unfinished();
        unfinished.check()?;
        let folder = tempfile::Builder::new().prefix("uvgraft-").tempdir()?;
        unfinished.folders.push(folder.path().to_owned());
        Ok(Self { folder })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        unfinished().folders.retain(|path| path != self.folder.path());
    }
}

impl AtomicFile {
    /// Makes an empty temporary file beside `path`.
    ///
    /// # Errors
    /// What the system gives, or [`io::ErrorKind::Interrupted`] after [`abandon_unfinished`].
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = followed(path);
        let mut builder = tempfile::Builder::new();
        let builder = builder.prefix(".uvgraft-").suffix(".tmp");
        // Temporary files are private by default; an output is as public as the umask allows.
        #[cfg(unix)]
        let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
        let mut unfinished = unfinished();
        unfinished.check()?;
        let file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
        unfinished.paths.push(file.path().to_owned());
        drop(unfinished);
        // From here on, dropping it tidies up.
        let atomic = Self { file: Some(file), target };
        if let Ok(replaced) = atomic.target.metadata() {
            atomic.file()?.set_permissions(replaced.permissions())?;
        }
        Ok(atomic)
    }

    /// With a buffer for small writes.
    pub fn buffered(self) -> BufWriter<Self> {
        BufWriter::with_capacity(1 << 20, self)
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// What the system gives, or [`io::ErrorKind::Interrupted`] after [`abandon_unfinished`]; the
    /// place is unchanged then.
    pub fn commit(mut self) -> io::Result<()> {
        let mut unfinished = unfinished();
        unfinished.check()?;
        let Some(file) = self.file.take() else { return Ok(()) };
        unfinished.paths.retain(|path| path != file.path());
        // Where this fails, the error holds the file, and the file is removed with it, still
        // under the lock.
        file.persist(&self.target).map(drop).map_err(|error| error.error)
    }

    /// The file itself, which keeps the temporary name out of error messages.
    fn file(&self) -> io::Result<&File> {
        self.file.as_ref().map(NamedTempFile::as_file).ok_or(io::ErrorKind::NotFound.into())
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            let mut unfinished = unfinished();
            unfinished.paths.retain(|path| path != file.path());
            drop(file);
        }
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file()?.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file()?.seek(to)
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
