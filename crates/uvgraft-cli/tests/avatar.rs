//! `uvgraft avatar` through the program: the demo's figure, body models, FATE's textures, and
//! rejected input.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use uvgraft::{Channels, Mesh, Texels, Texture};
use uvgraft_avatar::body::{BodyKind, BodyModel, Shape};
use uvgraft_figure::Figure;
use uvgraft_figure::motion::as_amass;
use uvgraft_gltf::preset::Preset;
use uvgraft_gltf::scene::{PoseRequest, Scene};
use uvgraft_io::arrays::{self, NamedArrays, NumericArray};
use uvgraft_io::torch;
use uvgraft_tests::bodies;

use crate::bench::{Bench, texel_u8};

const SIDE: u32 = 256;
const WHOSE: &str = "--author Nobody --license only-author";
/// The common start of the demo's commands.
const DEMO: &str = "avatar demo.uvpair face.png --onto base.png --unit m --body demo";

fn floats(shape: &[usize], values: Vec<f32>) -> NumericArray {
    NumericArray::new_f32(shape.to_vec(), values).unwrap()
}

fn save(bench: &Bench, name: &str, arrays: &NamedArrays) {
    arrays::save_npz(arrays, bench.path(name)).unwrap();
}

/// The figure's pair, its face, its body with darker skin, and its wave.
fn demo() -> Bench {
    let figure = Figure::new();
    let bench = Bench::of_figure(&figure, SIDE);
    let avatar = figure.avatar();
    let wave = avatar.clips.iter().find(|clip| clip.name == "wave").unwrap();
    let wave = as_amass(&avatar.skeleton, wave);
    let mut motion = NamedArrays::new();
    motion.insert("poses", floats(&[wave.frames, 156], wave.poses));
    motion.insert("trans", floats(&[wave.frames, 3], wave.trans));
    motion.insert("mocap_framerate", floats(&[], vec![wave.mocap_framerate]));
    save(&bench, "wave.npz", &motion);
    bench
}

/// Saves a model's triangles with the vertices in rows of a layout, as a pair of the mesh with
/// itself.
fn save_model_pair(bench: &Bench, name: &str, model: &BodyModel) {
    let (count, row) = (model.vertices(), 103);
    let at = |index: usize| index as f32 / (row - 1) as f32;
    let uv: Vec<[f32; 2]> = (0..count).map(|vertex| [at(vertex % row), at(vertex / row)]).collect();
    let faces = model.triangles();
    let mesh = Mesh::from_triangles(vec![[0.0; 3]; count], uv, faces, faces).unwrap();
    let ids: Vec<u32> = (0..count as u32).collect();
    bench.save_pair(name, mesh.clone(), mesh, &ids);
}

fn scene(bench: &Bench, name: &str) -> Scene {
    Scene::load(bench.path(name)).unwrap()
}

/// The texture of an avatar file.
fn texture(bench: &Bench, name: &str) -> Texture {
    let scene = scene(bench, name);
    let [texture] = scene.textures() else { panic!("{name}: one texture") };
    texture.clone()
}

fn bytes(texture: &Texture) -> &[u8] {
    let Texels::U8(bytes) = texture.texels() else { panic!("8 bits") };
    bytes
}

/// The differences between two textures of the same format.
fn differences(a: &Texture, b: &Texture) -> Vec<u8> {
    assert_eq!((a.size(), a.channels()), (b.size(), b.channels()));
    bytes(a).iter().zip(bytes(b)).map(|(a, b)| a.abs_diff(*b)).collect()
}

fn mean(differences: &[u8]) -> f64 {
    differences.iter().map(|&value| f64::from(value)).sum::<f64>() / differences.len() as f64
}

/// The first number in a row of the summary.
fn stated(summary: &str, row: &str) -> usize {
    let line = summary.lines().find(|line| line.starts_with(row)).unwrap();
    let number = line.split_whitespace().nth(1).unwrap();
    number.replace(',', "").parse().unwrap()
}

