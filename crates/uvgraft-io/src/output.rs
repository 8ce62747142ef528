//! Atomic outputs: a temporary file next to the target, then a rename.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempDir};

/// A file that appears at its path when it is committed. If dropped before, an existing file is
/// unchanged.
///
/// Symbolic links are followed: the file they point to is replaced and the link is kept. A replaced
/// file passes on its permissions.
#[derive(Debug)]
pub struct AtomicFile {
    /// `None` once committed.
    file: Option<NamedTempFile>,
    target: PathBuf,
}

/// Temporary files of this process, to be removed on interruption.
///
/// Files are created, renamed and removed under this lock, so a thread that holds it never sees an
/// intermediate state.
static UNFINISHED: Mutex<Unfinished> =
    Mutex::new(Unfinished { paths: Vec::new(), folders: Vec::new(), is_abandoned: false });

struct Unfinished {
    paths: Vec<PathBuf>,
    folders: Vec<PathBuf>,
    is_abandoned: bool,
}

/// The list of paths stays valid after a panic.
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

/// Removes the temporary files of unfinished outputs and all temporary folders, and blocks new
/// outputs and commits from now on: for a process that is about to end.
pub fn abandon_unfinished() {
    let mut unfinished = unfinished();
    unfinished.is_abandoned = true;
    for path in unfinished.paths.drain(..) {
        // Nothing is left to report errors to.
        let _ = std::fs::remove_file(path);
    }
    for folder in unfinished.folders.drain(..) {
        /// A file created meanwhile keeps its folder from being removed, but only a few times.
        const TRIES: usize = 16;
        let _ = (0..TRIES).find(|_| std::fs::remove_dir_all(&folder).is_ok());
    }
}

/// A temporary folder in the system's temporary directory. It is removed on drop, or by
/// [`abandon_unfinished`].
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
}

impl TemporaryFolder {
    /// Creates an empty folder.
    ///
    /// # Errors
    /// Those of the system, or [`io::ErrorKind::Interrupted`] after [`abandon_unfinished`].
    pub fn create() -> io::Result<Self> {
        let mut unfinished = unfinished();
        unfinished.check()?;
        let folder = tempfile::Builder::new().prefix("uvgraft-").tempdir()?;
        unfinished.folders.push(folder.path().to_owned());
        Ok(Self { folder })
    }

    /// Its path.
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
    /// Creates an empty temporary file next to `path`.
    ///
    /// # Errors
    /// Those of the system, or [`io::ErrorKind::Interrupted`] after [`abandon_unfinished`].
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = followed(path);
        let mut builder = tempfile::Builder::new();
        let builder = builder.prefix(".uvgraft-").suffix(".tmp");
        // Temporary files are private by default; the permissions of an output follow the umask.
        #[cfg(unix)]
        let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
        let mut unfinished = unfinished();
        unfinished.check()?;
        let file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
        unfinished.paths.push(file.path().to_owned());
        drop(unfinished);
        // From here on, dropping it cleans up.
        let atomic = Self { file: Some(file), target };
        if let Ok(replaced) = atomic.target.metadata() {
            atomic.file()?.set_permissions(replaced.permissions())?;
        }
        Ok(atomic)
    }

    /// Adds a buffer for small writes.
    pub fn buffered(self) -> BufWriter<Self> {
        BufWriter::with_capacity(1 << 20, self)
    }

    /// Moves the file into place.
    ///
    /// # Errors
    /// Those of the system, or [`io::ErrorKind::Interrupted`] after [`abandon_unfinished`]; the
    /// target is then unchanged.
    pub fn commit(mut self) -> io::Result<()> {
        let mut unfinished = unfinished();
        unfinished.check()?;
        let Some(file) = self.file.take() else { return Ok(()) };
        unfinished.paths.retain(|path| path != file.path());
        // On failure the error owns the file, which is removed with it, still under the lock.
        file.persist(&self.target).map(drop).map_err(|error| error.error)
    }

    /// The file itself; using it directly keeps the temporary name out of error messages.
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

/// Writes a file through `fill`. After a crash, an error or a kill, an existing file at `path` is
/// unchanged; see [`AtomicFile`].
///
/// # Errors
/// Those of creating, filling or renaming the temporary file; `path` is then unchanged.
pub fn write_atomically<E: From<io::Error>>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<AtomicFile>) -> Result<(), E>,
) -> Result<(), E> {
    let mut writer = AtomicFile::create(path)?.buffered();
    fill(&mut writer)?;
    writer.into_inner().map_err(io::IntoInnerError::into_error)?.commit()?;
    Ok(())
}

/// The final target of links, whether or not it exists.
fn followed(path: &Path) -> PathBuf {
    /// The same limit as in Linux.
    const MAX_LINKS: usize = 40;
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
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
        // At first the link is dangling.
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
