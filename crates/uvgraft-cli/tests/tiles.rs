//! UDIM tiles and UV coordinates outside the unit square, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::{Bench, texel_u8};
use serde_json::Value;
use uvgraft::{Channels, Corner, Mesh, Texture};
use uvgraft_io::{obj, pair_file};
use uvgraft_tests::real;

const RED: [u8; 3] = [255, 0, 0];
const BLUE: [u8; 3] = [0, 0, 255];

/// Quads with separate vertices, from one corner to the opposite one.
fn quads(places: &[[f32; 4]]) -> Mesh {
    let uv: Vec<[f32; 2]> = places
        .iter()
        .flat_map(|&[left, top, right, bottom]| {
            [[left, top], [right, top], [right, bottom], [left, bottom]]
        })
        .collect();
    let positions = (0..uv.len()).map(|k| [k as f32, (k % 4 / 2) as f32, 0.0]).collect();
    let corners: Vec<Corner> = (0..uv.len() as u32).map(|k| Corner { vertex: k, uv: k }).collect();
    Mesh::from_polygons(positions, uv, &corners, &vec![4; places.len()]).unwrap()
}

/// A face that fills tile 1001 and an eye that fills tile 1003, in a target where both are in the unit
/// square side by side, as `eyes.uvpair`.
fn bench() -> Bench {
    let bench = Bench::new();
    let source = quads(&[[0.0, 0.0, 1.0, 1.0], [2.0, 0.0, 3.0, 1.0]]);
    let target = quads(&[[0.0, 0.0, 0.5, 1.0], [0.5, 0.0, 1.0, 1.0]]);
    obj::save(&source, bench.path("tiles.obj")).unwrap();
    obj::save(&target, bench.path("square.obj")).unwrap();
    let report = bench.make("pair tiles.obj square.obj --by faces -o eyes.uvpair");
    let row = |name: &str| {
        let line = report.lines().find(|line| line.starts_with(name));
        line.unwrap_or_else(|| panic!("{name} in {report}"))[name.len()..].trim().to_owned()
    };
    assert_eq!(row("linked in other tiles").split_whitespace().collect::<Vec<_>>(), ["2", "2"]);
    assert!(row("UV tiles").starts_with("1001, 1003"), "{report}");
    bench.paint("face_1001.png", (32, 32), Channels::Rgb, &RED);
    bench.paint("face_1003.png", (32, 32), Channels::Rgb, &BLUE);
    bench
}

/// The colours of all texels that are not transparent, with how many there are.
fn colors(texture: &Texture) -> Vec<(Vec<u8>, usize)> {
    let mut counts = std::collections::BTreeMap::new();
    for k in 0..texture.size().texels() as u32 {
        let texel = texel_u8(texture, k % texture.size().width, k / texture.size().width);
        if texel.get(3) != Some(&0) {
            *counts.entry(texel[..3].to_vec()).or_default() += 1;
        }
    }
    counts.into_iter().collect()
}

