//! Measuring seams, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use serde_json::{Value, json};
use uvgraft::{Channels, Depth, Encoding, Mesh, Pair, Size, Texels, Texture};
use uvgraft_figure::Figure;
use uvgraft_image::{self as image, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_tests::looks::frame::figure_pair;
use uvgraft_tests::looks::{BodyFrame, BodyLook, FaceLook, HeadFrame, LayoutSpots, SkinTone};

use crate::bench::{Bench, texel_u8};

const RED: [u8; 3] = [200, 50, 50];
const BLUE: [u8; 3] = [50, 50, 200];
const GREY: [u8; 3] = [120, 120, 120];

/// Unit squares in a row, two triangles each; `uv` has the corners of each.
fn row(uv: &[[[f32; 2]; 4]]) -> Mesh {
    let squares = 0..uv.len() as u32;
    let positions = squares
        .clone()
        .flat_map(|k| {
            let (left, right) = (k as f32, (k + 1) as f32);
            [[left, 0.0, 0.0], [right, 0.0, 0.0], [right, 1.0, 0.0], [left, 1.0, 0.0]]
        })
        .collect();
    let faces: Vec<[u32; 3]> =
        squares.map(|k| 4 * k).flat_map(|k| [[k, k + 1, k + 2], [k, k + 2, k + 3]]).collect();
    Mesh::from_triangles(positions, uv.concat(), &faces, &faces).unwrap()
}

fn square(left: f32, top: f32) -> [[f32; 2]; 4] {
    [[left, top], [left + 0.2, top], [left + 0.2, top + 0.2], [left, top + 0.2]]
}

/// `row.uvpair`: the target has three squares, of which the first two are linked; the first is an
/// island of its own in red, the others share one in blue and grey (`paint.png`). The source has
/// two in one island.
fn bench() -> Bench {
    let bench = Bench::new();
    let source = row(&[square(0.1, 0.1), square(0.3, 0.1)]);
    let target = row(&[square(0.1, 0.7), square(0.4, 0.2), square(0.6, 0.2)]);
    let ids: Vec<i64> = (0..8).collect();
    let file = PairFile {
        pair: Pair::by_vertex_map(source, target, &ids).unwrap().into(),
        source_name: "two.obj".to_owned(),
        target_name: "three.obj".to_owned(),
        note: String::new(),
    };
    pair_file::write(&file, bench.path("row.uvpair")).unwrap();
    save(&bench, "paint.png", |x, y| match (x, y) {
        (_, 60..) => RED,
        (60.., _) => GREY,
        _ => BLUE,
    });
    bench
}

fn save(bench: &Bench, name: &str, color: impl Fn(u32, u32) -> [u8; 3]) {
    let texels = (0..10_000).flat_map(|k| color(k % 100, k / 100)).collect();
    let texture =
        Texture::new(Size::square(100), Channels::Rgb, Encoding::Srgb, Texels::U8(texels)).unwrap();
    let options = WriteOptions::default();
    let written = image::write(&texture.into(), bench.path(name), &options).unwrap();
    assert_eq!(written.losses, []);
}

fn delta_e(a: [u8; 3], b: [u8; 3]) -> f64 {
    let [a, b] = [a, b].map(|color| color.map(|value| f32::from(value) / 255.0));
    uvgraft::color::delta_e(a, b)
}

#[test]
fn a_table_for_people() {
    let bench = bench();
    let (seam, rim) = (delta_e(RED, BLUE), delta_e(BLUE, GREY));
    let found = bench.succeed("seams row.uvpair paint.png");
    let (seam, rim) = (format!("{seam:.2}"), format!("{rim:.2}"));
    let wanted = format!(
        "\
paint.png, 100×100 texels, on three.obj; the region is the linked triangles
colour differences (CIEDE2000) across edges, sampled 1 texel from the edge on either side

| edges                  | count | length |  mean | median |  95 % |  99 % | largest |
|:-----------------------|------:|-------:|------:|-------:|------:|------:|--------:|
| UV seams               |     1 |  1.000 | {seam} |  {seam} | {seam} | {seam} |   {seam} |
| adjacent edges         |     2 |  2.828 |  0.00 |   0.00 |  0.00 |  0.00 |    0.00 |
| UV seams in the region |     1 |  1.000 | {seam} |  {seam} | {seam} | {seam} |   {seam} |
| adjacent edges         |     2 |  2.828 |  0.00 |   0.00 |  0.00 |  0.00 |    0.00 |
| boundary of the region |     1 |  1.000 | {rim} |  {rim} | {rim} | {rim} |   {rim} |
| adjacent edges         |     2 |  2.828 |  0.00 |   0.00 |  0.00 |  0.00 |    0.00 |
| all ordinary edges     |     3 |  4.243 |  0.00 |   0.00 |  0.00 |  0.00 |    0.00 |

Adjacent edges share a vertex with those above them; differences there are the texture's
own detail. A difference of about 1 is barely visible, one of about 2.3 at a glance.

The worst edges, and the position of their largest difference in texels:

|     |  mean | largest | what     | triangles |   one side | other side |
|----:|------:|--------:|:---------|----------:|-----------:|-----------:|
|   1 | {seam} |   {seam} | UV seam  |      0, 3 | 30.0, 70.5 | 40.0, 20.5 |
|   2 | {rim} |   {rim} | boundary |      2, 5 | 60.0, 20.5 | 60.0, 20.5 |

8 open mesh edges skipped

verdict (whether the picture is right, only eyes can tell)
  boundary of the region   plainly visible (median {rim}, adjacent edges 0.00)
  UV seams in the region   plainly visible (median {seam}, adjacent edges 0.00)
"
    );
    assert_eq!(found, wanted);
    // One of each kind.
    assert_eq!(bench.succeed("seams row.uvpair paint.png --worst 1"), wanted);
    let none = bench.succeed("seams row.uvpair paint.png --worst 0");
    assert!(!none.contains("worst"), "{none}");
}

#[test]
fn json_for_programs() {
    let bench = bench();
    let parse = |args: &str| -> Value { serde_json::from_str(&bench.succeed(args)).unwrap() };
    let document = parse("seams row.uvpair paint.png --json --unit m --distance 0.25m");
    assert_eq!(document["texture"], "paint.png");
    assert_eq!(document["mesh"], "three.obj");
    assert_eq!(document["size"], json!({"width": 100, "height": 100}));
    assert_eq!(document["region"], "the linked triangles");
    assert_eq!(document["offset"], json!({"distance": 0.25}));
    let rim = &document["edges"]["rim"];
    assert_eq!(
        (&rim["edges"], &rim["length"], &rim["points"]),
        (&json!(1), &json!(1.0), &json!(20))
    );
    for name in ["mean", "median", "p95", "p99", "max"] {
        let found = rim["delta_e"][name].as_f64().unwrap();
        assert!((found - delta_e(BLUE, GREY)).abs() < 1e-4, "{name}: {found}");
    }
    assert_eq!(document["edges"]["ordinary"]["delta_e"]["max"], 0.0);
    let worst = &document["worst"][1];
    assert_eq!((&worst["is_rim"], &worst["is_uv_seam"]), (&json!(true), &json!(false)));
    assert_eq!(worst["faces"], json!([2, 5]));
    assert_eq!(worst["ends"], json!([[2.0, 0.0, 0.0], [2.0, 1.0, 0.0]]));
    // A quarter of each square, which is 20 texels wide.
    for (side, wanted) in [0.55, 0.65].into_iter().enumerate() {
        let found = worst["sampled_uv"][side][0].as_f64().unwrap();
        assert!((found - wanted).abs() < 1e-6, "{found}");
    }
    assert_eq!(document["notes"]["single_edges"], 8);
    assert_eq!(document["notes"]["shortened"], 0);
    // Squares have no head.
    assert!(document["tone"].is_null());
}

#[test]
fn the_other_layout_has_other_seams() {
    let bench = bench();
    let text = bench.succeed("seams row.uvpair paint.png --reverse --json --offset 2.5");
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&document["mesh"], &document["offset"]),
        (&json!("two.obj"), &json!({"texels": 2.5}))
    );
    let none = json!({"edges": 0, "length": 0.0, "points": 0, "delta_e": null});
    assert_eq!((&document["edges"]["rim"], &document["edges"]["uv_seams"]), (&none, &none));
    assert_eq!(document["edges"]["ordinary"]["edges"], 3);
    assert_eq!(document["worst"], json!([]));
    let text = bench.succeed("seams row.uvpair paint.png --reverse --picture none.png");
    assert!(text.contains("| boundary of the region |     0 |      0 |    – |"), "{text}");
    assert!(bench.texture("none.png").size().width > 1000);
}

