//! The convention of the published reference implementation, for comparison: positions are built at
//! texel centres but sampled with corners aligned, values are truncated, nothing is padded and no
//! gutter is made. Bilinear, one sample per texel.

use uvgraft::{Direction, MapOptions, Pair, SamplingMap, Texels, Texture};

/// Carries an 8-bit RGB texture the reference's way.
///
/// # Panics
/// If a texture is not 8-bit RGB.
pub fn transfer(pair: &Pair, direction: Direction, source: &Texture, mut base: Texture) -> Texture {
    let map = SamplingMap::new(pair, direction, base.size(), &MapOptions { gutter_px: 0 });
    let (size, width) = (source.size(), base.size().width as usize);
    let Texels::U8(source) = source.texels() else { panic!("8 bits") };
    let Texels::U8(target) = base.texels_mut() else { panic!("8 bits") };
    let last = [size.width, size.height].map(|count| f64::from(count - 1));
    for row in 0..map.size().height {
        for run in map.row(row).iter().filter(|run| !map.is_gutter(**run)) {
            let patch = &map.patches()[run.patch as usize];
            for x in run.x..run.x + run.len {
                let uv = patch.src_uv_from_tgt_px.at([f64::from(x) + 0.5, f64::from(row) + 0.5]);
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
                    target[(row as usize * width + x as usize) * 3 + channel] = value as u8;
                }
            }
        }
    }
    base
}