#[test]
fn the_demo_becomes_an_avatar_for_each_platform() {
    let bench = demo();
    bench.succeed(
        "transfer demo.uvpair face.png --onto base.png --blend membrane --tone source --unit m -o body.png",
    );
    let (base, body) = (bench.texture("base.png"), bench.texture("body.png"));
    // The head's islands cover a good part of the body's layout.
    let changed = differences(&base, &body).iter().filter(|&&value| value > 2).count();
    assert!(changed * 20 > bytes(&base).len(), "{changed} values");
    let figure = Figure::new();
    let (whole, joints) = (figure.body.faces().len(), figure.avatar().skeleton.joints().len());
    let mut names = Vec::new();
    let presets = std::iter::once(None).chain(Preset::ALL.map(Some));
    for (preset, extension) in presets.flat_map(|preset| [(preset, "glb"), (preset, "vrm")]) {
        let option = preset.map_or_else(String::new, |preset| format!("--preset {}", preset.name));
        let budget = preset.map_or(usize::MAX, |preset| preset.triangles);
        let name = format!("{}.{extension}", preset.map_or("plain", |preset| preset.name));
        let whose = if extension == "vrm" { WHOSE } else { "--author Nobody" };
        let command = format!("{DEMO} --motion wave.npz {whose} {option} -o {name}");
        if whole > budget && !cfg!(feature = "simplify") {
            bench.refuse(&command, &["at most", &budget.to_string(), "feature `simplify`"]);
            continue;
        }
        let summary = bench.make(&command);
        let scene = scene(&bench, &name);
        let triangles = stated(&summary, "mesh");
        assert_eq!(triangles, scene.triangles(), "{name}");
        assert!(triangles <= budget, "{name}: {triangles}\n{summary}");
        assert_eq!(triangles < whole, whole > budget, "{name}: {triangles} of {whole}");
        assert_eq!(stated(&summary, "joints"), joints, "{summary}");
        let clips: Vec<&str> = scene.clips().iter().map(|clip| &*clip.name).collect();
        assert_eq!(clips, ["wave"], "{name}");
        let differences = differences(&texture(&bench, &name), &body);
        if name.starts_with("web.") {
            // A JPEG with quality 92 and chroma at half the resolution, and a mouth.
            assert!(mean(&differences) < 4.0, "{name}: {}", mean(&differences));
        } else {
            // The same processing except for the last rounding, and what is painted into free
            // space: mouth and second eye.
            let painted = differences.iter().filter(|&&value| value > 1).count();
            assert!(painted * 30 < differences.len(), "{name}: {painted} of {}", differences.len());
        }
        names.push(name);
    }
    bench.assert_valid(&names);
}

#[test]
fn mouth_and_eyes_are_as_they_are_asked_for() {
    let bench = demo();
    let whole = Figure::new().body.faces().len();
    let run = |options: &str, name: &str| bench.make(&format!("{DEMO} {options} -o {name}"));
    let fitted = run("", "fitted.glb");
    assert!(fitted.contains("cavity, teeth and tongue"), "{fitted}");
    assert!(stated(&fitted, "mesh") > whole + 500, "{fitted}");
    let none = run("--mouth none", "none.glb");
    assert_eq!(stated(&none, "mesh"), whole);
    assert!(!none.contains("cavity"), "{none}");
    run("--mouth none --eyes clean", "clean.glb");
    // Two eyes of 20 texels across, out of 256², with their gutters.
    let drawn = differences(&texture(&bench, "none.glb"), &texture(&bench, "clean.glb"));
    let changed = drawn.chunks(3).filter(|texel| texel.iter().any(|&value| value > 0)).count();
    assert!((400..1500).contains(&changed), "{changed} texels");
    bench.refuse(&format!("{DEMO} --mouth open -o a.glb"), &["--mouth", "fitted", "none"]);
    bench.assert_valid(&["fitted.glb".to_owned(), "clean.glb".to_owned()]);
}

