//! The face on a body of darker skin, with each blending mode.

use std::sync::Arc;

use uvgraft::{BlendOptions, Graft, Pair, Size, Sizes, Texture, Tone};
use uvgraft_figure::{Figure, paint_body_in_tone};
use uvgraft_render::View;

use super::views::{BUST, render};
use uvgraft_assembly::drawing::Sheet;

/// Factor on the skin colour of the body.
const DARKER: [f32; 3] = [0.62, 0.52, 0.46];

const SHOT: Size = Size::new(440, 440);

/// The face on a darker body: with a hard border, with a feather, and with either side adapting to
/// the other's tone.
pub(super) struct Blends {
    /// The body with darker skin, without the face.
    pub(super) body: Texture,
    shots: Vec<(&'static str, [Texture; 2])>,
}

impl Blends {
    /// - `sizes`: of the face and of the body's texture.
    pub(super) fn new(
        figure: &Figure,
        pair: &Arc<Pair>,
        face: &Texture,
        sizes: Sizes,
    ) -> anyhow::Result<Self> {
        let body = paint_body_in_tone(figure, sizes.to, DARKER);
        let hard = BlendOptions::default();
        // The figure is in metres.
        let feather = hard.feather(0.015);
        let membrane = feather.membrane();
        let mut shots = Vec::new();
        for (caption, options) in [
            ("pasted", hard),
            ("--feather 15mm", feather),
            ("--blend membrane", membrane),
            ("--blend membrane --tone source", membrane.tone(Tone::Source)),
        ] {
            let graft = Graft::builder(Arc::clone(pair), sizes).blend(options).build()?;
            let result = graft.apply(face, &body)?;
            let views = [20.0, -75.0].map(|azimuth| View { azimuth, ..BUST });
            shots.push((caption, views.map(|view| render(&figure.body, &result, &view, SHOT))));
        }
        Ok(Self { body, shots })
    }

    pub(super) fn picture(&self) -> Sheet {
        const CAPTION: u32 = 44;
        const GAP: u32 = 8;
        let columns = self.shots.len() as u32;
        let width = columns * SHOT.width + (columns - 1) * GAP;
        let mut picture = Sheet::new(Size::new(width, CAPTION + 2 * SHOT.height), [24, 26, 30]);
        for (column, (caption, shots)) in (0..).zip(&self.shots) {
            let left = column * (SHOT.width + GAP);
            for (row, shot) in (0..).zip(shots) {
                picture.paste(shot, left, CAPTION + row * SHOT.height);
            }
            // The longest caption does not fit at twice the font's size.
            let scale = if Sheet::text_width(caption, 2) > SHOT.width { 1 } else { 2 };
            let space = SHOT.width.saturating_sub(Sheet::text_width(caption, scale));
            picture.text(caption, left + space / 2, 22 - 4 * scale, scale, [236, 238, 242]);
        }
        picture
    }
}
