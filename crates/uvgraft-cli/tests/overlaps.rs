//! Which of two overlapping charts is shown, through the program.

use crate::bench::{Bench, charts};
use uvgraft::Channels;

/// The second chart exactly on the first.
fn bench() -> Bench {
    let bench = charts::bench(0.0);
    bench.paint_halves("source.png", [200, 10]);
    bench
}

#[test]
fn either_chart_can_be_preferred() {
    let bench = bench();
    for (option, shown) in
        [("", 200), ("--prefer first", 200), ("--prefer left", 10), ("--prefer right", 200)]
    {
        let common = format!("eyes.uvpair source.png --size 32 --gutter 0 {option}");
        for fit in ["", "--fit"] {
            bench.succeed(&format!(
                "transfer {common} {fit} --onto #808080 -o out.png --mask mask.png"
            ));
            let (out, mask) = (bench.texture("out.png"), bench.texture("mask.png"));
            assert_eq!(out.channels(), Channels::Grey);
            for x in 0..32 {
                let (wanted, linked) = if x < 16 { (shown, 1.0) } else { (128, 0.0) };
                // Where the halves meet in the source, they blend.
                if (4..12).contains(&x) || x >= 18 {
                    let found = out.get(x, 9, 0) * 255.0;
                    assert_eq!(found, wanted as f32, "{option} {fit} at {x}");
                    assert_eq!(mask.get(x, 9, 0), linked, "{option} {fit} at {x}");
                }
            }
        }
        bench.succeed(&format!("map eyes.uvpair --size 32 --gutter 0 {option} -o grid.npy"));
        let bytes = bench.bytes("grid.npy");
        let row = &bytes[bytes.len() - 32 * 32 * 8..];
        let u = f32::from_le_bytes([row[0], row[1], row[2], row[3]]);
        let wanted = if shown == 10 { 0.5 + 1.0 / 64.0 } else { 1.0 / 64.0 };
        assert!((u - wanted).abs() < 1e-6, "{option}: {u}");
    }
    bench.refuse("map eyes.uvpair --size 32 --prefer both -o grid.npy", &["first, left, right"]);
}
