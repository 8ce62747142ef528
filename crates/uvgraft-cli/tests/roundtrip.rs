//! Round trips and fits, through the program.

use crate::bench::Bench;
use serde_json::{Value, json};
use uvgraft::{Channels, Depth};

/// A bench with a texture in the target's layout, of which the sheet covers a sixth.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.paint_noise("body.png", (160, 120), Channels::Rgb, Depth::U8);
    bench.paint_noise("head.png", (80, 60), Channels::Rgb, Depth::U8);
    bench
}

#[test]
fn a_report_in_markdown() {
    let bench = bench();
    let args = "roundtrip my.uvpair body.png --via 96 --metrics l1,psnr --repeats 1";
    let printed = bench.succeed(&format!("{args} --fit --baseline grid,affine"));
    // Whole image and region.
    assert_eq!(
        printed.matches("lanczos3, fitted |").count(),
        3,
        "two heads and a row of times\n{printed}"
    );
    assert_eq!(printed.matches("\n| metric ").count(), 2, "{printed}");
    for wanted in [
        "# Round trip of body.png (target.obj)",
        "160×120 → 96×96 (source.obj) → 160×120, pair my.uvpair",
        "## Whole image, laid over the original",
        "## Transferred region: 3,072 texels, 16.0 %",
        "\n| PSNR (dB) ↑ |",
        "\n| affine           |",
        "bounding box of each triangle",
        "extrapolated from 8 triangles",
    ] {
        assert!(printed.contains(wanted), "{wanted}\n{printed}");
    }
    // Without what was not requested.
    let printed = bench.succeed(&format!("{args} --filter nearest,bilinear"));
    assert!(printed.contains("| nearest ") && printed.contains("| bilinear "), "{printed}");
    assert!(!printed.contains("grid") && !printed.contains("fitted"), "{printed}");
}

#[test]
fn json_and_the_region() {
    let bench = bench();
    // Of paths, reports hold the files' names alone.
    let pair = bench.path("my.uvpair");
    let args = format!(
        "roundtrip {} ./body.png --via 96 --metrics l1,psnr --repeats 1 --json --fit",
        pair.display()
    );
    let report: Value = serde_json::from_str(&bench.succeed(&args)).unwrap();
    assert_eq!((&report["texture"], &report["linked"]), (&json!("body.png"), &json!(3072)));
    assert_eq!(report["pair"], json!("my.uvpair"));
    assert_eq!(report["via"], json!({"width": 96, "height": 96}));
    let score = |outcome: usize, region: usize, metric: &str| {
        report["outcomes"][outcome]["regions"][region]["scores"][metric].as_f64().unwrap()
    };
    for outcome in 0..2 {
        // The whole and the region differ by the untouched part.
        let share = 3072.0 / (160.0 * 120.0);
        let (whole, region) = (score(outcome, 0, "l1"), score(outcome, 1, "l1"));
        assert!((whole - share * region).abs() < 1e-6, "{whole} {region}");
        assert!(report["outcomes"][outcome]["there_s"].as_f64().unwrap() > 0.0);
    }
    assert!(score(1, 1, "psnr") > score(0, 1, "psnr") + 1.0, "a fit is better\n{report}");
    let fit = &report["outcomes"][1]["fit"];
    assert!(fit["steps"].as_u64().unwrap() > 1, "{fit}");
    let rms = |name: &str| fit[name].as_f64().unwrap();
    assert!(rms("fitted_rms_levels") < rms("sampled_rms_levels"), "{fit}");
}

#[test]
fn a_folder_of_pictures() {
    let bench = bench();
    bench.succeed(
        "roundtrip my.uvpair head.png --from source --via 120 --metrics l1 --repeats 1 \
         --baseline grid -o out",
    );
    for method in ["lanczos3", "grid"] {
        let size = |picture: &str| bench.texture(&format!("out/{method}-{picture}.png")).size();
        assert_eq!((size("via").width, size("back").width), (120, 80));
        assert!(size("heatmap").width > 500);
    }
    let markdown = String::from_utf8(bench.bytes("out/report.md")).unwrap();
    assert!(markdown.contains("# Round trip of head.png (source.obj)"), "{markdown}");
    let json: Value = serde_json::from_slice(&bench.bytes("out/report.json")).unwrap();
    assert_eq!(json["outcomes"].as_array().unwrap().len(), 2);
    // The texture around the sheet is unchanged.
    let (original, back) = (bench.texture("head.png"), bench.texture("out/lanczos3-back.png"));
    assert_eq!(
        (original.get(0, 0, 1), original.get(79, 59, 2)),
        (back.get(0, 0, 1), back.get(79, 59, 2))
    );
    assert_ne!(original, back);
}

