//! Pictures of GLB files through the program.

use serde_json::{Value, json};
use uvgraft::{Channels, Size};
use uvgraft_tests::strip::{self, Strip};

use crate::bench::{Bench, texel_u8};

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("me.glb", Strip::new().glb());
    bench
}

#[test]
fn a_picture_has_the_colours_of_the_texture() {
    let bench = bench();
    bench.succeed("render me.glb -o me.png --unlit --azimuth 0 --elevation 0 --size 60x80");
    let picture = bench.texture("me.png");
    assert_eq!(picture.size(), Size::new(60, 80));
    // Red, green, blue and white quarters around the centre, on white.
    for (at, wanted) in [
        ((25, 35), [255, 0, 0]),
        ((34, 35), [0, 255, 0]),
        ((25, 44), [0, 0, 255]),
        ((34, 44), [255; 3]),
        ((2, 2), [255; 3]),
    ] {
        assert_eq!(texel_u8(&picture, at.0, at.1), wanted, "{at:?}");
    }
    // The same again, with various numbers of threads.
    let bytes = bench.bytes("me.png");
    for threads in [1, 3] {
        bench.succeed(&format!(
            "render me.glb -o me.png --unlit --azimuth 0 --elevation 0 --size 60x80 --threads {threads}"
        ));
        assert_eq!(bench.bytes("me.png"), bytes);
    }
}

#[test]
fn poses_clips_and_expressions_move_it() {
    let bench = bench();
    let draw = |options: &str| {
        bench.succeed(&format!(
            "render me.glb -o me.webp --unlit --background transparent --azimuth 50 \
             --size 40x40 {options}"
        ));
        bench.texture("me.webp")
    };
    let rest = draw("");
    assert_eq!(rest.channels(), Channels::Rgba);
    assert_eq!(draw("--clip bend --frame 0"), rest);
    assert_eq!(draw("--pose rest --expression bulge=0"), rest);
    let bent = draw("--clip bend --frame 1");
    assert_ne!(bent, rest);
    // The end, as printed with one decimal; anything beyond is rejected.
    assert_eq!(draw("--frame 1.04"), bent);
    bench.refuse(
        "render me.glb -o me.png --frame 7",
        &["--frame must be within", "bend", "1.00 s", "got 7"],
    );
    assert_eq!(draw("--pose head=0,0,90"), bent);
    assert_ne!(draw("--expression bulge"), rest);
    assert_ne!(draw("--camera head"), rest);
}

#[test]
fn the_camera_is_reported_as_json() {
    let bench = bench();
    let reported = bench.succeed("render me.glb -o me.png --size 8 --print-camera --azimuth 90");
    let camera: Value = serde_json::from_str(&reported).unwrap();
    let eye: Vec<f64> = serde_json::from_value(camera["eye"].clone()).unwrap();
    assert!(eye[0] > 3.0 && eye[2].abs() < 1e-4, "{reported}");
    assert_eq!((&camera["target"], &camera["fov_y"]), (&json!([0.0, 1.0, 0.0]), &json!(24.0)));
}

#[test]
fn a_camera_aims_at_bones_and_boxes() {
    let bench = bench();
    let camera = |options: &str| -> Value {
        let reported = bench.succeed(&format!(
            "render me.glb -o me.png --size 8 --print-camera --azimuth 0 --elevation 0 {options}"
        ));
        serde_json::from_str(&reported).unwrap()
    };
    // The head moves only the upper end.
    assert_eq!(camera("--look-at head")["target"], json!([0.0, 2.0, 0.0]));
    let moved = camera("--look-at head --pose head=0,0,90");
    let x = moved["target"][0].as_f64().unwrap();
    assert!((x + 1.0).abs() < 1e-5, "{moved}");
    let boxed = camera("--look-at=-1,0,-1,3,1,1");
    assert_eq!(boxed["target"], json!([1.0, 0.5, 0.0]));
    // A box four times as wide as high is viewed from a distance that fits its width.
    let eye = boxed["eye"][2].as_f64().unwrap();
    assert!(eye > 2.0 / 12_f64.to_radians().tan(), "{boxed}");
}

#[test]
fn heads_are_found_by_their_necks_and_busts_are_all_head() {
    let bench = bench();
    let target = |file: &str| {
        let reported =
            bench.succeed(&format!("render {file} -o a.png --size 8 --print-camera --camera head"));
        let camera: Value = serde_json::from_str(&reported).unwrap();
        camera["target"][1].as_f64().unwrap()
    };
    let named = |name: &str, scale: f32| {
        let strip = Strip::new()
            .with("/nodes/1/name", json!(name))
            .with("/nodes/0/scale", json!([scale, scale, scale]));
        bench.write("other.glb", strip.glb());
        target("other.glb")
    };
    assert_eq!(named("neck", 1.0), target("me.glb"));
    let (body, bust) = (named("tip", 1.0), named("tip", 0.2));
    assert!(body > 1.5 && (bust - 0.2).abs() < 1e-5, "{body} {bust}");
}

