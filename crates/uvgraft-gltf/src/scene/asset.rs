//! A glTF asset: its JSON, and the buffers and images that it refers to.
//!
//! # Source
//! Khronos, "glTF 2.0 Specification", sections 2.7 (asset), 3.6 (buffers) and 3.8 (images).

use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt::Display;
use std::ops::Deref;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use uvgraft_files::input::{Input, ReadError, find_within};

use super::budget::{
    Budget, Demand, MAX_BYTES, MAX_EXTERNAL_BYTES, MAX_JSON_BYTES, MAX_OBJECTS, Purpose,
};
use super::check::too_many;
use super::document::Document;
use super::error::SceneError;
use crate::container::{Glb, is_glb};

/// Bytes that an object of the JSON takes, with what is made of it: those of materials are the largest.
const OBJECT: u64 = 2 << 10;
/// Bytes that an element of a list or an object of the JSON takes: names take most.
const ELEMENT: u64 = 64;

/// The folder of a file's external files; bytes have none.
pub(super) fn folder_of(input: &Input) -> Option<&Path> {
    input.path().map(|path| path.parent().unwrap_or(Path::new("")))
}

/// Reads a file and parses it, with its folder, unless it alone exceeds the budget.
pub(super) fn parse_within<T>(
    input: &Input,
    budget: Budget,
    parse: impl FnOnce(&[u8], Option<&Path>) -> Result<T, SceneError>,
) -> Result<T, ReadError<SceneError>> {
    let length = input.path().and_then(|path| path.metadata().ok()).map_or(0, |meta| meta.len());
    let mut demand = Demand::new(budget);
    demand.store(length.min(MAX_BYTES));
    let named = |reason| ReadError::Content { path: input.name().to_owned(), reason };
    demand.check().map_err(named)?;
    input.parse(MAX_BYTES, |bytes| parse(bytes, folder_of(input)))
}

/// A file split into its parts. Their contents are not validated yet.
pub(super) struct Asset<'a> {
    pub document: Document,
    /// The JSON of the document.
    pub json: &'a [u8],
    /// The binary chunk of a GLB.
    binary: Option<&'a [u8]>,
    /// Folder of external files; without it, they are not read.
    folder: Option<&'a Path>,
    /// What the file asks for.
    demand: RefCell<Demand>,
    /// External files that were read.
    external: RefCell<External>,
}

#[derive(Default)]
struct External {
    files: HashMap<PathBuf, Arc<Vec<u8>>>,
    bytes: u64,
}

/// Bytes of a part of the file, or those of an external file or of data in the JSON, which those who use
/// them share.
#[derive(Clone)]
pub(super) enum Bytes<'a> {
    Part(&'a [u8]),
    Shared(Arc<Vec<u8>>),
}

impl Deref for Bytes<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Part(bytes) => bytes,
            Self::Shared(bytes) => bytes,
        }
    }
}

impl From<Vec<u8>> for Bytes<'_> {
    fn from(bytes: Vec<u8>) -> Self {
        Self::Shared(Arc::new(bytes))
    }
}

impl<'a> Asset<'a> {
    pub fn new(
        bytes: &'a [u8],
        folder: Option<&'a Path>,
        budget: Budget,
    ) -> Result<Self, SceneError> {
        Self::accepting(bytes, folder, budget, is_supported)
    }

    /// As [`Asset::new`], also for files whose textures or materials are not supported.
    pub fn for_geometry(bytes: &'a [u8], folder: Option<&'a Path>) -> Result<Self, SceneError> {
        let of_looks = |name: &str| name.contains("_texture_") || name.contains("_materials_");
        let accepts = |name: &str| is_supported(name) || of_looks(name);
        Self::accepting(bytes, folder, Budget::default(), accepts)
    }