#[test]
fn opacity_that_is_missing_is_said() {
    let bench = bench();
    bench.paint("clear.png", (64, 32), Channels::Rgba, &[9, 9, 9, 0]);
    let text = bench.succeed("seams row.uvpair clear.png --picture clear_seams.png");
    assert!(text.contains("points skipped: one side is transparent"), "{text}");
    assert!(!text.contains("worst"), "{text}");
}

#[test]
fn the_picture_shows_edges_and_places() {
    let bench = bench();
    bench.succeed("seams row.uvpair paint.png --picture seams.png");
    let picture = bench.texture("seams.png");
    let count = |wanted: &dyn Fn(&[u8]) -> bool| {
        let size = picture.size();
        let texels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        texels.filter(|&(x, y)| wanted(&texel_u8(&picture, x, y))).count()
    };
    // Both steps exceed the scale: the seam is drawn in its top red twice, 228 pixels long, the
    // boundary once in its top colour; each 2 or 3 pixels wide except for antialiasing.
    assert!(count(&|texel| texel == [226, 36, 40]) > 2 * 228);
    assert!(count(&|texel| texel == [252, 70, 226]) > 228);
    // Crops: at the seam one side has the texture's red, the other its blue.
    assert!(count(&|texel| texel == RED) > 10_000 && count(&|texel| texel == BLUE) > 10_000);
}

