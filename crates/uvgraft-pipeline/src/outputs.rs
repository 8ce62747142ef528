//! Checks of output paths before any work starts.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::failure::{Failure, Result};

/// Output paths checked to be writable, distinct, and different from all inputs.
pub struct Outputs {
    inputs: HashSet<PathBuf>,
    accepted: HashSet<PathBuf>,
}

impl Outputs {
    /// Outputs of a command that reads `inputs`.
    pub fn new<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Self {
        Self { inputs: inputs.into_iter().map(resolve).collect(), accepted: HashSet::new() }
    }

    /// Checks that an output can be written and is neither an input nor another output.
    ///
    /// # Errors
    /// The reason, as the fault of the input.
    pub fn check(&mut self, output: &Path) -> Result<()> {
        let name = output.display();
        if output.is_dir() {
            return Err(Failure::input(format!(
                "cannot write {name}: must be a file, but is a folder"
            )));
        }
        // Renaming the output into place would replace a device or a pipe by a file.
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
                "two outputs have the name {name}; choose different names"
            )));
        }
        can_write_into(folder_of(output))
            .map_err(|failure| failure.context(format_args!("cannot write {name}")))?;
        self.accepted.insert(resolved);
        Ok(())
    }
}

/// Checks that a folder can be created.
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
    // Creating a file is the only reliable test. The kind of the error is the reason; its text
    // would name a temporary file unknown to the user.
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

/// The canonical path, whether or not the file exists.
fn resolve(path: &Path) -> PathBuf {
    if let Ok(resolved) = path.canonicalize() {
        return resolved;
    }
    match (folder_of(path).canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}
