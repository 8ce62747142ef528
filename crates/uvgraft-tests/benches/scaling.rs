//! How run times scale with texture and mesh size: Markdown tables, medians of several runs. The
//! time per texel or triangle should stay constant, cache effects aside.

#![allow(clippy::print_stdout, reason = "tables are what this is for")]

use std::sync::Arc;
use std::time::Instant;

use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, Graft, MapOptions, SamplingMap, Size, Sizes,
    Texture,
};
use uvgraft_tests::synthetic;

/// The median time of `runs` runs of `work`, in milliseconds; `prepare` is not timed.
fn median_ms<T, R>(
    runs: usize,
    mut prepare: impl FnMut() -> T,
    mut work: impl FnMut(T) -> R,
) -> f64 {
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let input = prepare();
            let start = Instant::now();
            let result = work(input);
            let time = start.elapsed().as_secs_f64() * 1e3;
            drop(result);
            time
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[runs / 2]
}

/// Transfers between textures of the same size, for one pair.
fn textures() {
    let pair = synthetic::sheets(20_000);
    println!(
        "\n| texture | covered texels | map | map and padding | bilinear, 8-bit RGB | ns per texel |"
    );
    println!("|---|---|---|---|---|---|");
    for side in [512, 1024, 2048, 4096, 8192] {
        let size = Size::square(side);
        let options = MapOptions::default();
        let runs = if side > 4096 { 5 } else { 11 };
        let map = median_ms(
            runs,
            || (),
            |()| SamplingMap::new(&pair, Direction::Forward, size, &options),
        );
        let builder = Graft::builder(Arc::clone(&pair), Sizes { from: size, to: size })
            .filter(Filter::Bilinear)
            .map_options(options);
        let new = || builder.clone().build().expect("a sound size");
        let prepared = median_ms(runs, || (), |()| new());
        let graft = new();
        let filled = |value| {
            Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[value; 3])
                .expect("a sound size")
        };
        let (source, base) = (filled(0.3), filled(0.6));
        let applied = median_ms(
            runs,
            || (source.clone(), base.clone()),
            |(source, base)| graft.apply(source, base),
        );
        let covered = graft.map().stats().covered;
        let each = (prepared + applied) * 1e6 / covered as f64;
        println!(
            "| {side}² | {covered} | {map:.2} ms | {prepared:.2} ms | {applied:.2} ms | {each:.2} |"
        );
    }
}

/// Maps of one size, for meshes with more and more triangles.
fn meshes() {
    let size = Size::square(2048);
    println!("\n| triangles | map of {size} | ns per triangle and covered texel |");
    println!("|---|---|---|");
    for triangles in [1_000, 10_000, 100_000, 1_000_000] {
        let pair = synthetic::sheets(triangles);
        let new = || SamplingMap::new(&pair, Direction::Forward, size, &MapOptions::default());
        let time = median_ms(7, || (), |()| new());
        let triangles = pair.target().faces().len();
        let each = time * 1e6 / (triangles + new().stats().covered) as f64;
        println!("| {triangles} | {time:.2} ms | {each:.2} |");
    }
}

fn main() {
    textures();
    meshes();
}