#[test]
fn an_eye_in_a_tile_of_its_own_gets_its_own_image() {
    let bench = bench();
    let transfer = "transfer eyes.uvpair face_<UDIM>.png -o out.png --size 64 --gutter 0";
    for filter in ["bilinear", "lanczos3"] {
        bench.succeed(&format!("{transfer} --filter {filter}"));
        let out = bench.texture("out.png");
        // Neither colour bleeds into the other.
        assert_eq!(colors(&out), [(BLUE.to_vec(), 2048), (RED.to_vec(), 2048)]);
        assert_eq!(texel_u8(&out, 31, 9)[..3], RED);
        assert_eq!(texel_u8(&out, 32, 9)[..3], BLUE);
    }
    // A material map, and numbers in place of the placeholder.
    bench.succeed("transfer eyes.uvpair --map albedo=face_<UDIM>.png -o maps --size 64 --gutter 0");
    assert_eq!(colors(&bench.texture("maps/albedo.png")).len(), 2);
    bench.write("f.1001.png", bench.bytes("face_1001.png"));
    bench.write("f.1003.png", bench.bytes("face_1003.png"));
    bench.succeed("transfer eyes.uvpair f.1001.png f.1003.png -o two.png --size 64 --gutter 0");
    assert_eq!(colors(&bench.texture("two.png")).len(), 2);

    // One image alone, by number and as the only one found.
    let run = bench.run("transfer eyes.uvpair f.1003.png -o one.png --size 64 --gutter 0");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("no image for tile 1001, so 2 triangles are left unlinked"));
    assert_eq!(colors(&bench.texture("one.png")), [(BLUE.to_vec(), 2048)]);
    std::fs::remove_file(bench.path("face_1003.png")).unwrap();
    let run = bench.run(transfer);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let wanted = "face_<UDIM>.png: no image for tile 1003, so 2 triangles are left unlinked";
    assert!(run.stderr.contains(wanted), "{}", run.stderr);
    assert_eq!(colors(&bench.texture("out.png")), [(RED.to_vec(), 2048)]);
    // Without a placeholder it is a texture of the unit square, as ever.
    bench.succeed("transfer eyes.uvpair face_1001.png -o plain.png --size 64 --gutter 0");
    assert_eq!(bench.bytes("plain.png"), bench.bytes("out.png"));
}

#[test]
fn a_target_with_several_tiles_gets_several_images() {
    let bench = bench();
    bench.succeed("transfer eyes.uvpair face_<UDIM>.png -o square.png --size 64 --gutter 0");
    bench.paint("base_1001.png", (16, 16), Channels::Rgb, &[9; 3]);
    bench.paint("base_1003.png", (8, 8), Channels::Rgb, &[9; 3]);
    let back =
        "transfer --reverse eyes.uvpair square.png --onto base_<UDIM>.png -o back_<UDIM>.png";
    bench.succeed(&format!("{back} --filter nearest --mask mask_<UDIM>.png"));
    for (tile, color, side) in [("1001", RED, 16), ("1003", BLUE, 8)] {
        let image = bench.texture(&format!("back_{tile}.png"));
        assert_eq!(image.size().width, side);
        assert_eq!(colors(&image), [(color.to_vec(), (side * side) as usize)]);
        assert!(bench.exists(&format!("mask_{tile}.png")));
    }
    // In a folder, names get numbers.
    bench.succeed("transfer --reverse eyes.uvpair --map albedo=square.png -o maps/ --mask m_<UDIM>.png --size 8");
    assert!(bench.exists("maps/albedo.1001.png") && bench.exists("maps/albedo.1003.png"));
    // All are written or none.
    std::fs::remove_file(bench.path("base_1003.png")).unwrap();
    std::fs::remove_file(bench.path("back_1001.png")).unwrap();
    let run = bench.run(back);
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert!(run.stderr.contains("base_1003.png"), "{}", run.stderr);
    assert!(!bench.exists("back_1001.png"));
    bench.assert_no_litter();
}

#[test]
fn what_cannot_be_is_refused() {
    let bench = bench();
    let with = |rest: &str| format!("transfer eyes.uvpair {rest} --size 16");
    bench.refuse(
        &with("none_<UDIM>.png -o out.png"),
        &["none_<UDIM>.png", "no file with the number of a tile", "none_1001.png"],
    );
    bench.refuse(&with("<UDIM>_<UDIM>.png -o out.png"), &["exactly once, in the file name"]);
    bench.paint("low_0999.png", (8, 8), Channels::Rgb, &RED);
    bench.refuse(
        &with("low_<UDIM>.png -o out.png"),
        &["low_0999.png", "UDIM tile number must be from 1001 to 9999, got 0999"],
    );
    bench.paint("odd_1001.png", (8, 8), Channels::Rgb, &RED);
    bench.paint("odd_1003.png", (8, 16), Channels::Rgb, &RED);
    bench.refuse(
        &with("odd_<UDIM>.png -o out.png"),
        &["odd_1001.png has 8×8", "odd_1003.png has 8×16"],
    );
    for name in ["f.1001.png", "g.1001.png", "g.1003.png"] {
        bench.paint(name, (8, 8), Channels::Rgb, &RED);
    }
    bench.refuse(&with("f.1001.png f.1003.png -o out.png"), &["f.1003.png: No such file"]);
    bench.refuse(&with("f.1001.png g.1001.png -o out"), &["g.1003.png", "tile 1003 is not given"]);
    bench.make("pair tiles.obj tiles.obj --by faces -o both.uvpair");
    bench.refuse(
        "transfer both.uvpair face_<UDIM>.png -o out.png --size 16",
        &["out.png", "several tiles (1001, 1003)", "<UDIM>"],
    );
    bench.refuse(
        "transfer both.uvpair face_<UDIM>.png -o face_<UDIM>.png --size 16",
        &["face_1001.png", "is also an input"],
    );
    bench.refuse(&with("face_<UDIM>.png -o out.png --skip-existing"), &["--skip-existing"]);
}

