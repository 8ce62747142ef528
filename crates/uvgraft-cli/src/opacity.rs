//! Transparent textures in comparisons, which look at colours only.

use std::path::Path;

use uvgraft::{Depth, Size, TexelsMut, Texture};

use crate::failure::warn;

/// Whether every texel is opaque.
fn is_opaque(texture: &Texture) -> bool {
    let Size { width, height } = texture.size();
    let channels = texture.channels();
    let alpha = channels.count() - 1;
    !channels.has_alpha()
        || (0..height).all(|y| (0..width).all(|x| texture.get(x, y, alpha) >= 1.0))
}

/// Warns that a texture is composited over black, if it is not opaque.
pub(crate) fn warn_unless_opaque(texture: &Texture, path: &Path) {
    if !is_opaque(texture) {
        let name = path.display();
        warn(format_args!("{name} has transparent texels; comparing it over black"));
    }
}

/// The colours over black, without alpha, at the same depth.
pub(crate) fn over_black(texture: Texture) -> Texture {
    let (channels, depth) = (texture.channels(), texture.depth());
    if !channels.has_alpha() {
        return texture;
    }
    let mut texture = texture.converted(channels, Depth::F32);
    if let TexelsMut::F32(values) = texture.texels_mut() {
        for texel in values.chunks_exact_mut(channels.count()) {
            if let [colors @ .., alpha] = texel {
                colors.iter_mut().for_each(|color| *color *= *alpha);
            }
        }
    }
    texture.converted(channels.without_alpha(), depth)
}
