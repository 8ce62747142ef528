//! Files of the networks that find faces and their landmarks (`face_networks.safetensors`): the
//! original models, in a safetensors container.
//!
//! - The header's `__metadata__` MUST hold the key `uvgraft-face-networks` with a JSON object as its
//!   text, which has `version`.
//! - There MUST be the tensors `landmark` and `detection` (u8, TensorFlow Lite models) and `geometry`
//!   (u8, protobuf), and there MAY be `iris` (u8, a TensorFlow Lite model). Each MUST have the SHA-256
//!   that its original has.
//! - Other tensors and keys MAY be present; readers of this version ignore them.

mod geometry;
pub mod import;

use std::collections::HashMap;
use std::io::{self, Write as _};
use std::path::Path;

use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};

pub use geometry::{CanonicalMesh, LANDMARKS, TRIANGLES};

use crate::tflite::{self, Model, TfliteError};
use uvgraft_files::checksum::sha256;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_files::output::write_atomically;

/// The newest version of the format, which is the one that is written.
pub const VERSION: u32 = 1;

/// Files larger than this are refused; all networks take 4.1 MB.
pub const MAX_BYTES: u64 = 16 << 20;

const METADATA_KEY: &str = "uvgraft-face-networks";

/// The original files, as bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaceNetworkFiles {
    /// The network that finds landmarks (`face_landmark.tflite`).
    pub landmark: Vec<u8>,
    /// The canonical face (`geometry_pipeline_metadata_landmarks.binarypb`).
    pub geometry: Vec<u8>,
    /// The network that finds faces (`face_detection_short_range.tflite`).
    pub detection: Vec<u8>,
    /// The network that finds irises (`iris_landmark.tflite`), if it was imported.
    pub iris: Option<Vec<u8>>,
}

/// The networks, parsed.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceModels {
    /// Finds landmarks in a crop of 192 × 192 texels.
    pub landmark: Model,
    /// Finds faces in a picture of 128 × 128 texels.
    pub detection: Model,
    /// Finds the iris in a crop of 64 × 64 texels around an eye.
    pub iris: Option<Model>,
    /// The face whose vertices are the landmarks.
    pub canonical: CanonicalMesh,
}

/// Why networks were not imported or a file of them was rejected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FaceNetworksError {
    /// The file to import is none of [`import::KNOWN_FILES`].
    #[error(
        "not {}: its SHA-256 must be {}, got {found}",
        import::PACKAGE.name, import::PACKAGE.sha256
    )]
    Unknown {
        /// Its SHA-256.
        found: String,
    },
    /// The archive to import is damaged.
    #[error("cannot unpack: {0}")]
    Archive(#[from] io::Error),
    /// The archive to import lacks a file.
    #[error("must contain {0}")]
    Missing(
        /// The file's path.
        &'static str,
    ),
    /// Another kind of file.
    #[error(
        "not a file of face networks: must be a safetensors file with `{METADATA_KEY}` in its \
         metadata"
    )]
    Foreign,
    /// Written by a later version of this program.
    #[error("face networks must be of version {VERSION} or older, got {found}; update uvgraft")]
    Version {
        /// The version that the file states.
        found: u32,
    },
    /// The container is malformed.
    #[error("truncated or damaged face networks: {0}")]
    Container(String),
    /// A tensor is missing or has the wrong type.
    #[error("damaged face networks: tensor `{0}` is missing or not bytes")]
    Tensor(
        /// Which one.
        &'static str,
    ),
    /// A network changed after it was published.
    #[error("damaged face networks: SHA-256 of `{part}` must be {wanted}, got {found}")]
    Checksum {
        /// Which one.
        part: &'static str,
        /// Of the bytes.
        found: String,
        /// Of the original.
        wanted: &'static str,
    },
    /// A network cannot be read.
    #[error("{part}: {reason}")]
    Model {
        /// Which one.
        part: &'static str,
        /// Why.
        reason: TfliteError,
    },
    /// The canonical face cannot be read.
    #[error("the canonical face must have {LANDMARKS} vertices and {TRIANGLES} triangles")]
    Geometry,
}

/// A part of the file and the SHA-256 of its original.
struct Part {
    name: &'static str,
    sha256: &'static str,
}

const LANDMARK: Part = Part {
    name: "landmark",
    sha256: "c603fa6149219a3e9487dc9abd7a0c24474c77263273d24868378cdf40aa26d1",
};
const GEOMETRY: Part = Part {
    name: "geometry",
    sha256: "bdbcda96dfcb7da883da124aaa2c55dee49770d934f0fcc71747f8c21bdc75b4",
};
const DETECTION: Part = Part {
    name: "detection",
    sha256: "3bc182eb9f33925d9e58b5c8d59308a760f4adea8f282370e428c51212c26633",
};
const IRIS: Part = Part { name: "iris", sha256: import::IRIS_MODEL.sha256 };

#[derive(Serialize, Deserialize)]
struct Header {
    version: u32,
}

impl FaceNetworkFiles {
    /// Parses the networks.
    ///
    /// # Errors
    /// [`FaceNetworksError::Checksum`] if a file is not the original, or why it cannot be parsed.
    pub fn parse(&self) -> Result<FaceModels, FaceNetworksError> {
        let model = |part: Part, bytes: &[u8]| {
            check(&part, bytes)?;
            let wrong = |reason| FaceNetworksError::Model { part: part.name, reason };
            tflite::parse(bytes).map_err(wrong)
        };
        check(&GEOMETRY, &self.geometry)?;
        Ok(FaceModels {
            landmark: model(LANDMARK, &self.landmark)?,
            detection: model(DETECTION, &self.detection)?,
            iris: self.iris.as_deref().map(|bytes| model(IRIS, bytes)).transpose()?,
            canonical: geometry::parse(&self.geometry)?,
        })
    }
}

