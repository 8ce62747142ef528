//! Names of the images of base colours: parts with different images have layouts of their own.

use std::collections::HashMap;

use super::super::accessor::Accessors;
use super::super::appearance::base_color_texture;
use super::super::budget::MAX_BYTES;
use super::super::document::{Document, Image, Material, Primitive};
use super::super::images::source;

/// Names are cut off after this many characters.
const MAX_NAME: usize = 60;

/// Bytes of images that are compared: those of any file. Views may overlap, so that there may be more; their images
/// then count as different.
const MAX_COMPARED: usize = MAX_BYTES as usize;

/// For each material the name of the image of its base colour.
pub(super) struct ImageNames(Vec<String>);

/// What makes images the same: some exporters write an image once for each material that uses it.
#[derive(PartialEq, Eq, Hash)]
enum Content<'a> {
    File(&'a str),
    Bytes(&'a [u8]),
    /// Without readable content.
    Number(u32),
}

impl ImageNames {
    pub fn new(document: &Document, accessors: &Accessors<'_>) -> Self {
        let images: Vec<Option<u32>> = document
            .materials
            .iter()
            .map(|material| base_color_image(document, material))
            .collect();
        let mut names: HashMap<Content<'_>, String> = HashMap::new();
        let mut taken: HashMap<String, u32> = HashMap::new();
        let mut of_images: HashMap<u32, String> = HashMap::new();
        let mut at_views: HashMap<u32, u32> = HashMap::new();
        let mut left = MAX_COMPARED;
        let mut name_of = |number: u32| {
            // Images of one view are one, without a look at their bytes.
            let view = document.images.get(number as usize).and_then(|image| image.buffer_view);
            let number = view.map_or(number, |view| *at_views.entry(view).or_insert(number));
            if let Some(name) = of_images.get(&number) {
                return name.clone();
            }
            let image = document.images.get(number as usize);
            let content = image.and_then(|image| content(image, accessors, &mut left));
            let name = names.entry(content.unwrap_or(Content::Number(number)));
            let name = name.or_insert_with(|| {
                let name = image.map_or_else(String::new, own_name);
                let is_free = *taken.entry(name.clone()).or_insert(number) == number;
                match (name.as_str(), is_free) {
                    ("", _) => format!("image {number}"),
                    (_, true) => name,
                    (_, false) => format!("{name} (image {number})"),
                }
            });
            of_images.insert(number, name.clone());
            name.clone()
        };
        Self(images.into_iter().map(|image| image.map_or_else(String::new, &mut name_of)).collect())
    }

    /// The name of the image of a primitive's base colour, which no other image of the file has; empty
    /// if it has none.
    pub fn of(&self, primitive: &Primitive) -> &str {
        let material = primitive.material.and_then(|index| self.0.get(index as usize));
        material.map_or("", String::as_str)
    }
}

/// The image of a material's base colour. Geometry is read without its images, so what is wrong with
/// them is no error.
fn base_color_image(document: &Document, material: &Material) -> Option<u32> {
    let texture = base_color_texture(material)?.index;
    // AVIF names no image that is read, so the texture stands for it.
    let without_image = (document.images.len() as u32).saturating_add(texture);
    let texture = document.textures.get(texture as usize)?;
    source(texture).unwrap_or(Some(without_image))
}

/// - `left`: bytes that may still be compared.
fn content<'a>(
    image: &'a Image,
    accessors: &Accessors<'a>,
    left: &mut usize,
) -> Option<Content<'a>> {
    if let Some(uri) = &image.uri {
        return Some(Content::File(uri));
    }
    let (bytes, _) = accessors.view(image.buffer_view?, "image").ok()?;
    *left = left.checked_sub(bytes.len())?;
    Some(Content::Bytes(bytes))
}

/// The name of an image or of its file; empty where it has neither.
fn own_name(image: &Image) -> String {
    let file = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
    let name = image.name.as_deref().filter(|name| !name.trim().is_empty());
    let name = name.or(file).unwrap_or_default();
    name.chars().filter(|character| !character.is_control()).take(MAX_NAME).collect()
}
