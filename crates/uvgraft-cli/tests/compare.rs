//! Comparing textures, through the program.

use crate::bench::{Bench, texel_u8};
use serde_json::{Value, json};
use uvgraft::{Channels, Depth, Size};

/// A bench with two pictures that differ by 51 levels in red, and masks.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.paint("a.png", (40, 30), Channels::Rgb, &[51, 100, 200]);
    bench.paint("b.png", (40, 30), Channels::Rgb, &[102, 100, 200]);
    bench.paint("all.png", (40, 30), Channels::Grey, &[255]);
    bench.paint("none.png", (40, 30), Channels::Grey, &[127]);
    bench.paint("small.png", (20, 30), Channels::Rgb, &[1, 2, 3]);
    bench
}

#[test]
fn a_table_for_people() {
    let bench = bench();
    let printed = bench.succeed("compare a.png b.png --metrics psnr,l1");
    let wanted = "\
a.png and b.png, 40×30 texels

| metric    | better | whole image |
|:----------|:------:|------------:|
| L1        |   ↓    |     0.06667 |
| PSNR (dB) |   ↑    |       18.75 |
";
    assert_eq!(printed, wanted);
    let all = bench.succeed("compare a.png b.png --metrics all");
    let default = bench.succeed("compare a.png b.png");
    for row in ["| L1 ", "| PSNR (dB) ", "| SSIM ", "| SSIM, uniform ", "| SSIMULACRA 2 "] {
        assert!(all.contains(row) && default.contains(row), "{row}\n{all}\n{default}");
    }
    assert_eq!(default.contains("| FLIP "), cfg!(feature = "flip"));
    assert!(all.contains("| FLIP ") && all.contains("| LPIPS, VGG "), "{all}");
    assert!(!default.contains("| LPIPS, VGG "), "slow, so only when asked for\n{default}");
}

#[test]
fn json_for_programs() {
    let bench = bench();
    let parse = |args: &str| -> Value { serde_json::from_str(&bench.succeed(args)).unwrap() };
    let document = parse("compare a.png b.png --json --metrics l1,ssimulacra2");
    assert_eq!(document["a"], "a.png");
    assert_eq!(document["b"], "b.png");
    assert_eq!(document["size"], json!({"width": 40, "height": 30}));
    let region = &document["regions"][0];
    assert_eq!((&region["region"], &region["texels"]), (&json!("whole image"), &json!(1200)));
    let l1 = region["scores"]["l1"].as_f64().unwrap();
    assert!((l1 - 0.2 / 3.0).abs() < 1e-7, "{l1}");
    assert!(region["scores"]["ssimulacra2"].as_f64().unwrap() < 100.0);

    let same = parse("compare a.png a.png --json --metrics psnr,ssim,l1");
    let wanted = json!({"l1": 0.0, "psnr": "inf", "ssim": 1.0});
    assert_eq!(same["regions"][0]["scores"], wanted);
}

#[test]
fn a_column_for_each_mask() {
    let bench = bench();
    bench.paint_noise("noise.png", (40, 30), Channels::Grey, Depth::U8);
    let run = bench.run("compare a.png b.png --json --metrics l1 --mask all.png --mask noise.png");
    assert_eq!(run.code, Some(0));
    assert_eq!(run.stderr, "note: all.png: --mask has no effect: white everywhere\n");
    let regions = &serde_json::from_str::<Value>(&run.stdout).unwrap()["regions"];
    assert_eq!((&regions[0]["region"], &regions[0]["texels"]), (&json!("all.png"), &json!(1200)));
    let noise = bench.texture("noise.png");
    let selected = (0..1200).filter(|k| texel_u8(&noise, k % 40, k / 40)[0] >= 128).count();
    assert_eq!(regions[1]["texels"], json!(selected));
}

/// A metric without a value reports the reason; the others still have values.
#[test]
fn what_cannot_be_computed_has_a_reason() {
    let bench = bench();
    bench.paint("tiny_a.png", (9, 7), Channels::Rgb, &[1, 2, 3]);
    bench.paint("tiny_b.png", (9, 7), Channels::Rgb, &[3, 2, 1]);
    let text = bench.succeed("compare tiny_a.png tiny_b.png --metrics l1,ssim,ssim-uniform");
    assert!(text.contains("| SSIM          |   ↑    |           – |"), "{text}");
    assert!(text.contains("\nSSIM needs images of at least 11 texels per side, got 9×7\n"));
    let text = bench.succeed("compare tiny_a.png tiny_b.png --json --metrics ssim,ssimulacra2");
    let document: Value = serde_json::from_str(&text).unwrap();
    for metric in ["ssim", "ssimulacra2"] {
        let reason = &document["regions"][0]["scores"][metric]["unavailable"];
        assert!(reason.as_str().unwrap().contains("texels per side"), "{document}");
    }
    if cfg!(not(feature = "flip")) {
        let text = bench.succeed("compare a.png b.png --metrics all");
        assert!(text.contains("FLIP: this build lacks the feature `flip`"), "{text}");
    }
}

