//! `uvgraft selfie` and `avatar --selfie` through the program. Tests with faces need the networks and
//! the photograph that `scripts/fetch-test-data.sh` fetches.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use uvgraft::{Channels, Encoding, Filter, Size, Texels, Texture};
use uvgraft_figure::{Figure, paint_head};
use uvgraft_gltf::scene::Scene;
use uvgraft_image::WriteOptions;
use uvgraft_io::obj;
use uvgraft_render::{Shading, View, render};
use uvgraft_tests::downloads;

use crate::bench::Bench;

const SELFIE: &str = "--head demo --size 512";

/// A folder with the imported networks and the astronaut; `None` if they were not fetched.
fn fetched() -> Option<Bench> {
    let (package, photo) = (downloads::face_mesh_package()?, downloads::photograph("astronaut")?);
    let bench = Bench::new();
    bench.run_args(&["weights", "import", package.to_str().unwrap()]);
    assert!(bench.exists("faces.safetensors"));
    bench.save("astronaut.png", photo);
    Some(bench)
}

/// A JPEG of a picture with EXIF data: a camera's name, 26 mm on film, and a comment with a file name.
fn jpeg(picture: &Texture) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.jpg");
    let options = WriteOptions::default();
    uvgraft_image::write(&picture.clone().into(), &path, &options).unwrap().losses.clear();
    let plain = std::fs::read(path).unwrap();
    let entry = |tag: u16, kind: u16, count: u32, value: u32| {
        [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()]
            .concat()
    };
    let directory = |entries: &[Vec<u8>]| {
        [&(entries.len() as u16).to_le_bytes()[..], &entries.concat(), &[0; 4]].concat()
    };
    let exif = 8 + 2 + 2 * 12 + 4;
    let name = exif + 2 + 12 + 4;
    let block = [
        b"II*\0\x08\0\0\0".to_vec(),
        directory(&[entry(272, 2, 14, name), entry(34_665, 4, 1, exif)]),
        directory(&[entry(41_989, 3, 1, 26)]),
        b"SECRET-CAMERA\0".to_vec(),
    ]
    .concat();
    let segment = |marker: u8, content: &[u8]| {
        [&[0xff, marker][..], &(content.len() as u16 + 2).to_be_bytes(), content].concat()
    };
    [
        &plain[..2],
        &segment(0xe1, &[b"Exif\0\0", &block[..]].concat()),
        &segment(0xfe, b"SECRET-COMMENT secret_name.jpg"),
        &plain[2..],
    ]
    .concat()
}

/// Pictures side by side.
fn beside(pictures: [&Texture; 2]) -> Texture {
    let size = pictures[0].size();
    let row = size.width as usize * 3;
    let values = pictures.map(|picture| {
        let Texels::U8(values) = picture.texels() else { panic!("8 bits") };
        values.chunks_exact(row)
    });
    let [left, right] = values;
    let texels = left.zip(right).flat_map(|(a, b)| [a, b].concat()).collect();
    let size = Size::new(2 * size.width, size.height);
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels)).unwrap()
}

fn resized(picture: Texture, size: Size) -> Texture {
    picture.resized(size, Filter::Lanczos3, uvgraft::Averaging::Encoded).unwrap()
}

#[test]
fn without_networks_the_commands_that_get_them_are_named() {
    let bench = Bench::new();
    bench.paint("me.png", (64, 64), Channels::Rgb, &[200, 150, 120]);
    let wanted =
        ["npm pack @mediapipe/face_mesh@0.4.1657299874", "uvgraft weights import mediapipe-"];
    bench.refuse(&format!("selfie me.png {SELFIE} -o face.png"), &wanted);
    let avatar = "avatar --selfie me.png --body demo --onto #c08a70 --size 256 -o me.glb";
    bench.refuse(avatar, &wanted);
    let reported = bench.run(avatar).stderr;
    assert!(reported.lines().count() == 1 && !reported.contains("\\n"), "{reported}");
}

#[test]
fn bad_options_and_files_are_refused_before_any_work() {
    let bench = Bench::new();
    bench.paint("me.png", (64, 64), Channels::Rgb, &[200, 150, 120]);
    bench.make_folder("frames");
    for (args, wanted) in [
        ("selfie me.png --head demo -o me.png", "output me.png is also an input"),
        ("selfie me.png --head target.obj -o target.obj", "must be an image"),
        ("selfie me.png --head target.obj -o face.png --mesh target.obj", "is also an input"),
        ("selfie me.png --head demo -o face.png --known face.png", "two outputs have the name"),
        ("selfie me.png --head demo -o face.png --mesh shape.ply", "extension must be .obj"),
        ("selfie me.png --head demo -o face.png --cameras c.txt", "extension must be .json"),
        ("selfie none.png --head demo -o face.png", "none.png: No such file"),
        ("selfie me.png --head none.obj -o face.png", "none.obj: No such file"),
        ("selfie me.png me.png --head demo -o face.png", "me.png: photograph given twice"),
        ("selfie frames --head demo -o face.png", "must contain at least one image"),
        ("selfie me.png frames --head demo -o face.png", "must be the only photograph given"),
        ("selfie me.png --head demo -o face.png --size 8192", "must be at most 4096×4096"),
        ("selfie me.png --head demo -o face.png --focal 0", "must be pixels above 0"),
        ("selfie me.png --head demo -o face.png --frames 5", "--frames has no effect"),
        (
            "avatar --selfie me.png --frames 5 --body demo --onto #c08a70 --size 256 -o me.glb",
            "--frames has no effect on photographs: it needs a folder",
        ),
        ("selfie me.png --head demo -o face.png --face 0", "must be a whole number from 1"),
        (
            "avatar --selfie me.png --body target.obj --onto #c08a70 --size 256 -o me.glb",
            "a pair file that links a head to this body is required",
        ),
        (
            "avatar --selfie me.png --likeness 2 --body demo --onto #c08a70 --size 256 -o me.glb",
            "must be a number from 0 to 1",
        ),
        (
            "avatar --selfie none.png --body demo --onto #c08a70 --size 256 -o me.glb",
            "none.png: No such file",
        ),
    ] {
        bench.refuse(args, &[wanted]);
    }
}

