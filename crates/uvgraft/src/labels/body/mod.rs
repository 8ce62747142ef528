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
mod steps;

pub(crate) use layout::BodyLayout;

use crate::color::Encoding;
use crate::layout_grid::GridColors;
use crate::skin::SkinError;
use crate::texture::{Channels, Texels, Texture};

use decide::Decision;
use steps::Steps;

/// How far each texel of the grid is skin of the body: grey data at the grid's size.
///
/// # Errors
/// [`SkinError`] if neither the face nor the neck is of one colour.
pub(crate) fn body_skin(body: &BodyLayout, base: &Texture) -> Result<Texture, SkinError> {
    let colors = GridColors::new(base, &body.grid);
    let steps = Steps::new(body, &colors);
    let texels = Texels::U8(Decision::new(body, &colors, &steps)?.levels());
    Ok(Texture::new(body.grid.size(), Channels::Grey, Encoding::Data, texels)
        .expect("the size is that of a grid"))
}
