//! Transferring textures, through the program.

use std::io::Cursor;
use std::time::{Duration, SystemTime};

use crate::bench::{Bench, texel, texel_u8};
use uvgraft::{Channels, Depth, Encoding, Size};

const FACE: [u8; 3] = [200, 100, 50];
const BASE: [u8; 3] = [10, 20, 30];

/// A bench with a face and a base of one colour each.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.paint("face.png", (64, 64), Channels::Rgb, &FACE);
    bench.paint("base.png", (80, 60), Channels::Rgb, &BASE);
    bench
}

#[test]
fn forward_onto_a_base() {
    let bench = bench();
    let printed =
        bench.succeed("transfer my.uvpair face.png --onto base.png --gutter 0 -o out.png");
    assert_eq!(printed, "");
    let out = bench.texture("out.png");
    assert_eq!(
        (out.size(), out.channels(), out.depth()),
        (Size::new(80, 60), Channels::Rgb, Depth::U8)
    );
    for y in 0..60 {
        for x in 0..80 {
            // The sheet covers 0.1 to 0.5 of the target.
            let inside = (8..40).contains(&x) && (6..30).contains(&y);
            let wanted = if inside { FACE } else { BASE };
            assert_eq!(texel_u8(&out, x, y), wanted, "{x}, {y}");
        }
    }
}

#[test]
fn reverse_onto_a_base() {
    let bench = bench();
    bench.succeed("transfer my.uvpair face.png --reverse --onto base.png --gutter 0 -o out.png");
    let out = bench.texture("out.png");
    for (x, y, wanted) in
        [(8, 6, FACE), (71, 53, FACE), (7, 6, BASE), (72, 53, BASE), (40, 54, BASE)]
    {
        assert_eq!(texel_u8(&out, x, y), wanted, "{x}, {y}");
    }
}

/// Each corner of the sheet must arrive at its own corner, neither mirrored nor rotated.
#[test]
fn the_picture_keeps_its_orientation() {
    let bench = Bench::new();
    bench.paint_noise("noise.png", (40, 40), Channels::Rgb, Depth::U8);
    // Twice the size over half the extent: texels map to texels.
    bench.succeed("transfer my.uvpair noise.png --size 80 --onto #000 --filter nearest -o out.png");
    let (noise, out) = (bench.texture("noise.png"), bench.texture("out.png"));
    for y in 0..32 {
        for x in 0..32 {
            let wanted = texel_u8(&noise, 4 + x, 4 + y);
            assert_eq!(texel_u8(&out, 8 + x, 8 + y), wanted, "{x}, {y}");
        }
    }
    bench.succeed(
        "transfer my.uvpair out.png --reverse --onto noise.png --filter nearest --gutter 0 -o back.png",
    );
    assert!(bench.texture("back.png") == noise, "there and back");
}

#[test]
fn sizes_are_the_bases_or_as_asked() {
    let bench = bench();
    for (options, wanted) in [
        ("--size 40x30", Size::new(40, 30)),
        ("--size 33", Size::square(33)),
        ("--onto base.png", Size::new(80, 60)),
        ("--onto base.png --size 40x30", Size::new(40, 30)),
        ("--onto base.png --size 201x7", Size::new(201, 7)),
    ] {
        bench.succeed(&format!("transfer my.uvpair face.png {options} -o out.png"));
        let out = bench.texture("out.png");
        assert_eq!(out.size(), wanted, "{options}");
        let Size { width, height } = wanted;
        if width > 30 && height > 6 && options.contains("base") {
            assert_eq!(texel_u8(&out, width * 3 / 10, height * 3 / 10), FACE, "{options}");
            assert_eq!(texel_u8(&out, width - 1, height - 1), BASE, "{options}");
        }
    }
    bench.refuse(
        "transfer my.uvpair face.png --onto base.png --size 1 -o out.png",
        &["links no texel of a 1×1 result"],
    );
}

#[test]
fn colours_as_base() {
    let bench = bench();
    for (onto, channels, outside) in [
        ("", Channels::Rgba, &[0, 0, 0, 0][..]),
        ("--onto #123", Channels::Rgb, &[0x11, 0x22, 0x33]),
        ("--onto #8090A0", Channels::Rgb, &[0x80, 0x90, 0xa0]),
        ("--onto #8090a040", Channels::Rgba, &[0x80, 0x90, 0xa0, 0x40]),
        ("--onto #808080ff", Channels::Rgb, &[0x80, 0x80, 0x80]),
    ] {
        bench.succeed(&format!(
            "transfer my.uvpair face.png --size 40 --gutter 0 {onto} -o out.png"
        ));
        let out = bench.texture("out.png");
        assert_eq!(out.channels(), channels, "{onto}");
        assert_eq!(texel_u8(&out, 39, 0), outside, "{onto}");
        let inside = texel_u8(&out, 10, 10);
        assert_eq!(inside[..3], FACE, "{onto}");
        assert!(inside.get(3).is_none_or(|&alpha| alpha == 255), "{onto}");
    }
}

