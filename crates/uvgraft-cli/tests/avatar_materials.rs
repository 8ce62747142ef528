//! `uvgraft avatar` through the program: material maps, styles, heads in their own layout, levels
//! of detail, and options rejected before anything is read.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use serde_json::{Value, json};
use uvgraft::{Channels, Depth, Encoding, Size, Texture};
use uvgraft_figure::Figure;
use uvgraft_gltf::scene::{PoseRequest, PosedPrimitive, Scene};
use uvgraft_image as image;

use crate::bench::{Bench, texel_u8};

const SIDE: u32 = 512;
const WHOSE: &str = "--author Nobody --license only-author";
const DEMO: &str = "avatar demo.uvpair face.png --onto base.png --unit m --body demo";

/// The figure's pair, its face, and its body with darker skin.
fn demo() -> Bench {
    Bench::of_figure(&Figure::new(), SIDE)
}

/// The JSON of a GLB file, and its buffer.
fn parts(bench: &Bench, name: &str) -> (Value, Vec<u8>) {
    let bytes = bench.bytes(name);
    let word = |at: usize| u32::from_le_bytes(*bytes[at..].first_chunk().unwrap()) as usize;
    let json = &bytes[20..20 + word(12)];
    (serde_json::from_slice(json).unwrap(), bytes[28 + json.len()..].to_vec())
}

/// An image of a GLB file by its texture's index.
fn picture(parts: &(Value, Vec<u8>), texture: &Value) -> Texture {
    let (json, buffer) = parts;
    let source = &json["textures"][texture["index"].as_u64().unwrap() as usize]["source"];
    image_of(json, buffer, source)
}

fn image_of(json: &Value, buffer: &[u8], image: &Value) -> Texture {
    let view = &json["images"][image.as_u64().unwrap() as usize]["bufferView"];
    let view = &json["bufferViews"][view.as_u64().unwrap() as usize];
    let [from, length] =
        ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap_or(0) as usize);
    image::decode(&buffer[from..from + length]).unwrap().texture
}

#[test]
fn maps_of_a_face_go_into_the_material() {
    let bench = demo();
    let grey = |level: f32| {
        Texture::filled(Size::square(64), Channels::Grey, Encoding::Data, Depth::U8, &[level])
            .unwrap()
    };
    bench.save("rough.png", grey(0.2));
    bench.save("ao.png", grey(0.4));
    bench.draw("flat.png", (64, 64), |_, _| [128, 128, 255]);
    let maps =
        "--map roughness=rough.png --map ao=ao.png --map normal=flat.png --onto roughness=#e0e0e0";
    bench.succeed(&format!("{DEMO} {maps} --blend none -o me.glb"));
    bench.succeed(&format!("{DEMO} {maps} {WHOSE} --preset web -o me.vrm"));
    bench.succeed(
        "transfer demo.uvpair rough.png --onto #000000 --size 512 --data --mask mask.png -o r.png",
    );
    let mask = bench.texture("mask.png");
    let found = parts(&bench, "me.glb");
    let material = &found.0["materials"][0];
    let pbr = &material["pbrMetallicRoughness"];
    assert_eq!((&pbr["roughnessFactor"], &pbr["metallicFactor"]), (&json!(1.0), &json!(1.0)));
    assert_eq!(material["occlusionTexture"], pbr["metallicRoughnessTexture"]);
    let packed = picture(&found, &pbr["metallicRoughnessTexture"]);
    assert_eq!(packed.size(), Size::square(SIDE));
    let (mut faces, mut others) = (0, 0);
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        let texel = texel_u8(&packed, x, y);
        if texel_u8(&mask, x, y) == [255] {
            assert_eq!(texel, [102, 51, 0], "{x} {y}");
            faces += 1;
        } else if texel == [255, 224, 0] {
            others += 1;
        }
    }
    assert!(faces > 20_000 && others > 100_000, "{faces} {others}");
    let normals = picture(&found, &material["normalTexture"]);
    // At the edge of the head's own mesh, its smooth normals differ from the body's; elsewhere flat
    // stays flat.
    let texels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    let off = texels.filter(|&(x, y)| texel_u8(&normals, x, y)[2] < 250).count() as u32;
    assert!(off * 100 < SIDE * SIDE, "{off}");
    let primitive = &found.0["meshes"][0]["primitives"][0];
    assert!(primitive["attributes"]["TANGENT"].is_u64());
    assert!(primitive["targets"][0]["TANGENT"].is_u64());
    // For the web, colours are JPEG and data never is.
    let (vrm, _) = parts(&bench, "me.vrm");
    let types = vrm["images"].as_array().unwrap().iter();
    let types: Vec<&str> = types.map(|image| image["mimeType"].as_str().unwrap()).collect();
    assert_eq!(types, ["image/jpeg", "image/png", "image/png", "image/jpeg"]);
    bench.assert_valid(&["me.glb", "me.vrm"]);
}

