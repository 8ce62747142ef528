//! The images of a file, and what they are for.

use std::collections::{BTreeMap, HashSet};

use serde::Serialize;
use serde_json::Value;
use uvgraft_image as image;

use super::super::accessor::Accessors;
use super::super::asset::Asset;
use super::super::budget::MAX_NAME_BYTES;
use super::super::check::too_many;
use super::super::document::Document;
use super::super::error::SceneError;
use super::super::images::{bytes, is_ktx2};
use crate::glb::Ktx2Header;

/// An image of a file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct ImageContents {
    /// Its name, or the file that it is in.
    pub name: String,
    /// Its format, such as "PNG"; `None` if that is unknown.
    pub format: Option<&'static str>,
    /// Width and height, if they are known.
    pub size: Option<[u32; 2]>,
    /// Number of bytes as stored; `None` if they are missing.
    pub bytes: Option<usize>,
    /// Why size or bytes are unknown.
    pub problem: Option<String>,
    /// Who uses it.
    pub uses: Vec<ImageUse>,
}

/// A use of an image.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ImageUse {
    /// What for, as glTF and VRM call it: "baseColorTexture", "thumbnailImage", ...
    #[serde(rename = "as")]
    pub role: String,
    /// Name of the material; `None` if none uses it.
    pub material: Option<String>,
}

/// The images; those that cannot be read have a problem instead of a size.
pub(super) fn images(
    asset: &Asset<'_>,
    json: &Value,
    accessors: &Accessors<'_>,
) -> Result<Vec<ImageContents>, SceneError> {
    let mut uses = uses(&asset.document, json)?;
    let each = (0_u32..).zip(&asset.document.images);
    let described = each.map(|(number, stored)| {
        let entry = &json["images"][number as usize];
        let uri = stored.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
        let name = entry["name"].as_str().filter(|name| !name.is_empty()).or(uri);
        let mut found = ImageContents {
            name: name.unwrap_or_default().to_owned(),
            uses: uses.remove(&number).unwrap_or_default(),
            ..ImageContents::default()
        };
        match bytes(stored, asset, accessors, &format!("image {number}")) {
            Ok(bytes) => found.describe(&bytes),
            Err(error) => found.problem = Some(error.to_string()),
        }
        found
    });
    Ok(described.collect())
}

impl ImageContents {
    fn describe(&mut self, encoded: &[u8]) {
        self.bytes = Some(encoded.len());
        if is_ktx2(encoded) {
            self.format = Some("KTX2");
            self.size = Ktx2Header::read(encoded).map(|header| [header.sides[0], header.sides[1]]);
            return;
        }
        match image::decode_header(encoded) {
            Ok(header) => {
                self.format = Some(header.format.name());
                self.size = Some([header.size.width, header.size.height]);
            }
            Err(error) => self.problem = Some(error.to_string()),
        }
    }
}

/// The uses of each image. Extensions refer to textures as glTF itself does: by an object with an
/// `index`, under a key that ends with "Texture".
fn uses<'j>(
    document: &Document,
    json: &'j Value,
) -> Result<BTreeMap<u32, Vec<ImageUse>>, SceneError> {
    let mut uses: BTreeMap<u32, Vec<ImageUse>> = BTreeMap::new();
    let (mut known, mut bytes) = (HashSet::new(), 0);
    let mut add = |image: u32, role: &str, material: Option<&'j str>| {
        if !known.insert((image, role.to_owned(), material)) {
            return Ok(());
        }
        bytes += (role.len() + material.map_or(0, str::len)) as u64;
        too_many("bytes of names of images' uses", bytes, MAX_NAME_BYTES)?;
        uses.entry(image)
            .or_default()
            .push(ImageUse { role: role.to_owned(), material: material.map(str::to_owned) });
        Ok::<_, SceneError>(())
    };
    let source = |texture: &Value| {
        let texture = document.textures.get(texture.as_u64()? as usize)?;
        let extensions = &texture.extensions;
        let others = extensions.webp.as_ref().or(extensions.basisu.as_ref());
        texture.source.or(others.map(|source| source.source))
    };
    for material in json["materials"].as_array().into_iter().flatten() {
        let name = material["name"].as_str().unwrap_or_default();
        let mut rest = vec![material];
        while let Some(object) = rest.pop() {
            for (key, value) in object.as_object().into_iter().flatten() {
                if let (true, Some(image)) = (key.ends_with("Texture"), source(&value["index"])) {
                    add(image, key, Some(name))?;
                } else {
                    rest.push(value);
                }
            }
        }
    }
    let extensions = &json["extensions"];
    for properties in extensions["VRM"]["materialProperties"].as_array().into_iter().flatten() {
        let name = properties["name"].as_str().unwrap_or_default();
        for (key, texture) in properties["textureProperties"].as_object().into_iter().flatten() {
            source(texture).map_or(Ok(()), |image| add(image, key, Some(name)))?;
        }
    }
    let thumbnail = &extensions["VRMC_vrm"]["meta"]["thumbnailImage"];
    let thumbnail = thumbnail.as_u64().and_then(|image| u32::try_from(image).ok());
    let of_vrm0 = source(&extensions["VRM"]["meta"]["texture"]);
    thumbnail.or(of_vrm0).map_or(Ok(()), |image| add(image, "thumbnailImage", None))?;
    Ok(uses)
}