#[test]
fn channels_and_depths_of_the_result() {
    let bench = bench();
    let all = [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba];
    for channels in all {
        for depth in [Depth::U8, Depth::U16] {
            bench.paint_noise("noise.png", (40, 40), channels, depth);
            bench.succeed(
                "transfer my.uvpair noise.png --onto #777 --size 80 --filter nearest -o out.png",
            );
            let (noise, out) = (bench.texture("noise.png"), bench.texture("out.png"));
            assert_eq!((out.channels(), out.depth()), (channels, depth));
            // Transparent parts show the base.
            let (found, mut wanted) = (texel(&out, 20, 30), texel(&noise, 16, 26));
            if channels.has_alpha()
                && let Some((alpha, values)) = wanted.split_last_mut()
            {
                for value in values {
                    *value = *value * *alpha + f32::from(0x77u8) / 255.0 * (1.0 - *alpha);
                }
                *alpha = 1.0;
            }
            let close = found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 0.003);
            assert!(close, "{channels:?} {depth:?}: {found:?}, wanted {wanted:?}");
            // Without a base it arrives unchanged.
            bench.succeed(
                "transfer my.uvpair noise.png --size 80 --filter nearest --gutter 0 -o out.png",
            );
            let found = texel(&bench.texture("out.png"), 20, 30);
            let mut wanted = texel(&noise, 16, 26);
            wanted.resize(found.len(), 1.0);
            assert_eq!(found, wanted, "{channels:?} {depth:?}");

            bench.succeed("transfer my.uvpair noise.png --onto base.png -o out.png");
            let out = bench.texture("out.png");
            assert_eq!((out.channels(), out.depth()), (channels.union(Channels::Rgb), depth));
            let outside: Vec<u8> =
                texel(&out, 79, 59).iter().map(|value| (value * 255.0).round() as u8).collect();
            assert_eq!(outside[..3], BASE, "{channels:?} {depth:?}");
        }
    }
    // A coloured base makes a grey texture's result coloured; the greater depth wins.
    bench.paint_noise("grey.png", (40, 40), Channels::Grey, Depth::U8);
    bench.paint_noise("deep.png", (40, 40), Channels::Rgb, Depth::U16);
    bench.succeed("transfer my.uvpair grey.png --onto #f00 --size 40 -o out.png");
    assert_eq!(bench.texture("out.png").channels(), Channels::Rgb);
    bench.succeed("transfer my.uvpair grey.png --onto deep.png -o out.png");
    assert_eq!(bench.texture("out.png").depth(), Depth::U16);
}

#[test]
fn formats_follow_the_extension() {
    let bench = bench();
    for (name, start, tolerance) in [
        ("out.png", &b"\x89PNG"[..], 0),
        ("out.PNG", b"\x89PNG", 0),
        ("out.jpg", b"\xff\xd8\xff", 3),
        ("out.jpeg", b"\xff\xd8\xff", 3),
        ("out.webp", b"RIFF", 0),
        ("out.tif", b"II*\0", 0),
        ("out.tiff", b"II*\0", 0),
    ] {
        bench.succeed(&format!("transfer my.uvpair face.png --onto base.png -o {name}"));
        assert!(bench.bytes(name).starts_with(start), "{name}");
        let out = bench.texture(name);
        let inside = texel_u8(&out, 20, 15);
        let close = inside.iter().zip(FACE).all(|(a, b)| a.abs_diff(b) <= tolerance);
        assert!(close && out.size() == Size::new(80, 60), "{name}: {inside:?}");
    }
    bench.succeed("transfer my.uvpair face.png --onto base.png -o out.exr");
    let out = bench.texture("out.exr");
    assert_eq!((out.depth(), out.encoding()), (Depth::F32, Encoding::Linear));
    let red = texel(&out, 20, 15)[0];
    assert!((red - linear(200.0 / 255.0)).abs() < 1e-4, "{red}");

    // And back: every format is read, too.
    for name in ["out.jpg", "out.webp", "out.tif", "out.exr"] {
        let run = bench
            .run(&format!("transfer my.uvpair {name} --reverse --onto #000 --size 20 -o back.tif"));
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{name}");
        assert_eq!(bench.texture("back.tif").size(), Size::square(20));
    }
}

#[test]
fn what_a_format_cannot_hold_is_said() {
    let bench = bench();
    bench.paint_noise("deep.png", (16, 16), Channels::Rgb, Depth::U16);
    let run = bench.run("transfer my.uvpair deep.png --onto base.png -o out.jpg");
    assert_eq!(run.code, Some(0));
    assert_eq!(run.stderr, "warning: out.jpg: values rounded from 16 bits to 8 bits\n");
}

#[test]
fn jpeg_quality_counts() {
    let bench = bench();
    bench.paint_noise("noise.png", (64, 64), Channels::Rgb, Depth::U8);
    let size = |quality: u8| {
        let options = format!("--onto #000 --size 128 --quality {quality} -o out.jpg");
        bench.succeed(&format!("transfer my.uvpair noise.png {options}"));
        bench.bytes("out.jpg").len()
    };
    let [low, middle, high] = [1, 50, 100].map(size);
    assert!(low < middle && middle < high, "{low} {middle} {high}");
}

