//! Blending textures into their base, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::plane::{self, LINKED, source_columns};
use crate::bench::{Bench, texel_u8};
use uvgraft::{Channels, Depth, Encoding, Size, Texels, Texture};
use uvgraft_io::vertex_map;

const SKIN: [u8; 3] = [200, 150, 130];
const OTHER_SKIN: [u8; 3] = [150, 105, 85];
const CLOTH: [u8; 3] = [40, 60, 140];

/// Runs a transfer of the plane, with its unit given.
fn transfer(bench: &Bench, options: &str) -> Texture {
    bench.succeed(&format!("transfer plane.uvpair --unit m {options} -o out.png"));
    bench.texture("out.png")
}

fn transfer_with_warnings(bench: &Bench, options: &str) -> Texture {
    let run = bench.run(&format!("transfer plane.uvpair --unit m {options} -o out.png"));
    assert!(run.code == Some(0) && run.stderr.starts_with("warning: "), "{options}: {run:?}");
    bench.texture("out.png")
}

fn is_linked(x: u32, y: u32) -> bool {
    LINKED.contains(&x) && LINKED.contains(&y)
}

/// All positions in a target of 128 texels a side.
fn places() -> impl Iterator<Item = (u32, u32)> {
    (0..128 * 128).map(|k| (k % 128, k / 128))
}

