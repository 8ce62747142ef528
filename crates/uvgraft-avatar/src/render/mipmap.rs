//! A texture with smaller copies, for lookups over an area.

use uvgraft::color::linear_from_srgb;
use uvgraft::{Channels, Texels, Texture, Value};

pub(crate) struct Mipmap {
    levels: Vec<Level>,
    linear: Vec<f32>,
}

struct Level {
    width: usize,
    height: usize,
    texels: Vec<[u8; 3]>,
}

impl Mipmap {
    pub fn new(texture: &Texture) -> Self {
        let mut levels = vec![Level {
            width: texture.size().width as usize,
            height: texture.size().height as usize,
            texels: rgb(texture),
        }];
        while let Some(smaller) = levels.last().and_then(Level::halved) {
            levels.push(smaller);
        }
        let linear = (0..=255_u8).map(|value| linear_from_srgb(value.to_unit())).collect();
        Self { levels, linear }
    }

    /// The colour in linear light around `uv`, over `area` of the unit square.
    pub fn sample(&self, uv: [f32; 2], area: f32) -> [f32; 3] {
        let finest = &self.levels[0];
        let texels = area * (finest.width * finest.height) as f32;
        let level = 0.5 * texels.max(1.0).log2();
        let last = self.levels.len() - 1;
        let lower = (level as usize).min(last);
        let (a, b) = (
            self.levels[lower].bilinear(uv, &self.linear),
            self.levels[(lower + 1).min(last)].bilinear(uv, &self.linear),
        );
        let t = level.fract();
        [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t)
    }
}

impl Level {
    fn halved(&self) -> Option<Self> {
        if self.width.min(self.height) < 8 {
            return None;
        }
        let (width, height) = (self.width / 2, self.height / 2);
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            let upper = &self.texels[2 * y * self.width..][..2 * width];
            let lower = &self.texels[(2 * y + 1) * self.width..][..2 * width];
            for (a, b) in upper.chunks_exact(2).zip(lower.chunks_exact(2)) {
                texels.push([0, 1, 2].map(|k| {
                    let sum: u16 = [a[0][k], a[1][k], b[0][k], b[1][k]].map(u16::from).iter().sum();
                    ((sum + 2) / 4) as u8
                }));
            }
        }
        Some(Self { width, height, texels })
    }

    fn bilinear(&self, [u, v]: [f32; 2], linear: &[f32]) -> [f32; 3] {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        let texel = |dx: i32, dy: i32| {
            let column = (left as i32 + dx).clamp(0, self.width as i32 - 1) as usize;
            let row = (top as i32 + dy).clamp(0, self.height as i32 - 1) as usize;
            self.texels[row * self.width + column].map(|value| linear[usize::from(value)])
        };
        let (a, b, c, d) = (texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1));
        [0, 1, 2].map(|k| {
            let upper = a[k] + (b[k] - a[k]) * fx;
            let lower = c[k] + (d[k] - c[k]) * fx;
            upper + (lower - upper) * fy
        })
    }
}

/// The texels as 8-bit RGB; grey counts for all three, opacity is left out.
fn rgb(texture: &Texture) -> Vec<[u8; 3]> {
    fn collect<T: Value>(values: &[T], channels: Channels) -> Vec<[u8; 3]> {
        let order = if channels.has_color() { [0, 1, 2] } else { [0, 0, 0] };
        values
            .chunks_exact(channels.count())
            .map(|texel| order.map(|k| u8::from_unit(texel[k].to_unit())))
            .collect()
    }
    match texture.texels() {
        Texels::U8(values) => collect(values, texture.channels()),
        Texels::U16(values) => collect(values, texture.channels()),
        Texels::F32(values) => collect(values, texture.channels()),
    }
}
