//! Options of `avatar --selfie`: photographs in place of a face texture.

use std::path::PathBuf;

use crate::heading;
use crate::selfie::PhotoArgs;

/// Options for photographs in place of a face texture.
#[derive(clap::Args)]
#[command(next_help_heading = heading::PHOTOGRAPHS)]
pub(super) struct SelfieArgs {
    /// Photographs of one person, or a folder of frames, in place of a face texture
    ///
    /// The texture is made as by `uvgraft selfie`, and the head gets the shape of the face.
    #[arg(id = "photos", long = "selfie", value_name = "PHOTO", num_args = 1..)]
    pub(super) photos: Vec<PathBuf>,
    /// How much of the face's shape the head gets, from 0 to 1 [default: 1]
    #[arg(long, value_name = "SHARE", value_parser = share, allow_hyphen_values = true)]
    #[arg(requires = "photos")]
    pub(super) likeness: Option<f64>,
    #[command(flatten)]
    pub(super) photographs: PhotoArgs,
}

fn share(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().ok().filter(|share| (0.0..=1.0).contains(share));
    value.ok_or_else(|| "must be a number from 0 to 1".to_owned())
}
