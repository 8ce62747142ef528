//! Rejected input: always exit code 2 and a message with the file, what it must be and what it is;
//! never a panic, or a partial or lost file.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::{self, Bench};
use uvgraft::Channels;

/// Command lines of `uvgraft pair` with their meshes and map, and what the message must contain.
#[test]
fn meshes_and_vertex_maps() {
    let bench = Bench::new();
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n";
    for (name, text) in [
        ("no_vt.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n".to_owned()),
        ("index.obj", format!("{square}f 1/1 2/2 7/3\n")),
        ("uv_index.obj", format!("{square}f 1/1 2/2 3/9\n")),
        ("nan.obj", format!("{square}v 0 NaN 0\nf 1/1 2/2 3/3\n")),
        ("nan_uv.obj", format!("{square}vt inf 0\nf 1/1 2/2 3/3\n")),
        ("word.obj", format!("{square}v 0 zero 0\nf 1/1 2/2 3/3\n")),
        ("two_corners.obj", format!("{square}f 1/1 2/2\n")),
        ("points.obj", square.to_owned()),
        ("empty.obj", String::new()),
        ("prose.obj", "This is not a mesh.\n".to_owned()),
        ("short.txt", "1 2 3\n".to_owned()),
        ("float.txt", "1.0 2.0\n".to_owned()),
        ("words.txt", "one two\n".to_owned()),
        ("empty.txt", String::new()),
        ("beyond.txt", ids_with(3, 29)),
        ("below.txt", ids_with(4, -2)),
        ("elsewhere.txt", "-1 ".repeat(25)),
    ] {
        bench.write(name, text);
    }
    bench.paint("image.png", (4, 4), Channels::Rgb, &[1, 2, 3]);
    bench.write("binary.obj", [0x89, b'P', 0, 0xff, b'\n']);
    bench.write("ids.npz", b"PK\x03\x04 and so on");
    bench.derive("cut.npy", "ids.npy", |bytes| bytes.truncate(300));
    bench.derive("header_only.npy", "ids.npy", |bytes| bytes.truncate(40));
    let replaced = |name: &str, from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        bench.derive(name, "ids.npy", |bytes| replace(bytes, from, to));
    };
    replaced("float.npy", "'<i8'", "'<f8'");
    replaced("huge.npy", "(25,), }               ", "(9999999999999999999,)}");
    replaced("table.npy", "(25,), ", "(5, 5),");
    bench.make_folder("folder.obj");

    let cases: &[(&str, &[&str])] = &[
        ("none.obj target.obj --vertex-map ids.npy", &["none.obj: ", "No such file"]),
        ("source.obj none.obj --vertex-map ids.npy", &["none.obj: ", "No such file"]),
        ("source.obj target.obj --vertex-map none.npy", &["none.npy: ", "No such file"]),
        (
            "folder.obj target.obj --vertex-map ids.npy",
            &["folder.obj: must be a file, but is a folder"],
        ),
        (
            "no_vt.obj target.obj --vertex-map ids.npy",
            &["no_vt.obj: line 4: corner 1 must have a texture coordinate", "v/vt"],
        ),
        (
            "index.obj target.obj --vertex-map ids.npy",
            &["index.obj: line 7: corner 3: vertex index must be at most 3, got 7"],
        ),
        (
            "source.obj uv_index.obj --vertex-map ids.npy",
            &["uv_index.obj: line 7: corner 3: ", "at most 3, got 9"],
        ),
        ("nan.obj target.obj --vertex-map ids.npy", &["nan.obj: line 7: ", "must be a finite"]),
        (
            "source.obj nan_uv.obj --vertex-map ids.npy",
            &["nan_uv.obj: line 7: ", "must be a finite"],
        ),
        (
            "word.obj target.obj --vertex-map ids.npy",
            &["word.obj: line 7: ", "must be a number, got `zero`"],
        ),
        (
            "two_corners.obj target.obj --vertex-map ids.npy",
            &["two_corners.obj: line 7: face must have at least 3 corners, got 2"],
        ),
        (
            "points.obj target.obj --vertex-map ids.npy",
            &["points.obj: mesh must have faces", "3 vertices"],
        ),
        ("empty.obj target.obj --vertex-map ids.npy", &["empty.obj: the file is empty"]),
        ("prose.obj target.obj --vertex-map ids.npy", &["prose.obj: not an OBJ file"]),
        (
            "image.png target.obj --vertex-map ids.npy",
            &["image.png: a mesh must be an OBJ", "got a PNG image"],
        ),
        ("binary.obj target.obj --vertex-map ids.npy", &["line 1", "not an OBJ"]),
        (
            "source.obj target.obj --vertex-map short.txt",
            &["short.txt: ", "one entry per vertex of the source mesh, 25, got 3"],
        ),
        (
            "target.obj source.obj --vertex-map ids.npy",
            &[
                "ids.npy: ",
                "one entry per vertex of the source mesh, 29, got 25",
                "source and target swapped?",
            ],
        ),
        ("source.obj target.obj --vertex-map float.npy", &["float.npy: ", "'<f8'", "integers"]),
        ("source.obj target.obj --vertex-map float.txt", &["float.txt: line 1: ", "`1.0`"]),
        (
            "source.obj target.obj --vertex-map words.txt",
            &["words.txt: line 1: must be an integer, got `one`"],
        ),
        ("source.obj target.obj --vertex-map empty.txt", &["empty.txt: ", "got an empty file"]),
        ("source.obj target.obj --vertex-map source.obj", &["source.obj: line 1: ", "integer"]),
        (
            "source.obj target.obj --vertex-map beyond.txt",
            &["beyond.txt: ", "from 0 to 28, or -1 for none; got 29"],
        ),
        ("source.obj target.obj --vertex-map below.txt", &["entry 4 ", "-1 for none; got -2"]),
        (
            "source.obj target.obj --vertex-map elsewhere.txt",
            &[
                "elsewhere.txt: ",
                "none of the 32 source faces",
                "check that the vertex map belongs",
            ],
        ),
        (
            "source.obj target.obj --vertex-map huge.npy",
            &["huge.npy: ", "must have 79999999999999999992 bytes", "got 200"],
        ),
        ("source.obj target.obj --vertex-map table.npy", &["table.npy: ", "(1, N), got (5, 5)"]),
        ("source.obj target.obj --vertex-map cut.npy", &["cut.npy: ", "200 bytes", "got 172"]),
        ("source.obj target.obj --vertex-map header_only.npy", &["header_only.npy: ", "truncated"]),
        ("source.obj target.obj --vertex-map ids.npz", &["ids.npz: ", ".npz archive"]),
    ];
    for (files, wanted) in cases {
        bench.refuse(&format!("pair {files} -o out.uvpair --preview out.png"), wanted);
    }
}

