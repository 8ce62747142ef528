//! What killed processes leave behind, and its removal.
//!
//! A temporary file with a name is locked while its process lives, so it is a leftover if its lock is
//! free. That is certain only within one running kernel, since some network file systems do not pass
//! locks on: names therefore contain a tag of the kernel. Files of other machines, and of the time
//! before a restart, are removed if they are also older than [`FOREIGN`]. Processes are never
//! identified by their numbers, which containers and machines that share a folder use twice.

use std::collections::HashSet;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

/// What the names of temporary files start and end with.
pub(super) const START: &str = ".uvgraft-";
pub(super) const END: &str = ".tmp";

/// What the names of temporary folders start with, and the name of the locked file in them.
pub(super) const FOLDER_START: &str = "uvgraft-";
pub(super) const FOLDER_LOCK: &str = ".lock";

/// The age from which temporary files of other kernels are removed.
const FOREIGN: Duration = Duration::from_secs(24 * 60 * 60);

/// A tag of the running kernel, which containers share; empty where it is unknown.
static KERNEL: LazyLock<String> = LazyLock::new(|| {
    let id = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    id.chars().filter(char::is_ascii_hexdigit).take(12).collect()
});

/// What the name of a temporary file or folder starts with.
///
/// - `start`: [`START`] or [`FOLDER_START`].
pub(super) fn prefix(start: &str) -> String {
    format!("{start}{}-", *KERNEL)
}

/// Removes the leftovers in a folder, the first time that the folder is given. Whatever cannot be
/// read or removed stays.
pub(super) fn sweep_once(folder: &Path) {
    static SWEPT: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    let swept = |folder: &Path| {
        let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
        swept.insert(folder.to_path_buf())
    };
    if swept(folder) {
        sweep(folder, START, END, remove_file);
    }
}

/// Removes temporary folders that killed processes left in a folder.
pub(super) fn sweep_folders(parent: &Path) {
    sweep(parent, FOLDER_START, "", |folder, is_ours| {
        let locked = is_unlocked(&folder.join(FOLDER_LOCK), is_ours);
        if locked.is_some() && folder.symlink_metadata().is_ok_and(|found| found.is_dir()) {
            let _ = std::fs::remove_dir_all(folder);
        }
    });
}

/// Calls `remove` with each entry whose name has the start and end, and whether it is of this kernel.
fn sweep(folder: &Path, start: &str, end: &str, remove: impl Fn(&Path, bool)) {
    let ours = (!KERNEL.is_empty()).then(|| prefix(start));
    for entry in folder.read_dir().into_iter().flatten().flatten() {
        let name = entry.file_name();
        if let Some(name) = name.to_str()
            && name.starts_with(start)
            && name.ends_with(end)
        {
            let is_ours = ours.as_ref().is_some_and(|ours| name.starts_with(ours));
            remove(&entry.path(), is_ours);
        }
    }
}

fn remove_file(path: &Path, is_ours: bool) {
    // It is removed while it is locked, so that a process that has just created it finds out.
    let remove = |locked: File| is_at(&locked, path).then(|| std::fs::remove_file(path));
    let _ = is_unlocked(path, is_ours).map(remove);
}

/// The file, locked, if nobody else has locked it and it is old enough to be removed.
fn is_unlocked(path: &Path, is_ours: bool) -> Option<File> {
    // Links, pipes and devices are not ours.
    let found = path.symlink_metadata().ok().filter(std::fs::Metadata::is_file)?;
    let age = SystemTime::now().duration_since(found.modified().ok()?).unwrap_or_default();
    if !is_ours && age < FOREIGN {
        return None;
    }
    // Some file systems lock only what may be written.
    let file = File::options().read(true).write(true).open(path).ok()?;
    file.try_lock().ok()?;
    Some(file)
}

/// Locks a file that was just created, so that it is not a leftover.
///
/// Returns whether it still has its name: another process may have taken it for one and removed it.
/// File systems without locks leave it unlocked, and then it stays if its process is killed.
pub(super) fn lock(file: &File, path: &Path) -> bool {
    match file.try_lock() {
        Ok(()) => is_at(file, path),
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => true,
    }
}

/// Whether a path names an open file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |found: std::fs::Metadata| (found.dev(), found.ino());
    let found = file.metadata().ok().map(identity);
    found.is_some() && found == path.symlink_metadata().ok().map(identity)
}

/// Elsewhere an open file cannot lose its name.
#[cfg(not(unix))]
fn is_at(_file: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a temporary file as by another process.
    fn create(folder: &Path, start: &str) -> (PathBuf, File) {
        let path = folder.join(format!("{start}abc{END}"));
        let file = File::create(&path).unwrap();
        (path, file)
    }

    fn age(file: &File, seconds: u64) {
        file.set_modified(SystemTime::now() - Duration::from_secs(seconds)).unwrap();
    }

    #[test]
    fn leftovers_go_and_files_in_use_stay() {
        let folder = tempfile::tempdir().unwrap();
        let (left, file) = create(folder.path(), &prefix(START));
        drop(file);
        let (used, lock) = create(folder.path(), &format!("{}used", prefix(START)));
        lock.lock().unwrap();
        let other = folder.path().join(".uvgraft-manifest.jsonl");
        std::fs::write(&other, "{}").unwrap();
        sweep_once(folder.path());
        assert_eq!(left.exists(), KERNEL.is_empty());
        assert!(used.exists() && other.exists());
        drop(lock);
        // Once per process.
        sweep_once(folder.path());
        assert!(used.exists());
    }

    #[test]
    fn those_of_other_machines_go_when_they_are_old() {
        let folder = tempfile::tempdir().unwrap();
        let (path, file) = create(folder.path(), ".uvgraft-0123456789ab-");
        age(&file, 23 * 3600);
        sweep(folder.path(), START, END, remove_file);
        assert!(path.exists());
        age(&file, 25 * 3600);
        file.lock().unwrap();
        sweep(folder.path(), START, END, remove_file);
        assert!(path.exists(), "it is in use");
        file.unlock().unwrap();
        // A clock that was set back does not make it young again.
        sweep(folder.path(), START, END, remove_file);
        assert!(!path.exists());
    }

    #[cfg(unix)]
    #[test]
    fn links_and_folders_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("mine");
        std::fs::write(&target, "mine").unwrap();
        let link = folder.path().join(format!("{}x{END}", prefix(START)));
        std::os::unix::fs::symlink(&target, &link).unwrap();
        let inner = folder.path().join(format!("{}y{END}", prefix(START)));
        std::fs::create_dir(&inner).unwrap();
        sweep_once(folder.path());
        assert!(target.exists() && link.is_symlink() && inner.is_dir());
    }

    #[test]
    fn folders_go_with_their_lock() {
        let parent = tempfile::tempdir().unwrap();
        let make = |name: &str| {
            let folder = parent.path().join(format!("{}{name}", prefix(FOLDER_START)));
            std::fs::create_dir(&folder).unwrap();
            let lock = File::create(folder.join(FOLDER_LOCK)).unwrap();
            std::fs::write(folder.join("data"), "data").unwrap();
            (folder, lock)
        };
        let (left, lock) = make("left");
        drop(lock);
        let (used, lock) = make("used");
        lock.lock().unwrap();
        let without = parent.path().join(format!("{}without", prefix(FOLDER_START)));
        std::fs::create_dir(&without).unwrap();
        sweep_folders(parent.path());
        assert_eq!(left.exists(), KERNEL.is_empty());
        assert!(used.exists() && without.exists());
    }
}
