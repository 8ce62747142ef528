//! Names of the images of base colours: parts with different images have layouts of their own.

use std::collections::HashMap;

use super::super::accessor::Accessors;
use super::super::appearance::base_color_texture;
use super::super::document::{Document, Image, Material, Primitive};
use super::super::images::source;

/// Names are cut off after this many characters.
const MAX_NAME: usize = 60;

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
        let mut name_of = |number: u32| {
            let image = document.images.get(number as usize);
            let content = image.and_then(|image| content(image, accessors));
            let name = names.entry(content.unwrap_or(Content::Number(number)));
            name.or_insert_with(|| {
                let name = image.map_or_else(String::new, own_name);
                let is_free = *taken.entry(name.clone()).or_insert(number) == number;
                match (name.as_str(), is_free) {
                    ("", _) => format!("image {number}"),
                    (_, true) => name,
                    (_, false) => format!("{name} (image {number})"),
                }
            })
            .clone()
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

fn content<'a>(image: &'a Image, accessors: &Accessors<'a>) -> Option<Content<'a>> {
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => Some(Content::File(uri)),
        (None, Some(view)) => {
            accessors.view(view, "image").ok().map(|(bytes, _)| Content::Bytes(bytes))
        }
        (None, None) => None,
    }
}

/// The name of an image or of its file; empty where it has neither.
fn own_name(image: &Image) -> String {
    let file = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
    let name = image.name.as_deref().filter(|name| !name.trim().is_empty());
    let name = name.or(file).unwrap_or_default();
    name.chars().filter(|character| !character.is_control()).take(MAX_NAME).collect()
}
