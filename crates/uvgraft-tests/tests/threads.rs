//! The number of threads must not show in a result.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::{Channels, Depth, Encoding, Filter, Graft, Size, Sizes, Texture};
use uvgraft_tests::synthetic;

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