#[test]
fn refuses_what_makes_no_round_trip() {
    let bench = bench();
    bench.write("broken.png", b"no image");
    bench.make_folder("taken");
    bench.make_folder("taken/report.md");
    for (args, wanted) in [
        ("roundtrip my.uvpair broken.png --via 96", vec!["broken.png"]),
        ("roundtrip body.png body.png --via 96", vec!["body.png", "pair file"]),
        ("roundtrip my.uvpair none.png --via 96", vec!["none.png"]),
        ("roundtrip my.uvpair body.png --via 20000", vec!["--via", "20000", "16384"]),
        ("roundtrip my.uvpair body.png --via 0", vec!["--via"]),
        ("roundtrip my.uvpair body.png", vec!["--via"]),
        ("roundtrip my.uvpair body.png --via 96 --metrics best", vec!["best", "psnr"]),
        ("roundtrip my.uvpair body.png --via 96 --filter soft", vec!["soft", "lanczos3"]),
        ("roundtrip my.uvpair body.png --via 96 --filter nearest --fit", vec!["--fit", "nearest"]),
        ("roundtrip my.uvpair body.png --via 96 -o nowhere/out", vec!["nowhere"]),
        ("roundtrip my.uvpair body.png --via 96 -o head.png", vec!["head.png", "folder"]),
        ("roundtrip my.uvpair body.png --via 96 -o taken", vec!["report.md", "folder"]),
    ] {
        bench.refuse(args, &wanted);
    }
}

#[test]
fn broken_networks_are_an_error() {
    let bench = bench();
    bench.write("lpips.safetensors", b"no networks");
    let args = "roundtrip my.uvpair body.png --via 96 -o out --metrics lpips-alex";
    bench.refuse(args, &["lpips.safetensors"]);
}

#[test]
fn a_fitted_transfer_says_how_it_went() {
    let bench = bench();
    let said = bench.succeed(
        "transfer my.uvpair body.png --reverse --fit --size 96 --onto #808080 -o fitted.png",
    );
    assert!(
        said.starts_with("fitted.png: ") && said.contains(" steps, round-trip RMSE "),
        "{said}"
    );
    let quiet = bench
        .succeed("transfer my.uvpair body.png --reverse --size 96 --onto #808080 -o sampled.png");
    assert_eq!(quiet, "");
    assert_ne!(bench.texture("fitted.png"), bench.texture("sampled.png"));
    let one = bench.succeed(
        "transfer my.uvpair body.png --reverse --fit --fit-steps 1 --size 96 --onto #808080 -o one.png",
    );
    assert!(one.starts_with("one.png: 1 step, "), "{one}");

    bench.refuse(
        "transfer my.uvpair body.png --reverse --fit --filter nearest --size 96 -o out.png",
        &["--fit", "nearest"],
    );
    bench.refuse("transfer my.uvpair body.png --fit-steps 3 --size 96 -o out.png", &["--fit"]);
    bench.refuse(
        "transfer my.uvpair body.png --fit --fit-steps 0 --size 96 -o out.png",
        &["--fit-steps"],
    );
}

#[test]
fn what_is_not_opaque_is_laid_over_black_for_all() {
    let bench = bench();
    // Fully transparent, with a colour that must not show.
    bench.paint("clear.png", (160, 120), Channels::Rgba, &[255, 0, 255, 0]);
    let run = bench.run(
        "roundtrip my.uvpair clear.png --via 96 --metrics l1 --repeats 1 --baseline grid --json",
    );
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.contains("clear.png has transparent texels"), "{run:?}");
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    for outcome in 0..2 {
        assert_eq!(report["outcomes"][outcome]["regions"][0]["scores"]["l1"], json!(0.0));
    }
}

#[test]
fn floats_stay_floats() {
    let bench = bench();
    bench.paint_noise("body.exr", (160, 120), Channels::Rgb, Depth::F32);
    bench.succeed("roundtrip my.uvpair body.exr --via 96 --metrics l1 --repeats 1 -o out");
    assert_eq!(bench.texture("out/lanczos3-via.exr").depth(), Depth::F32);
    assert_eq!(bench.texture("out/lanczos3-back.exr").depth(), Depth::F32);
    assert!(bench.exists("out/lanczos3-heatmap.png"));
}
