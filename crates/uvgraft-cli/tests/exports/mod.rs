//! A pair and textures for exports, and what other tools should make of them, computed here.

#![allow(dead_code, reason = "each test file uses a part of it")]
#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::sync::Arc;

use uvgraft::{
    Channels, Direction, Encoding, Filter, Graft, MapOptions, SamplingMap, Size, Sizes, Texels,
    Texture,
};
use uvgraft_figure::Figure;
use uvgraft_io::pair_file;

use crate::bench::Bench;

/// The size of the sources. Small, so that most of the target takes one sample per texel.
pub const SOURCE: Size = Size::new(72, 64);
/// The size of the targets.
pub const TARGET: Size = Size::new(480, 520);

/// The demo's figure with a noisy face of [`SOURCE`] as `face.png`, and the same as filters read it
/// as `padded.png`.
pub fn figure() -> Bench {
    let figure = Figure::new();
    let bench = Bench::new();
    let (head, body) = (figure.head.clone(), figure.body.clone());
    bench.save_pair("demo.uvpair", head, body, &figure.vertex_map);
    let mut rng = noise(7);
    let texels: Vec<u8> = (0..SOURCE.texels() * 3).map(|_| rng()).collect();
    let rgb = |texels| Texture::new(SOURCE, Channels::Rgb, Encoding::Srgb, texels).unwrap();
    let floats: Vec<f32> = texels.iter().map(|&level| f32::from(level)).collect();
    bench.save("face.png", rgb(Texels::U8(texels)));
    let pair = pair_file::read(bench.path("demo.uvpair")).unwrap().pair;
    let graft = Graft::builder(Arc::clone(&pair), Sizes { from: SOURCE, to: TARGET });
    let operator = graft.filter(Filter::Bilinear).build().unwrap().operator();
    let padded = operator.padded(3, &floats);
    let levels = padded.iter().map(|&level| level as u8).collect();
    bench.save("padded.png", rgb(Texels::U8(levels)));
    bench
}

/// A small generator of bytes: a linear congruence of 64 bits (Knuth, MMIX).
fn noise(seed: u64) -> impl FnMut() -> u8 {
    let mut state = seed;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    }
}

/// The map of the pair.
pub fn map(bench: &Bench) -> SamplingMap {
    let pair = pair_file::read(bench.path("demo.uvpair")).unwrap().pair;
    SamplingMap::new(&pair, Direction::Forward, TARGET, &MapOptions::default())
}

/// For each texel its source position, and whether a source of [`SOURCE`] is not minified there.
pub fn positions(map: &SamplingMap) -> Vec<Option<([f64; 2], bool)>> {
    let mut positions = vec![None; map.size().texels()];
    for y in 0..map.size().height {
        for run in map.row(y) {
            let patch = &map.patches()[run.patch as usize];
            let scale = [f64::from(SOURCE.width), f64::from(SOURCE.height)];
            let length = |axis: usize| {
                let [x, y] = [0, 1].map(|k| patch.jacobian[k][axis] * scale[k]);
                x.hypot(y)
            };
            let is_single = length(0) < 1.49 && length(1) < 1.49;
            for x in run.x..run.x + run.len {
                let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let at = patch.src_uv_from_tgt_px.at(centre);
                positions[(y * map.size().width + x) as usize] = Some((at, is_single));
            }
        }
    }
    positions
}

/// One bilinear sample of a channel at (u, v), in levels; beyond the edge the edge texels repeat.
pub fn bilinear(texture: &Texture, uv: [f64; 2], channel: usize) -> f64 {
    let size = [texture.size().width, texture.size().height].map(f64::from);
    let at = [0, 1].map(|k| uv[k] * size[k] - 0.5);
    let mut sum = 0.0;
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let (x, y) = (at[0].floor() + dx, at[1].floor() + dy);
        let weight = (1.0 - (at[0] - x).abs()) * (1.0 - (at[1] - y).abs());
        let [x, y] = [x.clamp(0.0, size[0] - 1.0), y.clamp(0.0, size[1] - 1.0)];
        sum += weight * f64::from(texture.get(x as u32, y as u32, channel)) * 255.0;
    }
    sum
}
