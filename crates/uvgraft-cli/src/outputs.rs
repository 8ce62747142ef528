//! Outputs that are checked before any work is done.

use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::failure::{OrBadInput, bad_input};

/// Refuses an output that cannot be written, or that is one of the inputs.
pub(crate) fn check(output: &Path, inputs: &[&Path]) -> anyhow::Result<()> {
    if output.is_dir() {
        return Err(bad_input(format!("{} is a folder, a file is wanted", output.display())));
    }
    let resolved = resolve(output);
    for input in inputs {
        if resolve(input) == resolved {
            return Err(bad_input(format!(
                "output {} is also an input; choose another name",
                output.display()
            )));
        }
    }
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    // Creating a file is the only sure way to learn whether one can be created.
    tempfile::Builder::new()
        .prefix(".uvgraft-")
        .suffix(".tmp")
        .tempfile_in(folder.unwrap_or(Path::new(".")))
        .map(drop)
        .with_context(|| format!("cannot write {}", output.display()))
        .or_bad_input()
}

/// Where a path leads to, whether or not there is a file yet.
fn resolve(path: &Path) -> PathBuf {
    if let Ok(resolved) = path.canonicalize() {
        return resolved;
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    }
}
