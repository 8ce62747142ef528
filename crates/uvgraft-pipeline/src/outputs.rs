//! Outputs that are checked before any work is done.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::failure::{Failure, Result};

/// Outputs that were found to be writable, each a file of its own that is none of the inputs.
pub struct Outputs {
    inputs: HashSet<PathBuf>,
    accepted: HashSet<PathBuf>,
}

impl Outputs {
    /// Outputs of a command that reads `inputs`.
    pub fn new<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Self {
        Self { inputs: inputs.into_iter().map(resolve).collect(), accepted: HashSet::new() }
    }

    /// Refuses an output that cannot be written, or that is an input or another output.
    ///
    /// # Errors
    /// Why, as the fault of the input.
    pub fn check(&mut self, output: &Path) -> Result<()> {
        let name = output.display();
        if output.is_dir() {
            return Err(Failure::input(format!(
                "cannot write {name}: is a folder, must be a file"
            )));
        }
        // A device or a pipe would be replaced by a file, because outputs are renamed into place.
        if output.metadata().is_ok_and(|found| !found.is_file()) {
            return Err(Failure::input(format!("cannot write {name}: not a regular file")));
        }
        if output.metadata().is_ok_and(|found| found.permissions().readonly()) {
            return Err(Failure::input(format!("cannot write {name}: read-only file")));
        }
        let resolved = resolve(output);
        if self.inputs.contains(&resolved) {
            return Err(Failure::input(format!(
                "output {name} is also an input; choose another name"
            )));
        }
        if self.accepted.contains(&resolved) {
            return Err(Failure::input(format!(
                "{name} is the name of two outputs; choose different names"
            )));
        }
        can_write_into(folder_of(output))
            .map_err(|failure| failure.context(format_args!("cannot write {name}")))?;
        self.accepted.insert(resolved);
        Ok(())
    }
}

/// Refuses a folder that cannot be made.
pub(crate) fn check_new_folder(folder: &Path) -> Result<()> {
    can_write_into(folder_of(folder)).map_err(|failure| {
        failure.context(format_args!("cannot create the folder {}", folder.display()))
    })
}

fn can_write_into(folder: &Path) -> Result<()> {
    if !folder.exists() {
        return Err(Failure::input(format!("folder {} does not exist", folder.display())));
    }
    if !folder.is_dir() {
        return Err(Failure::input(format!("{} is not a folder", folder.display())));
    }
    // Creating a file is the only sure way to learn whether one can be created. The error's kind
    // tells why not; its text would name a file that the user never heard of.
    tempfile::Builder::new()
        .prefix(".uvgraft-")
        .suffix(".tmp")
        .tempfile_in(folder)
        .map(drop)
        .map_err(|error| Failure::input(format!("folder {}: {}", folder.display(), error.kind())))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Where a path leads to, whether or not there is a file yet.
fn resolve(path: &Path) -> PathBuf {
    if let Ok(resolved) = path.canonicalize() {
        return resolved;
    }
    match (folder_of(path).canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}