#[test]
fn a_body_model_moves_as_smplx_says() {
    // Chains of rotations in 32-bit floats, and fixtures rounded to a micrometre: the largest
    // difference was 0.8 µm.
    const TOLERANCE_M: f64 = 1e-5;
    let bench = Bench::new();
    let arrays = bodies::synthetic_model_with(BodyKind::SmplX, 20);
    let model = BodyModel::from_arrays(&arrays).unwrap();
    save(&bench, "model.npz", &arrays);
    drop(arrays);
    save_model_pair(&bench, "model.uvpair", &model);
    let case = bodies::fixtures().clips.into_iter().find(|case| case.kind == "smplx").unwrap();
    let motion = bodies::synthetic_motion(BodyKind::SmplX, case.frames);
    save(&bench, "walk.npz", &motion);
    let betas = motion.get("betas").unwrap().f32s().into_owned();
    bench.paint("face.png", (8, 8), Channels::Rgb, &[200, 150, 120]);
    let command = "avatar model.uvpair face.png --onto #c08a70 --size 64 --blend none --body model.npz \
                   --motion walk.npz --fps 0 --ground keep --up z --title me";
    let numbers: Vec<String> = betas.iter().map(ToString::to_string).collect();
    let numbers = numbers.join(",");
    let summary = bench.make(&format!("{command} --betas {numbers} -o me.glb"));
    assert_eq!(stated(&summary, "joints"), 55);
    assert!(summary.contains(&format!("{} frames", case.frames)), "{summary}");
    assert!(summary.contains("no pose correctives"), "{summary}");
    bench.make(&format!("{command} --betas walk.npz -o same.glb"));
    assert_eq!(bench.bytes("me.glb"), bench.bytes("same.glb"));
    bench.make(&format!("{command} -o mean.glb"));
    assert_ne!(bench.bytes("me.glb"), bench.bytes("mean.glb"));
    bench.make(&format!("{command} --betas walk.npz {WHOSE} -o me.vrm"));
    bench.assert_valid(&["me.glb".to_owned(), "me.vrm".to_owned()]);

    let shaped = model.shaped(&Shape { betas, ..Shape::default() }).unwrap();
    // The bones of a GLB have common names, which omit most fingers.
    for (name, bones) in [("me.glb", 26), ("me.vrm", 55)] {
        let scene = scene(&bench, name);
        let mut farthest = 0.0_f64;
        for (frame, joints) in case.joints.iter().enumerate() {
            let posing =
                PoseRequest { clip: Some((0, frame as f32 / 120.0)), ..PoseRequest::default() };
            let mut found = 0;
            for (joint, wanted_um) in shaped.skeleton().joints().iter().zip(joints.chunks(3)) {
                let bone = joint.human.unwrap().name();
                let Some([x, y, z]) = scene.bone(bone, &posing).unwrap() else { continue };
                found += 1;
                // The file has Y up, the fixtures Z up.
                for (found, &wanted) in [x, -z, y].into_iter().zip(wanted_um) {
                    farthest = farthest.max((f64::from(found) - f64::from(wanted) / 1e6).abs());
                }
            }
            assert!(found >= bones, "{name}: {found} bones");
        }
        assert!(farthest < TOLERANCE_M, "{name}: {farthest} m");
    }
}

/// A dump of 64 by 64: red increases to the right and green upwards, each from 0.1 to 0.9.
///
/// - `opacity`: before its sigmoid, by column.
fn dump(opacity: impl Fn(usize) -> f32) -> NamedArrays {
    const N: usize = 64;
    let raw = |color: f32| (2.0 * color - 1.0).atanh();
    let at = |index: usize| 0.1 + 0.8 * index as f32 / (N - 1) as f32;
    let red = (0..N * N).map(|texel| raw(at(texel % N)));
    // Row 0 is at the bottom.
    let green = (0..N * N).map(|texel| raw(at(texel / N)));
    let blue = (0..N * N).map(|_| raw(0.3));
    let mut arrays = NamedArrays::new();
    arrays.insert("color", floats(&[1, 3, N, N], red.chain(green).chain(blue).collect()));
    let opacity = (0..N * N).map(|texel| opacity(texel % N)).collect();
    arrays.insert("opacity", floats(&[1, 1, N, N], opacity));
    arrays
}

