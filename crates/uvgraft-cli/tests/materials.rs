//! Material maps, each treated according to its role, through the program.

use crate::bench::charts;
use crate::bench::plane::{self, LINKED};
use crate::bench::{Bench, texel_u8};
use uvgraft::{Channels, Depth, Encoding, Size, Texels, Texture};

/// A bench with the maps of a material; values other than flat ones are pseudo-random.
fn bench() -> Bench {
    let bench = plane::bench();
    bench.paint_noise("a.png", (64, 64), Channels::Rgb, Depth::U8);
    bench.paint("n.png", (64, 64), Channels::Rgb, &[128, 128, 255]);
    bench.paint_noise("r.png", (64, 64), Channels::Grey, Depth::U16);
    bench.paint_noise("d.exr", (64, 64), Channels::Grey, Depth::F32);
    bench
}

/// Runs a transfer of maps into `out`, with its unit given.
fn transfer(bench: &Bench, options: &str) {
    bench.succeed(&format!("transfer plane.uvpair --unit m {options} -o out"));
}

/// Tilted normals, in the OpenGL or DirectX convention.
fn draw_normals(bench: &Bench, name: &str, down: bool) {
    bench.draw(name, (64, 64), |x, y| {
        let [s, t] = [x, y].map(|k| (f64::from(k) / 9.0).sin() * 0.5);
        let z = (1.0 - s * s - t * t).sqrt();
        let [r, g, b] = [s, t, z].map(|value| (value * 127.0 + 128.0).round() as u8);
        [r, if down { 255 - g } else { g }, b]
    });
}

#[test]
fn maps_keep_what_they_are() {
    let bench = bench();
    transfer(
        &bench,
        "--map albedo=a.png --map normal=n.png --map roughness=r.png --map displacement=d.exr --size 128",
    );
    let names: Vec<String> = bench
        .content()
        .into_keys()
        .filter_map(|path| Some(path.strip_prefix("out").ok()?.to_str()?.to_owned()))
        .filter(|name| !name.is_empty())
        .collect();
    assert_eq!(names, ["albedo.png", "displacement.exr", "normal.png", "roughness.png"]);
    let [albedo, normal, roughness, displacement] =
        ["albedo.png", "normal.png", "roughness.png", "displacement.exr"]
            .map(|name| bench.texture(&format!("out/{name}")));
    // Data and normals are never transparent; colours without a base are.
    assert_eq!((albedo.channels(), albedo.depth()), (Channels::Rgba, Depth::U8));
    assert_eq!((normal.channels(), normal.depth()), (Channels::Rgb, Depth::U8));
    assert_eq!((roughness.channels(), roughness.depth()), (Channels::Grey, Depth::U16));
    assert_eq!((displacement.channels(), displacement.depth()), (Channels::Grey, Depth::F32));
    let [r, d] = ["r.png", "d.exr"].map(|name| bench.texture(name));
    for (x, y) in (0..128 * 128).map(|k| (k % 128, k / 128)) {
        let flat = texel_u8(&normal, x, y);
        let close = flat.iter().zip([128_u8, 128, 255]).all(|(a, b)| a.abs_diff(b) <= 1);
        assert!(close, "{x}, {y}: {flat:?}");
        let wanted = if LINKED.contains(&x) && LINKED.contains(&y) {
            [r.get(x - 32, y - 32, 0), d.get(x - 32, y - 32, 0)]
        } else {
            [0.0; 2]
        };
        assert_eq!([roughness.get(x, y, 0), displacement.get(x, y, 0)], wanted, "{x}, {y}");
    }
}

