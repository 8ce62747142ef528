//! Synthetic textures with detail at all scales, like photographs.

use rayon::prelude::*;
use uvgraft::{Channels, Encoding, Size, Texels, Texture, TextureError};

/// Value noise with knots this many texels apart, and its amplitude. Photographs have equal
/// contrast at every scale; the last one is grain, which makes PNG files as large as those of
/// photographs.
const OCTAVES: [(u32, f32); 5] = [(256, 90.0), (64, 60.0), (16, 40.0), (4, 24.0), (1, 12.0)];

/// An 8-bit RGB texture, deterministic for a size and a seed.
pub(super) fn detailed(size: Size, seed: u32) -> Result<Texture, TextureError> {
    let width = size.width as usize;
    let mut values = vec![0u8; size.texels() * 3];
    values.par_chunks_mut(width * 3).zip(0u32..size.height).for_each(|(row, y)| {
        for (x, texel) in (0u32..).zip(row.chunks_exact_mut(3)) {
            for (channel, value) in (0..).zip(texel) {
                let noise: f32 = OCTAVES
                    .iter()
                    .map(|&(cell, contrast)| contrast * smooth(x, y, cell, seed * 3 + channel))
                    .sum();
                *value = (128.0 + noise).round() as u8;
            }
        }
    });
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values))
}

/// Noise in `-0.5..0.5`, interpolated linearly between knots `cell` texels apart.
fn smooth(x: u32, y: u32, cell: u32, seed: u32) -> f32 {
    let knot = |dx, dy| hashed(x / cell + dx, y / cell + dy, seed ^ cell << 16);
    if cell == 1 {
        return knot(0, 0);
    }
    let [s, t] = [x, y].map(|at| (at % cell) as f32 / cell as f32);
    let top = knot(0, 0) + (knot(1, 0) - knot(0, 0)) * s;
    let bottom = knot(0, 1) + (knot(1, 1) - knot(0, 1)) * s;
    top + (bottom - top) * t
}

/// A pseudo-random number in `-0.5..0.5` for each position.
fn hashed(x: u32, y: u32, seed: u32) -> f32 {
    let mut value = x.wrapping_mul(0x9e37_79b1)
        ^ y.wrapping_mul(0x85eb_ca77).rotate_left(13)
        ^ seed.wrapping_mul(0xc2b2_ae3d).rotate_left(7);
    value = (value ^ value >> 15).wrapping_mul(0x2c1b_3c6d);
    value = (value ^ value >> 12).wrapping_mul(0x297a_2d39);
    value ^= value >> 15;
    (value >> 8) as f32 / (1 << 24) as f32 - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_have_detail_and_contrast() {
        let size = Size::new(300, 200);
        let texture = detailed(size, 1).unwrap();
        assert_eq!(texture, detailed(size, 1).unwrap());
        assert_ne!(texture, detailed(size, 2).unwrap());
        let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
        let steps = values.chunks_exact(3).zip(values[3..].chunks_exact(3));
        let mean_step =
            steps.map(|(a, b)| f64::from(a[0].abs_diff(b[0]))).sum::<f64>() / size.texels() as f64;
        assert!((2.0..16.0).contains(&mean_step), "{mean_step}");
        let (low, high) = (values.iter().min().unwrap(), values.iter().max().unwrap());
        assert!(high - low > 100, "{low} to {high}");
    }
}
