//! Checks that the page can show a GLB.

use serde::Deserialize;
use uvgraft_gltf::container::{self, ContainerError};

/// A GLB with a valid header, length and JSON, which requires nothing that the page lacks.
#[derive(Debug, Clone, Copy)]
pub struct Glb<'a>(&'a [u8]);

/// Why a file cannot be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GlbError {
    /// The container is damaged, or the file is of another type.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// The length in the header is not that of the file.
    #[error("the length in the GLB header must be that of the file, {actual} bytes, got {found}")]
    Length {
        /// Length in the header.
        found: u64,
        /// Length of the file.
        actual: u64,
    },
    /// The JSON cannot be read.
    #[error("cannot parse the JSON chunk: {0}")]
    Json(#[from] serde_json::Error),
    /// Part of its data is in another file.
    #[error("{what} is in the external file `{uri}`; a GLB must contain all its data to be viewed")]
    External {
        /// What is external, such as `image 0`.
        what: String,
        /// The URI of the other file.
        uri: String,
    },
    /// The file requires an extension that the page does not support.
    #[error("the file requires {name}, which the viewer does not support; export it without")]
    Extension {
        /// The extension's name.
        name: String,
    },
}

/// Extensions that need a decoder that the page does not have.
const NOT_READ: [&str; 4] = [
    "KHR_draco_mesh_compression",
    "KHR_texture_basisu",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];

#[derive(Deserialize)]
struct Json {
    #[serde(default)]
    buffers: Vec<Resource>,
    #[serde(default)]
    images: Vec<Resource>,
    #[serde(default, rename = "extensionsRequired")]
    required: Vec<String>,
}

#[derive(Deserialize)]
struct Resource {
    uri: Option<String>,
}

impl<'a> Glb<'a> {
    /// Checks a file.
    ///
    /// # Errors
    /// [`GlbError`]. Meshes and images are not checked: the page reports errors in them.
    pub fn new(bytes: &'a [u8]) -> Result<Self, GlbError> {
        let glb = container::Glb::read(bytes)?;
        let (found, actual) = (glb.length as u64, bytes.len() as u64);
        if found != actual {
            return Err(GlbError::Length { found, actual });
        }
        let json: Json = serde_json::from_slice(glb.json)?;
        for (kind, resources) in [("buffer", &json.buffers), ("image", &json.images)] {
            for (index, resource) in resources.iter().enumerate() {
                if let Some(uri) = resource.uri.as_ref().filter(|uri| !uri.starts_with("data:")) {
                    let (what, uri) = (format!("{kind} {index}"), uri.clone());
                    return Err(GlbError::External { what, uri });
                }
            }
        }
        match json.required.into_iter().find(|name| NOT_READ.contains(&name.as_str())) {
            Some(name) => Err(GlbError::Extension { name }),
            None => Ok(Self(bytes)),
        }
    }

    /// The whole file.
    pub fn bytes(&self) -> &'a [u8] {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &str) -> Vec<u8> {
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((json.len() as u32 + 20).to_le_bytes());
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(json.as_bytes());
        bytes
    }

    fn refused(bytes: &[u8]) -> String {
        Glb::new(bytes).unwrap_err().to_string()
    }

    #[test]
    fn valid_files_are_accepted() {
        let json = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4},{"uri":"data:,x"}],
            "extensionsRequired":["KHR_texture_transform"]}"#;
        let bytes = glb(json);
        assert_eq!(Glb::new(&bytes).unwrap().bytes(), bytes);
    }

    #[test]
    fn invalid_files_are_refused_with_a_reason() {
        assert!(refused(b"\x89PNG").starts_with("not a GLB file"), "{}", refused(b"\x89PNG"));
        assert_eq!(refused(b"glTF\x01\0\0\0"), "the GLB version must be 2, got 1");
        let whole = glb("{}");
        assert!(refused(&whole[..21]).contains("ends at byte 22, but the file has 21 bytes"));
        let longer = [&whole[..], b"more"].concat();
        assert!(refused(&longer).ends_with("26 bytes, got 22"), "{}", refused(&longer));
        let mut bytes = whole.clone();
        bytes[12] = 3;
        assert!(refused(&bytes).contains("a chunk of the GLB ends at byte 23"));
        bytes[12] = 2;
        bytes[16] = b'B';
        assert!(refused(&bytes).contains("no JSON chunk"));
        assert!(refused(&glb("{")).contains("cannot parse the JSON chunk"));
    }

    #[test]
    fn files_that_the_page_cannot_show_are_refused_by_name() {
        let external = glb(r#"{"images":[{"bufferView":0},{"uri":"skin.png"}]}"#);
        assert!(refused(&external).starts_with("image 1 is in the external file `skin.png`"));
        let basis = glb(r#"{"extensionsRequired":["KHR_texture_basisu"]}"#);
        assert!(refused(&basis).contains("requires KHR_texture_basisu"));
    }
}