#[test]
fn photographs_without_a_usable_face_are_refused() {
    let Some(bench) = fetched() else { return };
    let astronaut = bench.texture("astronaut.png");
    bench.save("both.png", beside([&astronaut, &astronaut]));
    bench.save("small.png", resized(astronaut.clone(), Size::square(96)));
    bench.paint("plain.png", (256, 256), Channels::Rgb, &[120, 130, 140]);
    bench.derive("cut.png", "astronaut.png", |bytes| bytes.truncate(bytes.len() / 2));
    bench.write("text.png", "not an image");
    // A header that promises 30,000 by 30,000 pixels.
    bench.derive("huge.png", "astronaut.png", |bytes| {
        bytes[16..24]
            .copy_from_slice(&[30_000_u32.to_be_bytes(), 30_000_u32.to_be_bytes()].concat());
        let checksum = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
    });
    for (photo, wanted) in [
        ("plain.png", "no face found"),
        ("both.png", "must show one face, got 2; choose one by --face N"),
        ("both.png --face 3", "--face must be from 1 to 2, got 3"),
        ("small.png", "the face must be at least 64 pixels wide"),
        ("cut.png", "cut.png: "),
        ("text.png", "text.png: "),
        ("huge.png", "must have at most "),
    ] {
        bench.refuse(&format!("selfie {photo} {SELFIE} -o face.png"), &[wanted]);
    }
    let wanted = ["source.obj: the mesh must have a head with a face"];
    bench.refuse("selfie astronaut.png --head source.obj -o face.png", &wanted);
    bench.derive("faces.safetensors", "faces.safetensors", |bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
    });
    let wanted = ["import the weights again"];
    bench.refuse(&format!("selfie astronaut.png {SELFIE} -o face.png"), &wanted);
}

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes
        .iter()
        .fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), |crc, _| step(crc)))
}

#[test]
fn a_photograph_becomes_a_texture_without_its_metadata() {
    let Some(bench) = fetched() else { return };
    bench.write("secret_name.jpg", jpeg(&bench.texture("astronaut.png")));
    let args = |folder: &str, threads: u16| {
        format!(
            "selfie secret_name.jpg {SELFIE} -o {folder}/face.png --known {folder}/known.png --mesh \
             {folder}/shape.obj --cameras {folder}/cameras.json --sheet {folder}/sheet.png --threads \
             {threads}"
        )
    };
    bench.make_folder("one");
    bench.make_folder("two");
    let said = bench.make(&args("one", 1));
    // 26 mm of 512 by 512 pixels.
    assert!(said.contains("focal length 435 pixels (from EXIF)"), "{said}");
    assert_eq!(bench.make(&args("two", 2)), said.replace("one/", "two/"));
    for name in ["face.png", "known.png", "shape.obj", "cameras.json", "sheet.png"] {
        let bytes = bench.bytes(&format!("one/{name}"));
        assert!(bytes == bench.bytes(&format!("two/{name}")), "{name} depends on threads");
        let holds = |part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
        for mark in [&b"SECRET"[..], b"secret_name", b"Exif", b"eXIf"] {
            assert!(!holds(mark), "{name} holds {}", mark.escape_ascii());
        }
    }
    let (face, known) = (bench.texture("one/face.png"), bench.texture("one/known.png"));
    assert_eq!((face.size(), known.size()), (Size::square(512), Size::square(512)));
    let share = (0..512).flat_map(|y| (0..512).map(move |x| (x, y)));
    let share = share.filter(|&(x, y)| known.get(x, y, 0) > 0.5).count() as f64 / (512.0 * 512.0);
    assert!((0.05..0.9).contains(&share), "{share}");
    let (shape, figure) = (obj::read(bench.path("one/shape.obj")).unwrap(), Figure::new().head);
    assert_eq!((shape.faces(), shape.uv()), (figure.faces(), figure.uv()));
    assert_ne!(shape.positions(), figure.positions());
    let cameras: serde_json::Value =
        serde_json::from_slice(&bench.bytes("one/cameras.json")).unwrap();
    let camera = &cameras["cameras"][0];
    assert_eq!(camera["size"], serde_json::json!([512, 512]));
    assert!(camera["residual_px"].as_f64().unwrap() < 3.0, "{camera}");
}

