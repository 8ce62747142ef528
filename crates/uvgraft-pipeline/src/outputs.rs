//! Checks of output paths before any work starts.

use std::collections::{HashMap, HashSet};
use std::fs::OpenOptions;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use uvgraft_files::output::{self, folder_of};

use crate::failure::{Context, Failure, Result};

/// Output paths checked to be writable, distinct, and different from all inputs.
pub struct Outputs {
    inputs: HashSet<PathBuf>,
    accepted: HashSet<PathBuf>,
    resolver: Resolver,
    /// Folders that files can be created in: a batch may have a million outputs in one.
    writable: HashSet<PathBuf>,
}

impl Outputs {
    /// Outputs of a command that reads `inputs`.
    pub fn new<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Self {
        let mut resolver = Resolver::default();
        let inputs = inputs.into_iter().map(|path| resolver.resolve(path)).collect();
        Self { inputs, accepted: HashSet::new(), resolver, writable: HashSet::new() }
    }

    /// Checks that an output can be written and is neither an input nor another output.
    ///
    /// # Errors
    /// The reason, as the fault of the input.
    pub fn check(&mut self, output: &Path) -> Result<()> {
        self.check_below(folder_of(output), output)
    }

    /// As [`Outputs::check`], but folders below `root` need not exist, since they will be created.
    pub(crate) fn check_below(&mut self, root: &Path, output: &Path) -> Result<()> {
        let name = output.display();
        let target = check_replaceable(output)?;
        let resolved = self.resolver.resolve(output);
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
        let folder = folder_of(&target);
        if !self.writable.contains(folder) {
            let mut existing = folder;
            // What a link leads to is not created.
            while target == output
                && existing != root
                && existing.starts_with(root)
                && !existing.exists()
            {
                existing = folder_of(existing);
            }
            can_write_into(existing).context(format_args!("cannot write {name}"))?;
            self.writable.insert(folder.to_path_buf());
        }
        self.accepted.insert(resolved);
        Ok(())
    }
}

/// Checks that an output has a name that a file can have, and that an existing one is a file that may
/// be replaced. Returns where symbolic links lead.
pub(crate) fn check_replaceable(output: &Path) -> Result<PathBuf> {
    let name = output.display();
    let refused = |reason: &str| Err(Failure::input(format!("cannot write {name}: {reason}")));
    let target = match output::target_of(output) {
        Ok(target) => target,
        Err(error) if error.kind() == ErrorKind::InvalidFilename => {
            return refused("the name is too long for its folder");
        }
        // That it is no folder is reported with the folder.
        Err(error) if error.kind() == ErrorKind::NotADirectory => return Ok(output.to_path_buf()),
        Err(error) => return refused(&error.to_string()),
    };
    let Ok(found) = target.metadata() else { return Ok(target) };
    if found.is_dir() {
        refused("must be a file, but is a folder")
    } else if !found.is_file() {
        // Renaming the output into place would replace a device or a pipe by a file.
        refused("not a regular file")
    } else if found.permissions().readonly() {
        refused("read-only file")
    } else if is_immutable(&target) {
        refused("immutable or append-only file")
    } else {
        Ok(target)
    }
}

/// Whether the file system keeps a file from being replaced, whoever asks.
fn is_immutable(file: &Path) -> bool {
    /// `EPERM`, which is the same number on all systems that have it. A file of somebody else is
    /// `EACCES` instead, and may be replaced if its folder allows it.
    const NOT_PERMITTED: i32 = 1;
    // Nothing is written.
    let opened = OpenOptions::new().write(true).open(file);
    cfg!(unix) && opened.is_err_and(|error| error.raw_os_error() == Some(NOT_PERMITTED))
}

/// Checks that a folder can be created.
pub(crate) fn check_new_folder(folder: &Path) -> Result<()> {
    let what = format_args!("cannot create the folder {}", folder.display());
    can_write_into(folder_of(folder)).context(what)
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
    output::check_folder(folder)
        .map_err(|error| Failure::input(format!("folder {}: {}", folder.display(), error.kind())))
}

/// Finds canonical paths, of each folder once.
#[derive(Default)]
struct Resolver {
    folders: HashMap<PathBuf, Option<PathBuf>>,
}

impl Resolver {
    /// The canonical path, whether or not the file exists.
    fn resolve(&mut self, path: &Path) -> PathBuf {
        // File systems of other systems may ignore case.
        let is_plain = cfg!(target_os = "linux") && !path.is_symlink();
        if let Some(name) = path.file_name().filter(|_| is_plain) {
            return self.folder(folder_of(path)).map_or(path.to_path_buf(), |it| it.join(name));
        }
        if let Ok(resolved) = path.canonicalize() {
            return resolved;
        }
        match (self.folder(folder_of(path)), path.file_name()) {
            (Some(folder), Some(name)) => folder.join(name),
            _ => path.to_path_buf(),
        }
    }

    fn folder(&mut self, folder: &Path) -> Option<&Path> {
        if !self.folders.contains_key(folder) {
            self.folders.insert(folder.to_path_buf(), folder.canonicalize().ok());
        }
        self.folders.get(folder)?.as_deref()
    }
}

/// The canonical path, whether or not the file exists.
pub(crate) fn resolve(path: &Path) -> PathBuf {
    Resolver::default().resolve(path)
}
