//! The face: an image, or the output of FATE.

use std::path::{Path, PathBuf};

use uvgraft::Texture;
use uvgraft_files::input::Input;
use uvgraft_image as image;
use uvgraft_io::fate;
use uvgraft_pipeline::{Blame, Observer, Result, without_non_finite};

use crate::selfie::FittedSelfie;

/// A texture in the head's layout.
pub(super) struct Face {
    pub(super) texture: Texture,
    /// The mask of trusted texels, if the source has one.
    pub(super) confidence: Option<Texture>,
    /// What to call it in messages: the file that it was read from.
    pub(super) name: PathBuf,
}

impl Face {
    /// Twice the size that FATE bakes at: FATE's texels lie on the corners of the texture, ours
    /// between them, and at this size interpolation loses next to nothing.
    const SIDE_OF_DUMPS: u32 = 2 * fate::BAKED_SIZE;

    /// Reads an image, a texture dump, or a FATE workspace.
    pub(super) fn read(input: &Input, observer: &dyn Observer) -> Result<Self> {
        let name = input.name();
        let is_dump = name.extension().is_some_and(|extension| {
            ["pth", "pt"].iter().any(|name| extension.eq_ignore_ascii_case(name))
        });
        if !(is_dump || input.path().is_some_and(Path::is_dir)) {
            let texture = image::read(input).or_input()?.texture;
            let (texture, unknown) = without_non_finite(texture, name);
            unknown.iter().for_each(|unknown| observer.warn(unknown));
            return Ok(Self { texture, confidence: None, name: name.to_path_buf() });
        }
        let read = fate::read(input, Self::SIDE_OF_DUMPS).or_input()?;
        let fate::FateTexture { color, confidence } = read.texture;
        Ok(Self { texture: color, confidence, name: read.file })
    }

    /// The texture made of photographs. What they don't show of the face is completed already, so no
    /// texel is left to the body.
    pub(super) fn of_selfie(selfie: &FittedSelfie) -> Self {
        let name = selfie.first_photo().to_path_buf();
        Self { texture: selfie.texture().clone(), confidence: None, name }
    }
}
