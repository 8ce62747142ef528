//! Temporary folders.

use std::fs::File;
use std::io;
use std::path::Path;

use tempfile::TempDir;

use super::{leftover, unfinished};

/// A temporary folder in the system's temporary directory. It is removed on drop, or by
/// [`abandon_unfinished`](super::abandon_unfinished).
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
    /// Locked, so that no other process takes the folder for a leftover.
    _lock: File,
}

impl TemporaryFolder {
    /// Creates a folder without visible files, and removes those that killed processes left.
    ///
    /// # Errors
    /// Those of the system, or [`io::ErrorKind::Interrupted`] after [`abandon_unfinished`](super::abandon_unfinished).
    pub fn create() -> io::Result<Self> {
        let mut unfinished = unfinished();
        unfinished.check()?;
        leftover::sweep_folders(&std::env::temp_dir());
        let prefix = leftover::prefix(leftover::FOLDER_START);
        let folder = loop {
            let folder = tempfile::Builder::new().prefix(&prefix).tempdir()?;
            let path = folder.path().join(leftover::FOLDER_LOCK);
            let lock = File::create(&path)?;
            if leftover::lock(&lock, &path) {
                break Self { folder, _lock: lock };
            }
        };
        unfinished.folders.push(folder.path().to_owned());
        Ok(folder)
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
