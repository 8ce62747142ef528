//! There and back: how much of a texture survives.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, FitOptions, Graft, MapOptions, Pair, SamplingMap,
    Size, Sizes, Texels, Texture,
};
use uvgraft_metrics::baseline::grid;
use uvgraft_metrics::lpips::Lpips;
use uvgraft_metrics::lpips_weights::sdist;
use uvgraft_metrics::{self as metrics, Colors};
use uvgraft_tests::{downloads, photographs, real, synthetic};

fn values(texture: &Texture) -> &[u8] {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    values
}

fn psnr(a: &Texture, b: &Texture) -> f64 {
    let [a, b] = [a, b].map(|texture| Colors::new(texture.clone()).unwrap());
    metrics::psnr(&a, &b, None).unwrap()
}

fn grey(size: Size) -> Texture {
    Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]).unwrap()
}

/// From the target's layout to the source's and back onto the original.
struct RoundTrip {
    there: Graft,
    back: Graft,
    via: Size,
}

impl RoundTrip {
    fn new(pair: &Arc<Pair>, size: Size, via: Size, filter: Filter) -> Self {
        let there = Graft::builder(Arc::clone(pair), Sizes { from: size, to: via })
            .direction(Direction::Reverse)
            .filter(filter);
        // On the way back, a gutter would replace the original's texels around its islands.
        let back = Graft::builder(Arc::clone(pair), Sizes { from: via, to: size })
            .filter(filter)
            .gutter_px(0);
        Self { there: there.build().unwrap(), back: back.build().unwrap(), via }
    }

    fn run(&self, texture: &Texture) -> Texture {
        let head = self.there.apply(texture, grey(self.via)).unwrap();
        self.back.apply(head, texture).unwrap()
    }
}

fn reference_round_trip(pair: &Pair, texture: &Texture, via: Size) -> Texture {
    let bare = MapOptions::with_gutter(0);
    let map = |direction, size| SamplingMap::new(pair, direction, size, &bare);
    let head = grid::transfer(&map(Direction::Reverse, via), texture, grey(via));
    grid::transfer(&map(Direction::Forward, texture.size()), &head, texture.clone())
}

#[test]
fn keeps_seven_decibels_more_than_the_reference() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let texture = synthetic::detailed(Size::square(4096), 1);
    let via = Size::square(2048);
    let reference = psnr(&reference_round_trip(&pair, &texture, via), &texture);
    println!("SMPL-X 4096² → FLAME 2048² → SMPL-X 4096², whole image:");
    println!("  the reference's convention  {reference:.2} dB");
    let results = Filter::ALL.map(|filter| {
        let trip = RoundTrip::new(&pair, texture.size(), via, filter);
        let own = psnr(&trip.run(&texture), &texture);
        println!("  {:<26}  {own:.2} dB", filter.to_string());
        (filter, own)
    });
    let (best, most) = results.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert_eq!(best, Filter::default(), "the default filter must keep most");
    assert!(most >= reference + 7.0, "{most:.2} dB against {reference:.2} dB");
}

#[test]
fn five_round_trips_do_not_change_the_brightness() {
    let pair = synthetic::pair();
    let (size, via) = (Size::square(1024), Size::square(512));
    let texture = synthetic::detailed(size, 2);
    let trip = RoundTrip::new(&pair, size, via, Filter::default());
    let linked = values(&trip.back.map().mask()).to_vec();
    let mean = |texture: &Texture| {
        let texels = values(texture).chunks_exact(3).zip(&linked).filter(|(_, mask)| **mask == 255);
        let (sum, count) = texels.fold((0.0, 0.0), |(sum, count), (texel, _)| {
            (sum + texel.iter().map(|&value| f64::from(value)).sum::<f64>(), count + 3.0)
        });
        sum / count
    };
    let (mut own, mut reference) = (texture.clone(), texture.clone());
    for _ in 0..5 {
        own = trip.run(&own);
        reference = reference_round_trip(&pair, &reference, via);
    }
    let drift = [&own, &reference].map(|result| mean(result) - mean(&texture));
    assert!(drift[0].abs() < 0.1, "drift of {:.3} levels", drift[0]);
    // Check that the test detects drift: truncation loses half a level in each of ten transfers.
    assert!(drift[1] < -2.5, "the reference drifts by {:.3} levels", drift[1]);
}

/// The scores for round trips.
#[derive(Debug, Clone, Copy)]
struct Scores {
    psnr: f64,
    ssim: f64,
    lpips: Option<f64>,
}

impl Scores {
    fn new(result: Texture, original: &Colors, lpips: Option<&Lpips>) -> Self {
        let result = Colors::new(result).unwrap();
        Self {
            psnr: metrics::psnr(original, &result, None).unwrap(),
            ssim: metrics::ssim(original, &result, None).unwrap(),
            lpips: lpips.map(|lpips| lpips.compare(original, &result).unwrap().mean()),
        }
    }
}

fn alex() -> Option<Lpips> {
    Some(Lpips::new(sdist::read(&downloads::lpips_sdist()?).unwrap().alex))
}

#[test]
fn photographs_survive_better_than_the_reference_leaves_them() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let Some(texture) = photographs::mosaic(Size::square(4096)) else { return };
    let (via, lpips) = (Size::square(2048), alex());
    let original = Colors::new(texture.clone()).unwrap();
    let judge = |name: &str, result: Texture| {
        let scores = Scores::new(result, &original, lpips.as_ref());
        println!("{name}: {scores:?}");
        scores
    };
    let reference = judge("reference", reference_round_trip(&pair, &texture, via));
    let trip = RoundTrip::new(&pair, texture.size(), via, Filter::default());
    let own = judge("default", trip.run(&texture));
    let base = grey(via);
    let fitted = trip.there.fit(&texture, base.format(), &FitOptions::default(), &mut |_| {});
    let head = fitted.unwrap().overlay.lay(0, base).unwrap();
    let fitted = judge("fitted", trip.back.apply(head, &texture).unwrap());

    assert!(own.psnr >= reference.psnr + 7.4, "{own:?}");
    assert!(fitted.psnr >= reference.psnr + 8.7, "{fitted:?}");
    for (better, worse) in [(own, reference), (fitted, own)] {
        assert!(better.ssim > worse.ssim, "{better:?} {worse:?}");
        let lower = better.lpips.zip(worse.lpips).is_none_or(|(better, worse)| better < worse);
        assert!(lower, "{better:?} {worse:?}");
    }
}