#[test]
fn textures_that_are_given_as_photographs_are_reported() {
    let Some(bench) = fetched() else { return };
    const TOLD: &str = "looks like the texture of a head rather than a photograph";
    let run = |photo: &str, output: &str| {
        let run = bench.run(&format!("selfie {photo} {SELFIE} -o {output}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr
    };
    let reported = run("astronaut.png", "face.png");
    assert!(!reported.contains(TOLD), "{reported}");
    let reported = run("face.png", "again.png");
    assert!(reported.contains("warning: face.png: ") && reported.contains(TOLD), "{reported}");
    let avatar = bench.run(
        "avatar --selfie face.png --onto #c08a70 --size 256 --body demo --mouth none -o me.glb",
    );
    assert!(avatar.code == Some(0) && avatar.stderr.contains(TOLD), "{}", avatar.stderr);
    let Some(folder) = std::env::var_os("UVGRAFT_DATA").map(std::path::PathBuf::from) else {
        return;
    };
    for name in ["body_light.jpg", "body_medium.jpg", "flame_mean_texture.jpg"] {
        let path = folder.join(name);
        let reported = run(path.to_str().unwrap(), "again.png");
        assert!(reported.contains(TOLD), "{name}: {reported}");
    }
}

#[test]
fn frames_of_a_folder_are_fused_and_those_without_a_face_left_out() {
    let Some(bench) = fetched() else { return };
    bench.make_folder("frames");
    let astronaut = bench.texture("astronaut.png");
    bench.save("frames/1.png", astronaut.clone());
    bench.save("frames/2.png", resized(astronaut, Size::square(480)));
    bench.paint("frames/3.png", (64, 64), Channels::Rgb, &[120, 130, 140]);
    let run = bench.run(&format!("selfie frames {SELFIE} -o face.png"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("frame left out: frames/3.png: no face found"), "{}", run.stderr);
    assert!(run.stdout.contains("photograph 2   480×480 pixels"), "{}", run.stdout);
}

#[test]
fn an_avatar_gets_the_face_and_its_shape() {
    let Some(bench) = fetched() else { return };
    let run = |output: &str, options: &str| {
        let onto = "--onto #c08a70 --size 512 --body demo";
        bench.make(&format!("avatar --selfie astronaut.png {onto} -o {output} {options}"))
    };
    let said = run("me.glb", "");
    assert!(said.contains("landmarks") && said.contains("joints"), "{said}");
    bench.make_folder("again");
    run("again/me.glb", "--threads 1");
    assert!(bench.bytes("me.glb") == bench.bytes("again/me.glb"));
    run("plain.glb", "--likeness 0");
    let positions = |name: &str| {
        let scene = Scene::load(bench.path(name)).unwrap();
        let posed = scene.pose(&uvgraft_gltf::scene::PoseRequest::default()).unwrap();
        posed.into_iter().flat_map(|drawn| drawn.positions).collect::<Vec<_>>()
    };
    // The mouth is fitted to each shape, so that vertices have other numbers.
    let plain = positions("plain.glb");
    let off = |at: [f32; 3]| {
        let away = |other: &[f32; 3]| glam::Vec3::from(at).distance_squared((*other).into());
        plain.iter().map(away).fold(f32::INFINITY, f32::min).sqrt()
    };
    let most = positions("me.glb").into_iter().map(off).fold(0.0, f32::max);
    assert!((0.002..0.05).contains(&most), "{most} m");
}

#[test]
fn a_photograph_of_the_figure_gives_its_texture_back() {
    let Some(bench) = fetched() else { return };
    let figure = Figure::new();
    let view =
        View { azimuth: 8.0, elevation: 2.0, target: [0.0, 1.6, 0.01], height: 0.45, floor: false };
    let texture = paint_head(&figure, Size::square(1024));
    let photo = render(
        &figure.head,
        &texture,
        |part| Shading::named(&part.material).unwrap_or_default(),
        &view,
        Size::square(900),
    );
    bench.save("figure.png", photo);
    let args = format!("selfie figure.png {SELFIE} -o face.png --known known.png --relight full");
    bench.make(&args);
    let (face, known) = (bench.texture("face.png"), bench.texture("known.png"));
    let wanted = resized(texture, Size::square(512));
    let mut differences = Vec::new();
    for (x, y) in (0..512).flat_map(|y| (0..512).map(move |x| (x, y))) {
        if known.get(x, y, 0) > 0.9 {
            differences.push([0, 1, 2].map(|k| face.get(x, y, k) - wanted.get(x, y, k)));
        }
    }
    assert!(differences.len() > 10_000, "{} texels known", differences.len());
    // The light of the renderer is not taken out entirely.
    let mean = differences.iter().flatten().map(|value| value.abs()).sum::<f32>()
        / (3 * differences.len()) as f32;
    assert!(mean < 0.1, "{mean}");
}
