//! What a GLB must be like for the page to show it.
//!
//! Based on the glTF 2.0 specification, section 4 (GLB File Format): 12 bytes of header (magic, version,
//! length of the whole), then a JSON chunk (length, type, text). VRM files are GLB files.

use serde::Deserialize;

/// A GLB whose header, length and JSON are as they should be, and that needs nothing which the page lacks.
#[derive(Debug, Clone, Copy)]
pub struct Glb<'a>(&'a [u8]);

/// Why a file cannot be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GlbError {
    /// The file is of another kind.
    #[error("not a GLB or VRM file: it begins with {found:02x?}, wanted [67, 6c, 54, 46] (glTF)")]
    Magic {
        /// The first four bytes, or fewer.
        found: Vec<u8>,
    },
    /// A container of another version.
    #[error("GLB version {found}, wanted 2")]
    Version {
        /// What the header says.
        found: u32,
    },
    /// The header's length is not the file's.
    #[error("its header says {told} bytes, the file has {actual}")]
    Length {
        /// What the header says.
        told: u32,
        /// The file's length.
        actual: u64,
    },
    /// The first chunk is no JSON, or ends behind the file.
    #[error("its first chunk is no JSON of up to {most} bytes: type {found:02x?}, {length} bytes")]
    Chunk {
        /// The chunk's type.
        found: [u8; 4],
        /// The length that the chunk tells.
        length: u32,
        /// What is left of the file.
        most: u64,
    },
    /// The JSON cannot be read.
    #[error("its JSON cannot be read: {0}")]
    Json(#[from] serde_json::Error),
    /// A part of it is in another file.
    #[error(
        "{what} is the file `{uri}`, which a page of one file cannot load; wanted a GLB that holds it"
    )]
    External {
        /// Such as `image 0`.
        what: String,
        /// Where it is.
        uri: String,
    },
    /// The file cannot be shown without an extension that the page does not know.
    #[error("it requires {name}, which the viewer does not read; write it without")]
    Extension {
        /// The extension's name.
        name: String,
    },
}

/// Extensions that need a decoder, of which the page has none.
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
    /// [`GlbError`] with what was found. Meshes and images are not looked into: the page says what is
    /// wrong with those.
    pub fn new(bytes: &'a [u8]) -> Result<Self, GlbError> {
        if !bytes.starts_with(b"glTF") {
            return Err(GlbError::Magic { found: bytes[..bytes.len().min(4)].to_vec() });
        }
        let word = |at: usize| {
            let bytes = bytes.get(at..at + 4).unwrap_or_default();
            bytes.try_into().map_or(0, u32::from_le_bytes)
        };
        let (version, told) = (word(4), word(8));
        if version != 2 {
            return Err(GlbError::Version { found: version });
        }
        let actual = bytes.len() as u64;
        if u64::from(told) != actual {
            return Err(GlbError::Length { told, actual });
        }
        let (length, kind) = (word(12), word(16).to_le_bytes());
        let text = bytes.get(20..).unwrap_or_default();
        let Some(text) = text.get(..length as usize).filter(|_| kind == *b"JSON") else {
            return Err(GlbError::Chunk { found: kind, length, most: text.len() as u64 });
        };
        let json: Json = serde_json::from_slice(text)?;
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
    fn sound_files_are_taken_whole() {
        let json = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4},{"uri":"data:,x"}],
            "extensionsRequired":["KHR_texture_transform"]}"#;
        let bytes = glb(json);
        assert_eq!(Glb::new(&bytes).unwrap().bytes(), bytes);
    }

    #[test]
    fn other_files_are_refused_with_what_was_found() {
        assert!(refused(b"\x89PNG").contains("begins with [89, 50, 4e, 47]"));
        assert!(refused(b"").contains("begins with []"));
        assert_eq!(refused(b"glTF\x01\0\0\0"), "GLB version 1, wanted 2");
        assert_eq!(refused(b"glTF"), "GLB version 0, wanted 2");
        let whole = glb("{}");
        assert_eq!(refused(&whole[..21]), "its header says 22 bytes, the file has 21");
        let mut bytes = whole.clone();
        bytes[12] = 3;
        assert!(refused(&bytes).contains("no JSON of up to 2 bytes"), "{}", refused(&bytes));
        bytes[12] = 2;
        bytes[16] = b'B';
        assert!(refused(&bytes).contains("no JSON"));
        assert!(refused(b"glTF\x02\0\0\0\x0c\0\0\0").contains("no JSON of up to 0 bytes"));
        assert!(refused(&glb("{")).contains("JSON cannot be read"));
    }

    #[test]
    fn files_that_the_page_cannot_show_are_refused_by_name() {
        let external = glb(r#"{"images":[{"bufferView":0},{"uri":"skin.png"}]}"#);
        assert!(refused(&external).starts_with("image 1 is the file `skin.png`"));
        let basis = glb(r#"{"extensionsRequired":["KHR_texture_basisu"]}"#);
        assert!(refused(&basis).contains("requires KHR_texture_basisu"));
    }
}