#[test]
fn outputs_of_a_pairing() {
    let bench = Bench::new();
    bench.make_folder("folder");
    link(&bench, "source.obj", "link_to_source");
    let files = "pair source.obj target.obj --vertex-map ids.npy";
    let cases: &[(&str, &[&str])] = &[
        ("-o none/out.uvpair", &["cannot write none/out.uvpair: ", "folder none does not exist"]),
        ("-o ids.npy/out.uvpair", &["cannot write ids.npy/out.uvpair: ids.npy is not a folder"]),
        ("-o folder", &["folder: must be a file, but is a folder"]),
        ("-o source.obj", &["output source.obj is also an input"]),
        ("-o ./target.obj", &["output ./target.obj is also an input"]),
        ("-o folder/../ids.npy", &["output folder/../ids.npy is also an input"]),
        ("-o out.uvpair --preview out.uvpair", &["out.uvpair", ".png"]),
        (
            "-o out.png --preview ./out.png",
            &["out.png: the extension is that of a PNG image", "use .uvpair"],
        ),
        ("-o out.uvpair --preview out.gif", &["out.gif: ", ".png"]),
        ("-o out.uvpair --preview none/out.png", &["none/out.png", "folder none does not exist"]),
        ("-o out.uvpair --source-size 0", &["'0'", "--source-size", "sides from 1 to 32768"]),
        ("-o out.uvpair --target-size big", &["'big'", "--target-size", "N or WxH"]),
        ("", &["required", "--output"]),
    ];
    for (output, wanted) in cases {
        bench.refuse(&format!("{files} {output}"), wanted);
    }
    if cfg!(unix) {
        bench.refuse(&format!("{files} -o link_to_source"), &["link_to_source is also an input"]);
        bench.refuse(&format!("{files} -o /dev/null"), &["/dev/null: not a regular file"]);
    }
    let refused = ["cannot be linked", "same faces:", "connectivity:", "surfaces:"];
    bench.refuse("pair source.obj target.obj -o out.uvpair", &refused);
    bench.refuse("pair source.obj target.obj --by vertex-map -o out.uvpair", &["--vertex-map"]);
}