#[test]
fn outputs_are_named_for_roles() {
    let bench = bench();
    transfer(
        &bench,
        "--map Base-Color=a.png --map AO=r.png --map height=d.exr --size 16 --format tif",
    );
    for name in ["base-color.tif", "ao.tif", "height.tif"] {
        assert!(bench.exists(&format!("out/{name}")), "{name}");
    }
    // TIFF supports floats, and displacement is always processed as floats.
    assert_eq!(bench.texture("out/height.tif").depth(), Depth::F32);
    assert_eq!(bench.texture("out/ao.tif").depth(), Depth::U16);
    bench.paint("d8.png", (64, 64), Channels::Grey, &[77]);
    bench
        .succeed("transfer plane.uvpair --map displacement=d8.png --format exr --size 128 -o deep");
    let deep = bench.texture("deep/displacement.exr");
    assert!((deep.get(64, 64, 0) - 77.0 / 255.0).abs() < 1e-6);
    bench.succeed("transfer plane.uvpair --map displacement=d8.png --size 128 -o deep");
    assert_eq!(bench.texture("deep/displacement.png").depth(), Depth::U8);
    // The result is the same with several threads and jobs.
    let before = bench.bytes("out/base-color.tif");
    transfer(
        &bench,
        "--map base-color=a.png --map ao=r.png --map height=d.exr --size 16 --format tif \
         --threads 4 --jobs 3",
    );
    assert_eq!(bench.bytes("out/base-color.tif"), before);
}

#[test]
fn roles_that_are_none() {
    let bench = bench();
    bench.make_folder("maps");
    bench.derive("maps/albedo.png", "a.png", |_| {});
    bench.derive("extensionless", "a.png", |_| {});
    bench.write("file", "old");
    let cases: &[(&str, &[&str])] = &[
        ("--map a.png --size 8 -o out", &["'a.png'", "ROLE=FILE"]),
        ("--map =a.png --size 8 -o out", &["'=a.png'", "ROLE=FILE"]),
        ("--map albedo= --size 8 -o out", &["'albedo='", "ROLE=FILE"]),
        (
            "--map colour=a.png --size 8 -o out",
            &["--map colour: role must be one of albedo,", "normal"],
        ),
        ("--map ../x=a.png --size 8 -o out", &["--map ../x: role must be one of albedo"]),
        (
            "--map albedo=a.png --map albedo=n.png --size 8 -o out",
            &["--map albedo: role given twice"],
        ),
        ("--map albedo=a.png --map ALBEDO=n.exr --size 8 -o out", &["albedo: role given twice"]),
        ("--map albedo=a.png -o out", &["must have a size", "--size N", "--onto ROLE=IMAGE"]),
        (
            "--map albedo=a.png --map normal=n.png --onto albedo=a.png -o out",
            &["must have a size", "--onto ROLE=IMAGE"],
        ),
        (
            "--map albedo=a.png --onto normal=n.png -o out",
            &["--onto normal=n.png", "no --map has the role normal"],
        ),
        (
            "--map albedo=a.png --onto a.png -o out",
            &["--onto must be ROLE=IMAGE or ROLE=COLOUR with --map, got a.png"],
        ),
        ("--map albedo=a.png --onto #808080 --size 8 -o out", &["got #808080", "ROLE=COLOUR"]),
        (
            "--map albedo=a.png --onto albedo=a.png --onto albedo=n.png -o out",
            &["--onto albedo: role given twice"],
        ),
        ("--map albedo=a.png --onto albedo=none.png -o out", &["none.png", "No such file"]),
        (
            "--map albedo=a.png --map ao=r.png --onto albedo=a.png --onto ao=none.png -o out",
            &["none.png", "No such file"],
        ),
        ("--map albedo=a.png --onto albedo=#12 --size 8 -o out", &["\"#12\"", "#RRGGBB"]),
        ("--map albedo=a.png --size 8 -o out.png", &["must be a folder, got out.png"]),
        ("--map albedo=a.png --size 8 -o file", &["must be a folder, got file"]),
        ("--map albedo=maps/albedo.png --size 8 -o maps", &["maps/albedo.png is also an input"]),
        ("--map albedo=extensionless --size 8 -o out", &["extensionless: ", "--format png"]),
        ("--map albedo=a.png --data --size 8 -o out", &["--map", "--data"]),
        ("--map albedo=a.png --fit --size 8 -o out", &["--fit", "--map"]),
        ("a.png --map albedo=a.png --size 8 -o out", &["--map", "cannot be used with"]),
        ("--size 8 -o out", &["required", "<TEXTURE>"]),
        ("a.png --onto a.png --onto n.png -o out.png", &["--onto n.png", "base given twice"]),
        ("--map normal=n.png --normal-y up --size 8 -o out", &["'up'", "opengl, directx"]),
        ("a.png --normal-y directx --size 8 -o out.png", &["--normal-y", "--map normal=FILE"]),
        ("a.png --normal-y-out opengl --size 8 -o out.png", &["--normal-y-out", "--map normal"]),
        ("--map albedo=a.png --normal-y directx --size 8 -o out", &["--normal-y", "--map normal"]),
        ("--map roughness=r.png --fill a.png --size 8 -o out", &["--fill needs a --map", "albedo"]),
        ("--map normal=n.png --fill a.png --size 8 -o out", &["--fill needs a --map", "albedo"]),
        ("--map ao=r.png --source-mask a.png --size 8 -o out", &["--source-mask needs --blend"]),
        ("--map albedo=a.png --quality 80 --size 8 -o out", &["--quality is for JPEG files only"]),
    ];
    for (options, wanted) in cases {
        bench.refuse(&format!("transfer plane.uvpair {options}"), wanted);
    }
}