#[test]
fn what_fate_baked_is_a_face() {
    const BASE: [u8; 3] = [0x20, 0x40, 0xe0];
    let bench = demo();
    bench.make_folder("workspace/baking/dump_texture");
    let save =
        |name: &str, arrays: &NamedArrays| torch::save_pth(arrays, bench.path(name)).unwrap();
    save("sure.pth", &dump(|_| 12.0));
    save("workspace/baking/dump_texture/00001_tex_dump.pth", &dump(|_| 12.0));
    save("half.pth", &dump(|column| if column < 26 { -12.0 } else { 12.0 }));
    let picture = |x: u32, y: u32| {
        let at = |place: f32| ((0.1 + 0.8 * place) * 255.0).round() as u8;
        let middle = |texel: u32| (texel as f32 + 0.5) / 1024.0;
        [at(middle(x)), at(1.0 - middle(y)), (0.3_f32 * 255.0).round() as u8]
    };
    bench.draw("sure.png", (1024, 1024), picture);
    // Left and right of the column where the opacity changes, 26 of 63.
    bench.draw("left.png", (256, 256), |x, _| if x < 90 { [255] } else { [0] });
    bench.draw("right.png", (256, 256), |x, _| if x > 125 { [255] } else { [0] });
    for side in ["left", "right"] {
        bench.succeed(&format!(
            "transfer demo.uvpair {side}.png --onto #000000 --size 256 --filter nearest -o {side}_body.png"
        ));
    }
    let make = |face: &str, blend: &str, name: &str| {
        bench.succeed(&format!(
            "avatar demo.uvpair {face} --onto #2040e0 --size 256 --unit m --body demo --mouth none --blend {blend} \
             --title me -o {name}"
        ));
        texture(&bench, name)
    };
    let sure = make("sure.pth", "none", "sure.glb");
    // Rounded to 8 bits twice: before the transfer and after it.
    let drawn = make("sure.png", "none", "drawn.glb");
    assert!(differences(&sure, &drawn).iter().all(|&value| value <= 1));
    make("workspace", "none", "found.glb");
    assert_eq!(bench.bytes("sure.glb"), bench.bytes("found.glb"));
    // A colour ramp is not skin.
    let tinted = bench.run(
        "avatar demo.uvpair sure.pth --onto #2040e0 --size 256 --unit m --body demo --tone base -o blended.glb",
    );
    assert_eq!(tinted.code, Some(0), "{}", tinted.stderr);
    assert!(
        tinted.stderr.contains("sure.pth: no skin detected on the cheeks"),
        "{}",
        tinted.stderr
    );
    assert_ne!(sure, texture(&bench, "blended.glb"));

    let half = make("half.pth", "none", "half.glb");
    let (left, right) = (bench.texture("left_body.png"), bench.texture("right_body.png"));
    let (mut counts, mut others) = ([0, 0], 0);
    for (x, y) in (0..256).flat_map(|y| (0..256).map(move |x| (x, y))) {
        let found = texel_u8(&half, x, y);
        if texel_u8(&left, x, y)[0] == 255 {
            // Except for the eye that now has its own island.
            others += usize::from(found != BASE);
            counts[0] += 1;
        } else if texel_u8(&right, x, y)[0] == 255 {
            let sure = texel_u8(&sure, x, y);
            assert!(found.iter().zip(&sure).all(|(a, b)| a.abs_diff(*b) <= 1), "{x} {y}");
            assert_ne!(found, BASE, "{x} {y}");
            counts[1] += 1;
        }
    }
    assert!(counts.iter().all(|&count| count > 500), "{counts:?}");
    assert!(others * 20 < counts[0], "{others} of {counts:?}");
}

/// The arrays without one of them, or with it replaced.
fn with(arrays: &NamedArrays, key: &str, array: Option<NumericArray>) -> NamedArrays {
    let mut changed = NamedArrays::new();
    for name in arrays.names().filter(|name| *name != key) {
        changed.insert(name, arrays.get(name).unwrap().clone());
    }
    if let Some(array) = array {
        changed.insert(key, array);
    }
    changed
}

/// An array with one value replaced.
fn spoilt(arrays: &NamedArrays, key: &str, at: usize, value: f32) -> Option<NumericArray> {
    let array = arrays.get(key).unwrap();
    let mut values = array.f32s().into_owned();
    values[at] = value;
    Some(floats(array.shape(), values))
}

/// A command for the system to create a file, if it is ever run.
const EVIL: &[u8] = b"cos\nsystem\n(S'touch owned'\ntR.";

/// A folder with a valid FLAME model, its pair and a face.
fn head() -> (Bench, NamedArrays) {
    let bench = Bench::new();
    let flame = bodies::synthetic_model_with(BodyKind::Flame, 20);
    save_model_pair(&bench, "head.uvpair", &BodyModel::from_arrays(&flame).unwrap());
    save(&bench, "flame.npz", &flame);
    bench.paint("face.png", (8, 8), Channels::Rgb, &[200, 150, 120]);
    bench.write("evil.pkl", EVIL);
    (bench, flame)
}

