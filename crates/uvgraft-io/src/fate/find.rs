//! Which of a workspace's files has the newest texture.

use std::cmp::Reverse;
use std::io;
use std::path::{Path, PathBuf};

use super::FateError;
use crate::input::ReadError;

/// What kind of file a texture is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureSource {
    /// The tensors that were trained: exact, and with the confidence.
    Dump,
    /// A picture of them, of 8 bits.
    Picture,
}

/// The file of a workspace that is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextureFile {
    /// The file of the colours.
    pub file: PathBuf,
    /// What kind of file it is.
    pub kind: TextureSource,
    /// How many other files of textures there are, which are older or less exact.
    pub others: usize,
}

/// Finds the newest texture of a workspace.
///
/// - Dumps go before pictures.
/// - Of several folders that begin with `baking`, the last by name counts: `baking_full_head`, which
///   FATE makes of the whole head, after `baking`. A baking folder itself is taken too.
/// - Of several files in it the one with the highest number before its name counts, which is the
///   epoch of dumps and the step of pictures.
///
/// # Errors
/// [`ReadError`], with the path, if a folder cannot be read, or there is no texture.
pub fn find(workspace: &Path) -> Result<TextureFile, ReadError<FateError>> {
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

/// The number that a name begins with.
fn number(name: &str) -> Option<u64> {
    let digits = name.find(|character: char| !character.is_ascii_digit()).unwrap_or(name.len());
    name[..digits].parse().ok()
}

/// What a folder holds, by name.
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