/// A file that cannot be a map of its role is reported, and the others are transferred.
#[test]
fn maps_that_are_none() {
    let bench = bench();
    bench.paint("grey.png", (64, 64), Channels::Grey, &[128]);
    for (map, wanted) in [
        ("normal=grey.png", "error: grey.png: a normal map must have three channels"),
        ("normal=r.png", "error: r.png: a normal map must have three channels"),
        ("normal=none.png", "error: none.png: "),
        ("roughness=plane.uvpair", "error: plane.uvpair: not a supported image"),
    ] {
        let format = if map.ends_with("uvpair") { "--format png" } else { "" };
        let run = bench.run(&format!(
            "transfer plane.uvpair --map {map} --map albedo=a.png --size 32 {format} -o out"
        ));
        assert_eq!(run.code, Some(2), "{map}: {}", run.stderr);
        assert!(run.stderr.starts_with(wanted), "{map}: {}", run.stderr);
        assert!(bench.exists("out/albedo.png"), "{map}");
        let role = map.split('=').next().unwrap();
        assert!(!bench.exists(&format!("out/{role}.png")), "{map}");
        bench.assert_no_litter();
    }
}

#[test]
fn green_points_up_or_down() {
    let bench = bench();
    draw_normals(&bench, "up.png", false);
    draw_normals(&bench, "down.png", true);
    let normals = |options: &str| {
        transfer(&bench, &format!("{options} --size 128"));
        bench.texture("out/normal.png")
    };
    let up = normals("--map normal=up.png");
    let original = bench.texture("up.png");
    let cases = [
        ("--map normal=up.png --normal-y opengl", false),
        ("--map normal=down.png --normal-y directx --normal-y-out opengl", false),
        ("--map normal=down.png --normal-y directx", true),
        ("--map normal=up.png --normal-y-out directx", true),
    ];
    for (options, down) in cases {
        let found = normals(options);
        for (x, y) in (0..128 * 128).map(|k| (k % 128, k / 128)) {
            let [mut wanted, found] = [&up, &found].map(|of| texel_u8(of, x, y));
            if down {
                wanted[1] = 255 - wanted[1];
            }
            // 127.5 is flat; it is stored as 128, whichever the direction.
            let close = found.iter().zip(&wanted).all(|(a, b)| a.abs_diff(*b) <= 1);
            assert!(close, "{options}: {x}, {y}: {found:?}, wanted {wanted:?}");
        }
    }
    // Both layouts have the same orientation, so normals are unchanged; two roundings make a level.
    for (x, y) in (0..64 * 64).map(|k| (k % 64, k / 64)) {
        let [found, wanted] = [texel_u8(&up, x + 32, y + 32), texel_u8(&original, x, y)];
        let close = found.iter().zip(&wanted).all(|(a, b)| a.abs_diff(*b) <= 1);
        assert!(close, "{x}, {y}: {found:?}, wanted {wanted:?}");
    }
    // A base of normals is in the result's convention, and unchanged.
    bench.draw("base.png", (128, 128), |x, y| [100 + (x % 50) as u8, 90 + (y % 70) as u8, 240]);
    transfer(
        &bench,
        "--map normal=up.png --onto normal=base.png --normal-y-out directx --gutter 0",
    );
    let [found, base] = ["out/normal.png", "base.png"].map(|name| bench.texture(name));
    for (x, y) in [(0, 0), (31, 60), (127, 127), (96, 96), (64, 20)] {
        assert_eq!(texel_u8(&found, x, y), texel_u8(&base, x, y), "{x}, {y}");
    }
}