const HEAD: &str = "avatar head.uvpair face.png --onto #c08a70 --size 16 --blend none";

#[test]
fn broken_models_are_refused() {
    let (bench, flame) = head();
    let zeros = |shape: &[usize]| Some(floats(shape, vec![0.0; shape.iter().product()]));
    save(&bench, "dropped.npz", &with(&flame, "weights", None));
    save(&bench, "nan.npz", &with(&flame, "v_template", spoilt(&flame, "v_template", 7, f32::NAN)));
    save(&bench, "short.npz", &with(&flame, "weights", zeros(&[5022, 5])));
    save(&bench, "flat.npz", &with(&flame, "v_template", zeros(&[5023, 2])));
    let mut corners = flame.get("f").unwrap().integers().unwrap();
    corners[2] += 1000;
    let turned = NumericArray::new_i64(vec![9976, 3], corners).unwrap();
    save(&bench, "other.npz", &with(&flame, "f", Some(turned)));
    save(&bench, "smpl.npz", &bodies::synthetic_model_with(BodyKind::Smpl, 2));
    bench.derive("cut.npz", "flame.npz", |bytes| bytes.truncate(bytes.len() / 2));
    bench.write("prose.npz", "This is not a model.");
    bench.write("empty.npz", "");
    let cases: &[(&str, &[&str])] = &[
        ("none.npz", &["none.npz: ", "No such file"]),
        ("dropped.npz", &["dropped.npz: not a body model", "no array `weights`", "`shapedirs`"]),
        ("nan.npz", &["nan.npz: `v_template` must be finite", "got NaN at index 7"]),
        ("short.npz", &["short.npz: `weights`", "[5023, 5], got [5022, 5]"]),
        ("flat.npz", &["flat.npz: `v_template`", "[vertices, 3], got [5023, 2]"]),
        (
            "other.npz",
            &[
                "other.npz: body does not match the target mesh of head.uvpair",
                "1 of its 9976 triangles",
            ],
        ),
        ("smpl.npz", &["smpl.npz", "head.uvpair", "got 5023", "must have 6890 vertices"]),
        ("evil.pkl", &["evil.pkl: refused: the pickle imports os.system"]),
        ("cut.npz", &["cut.npz: archive: truncated or damaged"]),
        ("prose.npz", &["got a file that starts with", "prose.npz: must be an NPZ"]),
        ("empty.npz", &["got an empty file"]),
        ("demo", &["head.uvpair: --body demo needs the pair written by `uvgraft demo`", "5023"]),
    ];
    for (body, wanted) in cases {
        bench.refuse(&format!("{HEAD} --body {body} -o me.glb"), wanted);
    }
    // The model itself is valid.
    bench.make(&format!("{HEAD} --body flame.npz -o me.glb"));
}

