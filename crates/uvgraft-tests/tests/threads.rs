//! The number of threads must not show in a result.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::{
    Averaging, Channels, Content, Depth, Direction, Encoding, Filter, Graft, NormalOptions, Size,
    Sizes, Texture,
};
use uvgraft_tests::synthetic;

/// A source that is kept is copied only where the map reads it, and a base whose values are converted
/// is worked on some rows at a time.
#[test]
fn kept_sources_and_tall_bases_give_the_same_bytes() {
    let pair = synthetic::pair();
    // Most of the source is not read; the target is taller than what is converted at once.
    for (direction, [from, to]) in [
        (Direction::Forward, [Size::new(311, 200), Size::new(97, 700)]),
        (Direction::Reverse, [Size::new(640, 517), Size::new(120, 561)]),
    ] {
        let source = synthetic::detailed(from, 4);
        let base = synthetic::detailed(to, 5);
        for filter in Filter::ALL {
            let builder = Graft::builder(Arc::clone(&pair), Sizes { from, to });
            let builder = builder.direction(direction).filter(filter);
            let normals = Content::Normals(NormalOptions::default());
            for builder in [
                builder.clone(),
                builder.clone().averaging(Averaging::Light),
                builder.clone().content(normals),
            ] {
                let graft = builder.build().unwrap();
                let kept = graft.apply(&source, &base).unwrap();
                assert!(kept == graft.apply(source.clone(), base.clone()).unwrap(), "{filter}");
                let overlay = graft.overlay(&source, base.format()).unwrap();
                for (first, rows) in
                    (0..to.height).step_by(61).map(|first| (first, first..first + 61))
                {
                    let rows = rows.start..rows.end.min(to.height);
                    let encoding = kept.encoding();
                    let band = base.rows(rows.clone()).with_encoding(encoding);
                    let band = overlay.lay(first, band).unwrap();
                    assert!(band == kept.rows(rows), "{filter}, row {first}");
                }
            }
        }
    }
}

#[test]
fn one_two_and_five_threads_give_the_same_bytes() {
    let pair = synthetic::pair();
    let (source_size, size) = (Size::new(311, 200), Size::new(517, 640));
    let source = synthetic::detailed(source_size, 4);
    let with_threads = |threads: usize, filter: Filter| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let graft = Graft::builder(Arc::clone(&pair), Sizes { from: source_size, to: size })
                .filter(filter)
                .build()
                .unwrap();
            let base =
                Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]).unwrap();
            graft.apply(&source, base).unwrap()
        })
    };
    for filter in Filter::ALL {
        let one = with_threads(1, filter);
        assert!(one == with_threads(2, filter) && one == with_threads(5, filter), "{filter}");
    }
}