    /// - `accepts`: whether a required extension is accepted.
    fn accepting(
        bytes: &'a [u8],
        folder: Option<&'a Path>,
        budget: Budget,
        accepts: impl Fn(&str) -> bool,
    ) -> Result<Self, SceneError> {
        let (json, binary) = if is_glb(bytes) {
            let glb = Glb::read(bytes)?;
            (json_chunk(glb.json), glb.binary)
        } else {
            (json(bytes)?, None)
        };
        too_many("bytes of JSON", json.len() as u64, MAX_JSON_BYTES)?;
        let count = |wanted: u8| json.iter().filter(|&&byte| byte == wanted).count() as u64;
        let (objects, elements) = (count(b'{'), count(b','));
        too_many("objects in the JSON", objects, MAX_OBJECTS)?;
        let mut demand = Demand::new(budget);
        demand.store(bytes.len() as u64);
        demand.add(Purpose::Structure, objects, OBJECT);
        demand.add(Purpose::Structure, elements, ELEMENT);
        demand.add(Purpose::Structure, json.len() as u64, 1);
        demand.check()?;
        let document: Document = serde_json::from_slice(json)?;
        if !document.asset.version.starts_with("2.") {
            let reason = format!("version must be 2.0, got {:?}", document.asset.version);
            return Err(SceneError::content("asset", reason));
        }
        if let Some(name) = document.extensions_required.iter().find(|name| !accepts(name)) {
            return Err(SceneError::extension(name));
        }
        let (demand, external) = (RefCell::new(demand), RefCell::default());
        Ok(Self { document, json, binary, folder, demand, external })
    }

    /// What the file asks for so far: itself and its external files.
    pub fn demand(&self) -> Demand {
        self.demand.borrow().clone()
    }

    /// The bytes of every buffer, at least as many as declared.
    pub fn buffers(&self) -> Result<Vec<Bytes<'a>>, SceneError> {
        let stand_ins = self.stand_ins();
        let mut buffers = Vec::new();
        for (index, buffer) in self.document.buffers.iter().enumerate() {
            let place = || format!("buffer {index}");
            if stand_ins[index] {
                buffers.push(Bytes::Part(&[]));
                continue;
            }
            let bytes = match (&buffer.uri, self.binary) {
                (Some(uri), _) => {
                    self.resource(uri).map_err(|why| SceneError::content(place(), why))?
                }
                (None, Some(binary)) if index == 0 => Bytes::Part(binary),
                (None, _) => {
                    return Err(SceneError::content(place(), "must have a URI or a binary chunk"));
                }
            };
            if (bytes.len() as u64) < buffer.byte_length {
                let (found, wanted) = (bytes.len(), buffer.byte_length);
                let reason = format!("must have {wanted} bytes, got {found}");
                return Err(SceneError::content(place(), reason));
            }
            buffers.push(bytes);
        }
        Ok(buffers)
    }

    /// Whether each buffer only stands in for what buffer views compressed by meshoptimizer decode to,
    /// so that its data need not be there: it may be marked as such or not.
    fn stand_ins(&self) -> Vec<bool> {
        let buffers = &self.document.buffers;
        let mut is_needed = vec![false; buffers.len()];
        let mut is_stand_in: Vec<bool> = buffers
            .iter()
            .map(|buffer| buffer.extensions.meshopt.as_ref().is_some_and(|it| it.fallback))
            .collect();
        let mark = |marks: &mut [bool], buffer: u32| {
            marks.get_mut(buffer as usize).into_iter().for_each(|mark| *mark = true);
        };
        for view in &self.document.buffer_views {
            let stream = view.extensions.meshopt.as_ref();
            mark(&mut is_needed, stream.map_or(view.buffer, |stream| stream.buffer));
            if stream.is_some() {
                mark(&mut is_stand_in, view.buffer);
            }
        }
        let is_chunk =
            |index: usize| index == 0 && buffers[index].uri.is_none() && self.binary.is_some();
        let both = is_stand_in.iter().zip(&is_needed).enumerate();
        both.map(|(index, (&stands_in, &needed))| stands_in && !needed && !is_chunk(index))
            .collect()
    }

    /// Resolves a URI: embedded data, or an external file in the folder.
    pub fn resource(&self, uri: &str) -> Result<Bytes<'a>, String> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (kind, text) = data.split_once(',').ok_or("data URI without a comma")?;
            if !kind.ends_with(";base64") {
                return Err("data URI must be base64".to_owned());
            }
            let decoded = STANDARD.decode(text);
            self.demand.borrow_mut().add(Purpose::Structure, text.len() as u64, 1);
            return decoded.map(Bytes::from).map_err(|error| format!("invalid data URI: {error}"));
        }
        let folder = self
            .folder
            .ok_or_else(|| format!("refers to the external file {:?}", shortened(uri)))?;
        let path = relative_path(uri)?;
        // Some exporters write names as they are, in which `%20` is not a blank.
        let is_file = |path: &Path| folder.join(path).is_file();
        let is_literal = uri.contains('%') && !is_file(&path) && is_file(Path::new(uri));
        let path = if is_literal { PathBuf::from(uri) } else { path };
        let named = |why: &dyn Display| format!("{}: {why}", folder.join(&path).display());
        let (found, length) = find_within(folder, &path).map_err(|error| named(&error))?;
        if let Some(known) = self.external.borrow().files.get(&found) {
            return Ok(Bytes::Shared(Arc::clone(known)));
        }
        self.admit(length).map_err(|error| named(&error))?;
        let file = Input::from(&found);
        let bytes = Arc::new(file.read(length).map_err(|error| named(&error))?.into_owned());
        self.external.borrow_mut().files.insert(found, Arc::clone(&bytes));
        Ok(Bytes::Shared(bytes))
    }

    /// Counts an external file that is about to be read.
    fn admit(&self, length: u64) -> Result<(), SceneError> {
        too_many("bytes", length, MAX_BYTES)?;
        let mut external = self.external.borrow_mut();
        external.bytes += length;
        too_many("bytes in external files", external.bytes, MAX_EXTERNAL_BYTES)?;
        let mut demand = self.demand.borrow_mut();
        demand.store(length);
        demand.check()
    }
}