#[test]
fn broken_motions_and_shapes_are_refused() {
    let (bench, _) = head();
    let walk = bodies::synthetic_motion(BodyKind::SmplH, 3);
    save(&bench, "walk.npz", &walk);
    save(&bench, "wide.npz", &with(&walk, "poses", Some(floats(&[3, 100], vec![0.0; 300]))));
    save(&bench, "nan.npz", &with(&walk, "poses", spoilt(&walk, "poses", 157, f32::NAN)));
    save(&bench, "still.npz", &with(&walk, "poses", None));
    save(&bench, "nan_betas.npz", &with(&walk, "betas", spoilt(&walk, "betas", 1, f32::NAN)));
    save(&bench, "shapeless.npz", &with(&walk, "betas", None));
    save(&bench, "rateless.npz", &with(&walk, "mocap_framerate", None));
    save(&bench, "degrees.npz", &with(&walk, "poses", Some(floats(&[3, 156], vec![70.0; 468]))));
    save(&bench, "matrices.npz", &with(&walk, "poses", Some(floats(&[3, 198], vec![0.0; 594]))));
    save(&bench, "never.npz", &with(&walk, "mocap_framerate", Some(floats(&[], vec![0.0]))));
    bench.derive("cut.npz", "walk.npz", |bytes| bytes.truncate(bytes.len() / 2));
    let cases: &[(&str, &[&str])] = &[
        ("--motion none.npz", &["none.npz: ", "No such file"]),
        ("--motion wide.npz", &["wide.npz: `poses` must have shape", "156 (SMPL-H)"]),
        ("--motion nan.npz", &["nan.npz: `poses` must be finite, got NaN in frame 1, value 1"]),
        ("--motion still.npz", &["still.npz: not a motion", "`poses`", "trans"]),
        ("--motion walk.npz", &["walk.npz: the skeleton of a motion", "must have hips"]),
        ("--motion evil.pkl", &["evil.pkl: refused: the pickle imports os.system"]),
        ("--motion cut.npz", &["cut.npz: archive: truncated or damaged"]),
        ("--betas abc", &["--betas abc: must be numbers", "got no such file", "a file"]),
        ("--betas 0.5,nan", &["got NaN"]),
        ("--betas -1,x", &["--betas -1,x: must be numbers", "got no such file"]),
        ("--betas nan_betas.npz", &["got NaN"]),
        ("--betas shapeless.npz", &["--betas shapeless.npz: must be numbers", "`betas`", "trans"]),
        ("--betas evil.pkl", &["evil.pkl: refused: the pickle imports os.system"]),
        ("--betas 0,0,0,0,0,0,0,0,0,0,1", &["this FLAME model takes at most 10 betas, got 11"]),
        ("--fps 999", &["--fps", "240"]),
        ("--fps 24", &["--motion"]),
        ("--motion walk.npz --up down", &["'down'", "y, z, -y, -z"]),
        (
            "--motion rateless.npz",
            &[
                "rateless.npz: use --fps to state the frame rate",
                "none of `mocap_framerate`",
                "`fps`",
            ],
        ),
        ("--motion rateless.npz --fps 0", &["rateless.npz: use --fps to state"]),
        ("--motion degrees.npz", &["degrees.npz: rotations must be in radians, got 121.2"]),
        ("--motion matrices.npz", &["matrices.npz: `poses`", "rotation vectors, not matrices"]),
        ("--motion never.npz", &["never.npz: the frame rate must be more than 0", "got 0"]),
        ("--ground feet", &["--motion"]),
    ];
    for (options, wanted) in cases {
        bench.refuse(&format!("{HEAD} --body flame.npz {options} -o me.glb"), wanted);
    }
}