fn difference(a: &[u8], b: &[u8]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

/// A colour with some grain, so that it has a covariance.
fn grain(color: [u8; 3], x: u32, y: u32) -> [u8; 3] {
    let [a, b] = [(x * 7 + y * 13) % 11, (x * 5 + y * 3) % 7].map(|value| value as u8);
    [color[0] + a, color[1] + b, color[2] + (a + b) / 2]
}

#[test]
fn a_feather_is_as_wide_as_it_says() {
    let bench = plane::bench();
    bench.paint_noise("face.png", (64, 64), Channels::Rgb, Depth::U8);
    bench.paint_noise("base.png", (128, 128), Channels::Rgb, Depth::U8);
    let base = bench.texture("base.png");
    let plain = transfer(&bench, "face.png --onto base.png");
    for feather in ["--feather 10mm", "--blend feather", "--blend feather --feather 1cm"] {
        let found = transfer(&bench, &format!("face.png --onto base.png {feather}"));
        for (x, y) in places() {
            let [found, plain, base] = [&found, &plain, &base].map(|of| texel_u8(of, x, y));
            if !is_linked(x, y) {
                assert_eq!(found, base, "{feather}: {x}, {y}");
                continue;
            }
            let to_rim = |k: u32| f64::from((k - 32).min(95 - k)) + 0.5;
            let inside = to_rim(x).min(to_rim(y)) * 1.25;
            // Near corners, distances over triangles are less accurate than these small ones
            // require.
            let is_near_a_corner = !(56..72).contains(&x) && !(56..72).contains(&y);
            if inside >= if is_near_a_corner { 20.0 } else { 10.0 } {
                assert_eq!(found, plain, "{feather}: {x}, {y}");
            } else if !is_near_a_corner {
                let t = inside / 10.0;
                let weight = t * t * (3.0 - 2.0 * t);
                for k in 0..3 {
                    let [found, plain, base] = [&found, &plain, &base].map(|of| f64::from(of[k]));
                    let wanted = base + (plain - base) * weight;
                    assert!((found - wanted).abs() <= 1.0, "{x}, {y}: {found}, wanted {wanted}");
                }
            }
        }
    }
    // Without a feather the border is hard.
    for none in ["--blend none", "--blend feather --feather 0", "--feather 0mm"] {
        assert!(transfer(&bench, &format!("face.png --onto base.png {none}")) == plain, "{none}");
    }
    // The same holds for 16 bits with alpha.
    bench.paint_noise("deep.png", (64, 64), Channels::Rgba, Depth::U16);
    let plain = transfer(&bench, "deep.png --onto base.png");
    let found = transfer(&bench, "deep.png --onto base.png --feather 10mm");
    assert_eq!((found.channels(), found.depth()), (Channels::Rgba, Depth::U16));
    for (x, y) in places() {
        for channel in 0..4 {
            let values = [&found, &plain].map(|of| of.get(x, y, channel));
            let inner = |k: u32| (48..80).contains(&k);
            if !is_linked(x, y) || (inner(x) && inner(y)) {
                assert_eq!(values[0], values[1], "{x}, {y}");
            }
        }
    }
}

#[test]
fn the_mask_holds_the_weights() {
    let bench = plane::bench();
    bench.paint("white.png", (64, 64), Channels::Grey, &[255]);
    vertex_map::save_npy(&source_columns(2..=6), bench.path("part.npy")).unwrap();
    for options in
        ["--feather 10mm", "--region part.npy", "--region part.npy --feather 5mm --grow 1ring"]
    {
        let line = format!("white.png --onto #000 --size 128 {options} --mask mask.png --gutter 0");
        let out = transfer(&bench, &line);
        let mask = bench.texture("mask.png");
        assert_eq!((mask.channels(), mask.depth()), (Channels::Grey, Depth::U8));
        for (x, y) in places() {
            assert_eq!(texel_u8(&mask, x, y), texel_u8(&out, x, y), "{options}: {x}, {y}");
        }
        let in_between = places().filter(|&(x, y)| !matches!(texel_u8(&mask, x, y)[0], 0 | 255));
        assert_eq!(in_between.count() > 0, options.contains("feather"), "{options}");
    }
}

#[test]
fn a_membrane_between_equal_rims_changes_nothing() {
    let bench = plane::bench();
    // One colour, with detail 25 mm from the boundary on either side: beyond the reach of the
    // colour comparison.
    let is_middle = |k: u32| (20..44).contains(&k);
    bench.draw("base.png", (128, 128), |x, y| match x < 12 || y < 12 {
        true => [y as u8, x as u8, 77],
        false => [160, 120, 100],
    });
    bench.draw("face.png", (64, 64), |x, y| {
        if is_middle(x) && is_middle(y) {
            [(x * 37 % 251) as u8, (y * 53 % 241) as u8, ((x * y) % 255) as u8]
        } else {
            [160, 120, 100]
        }
    });
    let plain = transfer(&bench, "face.png --onto base.png");
    for options in ["", "--feather 10mm", "--feather 0", "--tone base", "--tone none"] {
        let line = format!("face.png --onto base.png --blend membrane {options}");
        let found = transfer(&bench, &line);
        for (x, y) in places() {
            let [found, plain] = [&found, &plain].map(|of| texel_u8(of, x, y));
            assert!(difference(&found, &plain) <= 1, "{options} at {x}, {y}: {found:?} {plain:?}");
        }
    }
    // A result that overwrites its own base.
    bench.derive("before.png", "out.png", |_| {});
    let again = transfer(&bench, "face.png --onto before.png --blend membrane");
    let before = bench.texture("before.png");
    for (x, y) in places() {
        let [again, before] = [&again, &before].map(|of| texel_u8(of, x, y));
        assert!(difference(&again, &before) <= 1, "{x}, {y}: {again:?} {before:?}");
    }
}

#[test]
fn a_membrane_takes_on_the_tone_of_the_base() {
    let bench = plane::bench();
    bench.paint("base.png", (128, 128), Channels::Rgb, &SKIN);
    bench.paint("face.png", (64, 64), Channels::Rgb, &OTHER_SKIN);
    let found = transfer(&bench, "face.png --onto base.png --blend membrane");
    // The whole texture differs from the base by one ratio.
    for (x, y) in places() {
        let found = texel_u8(&found, x, y);
        assert!(difference(&found, &SKIN) <= 1, "{x}, {y}: {found:?}");
    }
    // A base of one colour has a single texel to compare with.
    let on_color = transfer(&bench, "face.png --onto #c89682 --size 128 --blend membrane");
    assert!(on_color == found);
    // The texture is unchanged if neither side may change.
    let alone = transfer(&bench, "face.png --onto base.png --blend membrane --tone none");
    assert_eq!(texel_u8(&alone, 64, 64), OTHER_SKIN);
    let feathered = transfer(&bench, "face.png --onto base.png --blend feather");
    assert!(alone == feathered);
}

/// A base of skin with a belt of cloth, and a face with another skin.
fn dressed() -> Bench {
    let bench = plane::bench();
    let is_cloth = |y: u32| (104..120).contains(&y);
    bench.draw("base.png", (128, 128), |x, y| grain(if is_cloth(y) { CLOTH } else { SKIN }, x, y));
    bench.draw("face.png", (64, 64), |x, y| grain(OTHER_SKIN, x, y));
    bench
}

#[test]
fn the_skin_of_the_base_takes_on_the_tone() {
    let bench = dressed();
    let base = bench.texture("base.png");
    for how in ["--blend membrane", "--match skin", "--blend membrane --match skin"] {
        let line = format!("face.png --onto base.png {how} --tone source --gutter 0");
        let found = transfer(&bench, &line);
        for (x, y) in places().filter(|&(x, y)| !is_linked(x, y)) {
            let [found, base] = [&found, &base].map(|of| texel_u8(of, x, y));
            if (104..120).contains(&y) {
                assert_eq!(found, base, "{how}: cloth at {x}, {y}");
            } else {
                // Grain and rounding are a few levels out of 50.
                let wanted = grain(OTHER_SKIN, x, y);
                assert!(
                    difference(&found, &wanted) <= 8,
                    "{how} at {x}, {y}: {found:?} {wanted:?}"
                );
            }
        }
        // The texture keeps its colours.
        let kept = texel_u8(&found, 64, 64);
        assert!(difference(&kept, &grain(OTHER_SKIN, 32, 32)) <= 1, "{how}: {kept:?}");
    }
}

#[test]
fn a_mask_says_what_is_skin() {
    let bench = dressed();
    let base = bench.texture("base.png");
    bench.draw("skin.png", (128, 128), |x, _| [if x < 64 { 255 } else { 0 }]);
    let found = transfer(
        &bench,
        "face.png --onto base.png --blend membrane --tone source --skin skin.png --gutter 0",
    );
    for (x, y) in places().filter(|&(x, y)| !is_linked(x, y)) {
        let [found, base] = [&found, &base].map(|of| texel_u8(of, x, y));
        if x >= 64 {
            assert_eq!(found, base, "{x}, {y}");
        } else {
            // The mask decides, even about cloth.
            assert!(base[0] - found[0] >= 5, "{x}, {y}: {found:?} {base:?}");
        }
    }
    // A black one leaves everything unchanged, with a warning.
    bench.paint("none.png", (8, 8), Channels::Grey, &[0]);
    let found = transfer_with_warnings(
        &bench,
        "face.png --onto base.png --blend membrane --tone source --skin none.png --gutter 0",
    );
    for (x, y) in places().filter(|&(x, y)| !is_linked(x, y)) {
        assert_eq!(texel_u8(&found, x, y), texel_u8(&base, x, y), "{x}, {y}");
    }
}

#[test]
fn skins_are_matched() {
    let bench = dressed();
    let mean = |of: &Texture| {
        let inner: Vec<Vec<u8>> =
            places().filter(|&(x, y)| is_linked(x, y)).map(|(x, y)| texel_u8(of, x, y)).collect();
        let sum = |k: usize| inner.iter().map(|rgb| f64::from(rgb[k])).sum::<f64>();
        [0, 1, 2].map(|k| sum(k) / inner.len() as f64)
    };
    let base = mean(&bench.texture("base.png"));
    let plain = mean(&transfer(&bench, "face.png --onto base.png"));
    for how in ["--match skin", "--match skin --feather 5mm", "--match skin --linear-light"] {
        let found = mean(&transfer(&bench, &format!("face.png --onto base.png {how}")));
        for k in 0..3 {
            let (before, after) = ((plain[k] - base[k]).abs(), (found[k] - base[k]).abs());
            assert!(before > 30.0 && after < 3.0, "{how}: {found:?}, wanted {base:?}");
        }
    }
}

/// On the demo's figure: dark skin continues from the face to the body, and clothes are unchanged.
#[test]
fn the_demos_body_takes_on_the_tone() {
    let bench = Bench::new();
    bench.succeed("demo -o demo --size 512");
    let face = bench.texture("demo/face.png");
    bench.draw("dark.png", (512, 512), |x, y| {
        let rgb = texel_u8(&face, x, y);
        [(0, 0.62), (1, 0.55), (2, 0.5)].map(|(k, gain)| (f64::from(rgb[k]) * gain) as u8)
    });
    let run = bench.run(
        "transfer demo/head_to_body.uvpair dark.png --onto demo/body_base.png --blend membrane \
         --tone source --unit m --mask mask.png -o out.png",
    );
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    // The extent is reported.
    assert!(
        run.stderr.starts_with("warning: dark.png: matching the tone makes the body's skin darker")
    );
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    let [base, out, mask] =
        ["demo/body_base.png", "out.png", "mask.png"].map(|name| bench.texture(name));
    let (mut skin, mut blue, mut changed) = (0, 0, 0);
    for (x, y) in (0..512 * 512).map(|k| (k % 512, k / 512)) {
        let [base, out] = [&base, &out]
            .map(|of| texel_u8(of, x, y).into_iter().map(i32::from).collect::<Vec<_>>());
        if texel_u8(&mask, x, y) != [0] {
            continue;
        }
        // Bare skin is much redder than blue; trousers are bluer than red.
        if base[0] > 170 && base[0] > base[1] + 25 && base[1] > base[2] {
            skin += 1;
            changed += u32::from(out[0] * 10 < base[0] * 8);
        } else if base[2] > base[0] + 20 {
            blue += 1;
            assert_eq!(out, base, "{x}, {y}");
        }
    }
    assert!(skin > 1000 && blue > 1000, "{skin} {blue}");
    assert!(changed * 10 > skin * 9, "{changed} of {skin}");
}

#[test]
fn a_mask_says_what_is_known() {
    let bench = plane::bench();
    bench.paint("face.png", (64, 64), Channels::Rgb, &OTHER_SKIN);
    bench.paint("base.png", (128, 128), Channels::Rgb, &SKIN);
    bench.paint("mean.png", (32, 32), Channels::Rgb, &CLOTH);
    bench.draw("known.png", (64, 64), |x, _| [if x < 32 { 0 } else { 255 }]);
    let row = |of: &Texture| [31, 36, 60, 68, 92, 96].map(|x| texel_u8(of, x, 64));
    let masked = "face.png --source-mask known.png --gutter 0";
    let found = transfer(&bench, &format!("{masked} --onto base.png"));
    assert_eq!(found.channels(), Channels::Rgb);
    assert_eq!(row(&found), [SKIN, SKIN, SKIN, OTHER_SKIN, OTHER_SKIN, SKIN]);
    let found = transfer(&bench, &format!("{masked} --onto base.png --fill mean.png"));
    assert_eq!(found.channels(), Channels::Rgb);
    assert_eq!(row(&found), [SKIN, CLOTH, CLOTH, OTHER_SKIN, OTHER_SKIN, SKIN]);
    // With a feather, the edge of the trusted area is a boundary like that of the linked area.
    let found = transfer(&bench, &format!("{masked} --onto base.png --feather 5mm"));
    let at = |x: u32| texel_u8(&found, x, 64);
    assert!(at(63) == SKIN && at(72) == OTHER_SKIN && at(88) == OTHER_SKIN);
    for x in [66, 94] {
        assert!(at(x) != OTHER_SKIN && at(x) != SKIN, "{x}: {:?}", at(x));
    }
    // Without a base, excluded areas are transparent, which needs an alpha channel.
    let found = transfer(&bench, &format!("{masked} --size 128"));
    assert_eq!(found.channels(), Channels::Rgba);
    assert_eq!([texel_u8(&found, 36, 64)[3], texel_u8(&found, 92, 64)[3]], [0, 255]);
    bench.refuse(
        &format!("transfer plane.uvpair {masked} --size 128 -o out.jpg"),
        &["out.jpg", "alpha", "JPEG"],
    );
    // Both results are opaque, so JPEG supports them.
    for options in ["", "--fill mean.png", "--feather 5mm --unit m", "--blend membrane --unit m"] {
        bench.succeed(&format!(
            "transfer plane.uvpair {masked} --onto base.png {options} -o out.jpg"
        ));
        let out = bench.texture("out.jpg");
        assert!(difference(&texel_u8(&out, 40, 8), &SKIN) <= 3, "{options}");
    }
    // A texture that is itself transparent in places.
    bench.draw("clear.png", (64, 64), |x, _| {
        let [r, g, b] = OTHER_SKIN;
        [r, g, b, if x < 32 { 0 } else { 255 }]
    });
    let found = transfer(&bench, "clear.png --fill mean.png --onto base.png --gutter 0");
    assert_eq!(found.channels(), Channels::Rgb);
    assert_eq!(row(&found), [SKIN, CLOTH, CLOTH, OTHER_SKIN, OTHER_SKIN, SKIN]);
}

#[test]
fn several_are_blended_as_each_alone() {
    let bench = dressed();
    bench.make_folder("in");
    bench.derive("in/a.png", "face.png", |_| {});
    bench.draw("in/b.png", (48, 48), |x, y| grain([180, 140, 100], x, y));
    bench.draw("in/c.png", (64, 64), |x, y| {
        let [r, g, b] = grain([140, 110, 90], x, y);
        [r, g, b, if x < 40 { 255 } else { 190 }]
    });
    bench.draw("known.png", (32, 32), |x, y| [if x + y < 40 { 255 } else { 30 }]);
    vertex_map::save_npy(&source_columns(0..=6), bench.path("part.npy")).unwrap();
    for options in [
        "--blend membrane --match skin --source-mask known.png --region part.npy",
        "--blend membrane --tone source --feather 3mm --exclude part.npy",
        "--feather 8mm --fill face.png --source-mask known.png --fit --fit-steps 3",
    ] {
        let common = format!("--onto base.png --unit m {options}");
        let alone: Vec<Vec<u8>> = ["a", "b", "c"]
            .map(|name| {
                let run =
                    bench.run(&format!("transfer plane.uvpair in/{name}.png {common} -o one.png"));
                assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{options}");
                bench.bytes("one.png")
            })
            .into();
        for how in ["--threads 1", "--threads 4", "--threads 4 --jobs 1", "--threads 1 --jobs 3"] {
            let run = bench.run(&format!("transfer plane.uvpair in {common} {how} -o out"));
            assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{options} {how}");
            for (name, alone) in ["a", "b", "c"].iter().zip(&alone) {
                let found = bench.bytes(&format!("out/{name}.png"));
                assert!(found == *alone, "{options} {how}: {name}");
            }
        }
    }
}

#[test]
fn a_preview_is_drawn() {
    let bench = dressed();
    vertex_map::save_npy(&source_columns(0..=4), bench.path("part.npy")).unwrap();
    let preview = |options: &str| {
        transfer(&bench, &format!("face.png --onto base.png {options} --preview seen.png"));
        bench.texture("seen.png")
    };
    let [all, part, soft] =
        ["", "--region part.npy", "--region part.npy --feather 10mm"].map(preview);
    for picture in [&all, &part, &soft] {
        assert_eq!(picture.channels(), Channels::Rgb);
        assert!(picture.size().width > 2000 && picture.size().height > 1000);
    }
    assert!(all != part && part != soft);
    // Yellow marks what is transferred: the whole source, or its left half.
    let yellow = |of: &Texture| {
        let Size { width, height } = of.size();
        let texels = (0..width * height).map(|k| texel_u8(of, k % width, k / width));
        texels.filter(|rgb| rgb[0] > 220 && rgb[1] > 160 && rgb[2] < 110).count()
    };
    let [all, part, soft] = [&all, &part, &soft].map(yellow);
    assert!(part * 10 > all * 4 && part * 10 < all * 6, "{part} of {all}");
    assert!(soft < part, "{soft} {part}");

    // In reverse, from the other layout.
    bench.paint("small.png", (64, 64), Channels::Rgb, &SKIN);
    bench.succeed(
        "transfer plane.uvpair base.png --reverse --onto small.png --preview seen.png -o out.png",
    );

    let line = "transfer plane.uvpair face.png --onto base.png";
    for (options, wanted) in [
        ("--preview base.png -o out.png", &["output base.png is also an input"][..]),
        ("--preview ./face.png -o out.png", &["output ./face.png is also an input"]),
        ("--preview plane.uvpair -o out.png", &["plane.uvpair", "a preview must be an image"]),
        ("--preview out.png -o out.png", &["two outputs have the name out.png"]),
        ("--preview seen.txt -o out.png", &["seen.txt: a preview must be an image", ".png"]),
        ("--preview none/seen.png -o out.png", &["none/seen.png: folder none does not exist"]),
        ("--mask m.png --preview m.png -o out.png", &["two outputs have the name m.png"]),
        ("--source-mask seen.png -o seen.png", &["output seen.png is also an input"]),
        ("--fill seen.png -o seen.png", &["output seen.png is also an input"]),
        ("--region seen.png -o seen.png", &["output seen.png is also an input"]),
        ("--exclude target:seen.png --mask seen.png -o out.png", &["seen.png is also an input"]),
        (
            "--blend membrane --tone source --skin seen.png -o seen.png",
            &["output seen.png is also an input"],
        ),
    ] {
        bench.refuse(&format!("{line} {options}"), wanted);
    }
    // It is drawn even if everything is up to date.
    std::fs::remove_file(bench.path("seen.png")).unwrap();
    let line = format!("{line} --skip-existing -o out.png");
    bench.succeed(&line);
    assert_eq!(bench.succeed(&format!("{line} --preview seen.png")), "1 of 1 up to date\n");
    assert!(bench.exists("seen.png"));
}

#[test]
fn failed_runs_leave_nothing() {
    let bench = dressed();
    bench.derive("cut.png", "face.png", |bytes| bytes.truncate(bytes.len() / 2));
    bench.derive("cut_base.png", "base.png", |bytes| bytes.truncate(bytes.len() / 2));
    let options = "--blend membrane --unit m --mask mask.png --preview seen.png -o out.png";
    for (files, wanted) in [
        ("cut.png --onto base.png", "cut.png: truncated PNG"),
        ("face.png --onto cut_base.png", "cut_base.png: truncated PNG"),
        ("face.png --onto base.png --source-mask cut.png", "cut.png: truncated PNG"),
        ("face.png --onto base.png --fill cut.png", "cut.png: truncated PNG"),
        ("face.png --onto base.png --region cut.png", "cut.png: truncated PNG"),
        ("face.png --onto base.png --tone source --skin cut.png", "cut.png: truncated PNG"),
    ] {
        bench.refuse(&format!("transfer plane.uvpair {files} {options}"), &[wanted]);
    }
}

#[test]
fn masks_that_do_not_fit() {
    let bench = dressed();
    bench.draw("wide.png", (64, 32), |x, _| [if x < 9 { 255 } else { 0 }]);
    // The colour of skin in label pictures.
    bench.paint("labels.png", (64, 32), Channels::Rgb, &[222, 165, 138]);
    bench.write("text.png", "no image");
    let line = "transfer plane.uvpair face.png --onto base.png --unit m";
    for (options, wanted) in [
        (
            "--source-mask wide.png",
            &[
                "wide.png: the confidence mask must have the aspect ratio",
                "64×64, got 64×32",
                "(face.png)",
            ][..],
        ),
        (
            "--fill wide.png",
            &[
                "wide.png: the mean texture must have the aspect ratio",
                "64×64, got 64×32",
                "(face.png)",
            ],
        ),
        ("--source-mask none.png", &["none.png", "No such file"]),
        ("--source-mask text.png", &["text.png: not a supported image"]),
        ("--fill source.obj", &["source.obj: not a supported image"]),
        ("--blend membrane --tone source --skin text.png", &["text.png: not a supported image"]),
        ("--skin wide.png", &["--skin", "--tone source"]),
        (
            "--blend membrane --tone source --skin wide.png",
            &["wide.png: must have the aspect ratio of the base, which is 128×128, got 64×32"],
        ),
        (
            "--blend membrane --labels labels.png",
            &["face.png: labels.png: must have the aspect ratio of the texture", "got 64×32"],
        ),
        ("--blend feather --tone source", &["--tone needs --blend membrane or --match skin"]),
        ("--tone source", &["--tone needs --blend membrane or --match skin"]),
        ("--tone base", &["--tone needs --blend membrane or --match skin"]),
        ("--feather 5mm --tone none", &["--tone needs --blend membrane or --match skin"]),
        ("--keep-all", &["--keep-all", "--blend feather or membrane"]),
        ("--blend feather --feather 0 --keep-all", &["--keep-all", "--feather"]),
        ("--blend feather --feather 0mm --labels wide.png", &["--labels", "--feather"]),
        ("--match skin --tone none", &["--match skin", "--tone none"]),
        ("--blend none --feather 3mm", &["--feather", "--blend none"]),
        ("--blend soft", &["'soft'", "none, feather, membrane"]),
        ("--tone mean", &["'mean'", "base, source, both, none"]),
        ("--match hair", &["'hair'", "skin"]),
        ("--data --fill wide.png", &["--data", "--fill"]),
        ("--data --source-mask wide.png", &["--data", "--source-mask"]),
        ("--data --blend membrane", &["--data", "--blend feather or --tone none"]),
        ("--data --match skin", &["--data", "--match"]),
        ("--fit --overlap average", &["--fit", "--overlap"]),
    ] {
        bench.refuse(&format!("{line} {options} -o out.png"), wanted);
    }
    // Rounding to whole texels does not count as another shape, but other sizes do.
    let left = |x, _| [if x < 20 { 255 } else { 0 }];
    bench.draw("near.png", (63, 64), left);
    bench.draw("half.png", (32, 32), left);
    for mask in ["near.png", "half.png"] {
        transfer(&bench, &format!("face.png --onto base.png --source-mask {mask}"));
    }
}

/// Masks and mean textures that change nothing are told; a mask that trusts nothing is refused.
#[test]
fn masks_of_one_value() {
    let bench = dressed();
    for (name, level) in [("black.png", 0), ("white.png", 255), ("grey.png", 128)] {
        bench.paint(name, (16, 16), Channels::Grey, &[level]);
    }
    bench.paint("clear.png", (16, 16), Channels::Rgba, &[0, 0, 0, 255]);
    bench.draw("known.png", (64, 64), |x, _| [if x < 32 { 0 } else { 255 }]);
    let line = "transfer plane.uvpair face.png --onto base.png --unit m";
    for options in ["", "--feather 5mm", "--fill grey.png", "--blend membrane"] {
        for mask in ["black.png", "clear.png"] {
            bench.refuse(
                &format!("{line} --source-mask {mask} {options} -o out.png"),
                &[mask, "--source-mask must be white where textures can be trusted", "black"],
            );
        }
    }
    let skin = "--blend membrane --tone source --skin";
    for (options, wanted) in [
        (
            "--source-mask white.png",
            "note: white.png: --source-mask has no effect: white everywhere\n",
        ),
        ("--source-mask grey.png", ""),
        ("--source-mask known.png", ""),
        (
            "--fill grey.png",
            "note: face.png: --fill has no effect: no alpha, and no --source-mask\n",
        ),
        ("--fill grey.png --source-mask known.png", ""),
        (&format!("{skin} white.png"), ""),
        (
            &format!("{skin} black.png"),
            "warning: black.png: --skin is black everywhere, so nothing of the base takes on the tone\n",
        ),
    ] {
        let run = bench.run(&format!("{line} {options} -o out.png"));
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), wanted), "{options}");
    }
    bench.paint("open.png", (64, 64), Channels::Rgba, &[9, 9, 9, 77]);
    bench.succeed("transfer plane.uvpair open.png --onto base.png --fill grey.png -o out.png");
}

