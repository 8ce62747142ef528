//! Skin segmentation of a body's texture.
//!
//! Colour alone isn't enough: shirts come in every skin tone. But skin is connected: it is
//! what can be reached from the face without crossing a colour step (`steps`, `grow`). Hands,
//! feet, arms and legs that cloth separates from it are skin if their colour matches closely;
//! what adjoins skin across a step is cloth, whatever its colour (`decide`).

mod barrier;
mod decide;
mod grow;
mod layout;
mod shells;
mod steps;
mod taps;

use crate::color::Encoding;
use crate::layout_grid::{GridColors, LayoutGrid, NONE};
use crate::skin::{SkinError, SkinModel};
use crate::texture::{Channels, Size, Texels, Texture};
use decide::Decision;
pub(crate) use layout::BodyLayout;
use steps::Steps;

/// The body's skin mask: grey data at the grid's size, 255 for skin.
///
/// - `skin`: the body's skin colours, if known. `None` estimates them from the face, or
///   failing that from the neck.
///
/// # Errors
/// [`SkinError`] if neither the face nor the neck has a uniform colour.
pub(crate) fn body_skin(
    body: &BodyLayout,
    base: &Texture,
    skin: Option<&SkinModel>,
) -> Result<Texture, SkinError> {
    let colors = GridColors::new(base, &body.grid);
    let steps = Steps::new(body, &colors);
    let levels = Decision::new(body, &colors, &steps, skin)?.levels();
    let texels = Texels::U8(padded(&body.grid, levels));
    Ok(Texture::new(body.grid.size(), Channels::Grey, Encoding::Data, texels)
        .expect("the size is that of a grid"))
}

/// Extends levels outwards from the edges of islands, so that filters and gutters see no
/// edge there.
fn padded(grid: &LayoutGrid, mut levels: Vec<u8>) -> Vec<u8> {
    /// Texels of the grid: enough for a gutter of 16 texels in a texture of the same size.
    const RINGS: u32 = 18;
    let Size { width, height } = grid.size();
    let mut ring: Vec<u32> = (0..levels.len() as u32)
        .filter(|&texel| grid.faces()[texel as usize] != NONE && grid.is_at_edge(texel))
        .collect();
    let mut is_set: Vec<bool> = grid.faces().iter().map(|&face| face != NONE).collect();
    for _ in 0..RINGS {
        let mut next = Vec::new();
        for texel in ring {
            let (x, y) = (texel % width, texel / width);
            let beside = [
                (x > 0).then(|| texel - 1),
                (x + 1 < width).then(|| texel + 1),
                (y > 0).then(|| texel - width),
                (y + 1 < height).then(|| texel + width),
            ];
            for near in beside.into_iter().flatten() {
                if !std::mem::replace(&mut is_set[near as usize], true) {
                    levels[near as usize] = levels[texel as usize];
                    next.push(near);
                }
            }
        }
        ring = next;
    }
    levels
}
