//! Files without a name, which vanish with the process that made them, however it ends.

use std::fs::File;
use std::io;
use std::path::Path;

/// Creates an empty file without a name in a folder; `None` where the system or the file system
/// cannot give it a name later.
#[cfg(any(target_os = "linux", target_os = "android"))]
pub(super) fn create(folder: &Path) -> io::Result<Option<File>> {
    use rustix::fs::{Mode, OFlags};
    use rustix::io::Errno;
    // They get their names through this folder.
    if !Path::new("/proc/self/fd").is_dir() {
        return Ok(None);
    }
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    match rustix::fs::open(folder, flags, Mode::from_raw_mode(0o666)) {
        Ok(file) => Ok(Some(file.into())),
        // What systems and file systems without such files say.
        Err(Errno::OPNOTSUPP | Errno::INVAL | Errno::ISDIR | Errno::NOENT | Errno::NOSYS) => {
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

/// Gives a file a name, unless there is a file of that name.
#[cfg(any(target_os = "linux", target_os = "android"))]
pub(super) fn link(file: &File, path: &Path) -> io::Result<()> {
    use std::os::fd::AsRawFd;

    use rustix::fs::{AtFlags, CWD};
    let from = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(rustix::fs::linkat(CWD, from, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android")))]
pub(super) fn create(_folder: &Path) -> io::Result<Option<File>> {
    Ok(None)
}

#[cfg(not(any(target_os = "linux", target_os = "android")))]
pub(super) fn link(_file: &File, _path: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
