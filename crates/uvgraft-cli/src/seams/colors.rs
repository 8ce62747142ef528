//! The colour maps of steps, and textures as they are shown behind them.

use uvgraft::{Encoding, Texture, color};
use uvgraft_metrics::seams::SeamEdge;

use uvgraft_assembly::drawing::Rgb;

/// Steps above this have the last colour of their scale, which is the same in all pictures to make
/// them comparable.
pub(super) const TOP: f64 = 10.0;

/// Colour maps for steps from 0 to [`TOP`], for UV seams and for the border of the region.
const SEAM: [Rgb; 4] = [[46, 180, 92], [190, 214, 56], [250, 156, 40], [226, 36, 40]];
const RIM: [Rgb; 4] = [[90, 226, 244], [74, 134, 255], [150, 80, 250], [252, 70, 226]];
/// The colour of edges that could not be measured.
pub(super) const UNKNOWN: Rgb = [128, 131, 138];
/// The background behind transparent texels.
pub(super) const BEHIND: Rgb = [12, 13, 15];

/// The colour of a step.
pub(super) fn step_color(delta_e: f64, is_rim: bool) -> Rgb {
    let anchors = if is_rim { RIM } else { SEAM };
    let at = (delta_e / TOP).clamp(0.0, 1.0) * (anchors.len() - 1) as f64;
    let low = (at as usize).min(anchors.len() - 2);
    blend(anchors[low], anchors[low + 1], at - low as f64)
}

/// The colour of an edge, by the mean of its steps.
pub(super) fn edge_color(edge: &SeamEdge) -> Rgb {
    edge.mean.map_or(UNKNOWN, |mean| step_color(mean, edge.is_rim))
}

/// Blends two colours, with `share` of the second.
pub(super) fn blend(a: Rgb, b: Rgb, share: f64) -> Rgb {
    std::array::from_fn(|k| {
        let [a, b] = [a, b].map(|color| f64::from(color[k]));
        (a + (b - a) * share + 0.5) as u8
    })
}

/// A texel as displayed over the dark background.
pub(super) fn shown(texture: &Texture, x: u32, y: u32) -> Rgb {
    let channels = texture.channels();
    let encode = |value: f32| match texture.encoding() {
        Encoding::Linear => color::srgb_from_linear(value),
        Encoding::Srgb | Encoding::Data => value,
    };
    let rgb = std::array::from_fn(|k| {
        let value = encode(texture.get(x, y, if channels.has_color() { k } else { 0 }));
        (value * 255.0 + 0.5) as u8
    });
    let opacity = if channels.has_alpha() { texture.get(x, y, channels.count() - 1) } else { 1.0 };
    blend(BEHIND, rgb, f64::from(opacity.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_steps() {
        assert_eq!(step_color(0.0, false), SEAM[0]);
        assert_eq!(step_color(TOP / 3.0, false), SEAM[1]);
        assert_eq!(step_color(55.0, false), SEAM[3]);
        assert_eq!(step_color(TOP * 0.5, true), [112, 107, 253]);
    }
}
