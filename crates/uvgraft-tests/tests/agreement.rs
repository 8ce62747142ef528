//! The library against an independent implementation.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, Graft, Pair, Size, Sizes, Texels, Texture,
};
use uvgraft_tests::{independent, real, synthetic};

/// Bilinear values must agree within one level of 255, which covers rounding.
const TOLERANCE: f64 = 1.0;

fn agree(pair: &Arc<Pair>, direction: Direction, source_size: Size, target_size: Size) {
    let source = synthetic::detailed(source_size, 3);
    let graft = Graft::builder(Arc::clone(pair), Sizes { from: source_size, to: target_size })
        .direction(direction)
        .filter(Filter::Bilinear)
        .gutter_px(0)
        .build()
        .unwrap();
    let base =
        Texture::filled(target_size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.0; 3]).unwrap();
    let result = graft.apply(&source, base).unwrap();
    let Texels::U8(values) = result.texels() else { panic!("8 bits") };
    let found = independent::transfer(pair, direction, &source, target_size);

    // Where charts overlap, the winner keeps a fringe of up to two texels around it.
    let width = target_size.width as usize;
    let mut near_overlap = vec![false; found.len()];
    for (texel, _) in found.iter().enumerate().filter(|(_, found)| found.covering > 1) {
        for row in -2..=2isize {
            let start = texel.saturating_add_signed(row * width as isize);
            let range = start.saturating_sub(2)..(start + 3).min(found.len());
            near_overlap.get_mut(range).into_iter().for_each(|near| near.fill(true));
        }
    }
    let mut compared = 0;
    for (texel, found) in found.iter().enumerate() {
        if !(found.linked && found.inside_source && found.covering == 1) || near_overlap[texel] {
            continue;
        }
        compared += 1;
        for channel in 0..3 {
            let (value, wanted) = (f64::from(values[texel * 3 + channel]), found.value[channel]);
            assert!(
                (value - wanted).abs() <= TOLERANCE,
                "{direction:?} {target_size}, texel {texel}: {value}, wanted {wanted}"
            );
        }
    }
    let linked = graft.map().stats().linked;
    assert!(compared * 10 > linked * 8, "only {compared} of {linked} texels were compared");
}

#[test]
fn synthetic_pair_both_ways() {
    let pair = synthetic::pair();
    for (direction, source, target) in [
        (Direction::Forward, Size::square(512), Size::square(1024)),
        (Direction::Reverse, Size::square(1024), Size::square(512)),
        (Direction::Forward, Size::new(700, 411), Size::new(1000, 1537)),
        (Direction::Reverse, Size::new(1000, 1537), Size::new(333, 257)),
    ] {
        agree(&pair, direction, source, target);
    }
}

#[test]
fn real_pair_both_ways() {
    let Some(pair) = real::flame_to_smplx() else { return };
    agree(&pair, Direction::Forward, Size::square(2048), Size::square(4096));
    agree(&pair, Direction::Reverse, Size::square(4096), Size::square(2048));
    agree(&pair, Direction::Forward, Size::new(1537, 1000), Size::new(1000, 1537));
    agree(&pair, Direction::Reverse, Size::new(1000, 1537), Size::new(1537, 1000));
}
