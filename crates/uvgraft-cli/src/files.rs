//! Files and folders that commands write, and errors that name them.

use std::io::{self, Write as _};
use std::path::Path;

use anyhow::Context;
use uvgraft_files::output::write_atomically;

use crate::failure::{OrBadInput, bad_input};
use crate::outcome;

/// Names the file in an error.
pub(crate) trait OrCannotWrite<T> {
    fn or_cannot_write(self, path: &Path) -> anyhow::Result<T>;
}

impl<T, E: Into<anyhow::Error>> OrCannotWrite<T> for Result<T, E> {
    fn or_cannot_write(self, path: &Path) -> anyhow::Result<T> {
        self.map_err(Into::into).with_context(|| format!("cannot write {}", path.display()))
    }
}

/// Writes a file, whole or not at all, and tells so.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_atomically::<io::Error>(path, |out| out.write_all(bytes)).or_cannot_write(path)?;
    outcome::wrote(path);
    Ok(())
}

/// Creates a folder and those around it, unless they exist.
pub(crate) fn create_folder(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))
        .or_bad_input()
}

/// Rejects a path that has none of some extensions.
pub(crate) fn check_extension(path: &Path, extensions: &[&str]) -> anyhow::Result<()> {
    let found = path.extension().unwrap_or_default();
    if extensions.iter().any(|extension| found.eq_ignore_ascii_case(extension)) {
        return Ok(());
    }
    let wanted = extensions.join(" or .");
    Err(bad_input(format!("{}: extension must be .{wanted}", path.display())))
}
