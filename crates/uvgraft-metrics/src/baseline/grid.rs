//! The convention of the published reference implementation of Song et al. (arXiv 2508.19518).
//!
//! Positions are computed at texel centres but sampled with aligned corners, an error of up to half
//! a texel. Values are truncated, and there is no padding and no gutter. Bilinear, one sample per
//! texel. Their implementation stores a grid of positions and faces for each texel; the resulting
//! picture is the same.

use uvgraft::map::SamplingMap;
use uvgraft::texture::{Channels, Depth, Texels, TexelsMut, Texture};
use uvgraft::threads::for_each_chunk;

/// Transfers a texture through a map the way the reference does, as 8-bit RGB. A map for this has
/// no gutter; if it has one, it is skipped.
///
/// # Panics
/// If the base and the map differ in size.
pub fn transfer(map: &SamplingMap, source: &Texture, base: Texture) -> Texture {
    assert_eq!(base.size(), map.size(), "a map is for one size");
    let source = source.clone().converted(Channels::Rgb, Depth::U8);
    let mut base = base.converted(Channels::Rgb, Depth::U8);
    let (size, width) = (source.size(), map.size().width as usize);
    let (Texels::U8(source), TexelsMut::U8(target)) = (source.texels(), base.texels_mut()) else {
        unreachable!("converted to 8 bits")
    };
    let last = [size.width, size.height].map(|count| f64::from(count - 1));
    for_each_chunk(target, width * 3, |row, target| {
        for run in map.row(row as u32).iter().filter(|run| !map.is_gutter(**run)) {
            let patch = &map.patches()[run.patch as usize];
            for x in run.x..run.x + run.len {
                let uv = patch.src_uv_from_tgt_px.at([f64::from(x) + 0.5, row as f64 + 0.5]);
                let at = [0, 1].map(|axis| (uv[axis] * last[axis]).clamp(0.0, last[axis]));
                let low = at.map(f64::floor);
                for channel in 0..3 {
                    let mut value = 0.0;
                    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                        let (column, line) =
                            ((low[0] + dx).min(last[0]), (low[1] + dy).min(last[1]));
                        let weight = (1.0 - (at[0] - low[0] - dx).abs())
                            * (1.0 - (at[1] - low[1] - dy).abs());
                        let texel = line as usize * size.width as usize + column as usize;
                        value += weight * f64::from(source[texel * 3 + channel]);
                    }
                    target[x as usize * 3 + channel] = value as u8;
                }
            }
        }
    });
    base
}
