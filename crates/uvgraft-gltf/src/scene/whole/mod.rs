//! Converts any file to a GLB that browsers can show without further decoders: self-contained,
//! uncompressed, with current material extensions. three.js would need WebAssembly decoders for
//! Draco, meshoptimizer and Basis Universal, as large as the whole viewer page; the decoders of the
//! offline renderer are available here anyway.

mod gloss;
mod metadata;

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use serde_json::{Map, Value, json};
use uvgraft::Texture;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_image::{self as image, Format, Image, WriteOptions};

use super::accessor::Accessors;
use super::asset::{Asset, parse_within};
use super::budget::{Budget, Demand, MAX_BYTES, MAX_TEXELS, Purpose};
use super::check::{find, too_many};
use super::document::Document;
use super::error::SceneError;
use super::images;
use super::unpack::unpack;
use crate::container::{Glb, is_glb};
use crate::glb::EmbeddedFormat;

/// Extensions that are resolved here and removed from the file.
const RESOLVED: [&str; 5] = [
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
];

/// Reads a GLB, VRM or glTF file with the external files that it refers to, which bytes cannot have, and converts it to a
/// GLB that is self-contained, uncompressed and free of specular-glossiness materials. A file that
/// already is all this is returned unchanged, but for metadata of its images, such as where a photograph
/// was taken.
///
/// # Errors
/// As [`super::Scene::load`]; parts that need no conversion are not validated.
pub fn whole(input: impl Into<Input>) -> Result<Vec<u8>, ReadError<SceneError>> {
    whole_within(input, Budget::default())
}

/// As [`whole`], with a bound on the memory that the conversion takes.
///
/// # Errors
/// As [`whole`].
pub fn whole_within(
    input: impl Into<Input>,
    budget: Budget,
) -> Result<Vec<u8>, ReadError<SceneError>> {
    parse_within(&input.into(), budget, |bytes, folder| {
        whole_of(bytes, folder, budget).map(Cow::into_owned)
    })
}

pub(super) fn whole_of<'a>(
    bytes: &'a [u8],
    folder: Option<&'a Path>,
    budget: Budget,
) -> Result<Cow<'a, [u8]>, SceneError> {
    let mut asset = Asset::new(bytes, folder, budget)?;
    if is_glb(bytes) && is_whole(&asset.document) {
        return metadata::removed(Cow::Borrowed(bytes));
    }
    let mut buffers = asset.buffers()?;
    let mut demand = asset.demand();
    demand.add_unpacked(&asset.document)?;
    demand.check()?;
    unpack(&mut asset.document, &mut buffers)?;
    let accessors = Accessors::new(&asset.document, &buffers);
    let mut json: Value = serde_json::from_slice(asset.json)?;
    let mut file = File::new(demand);
    file.copy_views(&mut json, &asset.document, &accessors)?;
    update_accessors(&mut json, &asset.document);
    each(&mut json, "meshes", |mesh| {
        each(mesh, "primitives", drop_extensions);
    });
    file.embed_images(&mut json, &asset, &accessors)?;
    gloss::resolve(&mut json, &asset, &accessors, &mut file)?;
    drop_extension_names(&mut json);
    json["bufferViews"] = Value::Array(file.views);
    json["buffers"] = json!([{ "byteLength": file.binary.len().next_multiple_of(4) }]);
    let packed = Glb::write(json.to_string().as_bytes(), &file.binary);
    let too_large = |_| SceneError::TooMany {
        what: "bytes of the uncompressed file",
        found: file.binary.len() as u64,
        max: u32::MAX.into(),
    };
    metadata::removed(Cow::Owned(packed.map_err(too_large)?))
}

/// Whether no conversion is needed.
fn is_whole(document: &Document) -> bool {
    let names = document.extensions_used.iter().chain(&document.extensions_required);
    !document.buffers.iter().any(|buffer| buffer.uri.is_some())
        && !document.images.iter().any(|image| image.uri.is_some())
        && !names.into_iter().any(|name| RESOLVED.contains(&name.as_str()))
}

