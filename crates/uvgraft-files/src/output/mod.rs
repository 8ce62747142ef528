//! Atomic outputs: a temporary file on the target's file system, which then takes its place.
//!
//! Where the system can, temporary files have no name, so that nothing is left of a killed process.
//! Elsewhere, and for the moment in which a file replaces another, they have one next to the target;
//! those of killed processes are removed when the next output is made in that folder.

mod folder;
mod leftover;
mod unnamed;

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

pub use self::folder::TemporaryFolder;

/// A file that appears at its path when it is committed. If dropped before, an existing file is
/// unchanged.
///
/// Symbolic links are followed: the file they point to is replaced and the link is kept. A replaced
/// file passes on its permissions.
#[derive(Debug)]
pub struct AtomicFile {
    /// `None` once committed.
    file: Option<Temporary>,
    target: PathBuf,
}

#[derive(Debug)]
enum Temporary {
    Unnamed(File),
    /// Locked, so that no other process takes it for a leftover.
    Named(NamedTempFile),
}

impl Temporary {
    fn create(folder: &Path) -> io::Result<Self> {
        leftover::sweep_once(folder);
        match unnamed::create(folder)? {
            Some(file) => Ok(Self::Unnamed(file)),
            None => named_file(folder).map(Self::Named),
        }
    }

    fn file(&self) -> &File {
        match self {
            Self::Unnamed(file) => file,
            Self::Named(file) => file.as_file(),
        }
    }

    /// The path at which it would be left.
    fn path(&self) -> Option<&Path> {
        match self {
            Self::Unnamed(_) => None,
            Self::Named(file) => Some(file.path()),
        }
    }

    /// Moves the file into place. On failure it is removed.
    fn persist(self, target: &Path) -> io::Result<()> {
        match self {
            Self::Unnamed(mut file) => match unnamed::link(&file, target) {
                Ok(()) => Ok(()),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    replace(&file, target)
                }
                Err(_) => {
                    // The system can make such files, but not name them.
                    let mut copy = named_file(folder_of(target))?;
                    copy.as_file().set_permissions(file.metadata()?.permissions())?;
                    file.rewind()?;
                    io::copy(&mut file, &mut copy)?;
                    Self::Named(copy).persist(target)
                }
            },
            Self::Named(file) => file.persist(target).map(drop).map_err(|error| error.error),
        }
    }
}

/// Moves a file without a name to where there is one already, by way of a name next to it.
fn replace(file: &File, target: &Path) -> io::Result<()> {
    // The lock is that of the file, whatever its name; without locks it would only be left behind.
    let _ = file.try_lock();
    let linked = builder(&leftover::prefix(leftover::START))
        .make_in(folder_of(target), |path| unnamed::link(file, path))?;
    linked.persist(target).map_err(|error| error.error)
}

/// Creates an empty file with a name.
fn named_file(folder: &Path) -> io::Result<NamedTempFile> {
    let prefix = leftover::prefix(leftover::START);
    loop {
        let file = builder(&prefix).tempfile_in(folder)?;
        if leftover::lock(file.as_file(), file.path()) {
            return Ok(file);
        }
    }
}

fn builder(prefix: &str) -> tempfile::Builder<'_, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(leftover::END);
    // Temporary files are private by default; the permissions of an output follow the umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
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

    fn forget(&mut self, file: &Temporary) {
        if let Some(path) = file.path() {
            self.paths.retain(|other| other != path);
        }
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

/// The file that an output at `path` creates or replaces: where symbolic links lead, whether or not
/// there is a file.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] for links that lead to themselves, and those of the system for
/// names that it cannot have, such as one that is too long, and for folders that it does not show.
pub fn target_of(path: &Path) -> io::Result<PathBuf> {
    /// The same limit as in Linux.
    const MAX_LINKS: usize = 40;
    let mut target = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        let found = match target.symlink_metadata() {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(target),
            found => found?,
        };
        if !found.is_symlink() {
            return Ok(target);
        }
        let next = target.read_link()?;
        target = target.parent().unwrap_or(Path::new("")).join(next);
    }
    Err(io::Error::new(io::ErrorKind::InvalidInput, "symbolic links must not lead to themselves"))
}

/// Checks that files can be created in a folder, by creating one.
///
/// # Errors
/// Those of the system.
pub fn check_folder(folder: &Path) -> io::Result<()> {
    // Dropped as an output would be, so that nothing is left of it if the process is killed.
    AtomicFile::create(&folder.join("output")).map(drop)
}

/// The folder that a file is in, `.` for a mere name.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

impl AtomicFile {
    /// Creates an empty temporary file for `path`, and removes what killed processes left in its
    /// folder.
    ///
    /// # Errors
    /// Those of [`target_of`] and of the system, or [`io::ErrorKind::Interrupted`] after
    /// [`abandon_unfinished`].
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = target_of(path)?;
        let mut unfinished = unfinished();
        unfinished.check()?;
        let file = Temporary::create(folder_of(&target))?;
        unfinished.paths.extend(file.path().map(Path::to_owned));
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
        unfinished.forget(&file);
        // On failure the file is removed, still under the lock.
        file.persist(&self.target)
    }

    /// The file itself; using it directly keeps the temporary name out of error messages.
    fn file(&self) -> io::Result<&File> {
        self.file.as_ref().map(Temporary::file).ok_or(io::ErrorKind::NotFound.into())
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            let mut unfinished = unfinished();
            unfinished.forget(&file);
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

    #[cfg(unix)]
    #[test]
    fn links_that_lead_nowhere_are_refused() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let [one, two] = ["one", "two"].map(|name| folder.path().join(name));
        symlink("two", &one).unwrap();
        symlink("one", &two).unwrap();
        let error = write_atomically::<io::Error>(&one, |out| out.write_all(b"new")).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
        assert!(one.is_symlink() && two.is_symlink());
    }

    #[test]
    fn names_that_the_system_cannot_have_are_reported_first() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("n".repeat(300));
        assert!(AtomicFile::create(&path).is_err());
    }

    #[test]
    fn files_take_their_places_with_and_without_a_name_before() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("out");
        let entries = || folder.path().read_dir().unwrap().count();
        for content in [b"old", b"new"] {
            let mut named = named_file(folder.path()).unwrap();
            named.write_all(content).unwrap();
            Temporary::Named(named).persist(&target).unwrap();
            assert_eq!((std::fs::read(&target).unwrap(), entries()), (content.to_vec(), 1));
        }
        std::fs::remove_file(&target).unwrap();
        for content in [b"old", b"new"] {
            let Some(mut file) = unnamed::create(folder.path()).unwrap() else {
                eprintln!("skipped: the temporary folder has no files without names");
                return;
            };
            file.write_all(content).unwrap();
            assert!(entries() <= 1, "it has a name");
            Temporary::Unnamed(file).persist(&target).unwrap();
            assert_eq!((std::fs::read(&target).unwrap(), entries()), (content.to_vec(), 1));
        }
        // A folder cannot be replaced.
        let taken = folder.path().join("taken");
        std::fs::create_dir(&taken).unwrap();
        for file in [
            Temporary::Named(named_file(folder.path()).unwrap()),
            Temporary::create(folder.path()).unwrap(),
        ] {
            assert!(file.persist(&taken).is_err());
            assert_eq!(entries(), 2);
        }
    }
}