/// `figure.uvpair`, the figure's head and body, with a brown face (`face.png`) and a light body
/// (`body.png`).
fn figure_bench() -> Bench {
    let bench = Bench::new();
    let pair = figure_pair(&Figure::new());
    let look = FaceLook { skin: SkinTone::BROWN, ..FaceLook::all()[0] };
    let layout = LayoutSpots::new(pair.source(), Size::square(384));
    bench.save("face.png", look.paint(pair.source(), &HeadFrame::FIGURE, &layout).texture);
    let look = BodyLook::new("very light", SkinTone::VERY_LIGHT);
    let layout = LayoutSpots::new(pair.target(), Size::square(768));
    bench.save("body.png", look.paint(pair.target(), &BodyFrame::FIGURE, &layout).texture);
    let [source_name, target_name] = ["head.obj", "body.obj"].map(str::to_owned);
    let file = PairFile { pair, source_name, target_name, note: String::new() };
    pair_file::write(&file, bench.path("figure.uvpair")).unwrap();
    bench
}

#[test]
fn the_tone_of_a_face() {
    let bench = figure_bench();
    let transfer =
        "transfer figure.uvpair face.png --onto body.png --unit m --feather 10mm --keep-all";
    bench.succeed(&format!("{transfer} -o plain.png"));
    // It warns that a face so much lighter is hardly the same person's.
    assert_eq!(bench.run(&format!("{transfer} --blend membrane -o toned.png")).code, Some(0));
    let judge = |texture: &str, options: &str| {
        bench.succeed(&format!("seams figure.uvpair {texture} --worst 1 {options}"))
    };
    let plain = judge("plain.png", "--onto body.png --face face.png");
    for wanted in ["\ntone: cheek to chest: ΔE ", " (base: ", "\nhair and brows: shifted by ΔE "]
    {
        assert!(plain.contains(wanted), "{wanted}\n{plain}");
    }
    assert!(plain.contains(" more than the base's.\n"), "{plain}");
    let verdict = "  tone of the face         does not match the body's\n";
    assert!(plain.ends_with(verdict), "{plain}");
    assert!(plain.contains(
        "\nThe face does not match the body's tone: its cheeks differ from the chest by ΔE"
    ));
    let toned = judge("toned.png", "--onto body.png --face face.png");
    assert!(toned.contains(" % of the transferred skin\n\nverdict ("), "{toned}");
    assert!(toned.ends_with("  tone of the face         matches the body's\n"), "{toned}");
    // Without anything to compare with there is no verdict.
    let alone = judge("plain.png", "");
    assert!(alone.contains("\ntone: cheek to chest: ΔE ") && !alone.contains("base's"), "{alone}");
    assert!(!alone.contains("hair and brows") && !alone.contains("body's tone"), "{alone}");

    let parse = |texture: &str, options: &str| -> Value {
        serde_json::from_str(&judge(texture, &format!("--json {options}"))).unwrap()
    };
    let tone = &parse("plain.png", "--onto body.png --face face.png")["tone"];
    let number = |name: &str| tone[name].as_f64().unwrap();
    assert!(number("cheek_to_chest") > number("own") + 4.0, "{tone}");
    assert!(number("hair_shift") < 1.0 && number("clipped") < 0.01, "{tone}");
    assert_eq!((&tone["chest"], &tone["fits"]), (&json!("chest"), &json!(false)));
    let tone = &parse("toned.png", "--onto body.png")["tone"];
    assert_eq!((&tone["hair_shift"], &tone["fits"]), (&Value::Null, &json!(true)));
    // A head has no chest.
    let tone = &parse("face.png", "--reverse")["tone"];
    assert_eq!((&tone["chest"], &tone["own"]), (&json!("neck"), &Value::Null));
}