/// NaN in a base goes into the result where the base shows, with a warning, however the base is read.
#[test]
fn nan_in_a_base_is_reported() {
    let bench = dressed();
    let base = |count: usize, size: Size| {
        let mut values = vec![0.5; size.texels() * 3];
        for k in 0..count {
            values[k * 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][k % 3];
        }
        Texture::new(size, Channels::Rgb, Encoding::Linear, Texels::F32(values)).unwrap()
    };
    bench.save("three.exr", base(3, Size::square(128)));
    bench.save("one.tif", base(1, Size::square(128)));
    bench.save("none.exr", base(0, Size::square(128)));
    bench.derive("other.png", "face.png", |_| {});
    for (options, wanted) in [
        ("face.png --onto three.exr -o out.exr", "three.exr: 3 texels are"),
        ("face.png --onto one.tif -o out.tif", "one.tif: 1 texel is"),
        ("face.png --onto three.exr -o out.png", "three.exr: 3 texels are"),
        ("face.png --onto three.exr --size 64 -o out.exr", "three.exr: 3 texels are"),
        ("face.png other.png --onto three.exr --format exr -o out", "three.exr: 3 texels are"),
        (
            "face.png --onto three.exr --blend membrane --unit m -o out.exr",
            "three.exr: 3 texels are",
        ),
    ] {
        let run = bench.run(&format!("transfer plane.uvpair {options}"));
        assert_eq!(run.code, Some(0), "{options}: {}", run.stderr);
        let messages: Vec<&str> =
            run.stderr.lines().filter(|line| line.contains("NaN or infinite")).collect();
        let wanted =
            format!("warning: {wanted} NaN or infinite, also in the result where the base shows");
        assert_eq!(messages, [wanted], "{options}");
    }
    let run = bench.run("transfer plane.uvpair face.png --onto none.exr -o out.exr");
    assert!(!run.stderr.contains("NaN"), "{}", run.stderr);
}