#[test]
fn coordinates_outside_are_clamped_or_repeated() {
    let bench = bench();
    let json = |text: &str| -> Value { serde_json::from_str(text).unwrap() };
    let pair = "pair tiles.obj square.obj --by faces --json -o new.uvpair";
    let run = bench.run(&format!("{pair} --outside repeat"));
    assert!(run.stderr.contains("tiles.obj: 2 triangles moved into the unit square"));
    let report = json(&run.stdout);
    assert_eq!((&report["links"], &report["source"]["outside"]), (&4.into(), &0.into()));
    bench.succeed("transfer new.uvpair face_1001.png -o out.png --size 64 --gutter 0");
    assert_eq!(colors(&bench.texture("out.png")), [(RED.to_vec(), 4096)]);

    let crossing = quads(&[[0.0, 0.0, 1.0, 1.0], [0.75, 0.0, 1.25, 1.0]]);
    obj::save(&crossing, bench.path("crossing.obj")).unwrap();
    let pair = pair.replace("tiles.obj", "crossing.obj");
    for how in ["repeat", "unlinked"] {
        let run = bench.run(&format!("{pair} --outside {how}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(run.stderr.contains("2 cross borders of tiles"), "{}", run.stderr);
        let report = json(&run.stdout);
        assert_eq!((&report["links"], &report["source"]["in_no_tile"]), (&2.into(), &2.into()));
    }
    let report = json(&bench.make(&format!("{pair} --outside clamp")));
    assert_eq!((&report["links"], &report["source"]["outside"]), (&4.into(), &0.into()));
}

#[test]
fn the_eyes_of_a_real_head_get_their_own_image() {
    let Some(folder) = real::folder() else { return };
    let bench = Bench::new();
    for file in ["flame_head_template.obj", "flame_hifi3d_uv.obj"] {
        std::fs::copy(folder.join(file), bench.path(file)).unwrap();
    }
    bench.make("pair flame_hifi3d_uv.obj flame_head_template.obj -o real.uvpair");
    let pair = pair_file::read(bench.path("real.uvpair")).unwrap().pair;
    let eyes = pair.pieces_in_other_tiles().len();
    assert_eq!((pair.piece_count() + eyes, eyes), (9976, 2176));
    bench.paint("face_1001.png", (128, 128), Channels::Rgb, &RED);
    bench.paint("face_1003.png", (128, 128), Channels::Rgb, &BLUE);
    let transfer = "transfer real.uvpair face_<UDIM>.png -o out.png --size 256 --filter bilinear";
    bench.succeed(transfer);
    let both = colors(&bench.texture("out.png"));
    assert!(both.len() == 2 && both[0].0 == BLUE && both[1].0 == RED, "{both:?}");
    assert!(both[0].1 > 500 && both[1].1 > 30_000, "{both:?}");
    std::fs::remove_file(bench.path("face_1003.png")).unwrap();
    let run = bench.run(transfer);
    assert!(
        run.stderr.contains("tile 1003, so 2176 triangles are left unlinked"),
        "{}",
        run.stderr
    );
    let alone = colors(&bench.texture("out.png"));
    assert!(alone.len() == 1 && alone[0].0 == RED, "{alone:?}");
}