#[test]
fn encoding_options_that_mean_nothing_to_the_outputs() {
    let bench = bench();
    bench.paint_noise("a.png", (16, 16), Channels::Rgb, Depth::U8);
    bench.paint_noise("b.png", (16, 16), Channels::Rgb, Depth::U8);
    let line = "transfer my.uvpair a.png --onto #000 --size 16";
    let quality = "--quality is for JPEG files only";
    let compress = "--compress is for PNG, TIFF and EXR files only";
    for (options, wanted) in [
        ("--quality 80 -o out.png", quality),
        // The default, too, if it is given.
        ("--quality 95 -o out.webp", quality),
        ("--quality 80 -o out.tif", quality),
        ("--quality 80 -o out.exr", quality),
        ("b.png --quality 80 -o out", quality),
        ("b.png --quality 80 --format webp -o out", quality),
        ("--compress -o out.jpg", compress),
        ("--compress -o out.webp", compress),
        ("b.png --compress --format jpg -o out", compress),
        ("--compress --quality 80 -o out.jpg", compress),
        ("--compress --quality 80 -o out.png", quality),
    ] {
        bench.refuse(&format!("{line} {options}"), &[wanted]);
    }
    bench.succeed(&format!("{line} --quality 80 -o out.jpg"));
    bench.succeed(&format!("{line} b.png --quality 80 --format jpg -o jpegs"));
    bench.succeed(&format!("{line} --compress -o out.tif"));
}

#[test]
fn masks() {
    let bench = bench();
    // White marks texels covered by a triangle, never the gutter.
    for gutter in [0, 2] {
        let options = format!("--gutter {gutter} --mask mask.png");
        bench.succeed(&format!("transfer my.uvpair face.png --onto base.png {options} -o out.png"));
        let mask = bench.texture("mask.png");
        assert_eq!((mask.size(), mask.channels()), (Size::new(80, 60), Channels::Grey));
        let values: Vec<u8> = (0..4800).map(|k| texel_u8(&mask, k % 80, k / 80)[0]).collect();
        assert!(values.iter().all(|value| [0, 255].contains(value)));
        let white = values.iter().filter(|&&value| value == 255).count();
        assert_eq!(white, 32 * 24, "{gutter}");
        assert_eq!(texel_u8(&mask, 20, 15), [255]);
        assert_eq!(texel_u8(&mask, 60, 45), [0], "the quad that nothing is linked to");
    }
}

#[test]
fn gutters() {
    let bench = bench();
    let reach = |gutter: &str| {
        bench.succeed(&format!("transfer my.uvpair face.png --onto base.png {gutter} -o out.png"));
        let out = bench.texture("out.png");
        // To the left of the sheet, which begins at texel 8.
        (0..8).rev().take_while(|&x| texel_u8(&out, x, 15) == FACE).count()
    };
    assert_eq!(reach("--gutter 0"), 0);
    assert_eq!(reach("--gutter 1"), 1);
    assert_eq!(reach("--gutter 5"), 5);
    assert_eq!(reach(""), 8);
    assert_eq!(reach("--gutter 256"), 8);
}

#[test]
fn filters_differ_and_keep_flat_colours() {
    let bench = bench();
    bench.paint_noise("noise.png", (64, 64), Channels::Rgb, Depth::U8);
    let filters = ["nearest", "bilinear", "catmull-rom", "lanczos3"];
    let mut results = Vec::new();
    for filter in filters {
        let options = format!("--onto base.png --filter {filter} -o out.png");
        bench.succeed(&format!("transfer my.uvpair face.png {options}"));
        assert_eq!(texel_u8(&bench.texture("out.png"), 20, 15), FACE, "{filter}");
        bench.succeed(&format!("transfer my.uvpair noise.png {options}"));
        results.push(bench.bytes("out.png"));
    }
    for (a, b) in [(0, 1), (1, 2), (2, 3)] {
        assert_ne!(results[a], results[b], "{} and {}", filters[a], filters[b]);
    }
    bench.succeed("transfer my.uvpair noise.png --onto base.png -o out.png");
    assert_eq!(bench.bytes("out.png"), results[3], "lanczos3 is the default");
    bench.succeed("transfer my.uvpair noise.png --onto base.png --data -o out.png");
    assert_eq!(bench.bytes("out.png"), results[1], "bilinear is the default for data");
}

/// Black and white stripes of one texel, minified to a quarter: averaged as encoded, or as light.
#[test]
fn averages_as_encoded_or_as_light() {
    let bench = Bench::new();
    let stripes: Vec<u8> =
        (0..256 * 256).flat_map(|k| [if k % 2 == 0 { 0 } else { 255 }; 3]).collect();
    let mut encoded = Vec::new();
    let mut encoder = png::Encoder::new(&mut encoded, 256, 256);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&stripes).unwrap();
    bench.write("stripes.png", encoded);
    let average = |option: &str| {
        let args =
            format!("transfer my.uvpair stripes.png --onto #000 --size 128 {option} -o out.png");
        bench.succeed(&args);
        texel_u8(&bench.texture("out.png"), 40, 40)[0]
    };
    assert!(average("").abs_diff(128) <= 2);
    assert!(average("--linear-light").abs_diff(188) <= 2);
}

