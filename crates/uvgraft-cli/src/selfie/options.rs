//! Options for photographs, shared by `selfie` and `avatar --selfie`.

use std::path::PathBuf;

use uvgraft::Choice;
use uvgraft_assembly::Input;
use uvgraft_assembly::selfie::{FocalLength, Networks, PhotoOptions};
use uvgraft_selfie::Relight;

use crate::choice::choice;
use crate::heading;
use crate::number::whole_number;

#[derive(Clone, clap::Args)]
#[command(next_help_heading = heading::PHOTOGRAPHS)]
pub(crate) struct PhotoArgs {
    /// Face to use where a photograph shows several, 1 for the largest
    #[arg(id = "face_number", long = "face", value_name = "N")]
    #[arg(value_parser = whole_number::<u16>(1..=1000), allow_negative_numbers = true)]
    #[arg(requires = "photos")]
    face: Option<u16>,
    /// Focal length in pixels, or as on 35 mm film, such as 28mm [default: from EXIF]
    ///
    /// Pixels are those of the upright image. The length on film is taken to have the same diagonal
    /// field of view. Photographs that don't state a focal length are taken to have one of 1.2 times
    /// their longer side, about 43 mm on film.
    #[arg(long, value_name = "PX|MM", value_parser = FocalLength::parse, requires = "photos")]
    #[arg(allow_hyphen_values = true)]
    focal: Option<FocalLength>,
    /// Usual texture of the head, such as a mean texture [default: for `demo` its own]
    ///
    /// An image in the head's UV layout. Landmarks are found on drawings of the head, and those with
    /// a texture look more like photographs than those without. Nothing of it gets into the result.
    #[arg(long, value_name = "IMAGE", requires = "photos")]
    head_texture: Option<PathBuf>,
    /// How much of the light in the photographs to remove
    #[arg(long, value_name = "HOW", value_parser = choice::<Relight>())]
    #[arg(default_value = Relight::Soft.name(), requires = "photos")]
    relight: Relight,
    /// Maximum number of frames used of a folder, evenly spaced [default: 9]
    #[arg(long, value_name = "N", requires = "photos")]
    #[arg(value_parser = whole_number::<u16>(1..=64), allow_negative_numbers = true)]
    frames: Option<u16>,
}

impl PhotoArgs {
    pub(crate) fn options(&self) -> PhotoOptions {
        PhotoOptions {
            face_number: self.face,
            focal: self.focal,
            head_texture: self.head_texture.as_ref().map(Input::from),
            relight: self.relight,
            frames: self.frames,
            networks: Networks::Imported,
        }
    }
}
