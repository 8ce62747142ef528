//! Finds the newest texture of a FATE workspace.

use std::cmp::Reverse;
use std::io;
use std::path::{Path, PathBuf};

use super::FateError;
use uvgraft_files::input::ReadError;

/// The source of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureSource {
    /// The trained tensors: exact, and with confidence.
    Dump,
    /// An 8-bit picture of them.
    Picture,
}

/// The texture file of a workspace.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextureFile {
    /// Path of the colours.
    pub file: PathBuf,
    /// Its kind.
    pub kind: TextureSource,
    /// Number of other texture files, which are older or less exact.
    pub others: usize,
}

/// Finds the newest texture of a workspace.
///
/// - Dumps take precedence over pictures.
/// - Of several folders whose names start with `baking`, the last by name is used:
///   `baking_full_head`, which FATE makes of the whole head, comes after `baking`. The path of a
///   baking folder itself is accepted too.
/// - Of several files in it, the one with the highest number at the start of its name is used: the
///   epoch of dumps, the step of pictures.
///
/// # Errors
/// [`ReadError`], with the path, if a folder cannot be read, or there is no texture.
pub fn find(workspace: impl AsRef<Path>) -> Result<TextureFile, ReadError<FateError>> {
    find_in(workspace.as_ref())
}

fn find_in(workspace: &Path) -> Result<TextureFile, ReadError<FateError>> {
    let mut bakings = vec![workspace.to_owned()];
    bakings.extend(
        entries(workspace)?.into_iter().filter(|path| name(path).starts_with("baking")).rev(),
    );
    let mut files = Vec::new();
    for (kind, folder, end) in [
        (TextureSource::Dump, "dump_texture", "tex_dump.pth"),
        (TextureSource::Picture, "visualize_texture", "color.png"),
    ] {
        for baking in &bakings {
            let folder = baking.join(folder);
            if !folder.is_dir() {
                continue;
            }
            let mut found = entries(&folder)?;
            found.retain(|path| name(path).ends_with(end) && path.is_file());
            found.sort_by_key(|path| Reverse((number(&name(path)), name(path))));
            files.extend(found.into_iter().map(|file| (file, kind)));
        }
    }
    let others = files.len().saturating_sub(1);
    match files.into_iter().next() {
        Some((file, kind)) => Ok(TextureFile { file, kind, others }),
        None => {
            let path = workspace.to_owned();
            Err(ReadError::Content { path, reason: FateError::Nothing })
        }
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The number at the start of a name.
fn number(name: &str) -> Option<u64> {
    let digits = name.find(|character: char| !character.is_ascii_digit()).unwrap_or(name.len());
    name[..digits].parse().ok()
}

/// The entries of a folder, sorted by name.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, ReadError<FateError>> {
    let read = || -> io::Result<Vec<PathBuf>> {
        let entries = std::fs::read_dir(folder)?;
        let mut paths: Vec<PathBuf> =
            entries.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
        paths.sort();
        Ok(paths)
    };
    read().map_err(|reason| ReadError::Io { path: folder.to_owned(), reason })
}
