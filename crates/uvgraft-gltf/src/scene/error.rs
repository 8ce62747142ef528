//! Why a file is no scene, and why a scene does not take a pose.

use uvgraft_io::image::ImageError;

use crate::container::ContainerError;

/// Why bytes were refused as a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Neither GLB nor JSON.
    #[error(
        "not a glTF file: must be GLB (glTF 2.0) or glTF JSON, starts with \"{}\"",
        start.escape_ascii()
    )]
    NotGltf {
        /// The first bytes, at most 8.
        start: Vec<u8>,
    },
    /// The GLB container is damaged.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// The JSON is damaged, or not glTF's.
    #[error("invalid JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The file cannot be shown without an extension that is not read.
    #[error("unsupported extension {name}; {advice}")]
    Extension {
        /// What it is called.
        name: String,
        /// What can be done about it.
        advice: &'static str,
    },
    /// Something refers to nothing, or contradicts itself.
    #[error("{place}: {reason}")]
    Content {
        /// Where, such as "accessor 3".
        place: String,
        /// What was found and what was wanted.
        reason: String,
    },
    /// More than is ever read, found before it is allocated.
    #[error("must have at most {max} {what}, got {found}")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many there are, or as many as were counted before giving up.
        found: u64,
        /// How many are read.
        max: u64,
    },
    /// An embedded image was refused.
    #[error("image {index}: {reason}")]
    Image {
        /// Its number in the file.
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

/// A pose that asks for something the scene does not have.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PosingError {
    /// There is nothing of that name.
    #[error("no {what} {name:?}; {}", known(choices))]
    Unknown {
        /// What was looked for: "clip", "bone", ...
        what: &'static str,
        /// Its name.
        name: String,
        /// What there is.
        choices: Vec<String>,
    },
    /// A pose that needs bones which the scene does not name.
    #[error(
        "the pose {pose} needs the bone {bone}, which neither VRM's humanoid nor the node names \
         identify"
    )]
    NoBone {
        /// Name of the pose.
        pose: &'static str,
        /// VRM's name of the bone.
        bone: &'static str,
    },
    /// A time, an angle or a weight that is infinite or no number.
    #[error("{what} must be finite, got {found}")]
    NotFinite {
        /// What it is.
        what: &'static str,
        /// What was given.
        found: String,
    },
}

/// "choose one of ...", with as many names as are readable.
fn known(choices: &[String]) -> String {
    const MOST: usize = 40;
    if choices.is_empty() {
        return "the file has none".to_owned();
    }
    let more = if choices.len() > MOST { ", ..." } else { "" };
    let shown: Vec<&str> = choices.iter().take(MOST).map(String::as_str).collect();
    format!("must be one of {}{more}", shown.join(", "))
}
