//! A transferred face before blending.

use std::sync::Arc;

use uvgraft::blend::BlendDomain;
use uvgraft::color::Encoding;
use uvgraft::content::Content;
use uvgraft::filter::Filter;
use uvgraft::graft::{Graft, GraftError};
use uvgraft::labels::{Label, Labels};
use uvgraft::texture::{Channels, Depth, Size, Sizes, Texels, Texture};

use super::sample::texel;

/// A face pasted onto a transparent texture with a hard edge, with labels for hair and skin.
#[derive(Debug, Clone)]
pub struct TransferredFace {
    /// Transparent outside the face.
    texture: Texture,
    /// Weights of hair or brow, in red, and of skin, in green, in the same layout.
    labels: Option<Texture>,
}

/// Label weights of a texel of a [`TransferredFace`], each from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LabelWeights {
    /// Hair of the head, beard and brows.
    pub hair: f32,
    pub skin: f32,
}

impl TransferredFace {
    /// Transfers a face, and the labels found in it.
    ///
    /// - `domain`: the pair and the direction in which the face was transferred.
    /// - `face`: in the source layout, of any size.
    /// - `size`: size of the texture to compare with.
    ///
    /// A texture that does not show a head has no labels; see [`TransferredFace::has_labels`].
    ///
    /// # Errors
    /// [`GraftError::Texture`] if memory runs out.
    pub fn new(domain: &BlendDomain, face: &Texture, size: Size) -> Result<Self, GraftError> {
        let transfer = |texture: &Texture, content, filter, blank: Texture| {
            Graft::builder(Arc::clone(domain.pair()), Sizes { from: texture.size(), to: size })
                .direction(domain.direction())
                .content(content)
                .filter(filter)
                .gutter_px(0)
                .build()?
                .apply(texture, blank)
        };
        let clear = Texture::filled(size, Channels::Rgba, Encoding::Srgb, Depth::U8, &[0.0; 4])?;
        let texture = transfer(face, Content::Color, Filter::Lanczos3, clear)?;
        let labels = match domain.labels(face) {
            Ok(labels) => {
                let none =
                    Texture::filled(size, Channels::Rgb, Encoding::Data, Depth::U8, &[0.0; 3])?;
                Some(transfer(&weights(&labels), Content::Data, Filter::Bilinear, none)?)
            }
            Err(_) => None,
        };
        Ok(Self { texture, labels })
    }

    /// The size after the transfer.
    pub fn size(&self) -> Size {
        self.texture.size()
    }

    /// Whether the labels of hair and skin are known.
    pub fn has_labels(&self) -> bool {
        self.labels.is_some()
    }

    /// Its colour at a texel: sRGB, 1.0 at full intensity; `None` outside the face.
    pub(super) fn color(&self, x: u32, y: u32) -> Option<[f32; 3]> {
        let (rgb, alpha) = texel(&self.texture, x, y);
        (alpha > 0.5 && rgb.iter().all(|value| value.is_finite())).then_some(rgb)
    }

    /// The label weights at a texel, if they are known.
    pub(super) fn shown(&self, x: u32, y: u32) -> Option<LabelWeights> {
        let labels = self.labels.as_ref()?;
        Some(LabelWeights { hair: labels.get(x, y, 0), skin: labels.get(x, y, 1) })
    }
}

/// Labels as a data texture, in the layout in which they were found.
fn weights(labels: &Labels) -> Texture {
    let size = labels.size();
    let level = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let texels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let values = texels.flat_map(|(x, y)| {
        let weight = |label| labels.weight(label, x, y);
        [level(weight(Label::Hair) + weight(Label::Brow)), level(weight(Label::Skin)), 0]
    });
    Texture::new(size, Channels::Rgb, Encoding::Data, Texels::U8(values.collect()))
        .expect("the size is that of a texture")
}