#[test]
fn looks_are_mtoon_or_unlit_and_vrm_files_have_a_thumbnail() {
    let bench = demo();
    bench.succeed(&format!("{DEMO} {WHOSE} --look mtoon -o toon.vrm"));
    bench.succeed(&format!(
        "{DEMO} --look unlit --author Jane --author Joe --title Me -o plain.glb"
    ));
    let (toon, buffer) = parts(&bench, "toon.vrm");
    let extensions = &toon["materials"][0]["extensions"];
    assert_eq!(extensions["VRMC_materials_mtoon"]["specVersion"], "1.0");
    // Materials with both extensions cause a warning.
    assert!(extensions["KHR_materials_unlit"].is_null());
    let thumbnail = &toon["extensions"]["VRMC_vrm"]["meta"]["thumbnailImage"];
    let thumbnail = image_of(&toon, &buffer, thumbnail);
    assert_eq!(thumbnail.size(), Size::square(512));
    // A face in the centre, and something else in the corners.
    let [middle, corner] = [(256, 280), (20, 20)].map(|(x, y)| texel_u8(&thumbnail, x, y));
    assert!(
        middle[0] > middle[2] + 20 && corner[0].abs_diff(corner[2]) < 20,
        "{middle:?} {corner:?}"
    );
    let (plain, _) = parts(&bench, "plain.glb");
    assert_eq!(plain["materials"][0]["extensions"], json!({ "KHR_materials_unlit": {} }));
    assert_eq!(plain["asset"]["extras"], json!({ "title": "Me", "authors": ["Jane", "Joe"] }));
    assert_eq!(plain["asset"]["copyright"], "Jane, Joe");
    bench.assert_valid(&["toon.vrm", "plain.glb"]);
}

/// The texture's colour at a coordinate, bilinear; 255 is full intensity.
fn sample(texture: &Texture, [u, v]: [f32; 2]) -> [f32; 3] {
    let Size { width, height } = texture.size();
    let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let (s, t) = (x - left, y - top);
    let texel = |dx: f32, dy: f32, channel| {
        let at = |value: f32, size: u32| value.clamp(0.0, (size - 1) as f32) as u32;
        texture.get(at(left + dx, width), at(top + dy, height), channel)
    };
    [0, 1, 2].map(|channel| {
        let rows =
            [0.0, 1.0].map(|dy| texel(0.0, dy, channel) * (1.0 - s) + texel(1.0, dy, channel) * s);
        255.0 * (rows[0] * (1.0 - t) + rows[1] * t)
    })
}

/// Colours on both sides of the boundary between two materials: the largest channel difference at
/// each vertex.
fn border(drawn: &[PosedPrimitive], textures: &[Texture]) -> Vec<f32> {
    let [body, head] = drawn else { panic!("two materials") };
    let places = body.positions.iter().zip(body.uv.iter());
    let bits = |place: &[f32; 3]| place.map(f32::to_bits);
    let places: std::collections::HashMap<_, _> =
        places.map(|(place, &uv)| (bits(place), uv)).collect();
    let shared = head.positions.iter().zip(head.uv.iter());
    let shared = shared.filter_map(|(place, &uv)| Some((*places.get(&bits(place))?, uv)));
    let off = |(body, head): ([f32; 2], [f32; 2])| {
        let [a, b] = [sample(&textures[0], body), sample(&textures[1], head)];
        (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max)
    };
    shared.map(off).collect()
}

