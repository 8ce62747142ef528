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
        check_replaceable(output)?;
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

/// Checks that an existing output is a file that may be replaced.
pub(crate) fn check_replaceable(output: &Path) -> Result<()> {
    let Ok(found) = output.metadata() else { return Ok(()) };
    let reason = if found.is_dir() {
        "must be a file, but is a folder"
    } else if !found.is_file() {
        // Renaming the output into place would replace a device or a pipe by a file.
        "not a regular file"
    } else if found.permissions().readonly() {
        "read-only file"
    } else {
        return Ok(());
    };
    Err(Failure::input(format!("cannot write {}: {reason}", output.display())))
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

pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The canonical path, whether or not the file exists.
pub(crate) fn resolve(path: &Path) -> PathBuf {
    if let Ok(resolved) = path.canonicalize() {
        return resolved;
    }
    match (folder_of(path).canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}