/// Texels of NaN neither count as evidence nor cover the base.
#[test]
fn nan_is_left_out() {
    let bench = dressed();
    let floats = |name: &str, side: u32, value: &dyn Fn(u32, u32) -> f32| {
        let texels = (0..side * side).flat_map(|k| [value(k % side, k / side); 3]).collect();
        let texture =
            Texture::new(Size::square(side), Channels::Rgb, Encoding::Linear, Texels::F32(texels));
        bench.save(name, texture.unwrap());
    };
    floats("nan.exr", 64, &|_, _| f32::NAN);
    floats("spotted.exr", 64, &|x, y| match (x * 7 + y * 3) % 19 {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => -f32::INFINITY,
        3 => -3.0,
        4 => f32::MAX,
        _ => 0.4,
    });
    let base = bench.texture("base.png");
    bench.refuse(
        "transfer plane.uvpair face.png --onto base.png --source-mask nan.exr -o out.png",
        &["nan.exr: --source-mask must be white where", "got black everywhere"],
    );
    let skinless = transfer_with_warnings(
        &bench,
        "face.png --onto base.png --blend membrane --tone source --skin nan.exr --gutter 0",
    );
    for (x, y) in places().filter(|&(x, y)| !is_linked(x, y)) {
        assert_eq!(texel_u8(&skinless, x, y), texel_u8(&base, x, y), "{x}, {y}");
    }
    let blends = [
        "--blend membrane",
        "--blend membrane --tone source",
        "--match skin",
        "--match skin --tone source --linear-light",
        "--blend membrane --source-mask spotted.exr",
        "--blend membrane --fill spotted.exr --source-mask spotted.exr",
        "--feather 5mm --region spotted.exr --exclude target:spotted.exr --grow 2mm",
        "--preview seen.png --mask mask.png --region spotted.exr",
    ];
    for files in [
        "nan.exr --onto base.png",
        "spotted.exr --onto base.png",
        "face.png --onto spotted.exr",
        "spotted.exr --onto nan.exr --size 40",
    ] {
        for blend in blends {
            let line = format!("transfer plane.uvpair {files} {blend} --unit m -o out.exr");
            let run = bench.run(&line);
            let clean = !run.stderr.contains("panicked") && matches!(run.code, Some(0 | 2));
            assert!(clean, "{line}: {run:?}");
            assert!(run.code == Some(0) || run.stderr.starts_with("error: "), "{line}: {run:?}");
        }
    }
}

