//! The face: an image, or the output of FATE.

use std::path::{Path, PathBuf};

use uvgraft::Texture;
use uvgraft_io::{fate, image};
use uvgraft_pipeline::without_non_finite;

use crate::failure::{OrBadInput, warn};

/// A texture in the head's layout.
pub(super) struct Face {
    pub(super) texture: Texture,
    /// The mask of trusted texels, if the source has one.
    pub(super) confidence: Option<Texture>,
    /// The file that it was read from.
    pub(super) file: PathBuf,
}

impl Face {
    /// Twice the size that FATE bakes at: FATE's texels lie on the corners of the texture, ours
    /// between them, and at this size interpolation loses next to nothing.
    const SIDE_OF_DUMPS: u32 = 2 * fate::BAKED_SIZE;

    /// Reads an image, a texture dump, or a FATE workspace.
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let is_dump = path.extension().is_some_and(|extension| {
            ["pth", "pt"].iter().any(|name| extension.eq_ignore_ascii_case(name))
        });
        if !(is_dump || path.is_dir()) {
            let texture = image::read(path).or_bad_input()?.texture;
            let (texture, unknown) = without_non_finite(texture, path);
            unknown.iter().for_each(warn);
            return Ok(Self { texture, confidence: None, file: path.to_path_buf() });
        }
        let read = fate::read(path, Self::SIDE_OF_DUMPS).or_bad_input()?;
        let fate::FateTexture { color, confidence } = read.texture;
        Ok(Self { texture: color, confidence, file: read.file })
    }
}