#[test]
fn wide_models_are_whole_in_the_picture() {
    let bench = Bench::new();
    let wide = Strip::new().with("/nodes/0/scale", json!([9, 1, 1]));
    bench.write("wide.glb", wide.glb());
    for (size, azimuth) in [("40x120", 0), ("120x40", 0), ("60x60", 50), ("40x120", 230)] {
        for options in ["", "--look-at foot", "--turntable 2"] {
            bench.succeed(&format!(
                "render wide.glb -o wide.png --unlit --background #000000 --size {size} \
                 --azimuth {azimuth} {options}"
            ));
            let frames: &[&str] = match options {
                "--turntable 2" => &["wide_000.png", "wide_001.png"],
                _ => &["wide.png"],
            };
            for frame in frames {
                let picture = bench.texture(frame);
                let Size { width, height } = picture.size();
                let is_lit = |x: u32, y: u32| (0..3).any(|k| picture.get(x, y, k) > 0.1);
                let rows = (0..height).any(|y| is_lit(0, y) || is_lit(width - 1, y));
                let columns = (0..width).any(|x| is_lit(x, 0) || is_lit(x, height - 1));
                let middle = (0..height).any(|y| is_lit(width / 2, y));
                assert!(!rows && !columns && middle, "{size} {azimuth} {options} {frame}");
            }
        }
    }
}

#[test]
fn moving_pictures_have_their_frames() {
    let bench = bench();
    bench.succeed("render me.glb -o me.gif --turntable 5 --size 24x32");
    let gif = bench.bytes("me.gif");
    assert!(gif.starts_with(b"GIF89a") && gif[6..10] == [24, 0, 32, 0]);
    bench.succeed("render me.glb -o me.webp --motion --fps 4 --size 24x32");
    let webp = bench.bytes("me.webp");
    let frames = webp.windows(4).filter(|name| name == b"ANMF").count();
    assert_eq!(frames, 4);
    bench.succeed("render me.glb -o turning.webp --motion --turntable --fps 4 --size 24x32");
    let turning = bench.bytes("turning.webp");
    assert!(turning.windows(4).filter(|name| name == b"ANMF").count() == 4 && turning != webp);
    bench.succeed("render me.glb -o me.png --motion --fps 2 --size 24x32");
    assert!(!bench.exists("me.png") && !bench.exists("me_002.png"));
    assert_ne!(bench.texture("me_000.png"), bench.texture("me_001.png"));
    // The first frame of a motion shows its start, with a camera that fits everything.
    bench.succeed("render me.glb -o still.gif --frame 0 --size 24x32");
    assert!(bench.bytes("still.gif").starts_with(b"GIF89a"));
}

#[test]
fn what_is_no_avatar_is_refused() {
    let bench = bench();
    let glb = bench.bytes("me.glb");
    bench.write("cut.glb", &glb[..700]);
    bench.write("empty.glb", "");
    bench.write("prose.glb", "This is not an avatar.");
    let save = |name: &str, strip: Strip| bench.write(name, strip.glb());
    save("cycle.glb", Strip::new().with("/nodes/1/children", json!([0])));
    save("joint.glb", Strip::new().with_bytes(strip::JOINTS, 0, [7, 1, 0, 0]));
    save("nan.glb", Strip::new().with_bytes(strip::POSITIONS, 0, f32::NAN.to_le_bytes()));
    save("count.glb", Strip::new().with("/accessors/0/count", json!(1_000_000)));
    save("fog.glb", Strip::new().with("/extensionsRequired", json!(["EXT_mesh_of_fog"])));
    let mut bomb = Strip::new();
    let view = bomb.view(&strip::png(30_000, 30_000, &[]));
    save("bomb.glb", bomb.with("/images/0/bufferView", view.into()));
    save("empty_scene.glb", Strip::new().with("/scenes/0/nodes", json!([])));
    save("still.glb", Strip::new().with("/animations", json!([])));
    let outside = Strip::new().with("/buffers/0/uri", json!("../secret.bin"));
    bench.write("outside.gltf", outside.json.to_string());
    for (args, wanted) in [
        ("none.glb -o a.png", &["none.glb: ", "No such file"][..]),
        ("cut.glb -o a.png", &["cut.glb: ", "truncated"]),
        ("empty.glb -o a.png", &["empty.glb: ", "not a glTF file"]),
        ("prose.glb -o a.png", &["prose.glb: ", "not a glTF file", "This is "]),
        ("cycle.glb -o a.png", &["cycle.glb: node 0", "its own ancestor"]),
        ("joint.glb -o a.png", &["joint.glb: node 2", "uses joint 7, but skin 0 has 2"]),
        ("nan.glb -o a.png", &["nan.glb: accessor 0: element 0", "finite"]),
        ("count.glb -o a.png", &["count.glb: accessor 0", "1000000 elements"]),
        ("fog.glb -o a.png", &["fog.glb: ", "EXT_mesh_of_fog", "gltf-transform"]),
        ("me.glb -o a.png --look-at tail", &["me.glb: ", "no bone \"tail\"", "head"]),
        ("me.glb -o a.png --look-at 1,2,3", &["six numbers"]),
        ("me.glb -o a.png --look-at 1,2,3,4,5,x", &["X0,Y0,Z0"]),
        ("me.glb -o a.png --look-at head --camera head", &["cannot be used with"]),
        ("bomb.glb -o a.png", &["texels of images, got 900000000"]),
        ("empty_scene.glb -o a.png", &["empty_scene.glb: no triangles"]),
        (
            "outside.gltf -o a.png",
            &["outside.gltf: buffer 0", "must be in the model's folder or below"],
        ),
        ("still.glb -o a.png --frame 1", &["still.glb: the file has no animations"]),
        ("still.glb -o a.gif --motion", &["still.glb: the file has no animations"]),
        ("still.glb -o a.png --clip run", &["still.glb: ", "no clip \"run\""]),
        ("me.glb -o a.png --clip run", &["me.glb: ", "0 (bend)"]),
        ("me.glb -o a.png --pose wave", &["me.glb: ", "leftUpperArm"]),
        ("me.glb -o a.png --pose dance", &["t-pose", "BONE=X,Y,Z"]),
        ("me.glb -o a.png --pose tail=0,0,1", &["me.glb: ", "no bone \"tail\"", "head"]),
        ("me.glb -o a.png --expression smile=1", &["me.glb: ", "\"smile\"", "bulge"]),
        ("me.glb -o a.png --azimuth nan", &["must be a number"]),
        ("me.glb -o a.png --background red", &["#ff8000"]),
        ("me.glb -o a.png --size 9000", &["at most 4096"]),
        ("me.glb -o a.png --fps 0", &["frames per second"]),
        ("me.glb -o a.png --pose wave --pose stand", &["--pose must name one", "wave and stand"]),
        ("me.glb -o a.png --expression bulge=1 --expression bulge=0", &["bulge: given twice"]),
        ("me.glb -o a.png --fps 30", &["--fps has no effect on a still picture"]),
        ("me.glb -o a.gif --fps 30 --frame 0", &["--fps has no effect"]),
        ("me.glb -o a.webp --fps 5 --camera head", &["needs --motion or a turntable"]),
        ("me.glb -o a.gif --motion --turntable 12", &["--turntable N cannot be used", "--motion"]),
        ("me.glb -o a.bmp", &["a.bmp: ", ".gif", ".png"]),
        ("me.glb -o a.jpg --background transparent", &["a.jpg: ", "transparency"]),
        ("me.glb -o me.glb", &["me.glb"]),
        ("me.glb -o none/a.png", &["none/a.png", "folder none does not exist"]),
        ("me.glb -o a.gif --turntable 3000 --size 1000", &["a.gif: 3000 frames"]),
    ] {
        bench.refuse(&format!("render {args}"), wanted);
    }
}