#[test]
fn pair_files() {
    let bench = Bench::new();
    bench.paint("source.png", (8, 8), Channels::Rgb, &[1, 2, 3]);
    let length = bench.bytes("my.uvpair").len();
    bench.derive("cut.uvpair", "my.uvpair", |bytes| bytes.truncate(length - 1));
    bench.derive("cut_early.uvpair", "my.uvpair", |bytes| bytes.truncate(100));
    bench.derive("flipped.uvpair", "my.uvpair", |bytes| bytes[length - 20] ^= 1);
    let newer = r#"\"version\":7"#;
    bench.derive("newer.uvpair", "my.uvpair", |bytes| replace(bytes, r#"\"version\":2"#, newer));
    bench.write("empty.uvpair", "");
    let cases: &[(&str, &[&str])] = &[
        ("none.uvpair", &["none.uvpair: ", "No such file"]),
        ("cut.uvpair", &["cut.uvpair: ", "truncated", &length.to_string()]),
        ("cut_early.uvpair", &["cut_early.uvpair: ", "truncated", "got 100"]),
        ("flipped.uvpair", &["flipped.uvpair: ", "damaged", "SHA-256"]),
        ("newer.uvpair", &["newer.uvpair: ", "version 2 or older, got 7", "update uvgraft"]),
        ("empty.uvpair", &["empty.uvpair: not a pair file"]),
        ("source.png", &["source.png: not a pair file"]),
        ("source.obj", &["source.obj: not a pair file"]),
    ];
    bench.paint("face.png", (8, 8), Channels::Rgb, &[1, 2, 3]);
    for (pair, wanted) in cases {
        bench.refuse(&format!("transfer {pair} face.png --size 8 -o out.png"), wanted);
        bench.refuse(&format!("inspect {pair} --preview out.png"), wanted);
        bench.refuse(&format!("inspect {pair} --json"), wanted);
    }
    bench.refuse("inspect my.uvpair --preview my.uvpair", &["my.uvpair", ".png"]);
    bench.refuse(
        "inspect my.uvpair --preview none/x.png",
        &["none/x.png", "folder none does not exist"],
    );
}

#[test]
fn textures() {
    let bench = Bench::new();
    bench.paint("good.png", (16, 16), Channels::Rgb, &[1, 2, 3]);
    bench.paint_noise("whole.png", (16, 16), Channels::Rgb, uvgraft::Depth::U8);
    bench.succeed("transfer my.uvpair whole.png --size 16 --onto #102030 -o whole.jpg");
    bench.derive("cut.png", "whole.png", |bytes| bytes.truncate(bytes.len() / 2));
    bench.derive("no_end.png", "whole.png", |bytes| bytes.truncate(bytes.len() - 12));
    bench.derive("cut.jpg", "whole.jpg", |bytes| bytes.truncate(bytes.len() / 2));
    bench.derive("flipped.png", "whole.png", |bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0x55;
    });
    bench.write("huge.png", huge_png());
    bench.write("text.png", "no image at all");
    bench.write("empty.png", "");
    bench.make_folder("folder.png");
    let cases: &[(&str, &[&str])] = &[
        ("none.png", &["none.png", "No such file"]),
        (
            "text.png",
            &["text.png: not a supported image", "PNG, JPEG, WebP, TIFF, EXR", "no image"],
        ),
        ("empty.png", &["empty.png: not a supported image", "the file is empty"]),
        ("my.uvpair", &["my.uvpair: not a supported image"]),
        ("cut.png", &["cut.png: truncated PNG"]),
        ("no_end.png", &["no_end.png: truncated PNG"]),
        ("cut.jpg", &["cut.jpg: truncated JPEG"]),
        ("flipped.png", &["flipped.png: damaged PNG"]),
        ("huge.png", &["huge.png: PNG must have at most 32768 texels a side", "got 100000×100000"]),
    ];
    for (texture, wanted) in cases {
        let source = format!("transfer my.uvpair {texture} --size 16 --mask m.png -o out.png");
        bench.refuse(&source, wanted);
        bench.refuse(&format!("{source} --reverse"), wanted);
        let base = format!("transfer my.uvpair good.png --onto {texture} --mask m.png -o out.png");
        bench.refuse(&base, wanted);
        bench.refuse(&format!("{base} --size 8"), wanted);
    }
    bench.refuse("transfer my.uvpair good.png --onto folder.png -o out.png", &["is a folder"]);
    bench.refuse(
        "transfer my.uvpair folder.png --size 8 -o out",
        &["folder.png must contain at least one image"],
    );
}

#[test]
fn options_of_a_transfer() {
    let bench = Bench::new();
    bench.paint("face.png", (16, 16), Channels::Rgb, &[1, 2, 3]);
    bench.paint("clear.png", (16, 16), Channels::Rgba, &[1, 2, 3, 4]);
    let cases: &[(&str, &[&str])] = &[
        ("face.png -o out.png", &["--size", "--onto"]),
        ("face.png --onto #808080 -o out.png", &["--size"]),
        ("face.png --size 8", &["required", "--output"]),
        ("face.png --size 8 -o out.png --onto #12345", &["\"#12345\"", "#RRGGBB"]),
        ("face.png --size 8 -o out.png --onto #gg0000", &["\"#gg0000\"", "#RRGGBB"]),
        ("face.png --size 8 -o out.png --onto #", &["\"#\"", "#RRGGBB"]),
        ("face.png --size 8 -o out.png --onto ##123", &["\"##123\"", "#RRGGBB"]),
        ("face.png --size 8 -o out.png --onto grey", &["grey: ", "such as #808080"]),
        ("face.png --size 0 -o out.png", &["'0'", "--size", "N or WxH"]),
        ("face.png --size 8x -o out.png", &["'8x'", "--size", "N or WxH"]),
        ("face.png --size 8x8x8 -o out.png", &["'8x8x8'", "--size", "N or WxH"]),
        ("face.png --size 40000 -o out.png", &["'40000'", "from 1 to 32768"]),
        ("face.png --size=-8 -o out.png", &["'-8'", "N or WxH"]),
        ("face.png --size 8 -o out.gif", &["out.gif: ", ".png", ".exr"]),
        ("face.png --size 8 -o out", &["out: ", ".png", ".exr"]),
        ("face.png --size 8 -o out.png --mask mask", &["mask: ", ".png"]),
        ("face.png --size 8 -o out.png --filter cubic", &["'cubic'", "catmull-rom", "lanczos3"]),
        ("face.png --size 8 -o out.png --gutter 257", &["257", "--gutter", "from 0 to 256"]),
        ("face.png --size 8 -o out.png --gutter=-1", &["-1", "--gutter"]),
        ("face.png --size 8 -o out.jpg --quality 0", &["'0'", "--quality", "from 1 to 100"]),
        ("face.png --size 8 -o out.jpg --quality 101", &["101", "--quality", "from 1 to 100"]),
        ("face.png --size 8 -o out.jpg", &["out.jpg", "alpha", "JPEG", "--onto '#808080'"]),
        (
            "clear.png --size 8 --onto #fff -o out.jpg",
            &["out.jpg", "alpha", "JPEG", "PNG, WebP, TIFF or EXR"],
        ),
        ("face.png --size 8 -o out.png --data --linear-light", &["--data", "--linear-light"]),
        ("face.png --size 8 -o out.png --format jpg", &["--format jpg", "out.png"]),
        ("face.png --size 8 -o out.png --format bmp", &["'bmp'", ".png"]),
        ("face.png --size 8 -o out.png --threads many", &["'many'", "--threads"]),
        ("--size 8 -o out.png", &["required", "<TEXTURE>"]),
        (
            "face.png --size 16384x1 -o out.webp",
            &["out.webp: WebP supports at most 16383 texels a side, got 16384×1"],
        ),
    ];
    for (options, wanted) in cases {
        bench.refuse(&format!("transfer my.uvpair {options}"), wanted);
    }
    bench.refuse("transform my.uvpair", &["'transform'", "transfer"]);
}

#[test]
fn outputs_of_a_transfer() {
    let bench = Bench::new();
    bench.make_folder("folder/face.png");
    bench.paint("face.png", (16, 16), Channels::Rgb, &[1, 2, 3]);
    bench.paint("base.png", (16, 16), Channels::Rgb, &[4, 5, 6]);
    bench.derive("pair.png", "my.uvpair", |_| {});
    link(&bench, "base.png", "link.png");
    let cases: &[(&str, &[&str])] = &[
        ("-o none/out.png", &["cannot write none/out.png: folder none does not exist"]),
        ("-o face.png/out.png", &["cannot write face.png/out.png: face.png is not a folder"]),
        ("-o folder", &["cannot write folder/face.png: must be a file, but is a folder"]),
        ("-o face.png", &["output face.png is also an input"]),
        ("-o ./face.png", &["output ./face.png is also an input"]),
        ("-o base.png", &["output base.png is also an input"]),
        ("-o folder/../base.png", &["output folder/../base.png is also an input"]),
        ("-o pair.png", &["output pair.png is also an input"]),
        ("-o out.png --mask ./out.png", &["two outputs have the name ./out.png"]),
        ("-o out.png --mask mask.jpg", &["mask.jpg", "must not be a JPEG file"]),
        ("-o out.png --mask face.png", &["output face.png is also an input"]),
        ("-o out.png --mask base.png", &["output base.png is also an input"]),
        ("-o out.png --mask none/mask.png", &["none/mask.png: folder none does not exist"]),
    ];
    for (output, wanted) in cases {
        bench.refuse(&format!("transfer pair.png face.png --onto base.png {output}"), wanted);
    }
    if cfg!(unix) {
        let args = "transfer my.uvpair face.png --onto base.png -o link.png";
        bench.refuse(args, &["output link.png is also an input"]);
    }
}

#[cfg(unix)]
#[test]
fn outputs_that_cannot_be_replaced() {
    let bench = Bench::new();
    bench.paint("face.png", (16, 16), Channels::Rgb, &[1, 2, 3]);
    link(&bench, "two.png", "one.png");
    link(&bench, "one.png", "two.png");
    link(&bench, "none/out.png", "dangling.png");
    let long = format!("{}.png", "n".repeat(300));
    let run = bench.run(&format!("transfer my.uvpair face.png --size 16 -o {long}"));
    assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{run:?}");
    assert!(run.stderr.ends_with(": the name is too long for its folder\n"), "{run:?}");
    for (output, wanted) in [
        ("one.png", "cannot write one.png: symbolic links must not lead to themselves"),
        ("dangling.png", "none does not exist"),
    ] {
        bench.refuse(&format!("transfer my.uvpair face.png --size 16 -o {output}"), &[wanted]);
        bench.refuse(&format!("inspect my.uvpair --preview {output}"), &[wanted]);
    }
}

/// Such files stay what they are even for root.
#[cfg(target_os = "linux")]
#[test]
fn immutable_outputs() {
    let bench = Bench::new();
    bench.paint("face.png", (16, 16), Channels::Rgb, &[1, 2, 3]);
    bench.write("out.png", "old");
    let chattr = |change: &str| {
        let mut run = std::process::Command::new("chattr");
        run.arg(change).arg(bench.path("out.png")).stderr(std::process::Stdio::null());
        run.status().is_ok_and(|status| status.success())
    };
    if !chattr("+i") {
        eprintln!("skipped: files cannot be made immutable here");
        return;
    }
    let run = bench.run("transfer my.uvpair face.png --size 16 -o out.png");
    assert!(chattr("-i"));
    assert_eq!(run.code, Some(2), "{run:?}");
    let wanted = "error: cannot write out.png: immutable or append-only file\n";
    assert_eq!(run.stderr, wanted);
    assert_eq!(bench.bytes("out.png"), b"old");
}

#[test]
fn several_textures() {
    let bench = Bench::new();
    for folder in ["in", "in/more", "empty", "same"] {
        bench.make_folder(folder);
    }
    for name in ["in/a.png", "in/b.png", "in/more/a.png", "same/c.png", "same/c.webp"] {
        bench.paint(name, (16, 16), Channels::Rgb, &[1, 2, 3]);
    }
    bench.derive("texture", "in/a.png", |_| {});
    bench.write("file", "old");
    let cases: &[(&str, &[&str])] = &[
        ("in -o in", &["output in/a.png is also an input"]),
        ("in/a.png in/b.png -o ./in/more/..", &["in/more/../a.png is also an input"]),
        ("in/a.png -o in", &["output in/a.png is also an input"]),
        (
            "in/a.png in/more/a.png -o out",
            &["in/a.png and in/more/a.png have the same output out/a.png"],
        ),
        ("in in/more -o out", &["in/a.png and in/more/a.png have the same output out/a.png"]),
        ("in/a.png in/a.png -o out", &["have the same output"]),
        (
            "same --format tif -o out",
            &["same/c.png and same/c.webp have the same output out/c.tif"],
        ),
        ("in/a.png in/b.png -o out.png", &["must be a folder, got out.png"]),
        ("in -o file", &["must be a folder, got file"]),
        ("none -o file", &["none: No such file"]),
        ("none/ -o file/", &["none/: No such file"]),
        ("in -o none/out", &["cannot create the folder none/out"]),
        ("empty -o out", &["empty must contain at least one image", ".png"]),
        ("texture in/a.png -o out", &["texture: ", "--format"]),
        ("in -o out --mask in/b.png", &["output in/b.png is also an input"]),
    ];
    for (files, wanted) in cases {
        bench.refuse(&format!("transfer my.uvpair {files} --size 8"), wanted);
    }
    // Errors other than in the textures are detected before a folder is created for them.
    bench.refuse("transfer my.uvpair in -o out", &["--size"]);
    bench.refuse("transfer none.uvpair in -o out --size 8", &["none.uvpair: "]);
    bench.refuse("transfer my.uvpair in -o out --onto none.png", &["none.png: "]);
}

/// A text map of the sheet's vertices with one index replaced.
fn ids_with(entry: u32, id: i64) -> String {
    let ids = (0..bench::SHEET_VERTICES).map(|vertex| match vertex == entry {
        true => id,
        false => bench::target_of(vertex).into(),
    });
    ids.map(|id| format!("{id}\n")).collect()
}

/// What a glTF file refers to is looked at before it is opened: a pipe would block for ever, and a link may lead
/// anywhere.
#[cfg(target_os = "linux")]
#[test]
fn files_beside_a_model_are_files_in_its_folder() {
    use std::os::unix::fs::symlink;
    let bench = Bench::new();
    let mut strip = uvgraft_tests::strip::Strip::new();
    for name in ["model/below", "elsewhere"] {
        bench.make_folder(name);
    }
    for name in ["elsewhere/strip.bin", "model/strip.bin", "model/below/strip.bin"] {
        bench.write(name, &strip.binary);
    }
    let made = std::process::Command::new("mkfifo").arg(bench.path("model/pipe")).status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo is missing");
    symlink("../elsewhere/strip.bin", bench.path("model/outside")).unwrap();
    symlink("below/strip.bin", bench.path("model/inside")).unwrap();
    symlink("pipe", bench.path("model/to_pipe")).unwrap();
    symlink("/dev/zero", bench.path("model/device")).unwrap();
    let is_finished = |command: &str| {
        let mut command_line = bench.command();
        command_line.args(command.split_whitespace()).stdout(std::process::Stdio::null());
        let mut program = command_line.stderr(std::process::Stdio::piped()).spawn().unwrap();
        // A machine may be slow; a pipe without a writer blocks for ever.
        for _ in 0..3_000 {
            if program.try_wait().unwrap().is_some() {
                let output = program.wait_with_output().unwrap();
                return (output.status.code(), String::from_utf8(output.stderr).unwrap());
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        program.kill().unwrap();
        panic!("{command}: blocks");
    };
    let image = strip.json["images"][0].clone();
    for (name, reason) in [
        ("strip.bin", None),
        ("inside", None),
        ("pipe", Some("must be a file, but is a pipe or a device")),
        ("to_pipe", Some("must be a file, but is a pipe or a device")),
        ("device", Some("must be a file, but is a pipe or a device")),
        ("below", Some("must be a file, but is a folder")),
        ("outside", Some("a link to a file elsewhere")),
    ] {
        for is_image in [false, true] {
            strip.json["buffers"][0]["uri"] = if is_image { "strip.bin" } else { name }.into();
            let of_file = serde_json::json!({ "uri": name });
            strip.json["images"][0] = if is_image { of_file } else { image.clone() };
            bench.write("model/me.gltf", strip.json.to_string());
            for command in [
                "inspect model/me.gltf",
                "inspect mesh model/me.gltf",
                "render model/me.gltf -o out.png --size 32",
                "view model/me.gltf -o out.html --no-open",
            ] {
                let (code, stderr) = is_finished(command);
                // No buffer is an image; reports have a row of what is wrong with images.
                let tells = !is_image || !command.starts_with("inspect");
                match reason {
                    Some(reason) if tells && !stderr.contains("no viewer") => {
                        let wanted = format!("model/{name}: ");
                        assert_eq!(code, Some(2), "{command}, {name}: {stderr}");
                        assert!(stderr.contains(&wanted) && stderr.contains(reason), "{stderr}");
                    }
                    None if !is_image && !stderr.contains("no viewer") => {
                        assert_eq!(code, Some(0), "{command}, {name}: {stderr}");
                    }
                    _ => assert!(matches!(code, Some(0 | 2)), "{command}, {name}: {stderr}"),
                }
            }
        }
    }
}

/// A complete PNG whose header claims more texels than any image may have.
fn huge_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 100_000, 100_000);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_chunk(png::chunk::IDAT, &[0x78, 0x9c, 0x03, 0, 0, 0, 0, 1]).unwrap();
    writer.write_chunk(png::chunk::IEND, &[]).unwrap();
    drop(writer);
    bytes
}

fn replace(bytes: &mut [u8], from: &str, to: &str) {
    assert_eq!(from.len(), to.len());
    let place = bytes.windows(from.len()).position(|window| window == from.as_bytes());
    let place = place.unwrap_or_else(|| panic!("no `{from}`"));
    bytes[place..place + to.len()].copy_from_slice(to.as_bytes());
}

fn link(bench: &Bench, to: &str, name: &str) {
    #[cfg(unix)]
    std::os::unix::fs::symlink(bench.path(to), bench.path(name)).unwrap();
    #[cfg(not(unix))]
    let _ = (bench, to, name);
}