/// A flame adds light where it covers nothing.
#[test]
fn a_base_keeps_light_without_coverage() {
    let bench = bench();
    let size = Size::new(80, 60);
    let glow: Vec<f32> = [0.75, 0.5, 0.25, 0.0].repeat(size.texels());
    let glow = uvgraft::Texels::F32(glow);
    let glow = uvgraft::Texture::new(size, Channels::Rgba, Encoding::Linear, glow).unwrap();
    let options = uvgraft_image::WriteOptions::default().keeps_light(true);
    let written = uvgraft_image::write(&glow.into(), bench.path("glow.exr"), &options);
    assert_eq!(written.unwrap().losses, []);
    assert_eq!(bench.succeed("transfer my.uvpair face.png --onto glow.exr -o out.exr"), "");
    assert_eq!(texel(&bench.texture("out.exr"), 79, 59), [0.75, 0.5, 0.25, 0.0]);
    // What hides beneath the transparency of other files is no light.
    bench.paint("clear.png", (80, 60), Channels::Rgba, &[200, 100, 50, 0]);
    let run = bench.run("transfer my.uvpair face.png --onto clear.png -o out.exr");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(texel(&bench.texture("out.exr"), 79, 59), [0.0; 4]);
}

/// A float image holds linear light and is encoded for an 8-bit file, unless it is data.
#[test]
fn data_is_never_converted() {
    let bench = bench();
    let value = |x: f32| {
        let texels = uvgraft::Texels::F32(vec![x; 32 * 32]);
        uvgraft::Texture::new(Size::square(32), Channels::Grey, Encoding::Linear, texels).unwrap()
    };
    let write = |name: &str, texture: uvgraft::Texture| {
        let options = uvgraft_image::WriteOptions::default();
        let written = uvgraft_image::write(&texture.into(), bench.path(name), &options);
        assert_eq!(written.unwrap().losses, []);
    };
    write("rough.exr", value(0.25));
    let result = |options: &str, at: u32| {
        let run = bench.run(&format!("transfer my.uvpair rough.exr --gutter 0 {options}"));
        assert_eq!(run.code, Some(0), "{options}: {}", run.stderr);
        let name = options.split(' ').next_back().unwrap();
        texel(&bench.texture(name), at, at)[0]
    };
    let close =
        |found: f32, wanted: f32| assert!((found - wanted).abs() < 2e-3, "{found} {wanted}");
    close(result("--size 40 --onto #808080 --data -o out.exr", 10), 0.25);
    close(result("--size 40 --onto #808080 --data -o out.exr", 39), 128.0 / 255.0);
    close(result("--size 40 --onto #808080 --data -o out.png", 10), 0.25);
    close(result("--size 40 --onto #808080 -o out.exr", 10), 0.25);
    close(result("--size 40 --onto #808080 -o out.exr", 39), linear(128.0 / 255.0));
    close(result("--size 40 --onto #808080 -o out.png", 10), 0.5371);
    bench.paint("grey.png", (40, 40), Channels::Grey, &[100]);
    close(result("--onto grey.png --data -o out.png", 10), 0.25);
    close(result("--onto grey.png --data -o out.png", 39), 100.0 / 255.0);
    close(result("--onto grey.png --data --size 20 -o out.tif", 19), 100.0 / 255.0);
}

#[test]
fn compressing_changes_the_size_alone() {
    let bench = bench();
    bench.paint_noise("noise.png", (64, 64), Channels::Rgb, Depth::U8);
    for name in ["out.png", "out.tif", "out.exr"] {
        let args = format!("transfer my.uvpair noise.png --onto #345 --size 256 -o {name}");
        bench.succeed(&args);
        let (fast, texture) = (bench.bytes(name).len(), bench.texture(name));
        bench.succeed(&format!("{args} --compress"));
        let small = bench.bytes(name).len();
        assert!(small <= fast, "{name}: {small} bytes after {fast}");
        assert_eq!(bench.texture(name), texture, "{name}");
    }
}