/// A metric named explicitly is required.
#[test]
fn a_named_metric_that_lacks_what_it_needs_is_refused() {
    let bench = bench();
    bench.refuse(
        "compare a.png b.png --metrics psnr,lpips-vgg",
        &["--metrics lpips-vgg", "not imported", "uvgraft weights"],
    );
    if cfg!(not(feature = "flip")) {
        bench.refuse("compare a.png b.png --metrics flip", &["--metrics flip", "feature `flip`"]);
    }
}

#[test]
fn opacity_is_laid_over_black_and_said() {
    let bench = bench();
    bench.paint("clear.png", (40, 30), Channels::Rgba, &[255, 200, 100, 0]);
    bench.paint("opaque.png", (40, 30), Channels::Rgba, &[51, 100, 200, 255]);
    bench.paint("black.png", (40, 30), Channels::Grey, &[0]);
    let run = bench.run("compare clear.png black.png --metrics l1");
    assert_eq!(run.code, Some(0));
    assert!(run.stdout.contains(" 0.00000 |"), "{}", run.stdout);
    assert_eq!(run.stderr, "warning: clear.png has transparent texels; comparing it over black\n");
    assert!(bench.succeed("compare opaque.png a.png --metrics l1").contains(" 0.00000 |"));
}

/// A single wrong texel in a large picture must be visible, at its position.
#[test]
fn heatmaps_keep_single_texels() {
    let bench = Bench::new();
    let (width, height) = (2500, 300);
    bench.paint("a.png", (width, height), Channels::Rgb, &[9, 9, 9]);
    let mut texels = [9, 9, 9].repeat((width * height) as usize);
    texels[((120 * width + 801) * 3) as usize] = 89;
    let texture = uvgraft::Texture::new(
        Size::new(width, height),
        Channels::Rgb,
        uvgraft::Encoding::Srgb,
        uvgraft::Texels::U8(texels),
    );
    let options = uvgraft_image::WriteOptions::default();
    let written = uvgraft_image::write(&texture.unwrap().into(), bench.path("b.png"), &options);
    assert_eq!(written.unwrap().losses, []);
    bench.succeed("compare a.png b.png --metrics l1 --heatmap map.png");
    let map = bench.texture("map.png");
    assert!(map.size().width < 1600, "{}", map.size());
    // Two texels per pixel; the panel is at the bottom, 24 pixels from the edges.
    let (left, top) = (24, map.size().height - 24 - height / 2);
    let at = |x: u32, y: u32| texel_u8(&map, left + x, top + y);
    assert_eq!(at(400, 60), [255, 250, 222], "80 levels are the scale's top");
    for (x, y) in [(0, 0), (399, 60), (401, 60), (400, 59), (400, 61), (1249, 149)] {
        assert_eq!(at(x, y), [8, 8, 16], "{x}, {y}");
    }
}

#[test]
fn refused() {
    let bench = bench();
    bench.paint_noise("whole.png", (40, 30), Channels::Rgb, Depth::U8);
    bench.derive("cut.png", "whole.png", |bytes| bytes.truncate(bytes.len() / 2));
    bench.write("text.png", "no image at all");
    let cases: &[(&str, &[&str])] = &[
        ("a.png missing.png", &["missing.png", "No such file"]),
        ("text.png b.png", &["text.png: not a supported image"]),
        ("a.png cut.png", &["cut.png: truncated PNG"]),
        ("cut.png b.png", &["cut.png: truncated PNG"]),
        ("a.png small.png", &["small.png: must be 40×30 like a.png, got 20×30"]),
        ("a.png b.png --mask small.png", &["small.png: must be 40×30 like a.png, got 20×30"]),
        ("a.png b.png --mask none.png", &["none.png: the mask selects no texel"]),
        ("a.png b.png --mask all.png --mask none.png", &["none.png: the mask selects no texel"]),
        ("a.png b.png --mask text.png", &["text.png: not a supported image"]),
        ("a.png b.png --mask cut.png", &["cut.png: truncated PNG"]),
        ("a.png b.png --metrics l2", &["`l2`", "l1, psnr, ssim, ssim-uniform", "lpips-vgg"]),
        ("a.png b.png --metrics=", &["--metrics", "l1, psnr"]),
        ("a.png", &["required", "<TEXTURE>"]),
        ("a.png my.uvpair", &["my.uvpair: not a supported image"]),
    ];
    for (args, wanted) in cases {
        bench.refuse(&format!("compare {args}"), wanted);
        bench.refuse(&format!("compare {args} --json --heatmap map.png"), wanted);
    }
    let heatmaps: &[(&str, &[&str])] = &[
        ("map", &["map: a heatmap must be an image", ".png"]),
        ("map.gif", &["map.gif: a heatmap must be an image", ".png"]),
        ("none/map.png", &["none/map.png", "folder none does not exist"]),
        ("a.png", &["output a.png is also an input"]),
        ("all.png", &["output all.png is also an input"]),
    ];
    for (heatmap, wanted) in heatmaps {
        bench.refuse(&format!("compare a.png b.png --mask all.png --heatmap {heatmap}"), wanted);
    }
}