#[test]
fn faces_outputs_and_options_are_checked() {
    let (bench, _) = head();
    let dump = dump(|_| 12.0);
    let save =
        |name: &str, arrays: &NamedArrays| torch::save_pth(arrays, bench.path(name)).unwrap();
    save("face.pth", &dump);
    bench.derive("cut.pth", "face.pth", |bytes| bytes.truncate(bytes.len() / 2));
    save("nan.pth", &with(&dump, "color", spoilt(&dump, "color", 3, f32::NAN)));
    save("grey.pth", &with(&dump, "color", Some(floats(&[1, 1, 64, 64], vec![0.0; 4096]))));
    bench.write("evil.pth", EVIL);
    bench.write("prose.png", "This is not a picture.");
    bench.make_folder("workspace/baking/dump_texture");
    for (face, wanted) in [
        ("none.png", &["none.png: ", "No such file"][..]),
        ("prose.png", &["prose.png: ", "not a supported image"]),
        ("cut.pth", &["cut.pth: archive: truncated or damaged"]),
        ("nan.pth", &["nan.pth: `color` must be finite, got 1 values"]),
        ("grey.pth", &["grey.pth: `color` must have shape [1, 3, N, N], got [1, 1, 64, 64]"]),
        ("evil.pth", &["evil.pth: ", "must be"]),
        ("workspace", &["workspace: ", "baking*/dump_texture", "visualize_texture", "must be"]),
    ] {
        let command = HEAD.replace("face.png", face);
        bench.refuse(&format!("{command} --body flame.npz -o me.glb"), wanted);
    }
    for name in ["head.glb", "flame.glb", "face.glb"] {
        let from = ["head.uvpair", "flame.npz", "face.png"];
        let from = from.into_iter().find(|from| from[..4] == name[..4]).unwrap();
        bench.derive(name, from, |_| {});
    }
    let sure = format!("{HEAD} --body flame.npz");
    for (command, wanted) in [
        (format!("{sure} -o me.gltf"), &["me.gltf: extension must be .glb or .vrm"][..]),
        (format!("{sure} -o me"), &["me: extension must be"]),
        (format!("{sure} -o none/me.glb"), &["none/me.glb", "folder none does not exist"]),
        (format!("{sure} -o me.vrm"), &["me.vrm: ", "--author NAME", "--license TERMS"]),
        (format!("{sure} --author Me -o me.vrm"), &["me.vrm: ", "--license TERMS", "everyone"]),
        (
            format!("{sure} {WHOSE} -o me.vrm"),
            &["flame.npz", "me.vrm", "`hips`", "`leftUpperLeg`"],
        ),
        (format!("{sure} --license mine -o me.vrm"), &["'mine'", "only-author"]),
        (format!("{sure} --license everyone -o me.glb"), &["--license is for", ".vrm"]),
        (format!("{sure} --quality 50 -o me.glb"), &["--quality", "--texture jpeg"]),
        (format!("{sure} --quality 50 --texture webp -o me.glb"), &["--quality"]),
        (format!("{sure} --quality 50 --preset quest -o me.glb"), &["--quality"]),
        (
            format!("{sure} --normal-y directx -o me.glb"),
            &["--normal-y directx has no effect without a normal map", "--map normal=FILE"],
        ),
        (
            format!("{sure} --normal-y directx --map roughness=face.png -o me.glb"),
            &["--normal-y directx has no effect"],
        ),
        (
            format!("{sure} --map ao=face.png --map occlusion=face.png -o me.glb"),
            &["--map occlusion=face.png: role given twice"],
        ),
        (
            format!("{sure} {WHOSE} --license-url terms.txt -o me.vrm"),
            &["--license-url must be a URL", "got \"terms.txt\""],
        ),
        (format!("{sure} {WHOSE} --license-url CC-BY -o me.vrm"), &["--license-url must be"]),
        (format!("{sure} {WHOSE} --license-url https:// -o me.vrm"), &["--license-url must be"]),
        (
            format!("{sure} {WHOSE} --license-url ftp://example.org -o me.vrm"),
            &["--license-url must be"],
        ),
        (
            "avatar head.uvpair face.png --onto #c08a70 --size 2048 --body flame.npz --preset quest -o me.glb"
                .to_owned(),
            &["2048×2048", "quest", "1024"],
        ),
        (format!("{sure} --preset ps5 -o me.glb"), &["'ps5'", "quest", "visionos"]),
        (format!("{HEAD} --body demo --betas 1 -o me.glb"), &["--betas", "--body demo"]),
        (sure.replace("--size 16", "") + " -o me.glb", &["--size"]),
        (sure.replace("#c08a70", "none.png") + " -o me.glb", &["none.png: ", "No such file"]),
        (sure.replace("head.uvpair", "face.png") + " -o me.glb", &["face.png: not a pair file"]),
        (sure.replace("head.uvpair", "head.glb") + " -o head.glb", &["head.glb is also an input"]),
        (sure.replace("flame.npz", "flame.glb") + " -o flame.glb", &["flame.glb is also an input"]),
        (sure.replace("face.png", "face.glb") + " -o face.glb", &["face.glb is also an input"]),
    ] {
        bench.refuse(&command, wanted);
    }
    // With the feature, both are accepted.
    #[cfg(not(feature = "ktx2"))]
    for more in ["", " --preset web"] {
        let command = format!("{sure} --texture ktx2{more} -o me.glb");
        bench.refuse(&command, &["--texture ktx2 needs", "feature `ktx2`", "use png"]);
    }
}

#[cfg(feature = "ktx2")]
#[test]
fn ktx2_textures_look_like_png() {
    let bench = demo();
    let [wanted, found] = ["png", "ktx2"].map(|format| {
        let name = format!("{format}.png");
        bench.make(&format!("{DEMO} --texture {format} -o me.glb"));
        bench.make(&format!("render me.glb --camera head --size 100x100 -o {name}"));
        bench.texture(&name)
    });
    let off = mean(&differences(&wanted, &found));
    assert!(off < 1.0, "{off}");
}