#[test]
fn icc_profiles_travel() {
    let bench = bench();
    let profile = |seed: u8| (0..500).map(|k: u32| (k % 251) as u8 ^ seed).collect::<Vec<u8>>();
    for (name, color, icc) in [
        ("one.png", png::ColorType::Rgb, 1),
        ("two.png", png::ColorType::Rgb, 2),
        ("grey.png", png::ColorType::Grayscale, 3),
    ] {
        let mut info = png::Info::with_size(16, 16);
        info.color_type = color;
        info.bit_depth = png::BitDepth::Eight;
        info.icc_profile = Some(profile(icc).into());
        let mut encoded = Vec::new();
        let encoder = png::Encoder::with_info(&mut encoded, info).unwrap();
        let values = vec![90; 16 * 16 * color.samples()];
        encoder.write_header().unwrap().write_image_data(&values).unwrap();
        bench.write(name, encoded);
    }
    let run = |args: &str| {
        let run = bench.run(&format!("transfer my.uvpair {args} -o out.png"));
        assert_eq!(run.code, Some(0), "{args}: {}", run.stderr);
        let file = Cursor::new(bench.bytes("out.png"));
        let reader = png::Decoder::new(file).read_info().unwrap();
        (reader.info().icc_profile.as_deref().map(<[u8]>::to_vec), run.stderr)
    };
    // The base's profile, without a message if the source has the same.
    assert_eq!(run("one.png --onto one.png"), (Some(profile(1)), String::new()));
    for (args, wanted, words) in [
        (
            "one.png --onto two.png",
            Some(2),
            &["one.png and two.png have different ICC profiles"][..],
        ),
        ("face.png --onto two.png", Some(2), &["two.png has an ICC profile but face.png has none"]),
        ("one.png --onto base.png", None, &["one.png has an ICC profile but base.png has none"]),
        ("one.png --onto grey.png", None, &["out.png: ICC profile dropped", "grey"]),
    ] {
        let (found, said) = run(args);
        assert_eq!(found, wanted.map(profile), "{args}");
        for words in words {
            assert!(said.contains(words) && said.starts_with("warning: "), "{args}: {said}");
        }
    }
    // Over a colour, the source's.
    assert_eq!(run("one.png --onto #abc --size 8"), (Some(profile(1)), String::new()));
    assert_eq!(run("one.png --size 8"), (Some(profile(1)), String::new()));
    assert_eq!(run("grey.png --onto #555 --size 8"), (Some(profile(3)), String::new()));
    let (found, said) = run("grey.png --onto #f00 --size 8");
    assert!(found.is_none() && said.contains("dropped"), "{said}");
}

#[test]
fn a_bad_texture_in_the_middle_stops_no_other() {
    let bench = bench();
    bench.make_folder("in");
    for (name, value) in [("in/1.png", 10), ("in/2.png", 20), ("in/4.png", 40)] {
        bench.paint(name, (16, 16), Channels::Rgb, &[value; 3]);
    }
    bench.write("in/3.png", "no image");
    bench.write("in/notes.txt", "left out");
    bench.write("in/._1.png", "hidden, left out");
    bench.make_folder("in/folder.png");
    let more = "--size 40 --onto #fff --mask mask.png --gutter 0";
    for sources in ["in", "in/1.png in/2.png in/3.png in/4.png"] {
        let run = bench.run(&format!("transfer my.uvpair {sources} {more} -o out"));
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{}", run.stderr);
        // Two lines and no progress bar, since standard error is not a terminal.
        let wanted = "error: in/3.png: not a supported image (PNG, JPEG, WebP, TIFF, EXR): \
                      starts with \"no image\"\nwarning: 3 of 4 textures transferred\n";
        assert_eq!(run.stderr, wanted);
        for (name, value) in [("out/1.png", 10), ("out/2.png", 20), ("out/4.png", 40)] {
            assert_eq!(texel_u8(&bench.texture(name), 10, 10), [value; 3]);
        }
        assert_eq!(bench.path("out").read_dir().unwrap().count(), 3);
        assert_eq!(bench.texture("mask.png").size(), Size::square(40));
        bench.assert_no_litter();
        std::fs::remove_dir_all(bench.path("out")).unwrap();
        std::fs::remove_file(bench.path("mask.png")).unwrap();
    }
}

#[test]
fn several_textures_into_a_folder() {
    let bench = bench();
    for folder in ["in", "out"] {
        bench.make_folder(folder);
    }
    bench.paint("in/a.png", (16, 16), Channels::Rgb, &FACE);
    bench.paint("in/b.webp", (32, 8), Channels::Rgb, &FACE);
    bench.paint("in/c.d.tif", (8, 32), Channels::Rgb, &FACE);
    bench.write("out/kept.txt", "kept");
    assert_eq!(bench.succeed("transfer my.uvpair in --size 40 --onto #fff -o out"), "");
    for name in ["out/a.png", "out/b.webp", "out/c.d.tif"] {
        assert_eq!(texel_u8(&bench.texture(name), 10, 10), FACE, "{name}");
    }
    // All in one format, into the folder itself, where no file is overwritten.
    bench.succeed("transfer my.uvpair in --size 40 --onto #fff --format jpg -o in");
    for name in ["in/a.jpg", "in/b.jpg", "in/c.d.jpg"] {
        assert!(bench.bytes(name).starts_with(b"\xff\xd8"), "{name}");
    }
    // A single texture in a folder keeps its name.
    bench.succeed("transfer my.uvpair face.png --size 40 -o out/");
    assert_eq!(bench.texture("out/face.png").size(), Size::square(40));
    assert_eq!(bench.bytes("out/kept.txt"), b"kept");
    // A slash requests a folder, and a dot before the extension is not doubled.
    bench.succeed("transfer my.uvpair face.png --size 40 --format .webp -o new.png/");
    assert_eq!(bench.texture("new.png/face.webp").size(), Size::square(40));
}

#[test]
fn threads_do_not_show_in_the_result() {
    let bench = Bench::new();
    bench.paint_noise("noise.png", (150, 130), Channels::Rgba, Depth::U16);
    bench.paint_noise("base.png", (333, 257), Channels::Rgb, Depth::U8);
    let result = |threads: &str| {
        let args =
            "transfer my.uvpair noise.png --onto base.png --mask mask.png --compress -o out.png";
        bench.succeed(&format!("{threads} {args}"));
        (bench.bytes("out.png"), bench.bytes("mask.png"))
    };
    let one = result("--threads 1");
    for threads in ["--threads 2", "--threads 7", ""] {
        assert!(result(threads) == one, "{threads}");
    }
    bench.succeed("transfer --threads 2 my.uvpair noise.png --size 8 -o out.png");
}