/// The new file's buffer and the views of it.
struct File {
    binary: Vec<u8>,
    views: Vec<Value>,
    /// Texels of the images that were converted.
    texels: u64,
    /// What the conversion asks for.
    demand: Demand,
}

/// A range of a buffer: its start and its length in bytes.
type Range = (u32, u64, u64);

impl File {
    /// - `demand`: what is asked for so far.
    fn new(demand: Demand) -> Self {
        Self { binary: Vec::new(), views: Vec::new(), texels: 0, demand }
    }

    /// Appends bytes as a view; returns its index. They have been admitted.
    fn add(&mut self, bytes: &[u8], view: Value) -> usize {
        let start = self.binary.len();
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.add_view(start, bytes.len(), view)
    }

    fn add_view(&mut self, start: usize, length: usize, mut view: Value) -> usize {
        view["buffer"] = 0.into();
        view["byteOffset"] = start.into();
        view["byteLength"] = length.into();
        self.views.push(view);
        self.views.len() - 1
    }

    /// Checks that so many bytes may be appended: they are in the buffer and in the file made of it.
    fn admit(&mut self, bytes: u64) -> Result<(), SceneError> {
        self.demand.add(Purpose::Structure, bytes, 2);
        self.demand.check()?;
        too_many("bytes in the uncompressed file", self.binary.len() as u64 + bytes, MAX_BYTES)
    }

    /// Counts an image that is to be decoded, in order to be stored in another way.
    fn count(&mut self, bytes: &[u8], number: u32) -> Result<(), SceneError> {
        let images::Extent { size, bytes_each, .. } = images::extent(bytes, number)?;
        let texels = size.texels() as u64;
        self.texels += texels;
        too_many("texels of images", self.texels, MAX_TEXELS)?;
        // Those that are made of it, and their encoder's.
        self.demand.pass(Purpose::Images, texels * (2 * bytes_each + 2 * 4 + 4));
        self.demand.check()
    }

    fn add_image(&mut self, bytes: &[u8]) -> Result<Value, SceneError> {
        self.admit(bytes.len() as u64)?;
        let kind =
            Format::detect(bytes).and_then(EmbeddedFormat::of).unwrap_or(EmbeddedFormat::Png);
        Ok(json!({ "bufferView": self.add(bytes, json!({})), "mimeType": kind.mime_type() }))
    }

    /// Copies all views in order; those compressed by Draco become placeholders.
    fn copy_views(
        &mut self,
        json: &mut Value,
        document: &Document,
        accessors: &Accessors<'_>,
    ) -> Result<(), SceneError> {
        let mut compressed = BTreeSet::new();
        each(json, "meshes", |mesh| {
            each(mesh, "primitives", |primitive| {
                let view = &primitive["extensions"]["KHR_draco_mesh_compression"]["bufferView"];
                compressed.extend(view.as_u64());
            });
        });
        let mut total = 0_u64;
        let mut starts: HashMap<Range, Option<usize>> = HashMap::new();
        for (index, view) in (0_u32..).zip(&document.buffer_views) {
            let range = (view.buffer, view.byte_offset, view.byte_length);
            if !compressed.contains(&u64::from(index)) && starts.insert(range, None).is_none() {
                total = total.saturating_add(view.byte_length);
            }
        }
        self.admit(total)?;
        for (index, view) in (0_u32..).zip(&document.buffer_views) {
            let own = json.pointer_mut(&format!("/bufferViews/{index}"));
            let mut own = own.map_or_else(|| json!({}), Value::take);
            drop_extensions(&mut own);
            if let Some(stride) = view.byte_stride {
                own["byteStride"] = stride.into();
            }
            if compressed.contains(&u64::from(index)) {
                self.add(&[0; 4], own);
                continue;
            }
            let bytes = accessors.view(index, &format!("buffer view {index}"))?.0;
            let start =
                starts.entry((view.buffer, view.byte_offset, view.byte_length)).or_default();
            if let Some(start) = *start {
                self.add_view(start, bytes.len(), own);
            } else {
                *start = Some(self.binary.len());
                self.add(bytes, own);
            }
        }
        Ok(())
    }