#[test]
fn data_is_never_converted() {
    let bench = bench();
    let texels = Texels::F32(vec![0.25; 64 * 64]);
    let quarter = Texture::new(Size::square(64), Channels::Grey, Encoding::Linear, texels);
    bench.save("quarter.exr", quarter.unwrap());
    for role in ["roughness", "ao", "metallic", "displacement", "mask"] {
        let line = format!("transfer plane.uvpair --map {role}=quarter.exr --size 32");
        let run = bench.run(&format!("{line} --format png -o out"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let found = bench.texture(&format!("out/{role}.png")).get(16, 16, 0);
        assert!((found - 0.25).abs() < 0.003, "{role}: {found}");
        bench.succeed(&format!("{line} --linear-light -o out"));
        assert_eq!(bench.texture(&format!("out/{role}.exr")).get(16, 16, 0), 0.25, "{role}");
    }
    for role in ["albedo", "emissive"] {
        let line = format!("transfer plane.uvpair --map {role}=quarter.exr --size 32");
        let run = bench.run(&format!("{line} --format png -o out"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        // The encoding of light 0.25.
        let found = bench.texture(&format!("out/{role}.png")).get(16, 16, 0);
        assert!((found - 0.5371).abs() < 0.003, "{role}: {found}");
    }
    // The fourth channel of data is data.
    bench.draw("packed.png", (64, 64), |x, y| [(x * 4) as u8, (y * 4) as u8, 9, 0]);
    transfer(&bench, "--map orm=packed.png --onto orm=#01020304 --size 128 --gutter 0");
    let packed = bench.texture("out/orm.png");
    assert_eq!(texel_u8(&packed, 60, 70), [112, 152, 9, 0]);
    assert_eq!(texel_u8(&packed, 10, 10), [1, 2, 3, 4]);
}

#[test]
fn all_maps_have_the_same_weights() {
    let bench = plane::bench();
    bench.paint("white.png", (64, 64), Channels::Grey, &[255]);
    bench.draw("known.png", (64, 64), |x, _| [if x < 44 { 255 } else { 0 }]);
    let texels = Texels::F32(vec![1.0; 64 * 64]);
    let one = Texture::new(Size::square(64), Channels::Grey, Encoding::Linear, texels);
    bench.save("one.exr", one.unwrap());
    bench.paint("x.png", (64, 64), Channels::Rgb, &[255, 128, 128]);
    for options in ["--feather 10mm", "--blend membrane", "--feather 10mm --source-mask known.png"]
    {
        transfer(
            &bench,
            &format!(
                "--map emissive=white.png --map roughness=white.png --map height=one.exr \
                 --map normal=x.png --onto emissive=#000 --onto roughness=#000 --onto height=#000 \
                 --size 128 --gutter 0 --mask mask.png {options}"
            ),
        );
        let [emissive, roughness, height, normal, mask] = [
            "out/emissive.png",
            "out/roughness.png",
            "out/height.exr",
            "out/normal.png",
            "mask.png",
        ]
        .map(|name| bench.texture(name));
        let mut between = 0;
        for (x, y) in (0..128 * 128).map(|k| (k % 128, k / 128)) {
            let weight = texel_u8(&mask, x, y)[0];
            between += u32::from(!matches!(weight, 0 | 255));
            assert_eq!(texel_u8(&roughness, x, y)[0], weight, "{options}: {x}, {y}");
            assert!((height.get(x, y, 0) * 255.0 - f32::from(weight)).abs() < 0.51, "{x}, {y}");
            if !options.contains("source-mask") {
                assert_eq!(texel_u8(&emissive, x, y)[0], weight, "{options}: {x}, {y}");
            }
            // The shortest way from the base's direction to the texture's, with length preserved.
            let [nx, ny, nz] = [0, 1, 2].map(|k| normal.get(x, y, k) * 2.0 - 1.0);
            assert!((nx * nx + ny * ny + nz * nz - 1.0).abs() < 0.03, "{options}: {x}, {y}");
            let share = f32::from(weight) / 255.0;
            let wanted = share / share.hypot(1.0 - share);
            assert!((nx - wanted).abs() < 0.02, "{options}: {x}, {y}: {nx}, wanted {wanted}");
        }
        assert!(between > 500, "{options}: {between}");
    }
}

/// The tone is found from the colours, and data has none.
#[test]
fn only_colours_are_toned() {
    let bench = plane::bench();
    bench.paint("face.png", (64, 64), Channels::Rgb, &[150, 105, 85]);
    bench.paint("base.png", (128, 128), Channels::Rgb, &[200, 150, 130]);
    let maps = ["albedo", "emissive", "orm"];
    let options: Vec<String> =
        maps.iter().map(|role| format!("--map {role}=face.png --onto {role}=base.png")).collect();
    transfer(&bench, &format!("{} --blend membrane", options.join(" ")));
    let middle = |role: &str| texel_u8(&bench.texture(&format!("out/{role}.png")), 64, 64);
    assert!(middle("albedo").iter().zip([200_u8, 150, 130]).all(|(a, b)| a.abs_diff(b) <= 1));
    assert_eq!(middle("emissive"), [150, 105, 85]);
    assert_eq!(middle("orm"), [150, 105, 85]);
}

/// Two squares side by side in the source, half overlapping in the target.
#[test]
fn overlaps_are_averaged() {
    let bench = charts::bench(0.25);
    bench.paint_noise("noise.png", (64, 64), Channels::Rgb, Depth::U8);
    // On the surface, too.
    for how in ["", "--blend none", "--data"] {
        let transfer = |options: &str| {
            bench.succeed(&format!(
                "transfer eyes.uvpair noise.png --size 64 --gutter 0 --onto #456 {how} {options} -o out.png"
            ));
            bench.texture("out.png")
        };
        let [left, right, first, average] =
            ["--prefer left", "--prefer right", "--overlap first", "--overlap average"]
                .map(transfer);
        assert!(first == transfer("--prefer first"));
        for (x, y) in (0..64 * 64).map(|k| (k % 64, k / 64)) {
            let [left, right, average] = [&left, &right, &average].map(|of| texel_u8(of, x, y));
            // A visible island keeps a fringe, beyond which the other one is alone.
            if (18..30).contains(&x) {
                for ((a, b), mean) in left.iter().zip(&right).zip(&average) {
                    let wanted = (f32::from(*a) + f32::from(*b)) / 2.0;
                    assert!((f32::from(*mean) - wanted).abs() <= 1.0, "{how}: {x}, {y}");
                }
            } else if !(14..=34).contains(&x) {
                assert!(average == left && average == right, "{how}: {x}, {y}");
            }
        }
    }
}
