//! Which of several overlapping triangles is shown, through the program.

use std::fmt::Write as _;

use crate::bench::{Bench, charts};
use uvgraft::{Channels, Depth, Texture};

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

/// An OBJ file of quads, each given by its four vertices in space, numbered from 1, and its square in
/// UV: left, bottom, right, top.
fn quads(vertices: u32, quads: &[([u32; 4], [f32; 4])]) -> String {
    let mut text = String::new();
    for vertex in 0..vertices {
        writeln!(text, "v {} {} {}", vertex % 2, vertex / 2 % 2, vertex / 4).expect("a string");
    }
    for &(_, [left, bottom, right, top]) in quads {
        for [u, v] in [[left, bottom], [right, bottom], [right, top], [left, top]] {
            writeln!(text, "vt {u} {v}").expect("a string");
        }
    }
    for (quad, (corners, _)) in quads.iter().enumerate() {
        // As triangles, so that both sides of a sheet have the same ones.
        let at = |k: usize| format!("{}/{}", corners[k], 4 * quad + k + 1);
        writeln!(text, "f {} {} {}\nf {} {} {}", at(0), at(1), at(2), at(0), at(2), at(3))
            .expect("a string");
    }
    text
}

/// The corners of the first quad of a grid of such vertices, from in front and from behind.
const FRONT: [u32; 4] = [1, 2, 4, 3];
const BACK: [u32; 4] = [4, 2, 1, 3];
const ALL: [f32; 4] = [0.0, 0.0, 1.0, 1.0];

/// How many texels differ from those of the same place, where a triangle is linked.
fn wrong(bench: &Bench, pair: &str, source: &str) -> (usize, usize) {
    bench.succeed(&format!(
        "transfer {pair} {source} --size 60 --onto #000000 --gutter 0 -o out.png --mask mask.png"
    ));
    let [out, mask, source] = ["out.png", "mask.png", source].map(|name| bench.texture(name));
    let is_linked = |x: u32, y: u32| mask.get(x, y, 0) > 0.5;
    let differs = |x: u32, y: u32| {
        let texel = |texture: &Texture| [0, 1, 2].map(|channel| texture.get(x, y, channel));
        texel(&out) != texel(&source)
    };
    let all = || (0..60).flat_map(|y| (0..60).map(move |x| (x, y)));
    let linked = all().filter(|&(x, y)| is_linked(x, y));
    (linked.clone().filter(|&(x, y)| differs(x, y)).count(), linked.count())
}

#[test]
fn both_sides_of_a_sheet_are_linked_to_themselves() {
    let bench = Bench::new();
    bench.paint_noise("noise.png", (60, 60), Channels::Rgb, Depth::U8);
    let (left, right) = ([0.0, 0.0, 0.45, 0.9], [0.55, 0.0, 1.0, 0.9]);
    bench.write("sheet.obj", quads(4, &[(FRONT, left), (BACK, right)]));
    bench.write("ids.txt", "0 1 2 3");
    // From both sides the same layout.
    bench.write("turned.obj", quads(4, &[(BACK, left), (FRONT, right)]));
    bench.write("reordered.obj", quads(4, &[(BACK, right), (FRONT, left)]));
    for (how, target) in [
        ("", "sheet.obj"),
        ("--vertex-map ids.txt", "sheet.obj"),
        ("--vertex-map ids.txt", "reordered.obj"),
    ] {
        bench.succeed(&format!("pair sheet.obj {target} {how} -o sheet.uvpair"));
        let (wrong, linked) = wrong(&bench, "sheet.uvpair", "noise.png");
        assert_eq!(wrong, 0, "{how} {target}");
        assert_eq!(linked, 2 * 27 * 54, "{how} {target}");
    }
    // The side in front is in the other half there.
    bench.succeed("pair sheet.obj turned.obj --vertex-map ids.txt -o turned.uvpair");
    bench.paint_halves("halves.png", [200, 10]);
    bench.succeed("transfer turned.uvpair halves.png --size 60 --onto #808080 -o out.png");
    let out = bench.texture("out.png");
    assert_eq!([10, 50].map(|x| (out.get(x, 30, 0) * 255.0) as u8), [10, 200]);
}

#[test]
fn what_is_not_linked_takes_no_texel_from_what_is() {
    let bench = Bench::new();
    bench.paint_noise("noise.png", (60, 60), Channels::Rgb, Depth::U8);
    let inside = (FRONT, ALL);
    let outside = ([5, 6, 8, 7], [-1.0, -1.0, 2.0, 2.0]);
    let above = ([5, 6, 8, 7], [0.25, 0.25, 0.75, 0.75]);
    bench.write("inside.obj", quads(8, &[inside]));
    bench.write("ids.txt", "0 1 2 3 -1 -1 -1 -1");
    // Triangles that cross the border of the unit square, or that have no counterpart.
    for others in [[outside, inside], [inside, outside], [above, inside], [inside, above]] {
        bench.write("other.obj", quads(8, &others));
        for prefer in ["first", "left", "right"] {
            let run = bench.run("pair inside.obj other.obj --vertex-map ids.txt -o other.uvpair");
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            bench.succeed(&format!(
                "transfer other.uvpair noise.png --size 60 --onto #000000 --prefer {prefer} -o out.png"
            ));
            assert_eq!(bench.texture("out.png"), bench.texture("noise.png"), "{others:?} {prefer}");
        }
        if others.contains(&outside) {
            assert_eq!(bench.run("pair other.obj other.obj -o itself.uvpair").code, Some(0));
            assert_eq!(wrong(&bench, "itself.uvpair", "noise.png"), (0, 60 * 60), "{others:?}");
        }
    }
}

#[test]
fn islands_within_others_take_nothing_around_them() {
    let bench = Bench::new();
    bench.paint_halves("halves.png", [200, 10]);
    let within = ([5, 6, 8, 7], [0.25, 0.25, 0.75, 0.75]);
    let [left, right] = [[0.1, 0.1, 0.4, 0.4], [0.6, 0.1, 0.9, 0.4]];
    bench.write("apart.obj", quads(8, &[([5, 6, 8, 7], left), (FRONT, right)]));
    bench.write("nested.obj", quads(8, &[within, (FRONT, ALL)]));
    bench.succeed("pair apart.obj nested.obj -o nested.uvpair");
    bench.succeed("transfer nested.uvpair halves.png --size 60 --onto #000000 -o out.png");
    let out = bench.texture("out.png");
    for (x, y) in (0..60).flat_map(|y| (0..60).map(move |x| (x, y))) {
        let is_within = (15..45).contains(&x) && (15..45).contains(&y);
        let wanted = if is_within { 200.0 } else { 10.0 };
        assert_eq!(out.get(x, y, 0) * 255.0, wanted, "{x} {y}");
    }
}

#[test]
fn reports_of_many_layers_count_each_texel_once() {
    let bench = Bench::new();
    let cards: Vec<_> = (0..300)
        .map(|card| ([1, 2, 4, 3].map(|corner| corner + 4 * card), [0.0, 0.0, 0.5, 1.0]))
        .collect();
    bench.write("cards.obj", quads(1200, &cards));
    let text = bench.succeed("pair cards.obj cards.obj -o cards.uvpair --json");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    for side in ["source", "target"] {
        let texels = &report[side]["texels"];
        assert_eq!(texels["covered"], texels["overlapping"], "{side}");
        assert_eq!(texels["linked"], texels["covered"], "{side}");
    }
    let text = bench.succeed("inspect mesh cards.obj");
    assert!(text.contains("524,288 at 1024×1024"), "{text}");
}
