//! Converts any file to a GLB that browsers can show without further decoders: self-contained,
//! uncompressed, with current material extensions. three.js would need WebAssembly decoders for
//! Draco, meshoptimizer and Basis Universal, as large as the whole viewer page; the decoders of the
//! offline renderer are available here anyway.

mod gloss;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Map, Value, json};
use uvgraft::Texture;
use uvgraft_io::image::{self, Format, Image, WriteOptions};
use uvgraft_io::input::{Input, ReadError};

use super::accessor::Accessors;
use super::asset::{Asset, MAX_BYTES, folder_of};
use super::check::find;
use super::document::Document;
use super::error::SceneError;
use super::images;
use super::unpack::unpack;
use crate::container::{Glb, is_glb};

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
/// already is all this is returned unchanged.
///
/// # Errors
/// As [`super::Scene::load`]; parts that need no conversion are not validated.
pub fn whole(input: impl Into<Input>) -> Result<Vec<u8>, ReadError<SceneError>> {
    let input = input.into();
    input.parse(MAX_BYTES, |bytes| whole_of(bytes, folder_of(&input)).map(Cow::into_owned))
}

pub(super) fn whole_of<'a>(
    bytes: &'a [u8],
    folder: Option<&'a Path>,
) -> Result<Cow<'a, [u8]>, SceneError> {
    let mut asset = Asset::new(bytes, folder)?;
    if is_glb(bytes) && is_whole(&asset.document) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut buffers = asset.buffers()?;
    unpack(&mut asset.document, &mut buffers)?;
    let accessors = Accessors::new(&asset.document, &buffers);
    let mut json: Value = serde_json::from_slice(asset.json)?;
    let mut file = File { binary: Vec::new(), views: Vec::new() };
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
    packed.map(Cow::Owned).map_err(too_large)
}

/// Whether no conversion is needed.
fn is_whole(document: &Document) -> bool {
    let outside = |uri: &Option<String>| uri.as_ref().is_some_and(|uri| !uri.starts_with("data:"));
    let names = document.extensions_used.iter().chain(&document.extensions_required);
    !document.buffers.iter().any(|buffer| outside(&buffer.uri))
        && !document.images.iter().any(|image| outside(&image.uri))
        && !names.into_iter().any(|name| RESOLVED.contains(&name.as_str()))
}

/// The new file's buffer and the views of it.
struct File {
    binary: Vec<u8>,
    views: Vec<Value>,
}

impl File {
    /// Appends bytes as a view; returns its index.
    fn add(&mut self, bytes: &[u8], mut view: Value) -> usize {
        view["buffer"] = 0.into();
        view["byteOffset"] = self.binary.len().into();
        view["byteLength"] = bytes.len().into();
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn add_image(&mut self, bytes: &[u8]) -> Value {
        let kind = match Format::detect(bytes) {
            Some(Format::Jpeg) => "image/jpeg",
            Some(Format::WebP) => "image/webp",
            _ => "image/png",
        };
        json!({ "bufferView": self.add(bytes, json!({})), "mimeType": kind })
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
        for (index, view) in (0..).zip(&document.buffer_views) {
            let own = json.pointer_mut(&format!("/bufferViews/{index}"));
            let mut own = own.map_or_else(|| json!({}), Value::take);
            drop_extensions(&mut own);
            if let Some(stride) = view.byte_stride {
                own["byteStride"] = stride.into();
            }
            let bytes = match compressed.contains(&u64::from(index)) {
                true => &[0; 4][..],
                false => accessors.view(index, &format!("buffer view {index}"))?.0,
            };
            self.add(bytes, own);
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
        for index in used {
            let place = format!("image {index}");
            let image = find(&asset.document.images, index, "image", "a texture")?;
            let bytes = images::bytes(image, asset, accessors, &place)?;
            let mut put = |image: Value| {
                let name = json["images"][index as usize]["name"].take();
                json["images"][index as usize] = image;
                if !name.is_null() {
                    json["images"][index as usize]["name"] = name;
                }
            };
            if images::is_ktx2(&bytes) {
                images::size(&bytes, index)?;
                let png = png(images::decode(&bytes, index)?, &place)?;
                put(self.add_image(&png));
            } else if image.uri.is_some() {
                put(self.add_image(&bytes));
            }
        }
        Ok(())
    }
}

fn png(texture: Texture, place: &str) -> Result<Vec<u8>, SceneError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = Image { texture, icc: None };
    // PNG stores 8-bit values without loss.
    let _written = image::encode(&image, Format::Png, &WriteOptions::default(), &mut bytes)
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