    /// Embeds external images, converts KTX2 images, and updates the textures that refer to them.
    fn embed_images(
        &mut self,
        json: &mut Value,
        asset: &Asset<'_>,
        accessors: &Accessors<'_>,
    ) -> Result<(), SceneError> {
        let mut used = BTreeSet::new();
        for (index, texture) in asset.document.textures.iter().enumerate() {
            let Some(source) = images::source(texture)? else { continue };
            used.insert(source);
            let texture = &mut json["textures"][index];
            if texture["extensions"]["EXT_texture_webp"].is_null() {
                texture["source"] = source.into();
            }
            drop_extensions(texture);
        }
        let stored = |index: u32| {
            let image = find(&asset.document.images, index, "image", "a texture")?;
            let bytes = images::bytes(image, asset, accessors, &format!("image {index}"))?;
            Ok::<_, SceneError>((image, bytes))
        };
        for &index in &used {
            let (_, bytes) = stored(index)?;
            if images::is_ktx2(&bytes) {
                self.count(&bytes, index)?;
            }
        }
        let mut embedded: HashMap<&String, Value> = HashMap::new();
        for index in used {
            let (image, bytes) = stored(index)?;
            let mut put = |image: Value| {
                let name = json["images"][index as usize]["name"].take();
                json["images"][index as usize] = image;
                if !name.is_null() {
                    json["images"][index as usize]["name"] = name;
                }
            };
            if images::is_ktx2(&bytes) {
                let png = png(images::decode(&bytes, index)?, &format!("image {index}"))?;
                put(self.add_image(&png)?);
            } else if let Some(uri) = &image.uri {
                let known = embedded.get(uri).cloned();
                let added = known.map_or_else(|| self.add_image(&bytes), Ok)?;
                embedded.insert(uri, added.clone());
                put(added);
            }
        }
        Ok(())
    }
}

fn png(texture: Texture, place: &str) -> Result<Vec<u8>, SceneError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = Image { texture, icc: None };
    // PNG stores 8-bit values without loss.
    let _written = image::encode(&image, Format::PNG, &WriteOptions::default(), &mut bytes)
        .map_err(|error| SceneError::content(place, error.to_string()))?;
    Ok(bytes.into_inner())
}

/// Updates accessors to the new positions of their values.
fn update_accessors(json: &mut Value, document: &Document) {
    for (index, accessor) in document.accessors.iter().enumerate() {
        let own = &mut json["accessors"][index];
        let Some(view) = accessor.buffer_view else { continue };
        own["bufferView"] = view.into();
        own["byteOffset"] = accessor.byte_offset.into();
        own["componentType"] = accessor.component_type.into();
    }
}

/// Calls a function for each element of a list.
fn each(value: &mut Value, list: &str, call: impl FnMut(&mut Value)) {
    let list = value.get_mut(list).and_then(Value::as_array_mut);
    list.into_iter().flatten().for_each(call);
}

/// Removes resolved extensions from an object.
fn drop_extensions(value: &mut Value) {
    let Some(extensions) = value.get_mut("extensions").and_then(Value::as_object_mut) else {
        return;
    };
    extensions.retain(|name, _| !RESOLVED.contains(&name.as_str()));
    if extensions.is_empty() {
        value.as_object_mut().map(|object| object.remove("extensions"));
    }
}

/// Removes resolved extensions from the file's lists of extensions.
fn drop_extension_names(json: &mut Value) {
    for list in ["extensionsUsed", "extensionsRequired"] {
        let Some(names) = json.get_mut(list).and_then(Value::as_array_mut) else { continue };
        names.retain(|name| !RESOLVED.iter().any(|resolved| name == resolved));
        if names.is_empty() {
            json.as_object_mut().map(|object: &mut Map<_, _>| object.remove(list));
        }
    }
}