#[test]
fn the_picture_shows_the_face() {
    let bench = figure_bench();
    let size = |options: &str| {
        bench.succeed(&format!("seams figure.uvpair body.png {options} --picture seams.png"));
        bench.texture("seams.png").size()
    };
    // Below everything else, side by side.
    let (one, two) = (size("--worst 0"), size("--worst 0 --onto body.png"));
    assert!(one.width == two.width && two.height > 1288 + 200, "{one} {two}");
    let picture = bench.texture("seams.png");
    let column =
        |x: u32| -> Vec<_> { (1400..two.height - 60).map(|y| texel_u8(&picture, x, y)).collect() };
    let (left, right) = (column(200), column(200 + (two.width - 2 * 24 + 24) / 2));
    assert!(left == right, "both are the body");
}

#[test]
fn references_are_checked() {
    let bench = bench();
    bench.paint("small.png", (10, 10), Channels::Rgb, &GREY);
    bench.write("text.png", "no image at all");
    let cases: &[(&str, &[&str])] = &[
        ("--onto missing.png", &["missing.png", "No such file"]),
        ("--onto text.png", &["text.png: not a supported image"]),
        ("--face missing.png", &["missing.png", "No such file"]),
        ("--face text.png", &["text.png: not a supported image"]),
        (
            "--onto small.png",
            &["small.png: base must have the size of the texture, 100×100, got 10×10"],
        ),
        ("--onto small.png --picture small.png", &["output small.png is also an input"]),
        ("--face small.png --picture small.png", &["output small.png is also an input"]),
    ];
    for (options, wanted) in cases {
        bench.refuse(&format!("seams row.uvpair paint.png {options}"), wanted);
    }
    // Without a head there is nothing to compare.
    let run = bench.run("seams row.uvpair paint.png --onto paint.png --face small.png");
    assert!(run.code == Some(0) && !run.stdout.contains("tone"), "{run:?}");
    assert_eq!(run.stderr, "warning: --onto and --face have no effect: the mesh has no head\n");
}

#[test]
fn refused() {
    let bench = bench();
    bench.write("text.png", "no image at all");
    bench.paint_noise("whole.png", (40, 30), Channels::Rgb, Depth::U8);
    bench.derive("cut.png", "whole.png", |bytes| bytes.truncate(bytes.len() / 2));
    let cases: &[(&str, &[&str])] = &[
        ("missing.uvpair paint.png", &["missing.uvpair", "No such file"]),
        ("paint.png paint.png", &["paint.png: not a pair file"]),
        ("row.uvpair missing.png", &["missing.png", "No such file"]),
        ("row.uvpair row.uvpair", &["row.uvpair: not a supported image"]),
        ("row.uvpair text.png", &["text.png: not a supported image"]),
        ("row.uvpair cut.png", &["cut.png: truncated PNG"]),
        ("row.uvpair", &["required", "<TEXTURE>"]),
        ("row.uvpair paint.png --offset -1", &["-1"]),
        ("row.uvpair paint.png --offset=-1", &["--offset", "must be a number of at least 0"]),
        (
            "row.uvpair paint.png --distance nan",
            &["'nan'", "--distance", "must be a number with a unit"],
        ),
        ("row.uvpair paint.png --distance -3mm", &["'-3mm'", "--distance", "at least 0"]),
        ("row.uvpair paint.png --offset 1 --distance 1mm", &["--offset", "cannot be used with"]),
        ("row.uvpair paint.png --worst 5000", &["--worst", "5000"]),
    ];
    for (args, wanted) in cases {
        bench.refuse(&format!("seams {args}"), wanted);
        bench.refuse(&format!("seams {args} --json --picture seams.png"), wanted);
    }
    let pictures: &[(&str, &[&str])] = &[
        ("seams", &["seams: a picture of seams must be an image", ".png"]),
        ("none/seams.png", &["none/seams.png", "folder none does not exist"]),
        ("paint.png", &["output paint.png is also an input"]),
    ];
    for (picture, wanted) in pictures {
        bench.refuse(&format!("seams row.uvpair paint.png --picture {picture}"), wanted);
    }
}
