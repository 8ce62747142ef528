//! Float images with NaN or infinite texels.

use std::path::Path;

use uvgraft::{Encoding, Texture};

/// Replaces NaN and infinite texels as [`Texture::without_non_finite`] does, and returns a warning
/// if there were any.
///
/// - `path`: the file, for the warning.
pub fn without_non_finite(texture: Texture, path: &Path) -> (Texture, Option<String>) {
    let (texture, count) = texture.without_non_finite();
    let texels = match count {
        0 => return (texture, None),
        1 => "1 texel is NaN or infinite;".to_owned(),
        _ => format!("{count} texels are NaN or infinite;"),
    };
    let remedy = if texture.encoding() == Encoding::Data {
        "using the value of the nearest finite texel"
    } else {
        "showing the base there"
    };
    (texture, Some(format!("{}: {texels} {remedy}", path.display())))
}
