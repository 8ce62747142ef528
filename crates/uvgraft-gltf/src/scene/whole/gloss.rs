//! Converts specular-glossiness materials to metallic-roughness with a specular colour.
//!
//! # Source
//! Khronos, "KHR_materials_specular", "Conversions": as the index of refraction goes to infinity,
//! the reflectance at normal incidence becomes the specular colour itself.

use std::collections::HashMap;

use serde_json::{Value, json};
use uvgraft::{Channels, Depth, Encoding, Texels, Texture};

use super::{File, drop_extensions, png};
use crate::scene::accessor::Accessors;
use crate::scene::asset::{Asset, Bytes};
use crate::scene::check::find;
use crate::scene::document::SpecularGlossiness;
use crate::scene::error::SceneError;
use crate::scene::images;

/// Practically infinite, so that the specular colour alone sets the reflectance.
const NO_BOUND: f32 = 1000.0;

/// Rewrites the materials in `json`: diffuse becomes the base colour, `1 - glossiness` the
/// roughness, and specular the `specularColorFactor` of a non-metal with a practically infinite
/// index of refraction.
pub(super) fn resolve(
    json: &mut Value,
    asset: &Asset<'_>,
    accessors: &Accessors<'_>,
    file: &mut File,
) -> Result<(), SceneError> {
    let mut known = HashMap::new();
    for material in &asset.document.materials {
        let gloss = material.extensions.specular_glossiness.as_ref();
        let Some(gloss) = gloss.filter(|gloss| known.insert(roughness_key(gloss), None).is_none())
        else {
            continue;
        };
        if let Some((source, bytes)) = stored(gloss, asset, accessors)? {
            file.count(&bytes, source)?;
        }
    }
    if known.is_empty() {
        return Ok(());
    }
    for (index, material) in asset.document.materials.iter().enumerate() {
        let Some(gloss) = &material.extensions.specular_glossiness else { continue };
        let own =
            json["materials"][index]["extensions"]["KHR_materials_pbrSpecularGlossiness"].take();
        drop_extensions(&mut json["materials"][index]);
        let mut rough = None;
        if !own["specularGlossinessTexture"].is_null() {
            let key = roughness_key(gloss);
            rough = match known.get(&key) {
                Some(&Some(rough)) => Some(rough),
                _ => roughness(gloss, json, asset, accessors, file)?,
            };
            known.insert(key, rough);
        }
        rewrite(&mut json["materials"][index], gloss, &own, rough);
    }
    let used = &mut json["extensionsUsed"];
    for name in ["KHR_materials_specular", "KHR_materials_ior"] {
        if let Some(used) = used.as_array_mut()
            && !used.iter().any(|known| known == name)
        {
            used.push(name.into());
        }
    }
    Ok(())
}

/// Writes a material as metallic-roughness.
///
/// - `own`: what its extension was in JSON.
/// - `rough`: the texture of its roughness.
fn rewrite(material: &mut Value, gloss: &SpecularGlossiness, own: &Value, rough: Option<usize>) {
    let mut pbr = json!({
        "baseColorFactor": gloss.diffuse_factor.unwrap_or([1.0; 4]),
        "metallicFactor": 0.0,
        "roughnessFactor": 1.0 - gloss.glossiness_factor.unwrap_or(1.0),
    });
    let mut specular = json!({
        "specularColorFactor": gloss.specular_factor.unwrap_or([1.0; 3]),
    });
    if !own["diffuseTexture"].is_null() {
        pbr["baseColorTexture"] = own["diffuseTexture"].clone();
    }
    let texture = &own["specularGlossinessTexture"];
    if !texture.is_null() {
        specular["specularColorTexture"] = texture.clone();
    }
    if let Some(rough) = rough {
        let mut texture = texture.clone();
        texture["index"] = rough.into();
        pbr["metallicRoughnessTexture"] = texture;
        pbr["roughnessFactor"] = json!(1.0);
    }
    material["pbrMetallicRoughness"] = pbr;
    material["extensions"]["KHR_materials_specular"] = specular;
    material["extensions"]["KHR_materials_ior"] = json!({ "ior": NO_BOUND });
}

/// Equal where textures of the roughness are equal.
fn roughness_key(gloss: &SpecularGlossiness) -> (Option<u32>, u32) {
    let texture = gloss.specular_glossiness_texture.as_ref().map(|info| info.index);
    (texture, gloss.glossiness_factor.unwrap_or(1.0).to_bits())
}

/// The image of specular colours and glossiness, by its index, and its bytes.
fn stored<'a>(
    gloss: &SpecularGlossiness,
    asset: &Asset<'a>,
    accessors: &Accessors<'a>,
) -> Result<Option<(u32, Bytes<'a>)>, SceneError> {
    let document = &asset.document;
    let Some(info) = &gloss.specular_glossiness_texture else { return Ok(None) };
    let texture = find(&document.textures, info.index, "texture", "a material")?;
    let Some(source) = images::source(texture)? else { return Ok(None) };
    let image = find(&document.images, source, "image", "a texture")?;
    let bytes = images::bytes(image, asset, accessors, &format!("image {source}"))?;
    Ok(Some((source, bytes)))
}

/// Adds a texture whose green channel is 1 minus the glossiness; returns its index in the new file.
fn roughness(
    gloss: &SpecularGlossiness,
    json: &mut Value,
    asset: &Asset<'_>,
    accessors: &Accessors<'_>,
    file: &mut File,
) -> Result<Option<usize>, SceneError> {
    let Some(info) = &gloss.specular_glossiness_texture else { return Ok(None) };
    let Some((source, bytes)) = stored(gloss, asset, accessors)? else { return Ok(None) };
    let place = format!("image {source}");
    let picture = images::decode(&bytes, source)?;
    let size = picture.size();
    let factor = gloss.glossiness_factor.unwrap_or(1.0);
    let mut texels = Vec::with_capacity(3 * size.texels());
    if let Texels::U8(rgba) = picture.converted(Channels::Rgba, Depth::U8).into_texels() {
        for texel in rgba.chunks_exact(4) {
            let rough = 255.0 - factor * f32::from(texel[3]);
            texels.extend([0, rough.round() as u8, 0]);
        }
    }
    let texture = Texture::new(size, Channels::Rgb, Encoding::Data, Texels::U8(texels))
        .map_err(|error| SceneError::content(place.as_str(), error.to_string()))?;
    let image = file.add_image(&png(texture, &place)?)?;
    let mut new = json["textures"][info.index as usize].clone();
    drop_extensions(&mut new);
    if let Some(extensions) = new.get_mut("extensions").and_then(Value::as_object_mut) {
        extensions.remove("EXT_texture_webp");
    }
    new["source"] = push(&mut json["images"], image).into();
    Ok(Some(push(&mut json["textures"], new)))
}

fn push(list: &mut Value, value: Value) -> usize {
    let Some(list) = list.as_array_mut() else { return 0 };
    list.push(value);
    list.len() - 1
}
