//! Errors of reading and posing scenes.

use uvgraft::listing::listed;
use uvgraft_image::ImageError;
use uvgraft_io::beginning;

use super::budget::MemoryShares;
use crate::container::ContainerError;

/// Why bytes were refused as a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file is neither GLB nor JSON.
    #[error("not a glTF file: must be GLB (glTF 2.0) or glTF JSON, {}", beginning(start))]
    NotGltf {
        /// The first bytes, at most 8.
        start: Vec<u8>,
    },
    /// The GLB container is damaged.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// The JSON is damaged or not glTF.
    #[error("invalid JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The file requires an unsupported extension.
    #[error("unsupported extension {name}; {advice}")]
    Extension {
        /// Its name.
        name: String,
        /// What the user can do about it.
        advice: &'static str,
    },
    /// A dangling reference, or inconsistent or invalid content.
    #[error("{place}: {reason}")]
    Content {
        /// Where, for example "accessor 3".
        place: String,
        /// What it must be, and what it is.
        reason: String,
    },
    /// A limit of the reader is exceeded; detected before anything is allocated.
    #[error("must have at most {max} {what}, got {found}")]
    TooMany {
        /// What exceeds the limit.
        what: &'static str,
        /// The number found, or the number counted so far.
        found: u64,
        /// The limit.
        max: u64,
    },
    /// The file asks for more memory than it may take; detected before anything is unpacked.
    #[error("{shares}")]
    Memory {
        /// What it asks for.
        shares: Box<MemoryShares>,
    },
    /// An embedded image was refused.
    #[error("image {index}: {reason}")]
    Image {
        /// Its index in the file.
        index: usize,
        /// Why.
        reason: ImageError,
    },
}

impl SceneError {
    pub(super) fn extension(name: &str) -> Self {
        let advice = match name {
            "KHR_texture_basisu" => {
                "build uvgraft with --features ktx2, or convert the file: gltf-transform \
                 ktxdecompress in.glb out.glb"
            }
            "EXT_texture_avif" => {
                "convert the file: gltf-transform png --formats avif in.glb out.glb"
            }
            _ => "convert the file, for example with gltf-transform copy in.glb out.glb",
        };
        Self::Extension { name: name.to_owned(), advice }
    }

    pub(super) fn content(place: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Content { place: place.into(), reason: reason.into() }
    }
}

/// Why a pose cannot be applied to a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseRequestError {
    /// Unknown name.
    #[error("no {what} {name:?}; {}", known(choices))]
    Unknown {
        /// What was requested: "clip", "bone", ...
        what: &'static str,
        /// Its name.
        name: String,
        /// The available names.
        choices: Vec<String>,
    },
    /// The pose needs a bone that the scene does not identify.
    #[error(
        "the pose {pose} needs the bone {bone}, which neither VRM's humanoid nor the node names \
         identify"
    )]
    NoBone {
        /// Name of the pose.
        pose: &'static str,
        /// VRM name of the bone.
        bone: &'static str,
    },
    /// A time, an angle or a weight is infinite or NaN.
    #[error("{what} must be finite, got {found}")]
    NotFinite {
        /// What it is.
        what: &'static str,
        /// The given value.
        found: String,
    },
}

/// "must be one of ...", with the beginnings of names.
pub(super) fn known(choices: &[String]) -> String {
    const LENGTH: usize = 60;
    if choices.is_empty() {
        return "the file has none".to_owned();
    }
    let shortened = |name: &String| match name.char_indices().nth(LENGTH) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.clone(),
    };
    format!("must be one of {}", listed(choices.iter().map(shortened)))
}