/// Masks, regions and means are inputs like any other: if one changes, outputs are remade, whatever
/// its modification time.
#[test]
fn changed_masks_count_where_outputs_exist() {
    let bench = dressed();
    bench.paint("known.png", (64, 64), Channels::Grey, &[254]);
    bench.paint("skin.png", (64, 64), Channels::Grey, &[255]);
    bench.paint("mean.png", (64, 64), Channels::Rgb, &SKIN);
    bench.paint("other.png", (64, 64), Channels::Rgb, &[200; 3]);
    vertex_map::save_npy(&source_columns(0..=4), bench.path("part.npy")).unwrap();
    vertex_map::save_npy(&source_columns(0..=1), bench.path("less.npy")).unwrap();
    vertex_map::save_npy(&source_columns(0..=3), bench.path("other.npy")).unwrap();
    let line = "transfer plane.uvpair face.png --onto base.png --unit m --source-mask known.png \
                --fill mean.png --blend membrane --feather 0 --tone source --skin skin.png \
                --region part.npy --exclude less.npy --skip-existing -o out.png";
    assert_eq!(bench.succeed(line), "0 of 1 up to date\n");
    for input in
        ["known.png", "skin.png", "mean.png", "part.npy", "less.npy", "base.png", "face.png"]
    {
        assert_eq!(bench.succeed(line), "1 of 1 up to date\n", "{input}");
        let other = if input.ends_with("npy") { "other.npy" } else { "other.png" };
        let content = bench.bytes(input);
        std::fs::copy(bench.path(other), bench.path(input)).unwrap();
        let file = std::fs::File::options().append(true).open(bench.path(input)).unwrap();
        file.set_modified(std::time::UNIX_EPOCH).unwrap();
        assert_eq!(bench.succeed(line), "0 of 1 up to date\n", "{input}");
        std::fs::write(bench.path(input), content).unwrap();
        assert_eq!(bench.succeed(line), "0 of 1 up to date\n", "{input}");
    }
}

/// If colours cannot be compared, that is reported, and the texture is laid over unchanged.
#[test]
fn colours_that_cannot_be_compared_are_left() {
    let bench = dressed();
    bench.paint("small.png", (64, 64), Channels::Rgb, &SKIN);
    let in_the_middle = |x: u32, y: u32| [x, y].iter().all(|at| (24..40).contains(at));
    bench.draw("clear.png", (64, 64), |x, y| [1, 2, 3, if in_the_middle(x, y) { 255 } else { 0 }]);
    for (line, why) in [
        (
            "base.png --reverse --onto small.png --blend membrane",
            "base.png: the region has no boundary",
        ),
        (
            "clear.png --onto base.png --blend membrane",
            "clear.png: the texture has no colours along",
        ),
        ("face.png --size 128 --blend membrane", "face.png: the base has no colours along"),
    ] {
        let run = bench.run(&format!("transfer plane.uvpair {line} --unit m -o out.png"));
        assert_eq!(run.code, Some(0), "{line}: {}", run.stderr);
        assert!(run.stderr.starts_with(&format!("warning: {why}")), "{line}: {}", run.stderr);
        assert!(run.stderr.ends_with("colours left unchanged\n"), "{line}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{line}: {}", run.stderr);
    }
}