#[test]
fn meshes_are_shown_with_one_texture_or_two_side_by_side() {
    let bench = Bench::new();
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\no all\nf 1/1 2/2 3/3 4/4\n";
    bench.write("square.obj", square);
    bench.succeed("pair square.obj square.obj -o square.uvpair");
    bench.draw("red.png", (8, 8), |_, _| [255, 0, 0]);
    bench.draw("blue.jpg", (8, 8), |_, _| [0, 0, 255]);
    let options = "--unlit --azimuth 0 --elevation 0 --size 40x40";
    // The pair has both meshes, and a part is one too.
    for mesh in ["square.obj", "square.obj#all", "square.uvpair", "square.uvpair#source"] {
        bench.succeed(&format!("render {mesh} -t red.png -t blue.jpg {options} -o both.png"));
        let both = bench.texture("both.png");
        assert_eq!(both.size(), Size::new(80, 40));
        let [red, blue] = [(20, 20), (60, 20)].map(|(x, y)| texel_u8(&both, x, y));
        assert_eq!(red, [255, 0, 0], "{mesh}");
        // JPEG changes colours a little.
        assert!(blue[2] > 250 && blue[0] < 5, "{mesh}: {blue:?}");
    }
    let run = bench.run(&format!("render square.obj {options} -o grey.png"));
    let wanted = "note: square.obj: shown in grey; --texture shows a texture on it\n";
    assert_eq!((run.code, &*run.stderr), (Some(0), wanted));
    assert_eq!(texel_u8(&bench.texture("grey.png"), 20, 20), [180; 3]);
    // A model's own texture is replaced.
    bench.write("me.glb", Strip::new().glb());
    bench.succeed(&format!("render me.glb -t red.png {options} -o red_me.png"));
    assert_eq!(texel_u8(&bench.texture("red_me.png"), 25, 20), [255, 0, 0]);
    for (args, wanted) in [
        (
            "square.uvpair#middle",
            "square.uvpair: the side of a pair must be source or target, got \"middle\"",
        ),
        ("square.obj -t red.png -t red.png -t red.png", "--texture must be given at most 2 times"),
        ("square.obj -t square.obj", "square.obj: not a supported image"),
        ("square.obj --motion -q", "square.obj: the file has no animations"),
        ("red.png", "red.png: a mesh must be an OBJ, PLY, GLB or glTF file"),
        ("square.obj -t red.png --memory 1K", "--memory allows 0"),
    ] {
        bench.refuse(&format!("render {args} -o out.png"), &[wanted]);
    }
}
