//! Which texels of a body's texture are skin.
//!
//! Colours alone cannot say: there are shirts in every tone of skin. But skin is connected: it is what one reaches from
//! the face without crossing a step of colour (`steps`, `grow`). Hands, feet, arms and legs that cloth keeps apart
//! from it are skin where their colour agrees closely; what touches skin across a step is cloth whatever its colour
//! (`decide`).

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

/// How far each texel of the grid is skin of the body: grey data at the grid's size.
///
/// - `skin`: the body's, if it is known; the face's, or else the neck's, if not.
///
/// # Errors
/// [`SkinError`] if neither the face nor the neck is of one colour.
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

/// Levels with what lies beside islands like their edges, so that neither filters nor gutters meet a border there.
fn padded(grid: &LayoutGrid, mut levels: Vec<u8>) -> Vec<u8> {
    /// Texels of the grid: a gutter of 16 texels of a texture of its size.
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