/// Required extensions that are accepted: supported, or without effect on rendering.
const SUPPORTED: [&str; 29] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    "VRM",
    "VRMC_materials_hdr_emissiveMultiplier",
    "VRMC_materials_mtoon",
    "VRMC_node_constraint",
    "VRMC_springBone",
    "VRMC_vrm",
    "VRMC_vrm_animation",
];

fn is_supported(extension: &str) -> bool {
    SUPPORTED.contains(&extension) || (cfg!(feature = "ktx2") && extension == "KHR_texture_basisu")
}

/// The JSON of a GLB: blanks pad it, but some exporters use NUL, and some write a BOM.
fn json_chunk(chunk: &[u8]) -> &[u8] {
    let is_padding = |byte: &u8| *byte == 0 || byte.is_ascii_whitespace();
    let end = chunk.iter().rposition(|byte| !is_padding(byte)).map_or(0, |last| last + 1);
    without_bom(&chunk[..end])
}

fn without_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The bytes of a JSON file, without BOM; errors if they do not look like JSON.
fn json(bytes: &[u8]) -> Result<&[u8], SceneError> {
    let bytes = without_bom(bytes);
    match bytes.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'{') => Ok(bytes),
        _ => Err(SceneError::NotGltf { start: bytes[..bytes.len().min(8)].to_vec() }),
    }
}

