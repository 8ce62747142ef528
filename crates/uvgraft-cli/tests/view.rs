//! `uvgraft view`: the page it writes, and rejected input.

use base64::Engine as _;
use uvgraft_gltf::scene::Scene;
use uvgraft_tests::mannequin;
use uvgraft_tests::strip::Strip;
use uvgraft_viewer::PAGE;

use crate::bench::Bench;

#[test]
fn writes_one_page_beside_the_avatar() {
    let bench = Bench::new();
    bench.write("me.glb", mannequin::file(false));
    // Text that could end an element, in a name that file systems allow.
    let evil = "<!--<script>&.png";
    bench.write(evil, mannequin::plain([1, 2, 3]).bytes());
    let args = ["view", "me.glb", "--texture", evil, "--texture", evil, "--no-open"];
    let run = bench.run_args(&args);
    let Some(empty) = PAGE else {
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        for wanted in ["this build has no viewer", "scripts/build-viewer.sh", "--features viewer"] {
            assert!(run.stderr.contains(wanted), "{}", run.stderr);
        }
        assert!(!bench.exists("me.html"));
        return;
    };
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!((&*run.stdout, &*run.stderr), ("", ""));
    assert_eq!(run.closing, "wrote: me.html\n");
    let page = String::from_utf8(bench.bytes("me.html")).unwrap();
    assert!(page.contains("<title>me.glb</title>"));
    assert_eq!(page.matches("<script>").count(), empty.matches("<script>").count());
    assert_eq!(page.matches("\\u003c!--\\u003cscript>&.png").count(), 2);

    // Without a user at the machine, nothing is opened.
    let mut command = bench.command();
    let output =
        command.env("CI", "1").args(["view", "me.glb", "-o", "other.HTM"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(String::from_utf8(output.stderr).unwrap().contains("no display"));
    let plain = String::from_utf8(bench.bytes("other.HTM")).unwrap();
    assert!(plain.len() < page.len() && plain.contains("<title>me.glb</title>"));
}

#[test]
fn a_page_holds_the_files_beside_a_gltf() {
    if PAGE.is_none() {
        return;
    }
    let bench = Bench::new();
    let strip = Strip::new();
    bench.write("strip.bin", &strip.binary);
    let strip = strip.with("/buffers/0/uri", "strip.bin".into());
    bench.write("me.gltf", strip.json.to_string());
    let run = bench.run("view me.gltf --no-open --look-at head");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let page = String::from_utf8(bench.bytes("me.html")).unwrap();
    // "glTF" and version 2 in base64, which nothing in another file matches.
    assert!(page.contains(">Z2xURgIAAA") && !page.contains("strip.bin"));
    assert!(page.contains(r#""lookAt":"head""#));
}

/// Photographs tell where they were taken; a page that is passed on does not.
#[test]
fn a_page_holds_pictures_without_their_metadata() {
    if PAGE.is_none() {
        return;
    }
    let bench = Bench::new();
    bench.write("me.glb", mannequin::file(false));
    // In base64, whichever byte of three it starts at.
    let secret = b"GPS".repeat(100);
    let encoded = ["R1BTR1BT", "UFNHUFNH", "U0dQU0dQ"];
    bench.draw("plain.jpg", (64, 64), |x, y| [x as u8 * 3, y as u8 * 2, 90]);
    bench.derive("photo.jpg", "plain.jpg", |bytes| {
        let comment = [&[0xff, 0xfe, 1, 46][..], &secret].concat();
        bytes.splice(2..2, comment);
        bytes.extend(&secret);
    });
    let page = |name: &str| {
        let run = bench.run(&format!("view me.glb --texture {name} --no-open"));
        assert_eq!((run.code, &*run.stderr), (Some(0), ""));
        String::from_utf8(bench.bytes("me.html")).unwrap()
    };
    let photo = page("photo.jpg");
    assert!(!encoded.iter().any(|secret| photo.contains(secret)));
    assert_eq!(photo, page("plain.jpg").replace("plain.jpg", "photo.jpg"));
}

#[test]
fn refuses_what_it_cannot_show() {
    if PAGE.is_none() {
        // The test above reports it visibly.
        return;
    }
    let bench = Bench::new();
    let file = mannequin::file(false);
    bench.write("me.glb", &file);
    bench.write("cut.glb", &file[..file.len() - 1]);
    bench.derive("old.glb", "me.glb", |bytes| bytes[4] = 1);
    bench.write("empty.glb", b"");
    bench.make_folder("folder.glb");
    bench.write("page.html", b"mine");
    let length = file.len();
    let reported = format!(
        "truncated file: the GLB ends at byte {length}, but the file has {} bytes",
        length - 1
    );
    for (args, wanted) in [
        ("none.glb", "none.glb: No such file"),
        ("folder.glb", "folder.glb: must be a file"),
        ("ids.npy", "ids.npy: "),
        ("empty.glb", "empty.glb: not a glTF file"),
        ("cut.glb", &*reported),
        ("old.glb", "version must be 2, got 1"),
        ("me.glb --look-at tail", "no bone \"tail\""),
        ("me.glb --look-at 1,2", "six numbers"),
        ("me.glb --texture none.png", "none.png: No such file"),
        ("me.glb --texture source.obj", "source.obj: not an image; must be .png, .jpg or .webp"),
        ("me.glb -o me.png", "me.png: extension must be .html"),
        ("me.glb -o none/me.html", "cannot write none/me.html"),
        ("page.html", "page.html is also an input"),
    ] {
        let before = bench.content();
        let run = bench.run(&format!("view --no-open {args}"));
        assert_eq!(run.code, Some(2), "{args}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: "), "{args}: {}", run.stderr);
        assert!(run.stderr.contains(wanted), "{args}: {}", run.stderr);
        assert_eq!(bench.content(), before, "{args}");
    }
}

#[test]
fn a_mesh_is_shown_once_for_each_texture() {
    if PAGE.is_none() {
        return;
    }
    let bench = Bench::new();
    bench.draw("before.png", (8, 8), |_, _| [255, 0, 0]);
    bench.draw("after.tif", (8, 8), |_, _| [0, 0, 255]);
    bench.succeed("view target.obj -t before.png -t after.tif --no-open");
    let page = String::from_utf8(bench.bytes("target.html")).unwrap();
    assert!(page.contains("<title>target.obj</title>") && page.contains(r#""textures":[]"#));
    let model = page.split("\">Z2xURg").nth(1).and_then(|rest| rest.split('<').next()).unwrap();
    let model = base64::prelude::BASE64_STANDARD.decode(format!("Z2xURg{}", model.trim())).unwrap();
    let scene = Scene::read(&model).unwrap();
    assert_eq!((scene.materials().len(), scene.textures().len()), (3, 2));
    // The page of a part has its name.
    bench.succeed("view my.uvpair#source -t before.png --no-open");
    assert!(bench.exists("my.uvpair_source.html"));
}