#[test]
fn a_head_keeps_its_own_texture() {
    let bench = demo();
    // Mouths meet the lips with their own colours, and add triangles.
    let face = bench.texture("face.png");
    bench.succeed(&format!(
        "{DEMO} --mouth none --blend none --texture-layout head+body -o sharp.glb"
    ));
    bench.succeed(&format!("{DEMO} --mouth none --texture-layout head+body -o me.glb"));
    bench.succeed(&format!("{DEMO} --mouth none {WHOSE} --texture-layout head+body -o me.vrm"));
    bench.succeed(&format!("{DEMO} --mouth none -o atlas.glb"));
    let scene = |name: &str| Scene::load(bench.path(name)).unwrap();
    let sharp = scene("sharp.glb");
    assert_eq!(sharp.materials()[1].name, "head");
    let drawn = sharp.pose(&PoseRequest::default()).unwrap();
    // The face is not resampled: on the head's triangles, texels are the face's own.
    let (mut checked, mut off) = (0, 0);
    for triangle in drawn[1].triangles.iter() {
        let corners = triangle.map(|corner| drawn[1].uv[corner as usize]);
        let middle = [0, 1].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
        let [x, y] = middle.map(|value| (value * SIDE as f32) as u32);
        checked += 1;
        off += u32::from(texel_u8(&face, x, y) != texel_u8(&sharp.textures()[1], x, y));
    }
    // The borders of the eyes are redrawn, since captures lack them.
    assert!(checked > 2000 && off * 50 < checked, "{off} of {checked}");

    let (me, atlas) = (scene("me.glb"), scene("atlas.glb"));
    assert_eq!(me.triangles(), atlas.triangles());
    let mut differences = border(&me.pose(&PoseRequest::default()).unwrap(), me.textures());
    differences.sort_by(f32::total_cmp);
    assert!(differences.len() > 30, "{}", differences.len());
    // Bilinear lookups in two grids: a level or two, more at the hairline.
    let middle = differences[differences.len() / 2];
    let most = differences[differences.len() * 95 / 100];
    assert!(middle < 3.0 && most < 12.0, "{middle} {most}");
    // Without a blend, the same boundary is visible.
    let mut hard = border(&drawn, sharp.textures());
    hard.sort_by(f32::total_cmp);
    assert!(hard[hard.len() / 2] > 3.0 * middle, "{} {middle}", hard[hard.len() / 2]);

    let (vrm, _) = parts(&bench, "me.vrm");
    let first_person = &vrm["extensions"]["VRMC_vrm"]["firstPerson"]["meshAnnotations"];
    let kinds: Vec<&str> =
        first_person.as_array().unwrap().iter().map(|of| of["type"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["auto", "thirdPersonOnly"]);
    bench.assert_valid(&["sharp.glb", "me.glb", "me.vrm"]);
}

#[cfg(feature = "simplify")]
#[test]
fn levels_are_files_or_part_of_one() {
    let bench = demo();
    let whole = Figure::new().body.faces().len();
    let options = "--texture-layout head+body --lods 3";
    let summary = bench.succeed(&format!("{DEMO} --mouth none {options} -o me.glb"));
    bench.succeed(&format!("{DEMO} --mouth none --lods 2 {WHOSE} -o me.vrm"));
    let one = bench.succeed(&format!("{DEMO} --mouth none {options} --lods-as msft -o all.glb"));
    let plain = Scene::load(bench.path("me.glb")).unwrap();
    assert_eq!(plain.triangles(), whole);
    let mut names = vec!["me.glb".to_owned(), "all.glb".to_owned(), "me.vrm".to_owned()];
    for level in 1..=3 {
        let name = format!("me.lod{level}.glb");
        let scene = Scene::load(bench.path(&name)).unwrap();
        let share = scene.triangles() as f64 / (whole >> level) as f64;
        assert!((0.9..1.06).contains(&share), "{name}: {}", scene.triangles());
        assert_eq!(scene.expressions(), plain.expressions());
        assert_eq!(scene.clips().len(), plain.clips().len());
        assert_eq!(scene.textures(), plain.textures());
        for summary in [&summary, &one] {
            let row = summary.lines().find(|line| line.starts_with(&format!("level {level}")));
            assert!(row.is_some_and(|row| row.contains("mm mean")), "{summary}");
        }
        names.push(name);
    }
    names.extend(["me.lod1.vrm", "me.lod2.vrm"].map(str::to_owned));
    let (json, _) = parts(&bench, "all.glb");
    let node = json["nodes"].as_array().unwrap().iter().find(|node| node["extensions"].is_object());
    assert_eq!(node.unwrap()["extensions"]["MSFT_lod"]["ids"].as_array().unwrap().len(), 3);
    assert_eq!(json["meshes"].as_array().unwrap().len(), 4);
    assert_eq!(Scene::load(bench.path("all.glb")).unwrap().triangles(), whole);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    bench.assert_valid(&names);
}

#[cfg(feature = "simplify")]
#[test]
fn a_budget_needs_no_preset_and_a_preset_says_what_it_is_for() {
    let bench = demo();
    bench.succeed(&format!("{DEMO} --triangles 6000 -o small.glb"));
    let scene = Scene::load(bench.path("small.glb")).unwrap();
    assert!(scene.triangles() <= 6300, "{}", scene.triangles());
    let summary = bench.succeed(&format!("{DEMO} --preset visionos -o vision.glb"));
    assert!(summary.contains("AR Quick Look opens only USDZ"), "{summary}");
    // Two materials on a headset are acceptable.
    let summary =
        bench.succeed(&format!("{DEMO} --preset quest --texture-layout head+body -o quest.glb"));
    assert!(summary.contains("material slots: 2"), "{summary}");
    assert!(bench.bytes("quest.glb").len() < 10 << 20);
    bench.assert_valid(&["small.glb", "vision.glb", "quest.glb"]);
}

/// None of the files exists, so anything rejected was rejected before reading.
#[test]
fn options_are_refused_before_anything_is_read() {
    let bench = Bench::new();
    let start = "avatar none.uvpair none.png --body none.npz";
    let with = format!("{start} --onto #c08a70 --size 64");
    for (command, wanted) in [
        (format!("{with} --quality 50 -o me.glb"), &["--quality", "--texture jpeg"][..]),
        (format!("{with} --betas abc -o me.glb"), &["--betas abc: must be numbers"]),
        (
            format!(
                "avatar none.uvpair none.png --body demo --betas 1 {} -o me.glb",
                "--onto a.png"
            ),
            &["--betas", "--body demo"],
        ),
        (format!("{start} --onto #c08a70 -o me.glb"), &["--size is required"]),
        (format!("{with} --blend none --feather 2mm -o me.glb"), &["--feather", "--blend none"]),
        (
            format!("{with} --map height=h.png -o me.glb"),
            &["--map height", "must be one of", "roughness"],
        ),
        (
            format!("{with} --map normal=a.png --map normal=b.png -o me.glb"),
            &["normal=b.png", "given twice"],
        ),
        (
            format!("{with} --map orm=a.png --map ao=b.png -o me.glb"),
            &["--map orm", "cannot be used with"],
        ),
        (format!("{with} --map normal -o me.glb"), &["ROLE=FILE"]),
        (
            format!("{with} --onto b.png -o me.glb"),
            &["--onto b.png", "colour texture given twice", "ROLE=IMAGE"],
        ),
        (
            format!("{start} --onto normal=b.png -o me.glb"),
            &["--onto", "must include the body's colours"],
        ),
        (format!("{with} --look mtoon -o me.glb"), &["--look mtoon", ".vrm"]),
        (
            format!("{with} --look mtoon {WHOSE} --map roughness=a.png -o me.vrm"),
            &["--look mtoon", "got roughness"],
        ),
        (format!("{with} --look unlit --map normal=a.png -o me.glb"), &["--look unlit", "normal"]),
        (format!("{with} --lods-as msft -o me.glb"), &["--lods"]),
        (format!("{with} --lods 9 -o me.glb"), &["--lods", "from 1 to 6"]),
        #[cfg(feature = "simplify")]
        (format!("{with} --lods 2 --lods-as msft {WHOSE} -o me.vrm"), &["--lods-as msft", ".glb"]),
        (format!("{with} --texture-layout cube -o me.glb"), &["head+body"]),
        (format!("{with} -o me.glb"), &["none.uvpair: ", "No such file"]),
    ] {
        bench.refuse(&command, wanted);
    }
}