#[cfg(unix)]
#[test]
fn links_and_odd_names() {
    let bench = bench();
    bench.write("kept.png", "old");
    std::os::unix::fs::symlink("kept.png", bench.path("link.png")).unwrap();
    std::os::unix::fs::symlink("face.png", bench.path("to_face.png")).unwrap();
    bench.succeed("transfer my.uvpair to_face.png --onto base.png -o link.png");
    assert!(bench.path("link.png").is_symlink());
    assert_eq!(texel_u8(&bench.texture("kept.png"), 20, 15), FACE);

    // Input formats follow from the content, output formats from the name.
    bench.derive("face.jpg", "face.png", |_| {});
    let odd = "ein Gesicht – 顔.png";
    let run = bench.run_args(&["transfer", "my.uvpair", "face.jpg", "--size", "40", "-o", odd]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert_eq!(bench.texture(odd).size(), Size::square(40));
}

/// The real meshes, which their licences keep out of the repository.
#[test]
fn a_real_head_and_body() {
    let Some(folder) = std::env::var_os("UVGRAFT_DATA").map(std::path::PathBuf::from) else {
        eprintln!("skipped: UVGRAFT_DATA is not set");
        return;
    };
    let bench = Bench::new();
    let path = |name: &str| folder.join(name).into_os_string().into_string().unwrap();
    let [head, body, ids] =
        ["flame_head_template.obj", "smplx_addon.obj", "smplx_flame_vertex_ids.npy"].map(path);
    let run = bench.run_args(&[
        "pair",
        &head,
        &body,
        "--vertex-map",
        &ids,
        "-o",
        "real.uvpair",
        "--json",
        "--source-size",
        "256",
        "--target-size",
        "256",
    ]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(
        (&report["source"]["faces"], &report["source"]["linked"]),
        (&9976.into(), &9976.into())
    );

    bench.paint("face.png", (256, 256), Channels::Rgb, &FACE);
    bench.succeed(
        "transfer real.uvpair face.png --size 512 --onto #0a141e --gutter 0 --mask mask.png -o body.png",
    );
    bench.succeed("transfer real.uvpair body.png --reverse --size 256 --onto #000 -o back.png");
    let (body, mask) = (bench.texture("body.png"), bench.texture("mask.png"));
    let mut counts = [0; 2];
    for (x, y) in (0..512).flat_map(|y| (0..512).map(move |x| (x, y))) {
        let covered = texel_u8(&mask, x, y) == [255];
        counts[usize::from(covered)] += 1;
        assert_eq!(texel_u8(&body, x, y), if covered { FACE } else { BASE }, "{x}, {y}");
    }
    assert!(counts.iter().all(|&count| count > 10_000), "{counts:?}");
    let back = bench.texture("back.png");
    let kept = (0..256 * 256).filter(|k| texel_u8(&back, k % 256, k / 256) == FACE).count();
    assert!(kept > 256 * 256 / 2, "{kept}");
}

/// The linear light of an sRGB value.
fn linear(value: f32) -> f32 {
    ((value + 0.055) / 1.055).powf(2.4)
}

/// Several at once give the same results as each alone, and messages come in their order.
#[test]
fn textures_at_once_equal_textures_alone() {
    let bench = Bench::new();
    bench.make_folder("in");
    bench.paint_noise("base.png", (200, 300), Channels::Rgb, Depth::U8);
    let names: Vec<String> = (0..9).map(|number| format!("{number}.png")).collect();
    for (number, name) in (0..).zip(&names) {
        let depth = if number % 4 == 3 { Depth::U16 } else { Depth::U8 };
        let channels = if number % 3 == 2 { Channels::Rgba } else { Channels::Rgb };
        bench.paint_noise(&format!("in/{name}"), (90 + number, 70), channels, depth);
    }
    bench.write("in/4.png", "no image");
    bench.write("in/7.png", "nor this");
    for (folder, how) in
        [("one", "--jobs 1"), ("three", "--jobs 3"), ("all", "--threads 4 --memory 500M")]
    {
        let args = format!("transfer my.uvpair in --onto base.png {how} -o {folder}");
        let run = bench.run(&args);
        assert_eq!(run.code, Some(2), "{args}");
        let said = ["4.png", "7.png", "7 of 9 textures transferred"]
            .map(|text| run.stderr.find(text).unwrap());
        assert!(said.is_sorted(), "{}", run.stderr);
    }
    for name in names.iter().filter(|name| *name != "4.png" && *name != "7.png") {
        bench.succeed(&format!("transfer my.uvpair in/{name} --onto base.png -o alone.png"));
        let alone = bench.bytes("alone.png");
        for folder in ["one", "three", "all"] {
            assert!(bench.bytes(&format!("{folder}/{name}")) == alone, "{folder}/{name}");
        }
    }
    bench.assert_no_litter();
}

#[test]
fn what_is_up_to_date_is_left_out_if_asked() {
    let bench = Bench::new();
    for folder in ["in", "out"] {
        bench.make_folder(folder);
    }
    for name in ["in/a.png", "in/b.png", "in/c.png", "base.png"] {
        bench.paint(name, (16, 16), Channels::Rgb, &FACE);
    }
    let args = "transfer my.uvpair in --onto base.png --skip-existing -o out";
    assert_eq!(bench.succeed(args), "0 of 3 up to date\n");
    let first = bench.bytes("out/a.png");
    assert_eq!(bench.succeed(args), "3 of 3 up to date\n");
    // Unless requested, all are made again.
    bench.write("out/a.png", "something else");
    assert_eq!(bench.succeed("transfer my.uvpair in --onto base.png -o out"), "");
    assert_eq!(bench.bytes("out/a.png"), first);
    assert_eq!(bench.succeed(args), "3 of 3 up to date\n");

    // A new source with an old time, an output that is missing, a truncated one, and an empty one.
    let set_time = |name: &str, time: SystemTime| {
        let file = std::fs::File::options().append(true).open(bench.path(name)).unwrap();
        file.set_modified(time).unwrap();
    };
    bench.paint("in/b.png", (16, 16), Channels::Rgb, &[9, 8, 7]);
    set_time("in/b.png", SystemTime::UNIX_EPOCH);
    std::fs::remove_file(bench.path("out/c.png")).unwrap();
    assert_eq!(bench.succeed(args), "1 of 3 up to date\n");
    assert!(bench.exists("out/c.png"));
    bench.derive("out/a.png", "out/a.png", |bytes| bytes.truncate(bytes.len() - 9));
    bench.write("out/b.png", "");
    assert_eq!(bench.succeed(args), "1 of 3 up to date\n");
    assert_eq!(bench.bytes("out/a.png"), first);
    // Two outputs swapped.
    let (a, b) = (bench.bytes("out/a.png"), bench.bytes("out/b.png"));
    std::fs::write(bench.path("out/a.png"), &b).unwrap();
    std::fs::write(bench.path("out/b.png"), &a).unwrap();
    assert_eq!(bench.succeed(args), "1 of 3 up to date\n");
    assert_eq!((bench.bytes("out/a.png"), bench.bytes("out/b.png")), (a, b));
    // Modification times say nothing about the content.
    for name in ["in/a.png", "base.png", "out/a.png", "my.uvpair"] {
        set_time(name, SystemTime::now() + Duration::from_secs(3600));
    }
    assert_eq!(bench.succeed(args), "3 of 3 up to date\n");

    // A skipped texture is still an output, which no other may overwrite.
    let clash = "transfer my.uvpair in --onto base.png --skip-existing --mask out/a.png -o out";
    bench.refuse(clash, &["out/a.png", "two outputs"]);
    // A single file, and a mask that is written anyway.
    let args =
        "transfer my.uvpair in/a.png --onto base.png --skip-existing --mask mask.png -o a.png";
    bench.succeed(args);
    let mask = bench.bytes("mask.png");
    std::fs::remove_file(bench.path("mask.png")).unwrap();
    assert_eq!(bench.succeed(args), "1 of 1 up to date\n");
    assert_eq!(bench.bytes("mask.png"), mask);
    bench.assert_no_litter();
}

/// Every relevant option counts and nothing else: neither the order of options, nor those without
/// effect.
#[test]
fn options_count_where_outputs_exist() {
    let bench = Bench::new();
    bench.make_folder("out");
    for name in ["a.png", "b.png", "base.png", "other.png"] {
        bench.paint_noise(name, (40, 40), Channels::Rgb, Depth::U8);
    }
    bench.paint("base.png", (40, 40), Channels::Rgb, &FACE);
    let run = |options: &str| {
        let line = format!("transfer my.uvpair a.png b.png --skip-existing -o out {options}");
        let run = bench.run(&line);
        // Some options do nothing here, which is told; they count all the same.
        assert_eq!(run.code, Some(0), "{line}: {}", run.stderr);
        run.stdout
    };
    let mut before = "--onto base.png".to_owned();
    assert_eq!(run(&before), "0 of 2 up to date\n");
    for options in [
        "--onto other.png",
        "--onto #808080 --size 40",
        "--onto #808080 --size 41",
        "--onto base.png --size 30",
        "--onto base.png --filter bilinear",
        "--onto base.png --gutter 3",
        "--onto base.png --prefer left",
        "--onto base.png --overlap average",
        "--onto base.png --linear-light",
        "--onto base.png --data",
        "--onto base.png --fit",
        "--onto base.png --fit --fit-steps 2",
        "--onto base.png --feather 200mm",
        "--onto base.png --source-mask a.png",
        "--onto base.png --fill other.png --source-mask a.png",
        "--onto base.png --compress",
    ] {
        assert_eq!(run(&before), "2 of 2 up to date\n", "{before}");
        let done = run(options);
        assert!(done.starts_with("0 of 2 up to date\n"), "{options} after {before}: {done}");
        before = options.to_owned();
    }
    for same in ["--threads 1", "--jobs 1", "--memory 1G", "--preview seen.png", "--mask mask.png"]
    {
        assert_eq!(run("--onto base.png"), "0 of 2 up to date\n");
        assert_eq!(run(&format!("{same} --onto base.png")), "2 of 2 up to date\n", "{same}");
        run("--onto other.png");
    }
    // Regions are unions, in whatever order.
    bench.write("one.txt", "0 1 2 5 6 7 10 11 12");
    bench.write("two.txt", "12 13 14 17 18 19 22 23 24");
    let unions = ["--region one.txt --region two.txt", "--region two.txt --region one.txt"];
    assert_eq!(run(&format!("--onto base.png {}", unions[0])), "0 of 2 up to date\n");
    assert_eq!(run(&format!("--onto base.png {}", unions[1])), "2 of 2 up to date\n");
    let [include, exclude] =
        ["--region one.txt --exclude two.txt", "--region two.txt --exclude one.txt"];
    assert_eq!(run(&format!("--onto base.png {include}")), "0 of 2 up to date\n");
    assert_eq!(run(&format!("--onto base.png {exclude}")), "0 of 2 up to date\n");
}

/// Unreadable lines of a manifest are skipped, and false ones are detected.
#[test]
fn a_manifest_that_was_tampered_with() {
    let bench = Bench::new();
    bench.make_folder("out");
    for name in ["a.png", "b.png", "base.png"] {
        bench.paint(name, (16, 16), Channels::Rgb, &FACE);
    }
    let args = "transfer my.uvpair a.png b.png --onto base.png --skip-existing -o out";
    assert_eq!(bench.succeed(args), "0 of 2 up to date\n");
    let manifest = "out/.uvgraft-manifest.jsonl";
    let whole = bench.bytes(manifest);
    for (cut, left) in [(whole.len() - 5, 1), (3, 0), (0, 0)] {
        std::fs::write(bench.path(manifest), &whole[..cut]).unwrap();
        assert_eq!(bench.succeed(args), format!("{left} of 2 up to date\n"), "{cut}");
        assert_eq!(bench.succeed(args), "2 of 2 up to date\n", "{cut}");
    }
    for bad in ["\u{0}\u{1}\n", "{}\n[]\nnull\n", "{\"output\":\"a.png\"}\n"] {
        bench.write(manifest, bad);
        assert_eq!(bench.succeed(args), "0 of 2 up to date\n", "{bad:?}");
    }
    // The entries of two outputs swapped.
    bench.paint("b.png", (16, 16), Channels::Rgb, &[1, 2, 3]);
    bench.write(manifest, "");
    bench.succeed(args);
    let text = String::from_utf8(bench.bytes(manifest)).unwrap();
    let swapped =
        text.replace("a.png", "x.png").replace("b.png", "a.png").replace("x.png", "b.png");
    bench.write(manifest, &swapped);
    assert_eq!(bench.succeed(args), "0 of 2 up to date\n");
}

/// Whether damage matters depends neither on which path is faster, nor on other textures.
#[test]
fn damage_where_nothing_is_read_never_matters() {
    let bench = Bench::new();
    bench.paint_noise("good.png", (300, 1200), Channels::Rgb, Depth::U8);
    let damaged = |name: &str, tenth: usize| {
        bench.derive(name, "good.png", |bytes| {
            let at = bytes.len() * tenth / 10;
            bytes[at] ^= 0x55;
        });
    };
    damaged("low.png", 9);
    damaged("high.png", 2);
    bench.succeed("transfer my.uvpair good.png --reverse --size 64 -o good.out.png");
    for _ in 0..8 {
        bench.succeed("transfer my.uvpair low.png --reverse --size 64 -o out.png");
        assert_eq!(bench.bytes("out.png"), bench.bytes("good.out.png"));
        bench.refuse(
            "transfer my.uvpair high.png --reverse --size 64 -o none.png",
            &["high.png: damaged PNG"],
        );
    }
    bench.succeed("transfer my.uvpair low.png good.png --reverse --size 64 --jobs 2 -o folder");
    assert_eq!(bench.bytes("folder/low.png"), bench.bytes("good.out.png"));
}

/// Only the source rows that are read are decoded: the content of the others has no effect.
#[test]
fn a_source_whose_lower_rows_are_not_read() {
    let bench = Bench::new();
    for (name, channels, depth) in
        [("rgb.png", Channels::Rgb, Depth::U8), ("rgba.png", Channels::Rgba, Depth::U16)]
    {
        bench.paint_noise(name, (400, 900), channels, depth);
        for filter in ["nearest", "bilinear", "catmull-rom", "lanczos3"] {
            let args = format!("--reverse --size 300 --filter {filter}");
            bench.succeed(&format!("transfer my.uvpair {name} {args} -o png.png"));
            // Decoded as a whole.
            let image = bench.image(name);
            let options = uvgraft_image::WriteOptions::default();
            let written = uvgraft_image::write(&image, bench.path("whole.tif"), &options);
            assert!(written.unwrap().losses.is_empty());
            bench.succeed(&format!("transfer my.uvpair whole.tif {args} -o tif.png"));
            assert!(bench.bytes("png.png") == bench.bytes("tif.png"), "{name} {filter}");
        }
    }
}
