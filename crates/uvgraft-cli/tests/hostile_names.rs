//! Names and coordinates in files must not reach terminals and rasterisers as they are.

use crate::bench::{Bench, Run};
use uvgraft::{Channels, Size, Texture};
use uvgraft_tests::strip::Strip;

/// Clears the screen, sets the title, forges a message, and turns the direction of text.
const NAME: &str = "x\x1b[2J\x1b]0;t\x07\nerror: forged\u{9b}1m\u{202e}";

#[track_caller]
fn assert_harmless(run: &Run) {
    for text in [&run.stdout, &run.stderr] {
        let bad = |it: char| (it.is_control() && it != '\n' && it != '\t') || it == '\u{202e}';
        assert!(!text.contains(bad), "{text:?}");
        assert!(!text.lines().any(|line| line.starts_with("error: forged")), "{text:?}");
    }
}

/// A mesh whose parts have the name, as an object and a material.
fn named_obj() -> String {
    // A line break would end the name here.
    let name = NAME.replace('\n', " ");
    format!(
        "o {name}\nusemtl {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    )
}

#[test]
fn names_in_meshes_and_pairs() {
    let bench = Bench::new();
    bench.write("named.obj", named_obj());
    for args in ["inspect mesh named.obj", "inspect mesh named.obj --json"] {
        let run = bench.run(args);
        assert_eq!(run.code, Some(0), "{run:?}");
        assert_harmless(&run);
        assert!(run.stdout.contains("1b"), "the name must be shown: {}", run.stdout);
    }
    let (head, body) = (bench.path("source.obj"), bench.path("target.obj"));
    let named = |name: &str| format!("{NAME}{name}");
    let ids = uvgraft_io::vertex_map::read(bench.path("ids.npy")).unwrap();
    let read = |path| uvgraft_io::obj::read(path).unwrap();
    let file = uvgraft_io::pair_file::PairFile {
        pair: uvgraft::Pair::by_vertex_map(read(&head), read(&body), &ids).unwrap().into(),
        source_name: named("source"),
        target_name: named("target"),
        note: named("note"),
    };
    uvgraft_io::pair_file::write(&file, bench.path("named.uvpair")).unwrap();
    for args in ["inspect named.uvpair", "inspect named.uvpair --json"] {
        let run = bench.run(args);
        assert_eq!(run.code, Some(0), "{run:?}");
        assert_harmless(&run);
    }
}

#[test]
fn names_in_avatars() {
    let bench = Bench::new();
    let mut strip = Strip::new();
    strip.json["animations"] = serde_json::json!([]);
    strip.json["extensionsRequired"] = serde_json::json!([NAME]);
    strip.json["extensionsUsed"] = serde_json::json!([NAME]);
    bench.write("extension.glb", strip.glb());
    let run = bench.run("render extension.glb -o out.png");
    assert_eq!(run.code, Some(2), "{run:?}");
    assert_harmless(&run);
    for args in ["inspect extension.glb", "view extension.glb -o out.html"] {
        assert_harmless(&bench.run(args));
    }
}

#[test]
fn names_in_archives() {
    let bench = Bench::new();
    let mut zip = Vec::new();
    // The smallest archive with a member of that name, without content.
    let (name, length) = (NAME.as_bytes(), NAME.len() as u16);
    zip.extend_from_slice(b"PK\x03\x04\x14\0\0\x08\0\0\0\0\0\0");
    zip.extend_from_slice(&[0; 12]);
    zip.extend_from_slice(&length.to_le_bytes());
    zip.extend_from_slice(&[0, 0]);
    zip.extend_from_slice(name);
    let directory = zip.len() as u32;
    zip.extend_from_slice(b"PK\x01\x02\x14\0\x14\0\0\x08\0\0\0\0\0\0");
    zip.extend_from_slice(&[0; 12]);
    zip.extend_from_slice(&length.to_le_bytes());
    zip.extend_from_slice(&[0; 16]);
    zip.extend_from_slice(name);
    let size = zip.len() as u32 - directory;
    zip.extend_from_slice(b"PK\x05\x06\0\0\0\0\x01\0\x01\0");
    zip.extend_from_slice(&size.to_le_bytes());
    zip.extend_from_slice(&directory.to_le_bytes());
    zip.extend_from_slice(&[0, 0]);
    bench.write("names.npz", zip);
    for args in [
        "avatar names.npz -o out.glb",
        "body shape names.npz -o out.obj",
        "inspect names.npz",
        "pair source.obj target.obj --vertex-map names.npz -o out.uvpair",
    ] {
        let run = bench.run(args);
        assert_eq!(run.code, Some(2), "{run:?}");
        assert_harmless(&run);
    }
}

#[cfg(unix)]
#[test]
fn names_of_files_and_options() {
    let bench = Bench::new();
    let size = Size::square(4);
    let texture = Texture::filled(
        size,
        Channels::Rgb,
        uvgraft::Encoding::Srgb,
        uvgraft::Depth::U8,
        &[0.5; 3],
    );
    let image = format!("{NAME}.png");
    bench.save(&image, texture.unwrap());
    let out = format!("out{NAME}.png");
    for args in [
        &["transfer", "my.uvpair", &image, "--size", "4", "-o", &out, "--fit", "2"][..],
        &["transfer", "my.uvpair", &out, "--size", "4", "-o", "none/out.png"],
        &["compare", &image, &image],
        &["compare", &image, &image, "--json"],
        &["compare", "none\x1b[2J.png", &image],
        &["inspect", &image],
        &["inspect", &format!("--{NAME}")],
        &[NAME],
        &["transfer", "my.uvpair", &image, "--size", NAME, "-o", "out.png"],
    ] {
        assert_harmless(&bench.run_args(args));
    }
}

#[test]
fn layouts_far_outside_the_unit_square_can_be_drawn() {
    let bench = Bench::new();
    for far in ["9e3", "-3e6", "1e12", "3e37"] {
        let text = bench.bytes("source.obj");
        let text = String::from_utf8(text).unwrap();
        let at = text.find("vt ").unwrap();
        let end = at + text[at..].find('\n').unwrap();
        let moved = format!("{}vt {far} {far}{}", &text[..at], &text[end..]);
        bench.write("far.obj", moved);
        bench.make("pair far.obj target.obj --vertex-map ids.npy -o far.uvpair");
        for args in [
            "inspect far.uvpair --preview out.png",
            "inspect mesh far.obj --preview out.png",
            "pair far.obj target.obj --vertex-map ids.npy --preview out.png -o other.uvpair",
        ] {
            let run = bench.run(args);
            assert_eq!(run.code, Some(0), "{far}: {run:?}");
        }
        bench.paint_noise("face.png", (64, 64), Channels::Rgb, uvgraft::Depth::U8);
        let run = bench.run("seams far.uvpair face.png --reverse --picture out.png");
        assert_eq!(run.code, Some(0), "{far}: {run:?}");
    }
}