fn check(part: &Part, bytes: &[u8]) -> Result<(), FaceNetworksError> {
    let found = sha256(bytes);
    if found == part.sha256 {
        return Ok(());
    }
    Err(FaceNetworksError::Checksum { part: part.name, found, wanted: part.sha256 })
}

/// The bytes of a file of face networks; the same for the same networks.
///
/// # Errors
/// [`FaceNetworksError::Container`] if the container's writer refuses.
pub fn encode(files: &FaceNetworkFiles) -> Result<Vec<u8>, FaceNetworksError> {
    let mut parts = vec![
        (LANDMARK.name, &files.landmark),
        (GEOMETRY.name, &files.geometry),
        (DETECTION.name, &files.detection),
    ];
    parts.extend(files.iris.as_ref().map(|iris| (IRIS.name, iris)));
    let views = parts
        .into_iter()
        .map(|(name, bytes)| Ok((name, TensorView::new(Dtype::U8, vec![bytes.len()], bytes)?)));
    let views = views
        .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()
        .map_err(|error| container(&error))?;
    let header = serde_json::to_string(&Header { version: VERSION });
    let header = header.map_err(|error| container(&error))?;
    let metadata = HashMap::from([(METADATA_KEY.to_owned(), header)]);
    safetensors::serialize(views, Some(metadata)).map_err(|error| container(&error))
}

/// The original files from the bytes of a file of face networks. They are not parsed yet.
///
/// # Errors
/// [`FaceNetworksError`]; checksums are compared by [`FaceNetworkFiles::parse`].
pub fn decode(bytes: &[u8]) -> Result<FaceNetworkFiles, FaceNetworksError> {
    // A safetensors file starts with the length of its header, and the header with a brace.
    if bytes.get(8) != Some(&b'{') {
        return Err(FaceNetworksError::Foreign);
    }
    let tensors = SafeTensors::deserialize(bytes).map_err(|error| container(&error))?;
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|error| container(&error))?;
    let header = metadata.metadata().as_ref().and_then(|metadata| metadata.get(METADATA_KEY));
    let header = header.ok_or(FaceNetworksError::Foreign)?;
    let Header { version } = serde_json::from_str(header).map_err(|error| container(&error))?;
    if version > VERSION {
        return Err(FaceNetworksError::Version { found: version });
    }
    let part = |part: Part| {
        let view = tensors.tensor(part.name).ok().filter(|view| view.dtype() == Dtype::U8);
        view.map(|view| view.data().to_vec()).ok_or(FaceNetworksError::Tensor(part.name))
    };
    Ok(FaceNetworkFiles {
        landmark: part(LANDMARK)?,
        geometry: part(GEOMETRY)?,
        detection: part(DETECTION)?,
        iris: tensors.names().contains(&IRIS.name).then(|| part(IRIS)).transpose()?,
    })
}

/// Reads a file of face networks and parses the networks.
///
/// # Errors
/// [`ReadError`] with the path and what is wrong.
pub fn read(input: impl Into<Input>) -> Result<FaceModels, ReadError<FaceNetworksError>> {
    input.into().parse(MAX_BYTES, |bytes| decode(bytes)?.parse())
}

/// Writes a file of face networks; after a crash, an existing file is unchanged.
///
/// # Errors
/// Those of encoding or writing.
pub fn write(files: &FaceNetworkFiles, path: impl AsRef<Path>) -> io::Result<()> {
    let bytes = encode(files).map_err(io::Error::other)?;
    write_atomically(path.as_ref(), |out| out.write_all(&bytes))
}

fn container(error: &dyn std::error::Error) -> FaceNetworksError {
    FaceNetworksError::Container(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(iris: Option<Vec<u8>>) -> FaceNetworkFiles {
        let (landmark, geometry, detection) = (vec![1; 90], vec![2; 80], vec![3; 70]);
        FaceNetworkFiles { landmark, geometry, detection, iris }
    }

    #[test]
    fn what_is_written_is_read_and_nothing_less() {
        for files in [files(None), files(Some(vec![4; 60]))] {
            let bytes = encode(&files).unwrap();
            assert_eq!(decode(&bytes).unwrap(), files);
            assert_eq!(bytes, encode(&files).unwrap());
            for end in 0..bytes.len() {
                assert!(decode(&bytes[..end]).is_err(), "cut at {end}");
            }
            let text = String::from_utf8_lossy(&bytes).into_owned();
            let changed = |from: &str, to: &str| {
                assert_eq!(from.len(), to.len());
                let place = text.find(from).unwrap();
                let changed = [&bytes[..place], to.as_bytes(), &bytes[place + from.len()..]];
                decode(&changed.concat()).unwrap_err().to_string()
            };
            assert!(
                changed("uvgraft-face", "uvgraft-feet").contains("not a file of face networks")
            );
            assert!(
                changed(r#"version\":1"#, r#"version\":7"#).contains("version 1 or older, got 7")
            );
            assert!(changed(r#""geometry""#, r#""geometrie"#).contains("damaged"));
        }
    }

    #[test]
    fn only_the_originals_are_parsed() {
        let error = files(None).parse().unwrap_err().to_string();
        assert!(error.contains("SHA-256 of `geometry` must be bdbcda96"), "{error}");
    }

    #[test]
    fn other_files_are_foreign() {
        let empty = safetensors::serialize(Vec::<(&str, TensorView<'_>)>::new(), None).unwrap();
        for bytes in [&b""[..], b"\x89PNG\r\n\x1a\n....", &empty] {
            assert!(matches!(decode(bytes), Err(FaceNetworksError::Foreign)));
        }
    }
}