/// The relative path in a URI, which must not leave the folder. Exporters on Windows write
/// backslashes, which no URI has.
fn relative_path(uri: &str) -> Result<PathBuf, String> {
    let scheme = uri.split_once("://").map(|(scheme, _)| scheme.to_ascii_lowercase());
    if scheme.is_some_and(|scheme| scheme != "file") {
        return Err(format!(
            "{:?} must be a file in the model's folder, got a URL: download it into that folder, and \
             write its name as the URI",
            shortened(uri)
        ));
    }
    let path = PathBuf::from(percent_decoded(uri)?.replace('\\', "/"));
    let mut parts = path.components().filter(|part| *part != Component::CurDir).peekable();
    let names_a_file =
        parts.peek().is_some() && parts.all(|part| matches!(part, Component::Normal(_)));
    if !names_a_file || uri.contains(':') {
        return Err(format!("{:?} must be in the model's folder or below", shortened(uri)));
    }
    Ok(path.components().filter(|part| *part != Component::CurDir).collect())
}

/// Decodes percent escapes such as `%20`.
fn percent_decoded(uri: &str) -> Result<String, String> {
    let bad = || format!("{:?} is not a URI", shortened(uri));
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let mut digit = || rest.next().and_then(|digit| char::from(digit).to_digit(16));
        let (Some(high), Some(low)) = (digit(), digit()) else { return Err(bad()) };
        bytes.push((16 * high + low) as u8);
    }
    String::from_utf8(bytes).map_err(|_| bad())
}

fn shortened(uri: &str) -> String {
    const MAX: usize = 60;
    if uri.chars().count() <= MAX { uri.to_owned() } else { uri.chars().take(MAX).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn external_files_must_be_in_the_folder() {
        for (uri, path) in [
            ("a.bin", "a.bin"),
            ("./a.bin", "a.bin"),
            ("b/c%20d.png", "b/c d.png"),
            ("b\\c d.png", "b/c d.png"),
            (".\\b%5cc.png", "b/c.png"),
            ("t%C3%AAte.png", "tête.png"),
        ] {
            assert_eq!(relative_path(uri), Ok(PathBuf::from(path)), "{uri}");
        }
        for uri in [
            "/etc/passwd",
            "../a.bin",
            "a/../../b",
            "..\\a.bin",
            "a\\..\\..\\b",
            "C:\\a.bin",
            "\\\\host\\a.bin",
            "file:///a.bin",
            "",
            ".",
            "./",
            "%2e%2e/a",
            "%2e%2e%5Ca",
            "%2",
        ] {
            assert!(relative_path(uri).is_err(), "{uri}");
        }
        for uri in ["http://x/y", "HTTPS://x/y.bin", "blob://x"] {
            assert!(relative_path(uri).is_err_and(|why| why.contains("got a URL")), "{uri}");
        }
    }

    #[test]
    fn json_is_padded_and_marked_in_many_ways() {
        let json = br#"{"asset":{"version":"2.0"}}"#;
        for (before, after) in
            [("", ""), ("", "\0\0"), ("", " \n\0"), ("\u{feff}", ""), ("\u{feff}", "\0  ")]
        {
            let chunk = [before.as_bytes(), json, after.as_bytes()].concat();
            let glb = Glb::write(&chunk, &[]).unwrap();
            let found = Asset::new(&glb, None, Budget::default()).map(|asset| asset.json.to_vec());
            assert_eq!(found.unwrap(), json, "{chunk:?}");
        }
        let glb = Glb::write(b"\0\0\0\0", &[]).unwrap();
        let found = Asset::new(&glb, None, Budget::default());
        assert!(found.is_err_and(|error| error.to_string().contains("JSON")));
    }

    #[test]
    fn unsupported_required_extensions_are_named() {
        let json = br#"{"asset":{"version":"2.0"},"extensionsRequired":["EXT_mesh_of_fog"]}"#;
        let error = Asset::new(json, None, Budget::default()).err().map(|error| error.to_string());
        let wanted = ["EXT_mesh_of_fog", "gltf-transform"];
        assert!(error.is_some_and(|error| wanted.iter().all(|wanted| error.contains(wanted))));
    }
}
