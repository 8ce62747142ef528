//! Headings that group options in the help.

use clap::Arg;

/// What most people need.
const COMMON: &str = "Common options";

/// Puts an option among the common ones if it is one of them. The help begins with these where the first option
/// of a command is one.
pub(crate) fn common(names: &[&str], option: Arg) -> Arg {
    match names.contains(&option.get_id().as_str()) {
        true => option.help_heading(COMMON),
        false => option,
    }
}

pub(crate) const FILES: &str = "Input and output";
pub(crate) const CORRESPONDENCE: &str = "Correspondence";
pub(crate) const SAMPLING: &str = "Sampling";
pub(crate) const REGION: &str = "Region";
pub(crate) const BLENDING: &str = "Blending";
pub(crate) const MATERIALS: &str = "Materials";
pub(crate) const BATCHES: &str = "Batches";
pub(crate) const ENCODING: &str = "Encoding";

pub(crate) const PHOTOGRAPHS: &str = "Photographs";

pub(crate) const BODY: &str = "Body";
pub(crate) const ANIMATION: &str = "Animation";
pub(crate) const TEXTURE: &str = "Texture";
pub(crate) const FEATURES: &str = "Mouth and eyes";
pub(crate) const LODS: &str = "Levels of detail";
pub(crate) const PLATFORM: &str = "Platform";
pub(crate) const METADATA: &str = "Metadata";

pub(crate) const CAMERA: &str = "Camera";
pub(crate) const POSE: &str = "Pose and animation";
pub(crate) const MOVING: &str = "Animation output";
pub(crate) const APPEARANCE: &str = "Appearance";

pub(crate) const MEASUREMENT: &str = "Measurement";
pub(crate) const TONE: &str = "Tone of the face";
pub(crate) const REPORT: &str = "Report";
pub(crate) const LIMITS: &str = "Limits";

pub(crate) const GLOBAL: &str = "Global options";
