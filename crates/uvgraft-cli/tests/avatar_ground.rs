//! Avatars that stand: bodies of every kind, with shapes and presets, as GLB and VRM, at rest and
//! in clips; and messages about the recorded people.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use uvgraft::{Channels, Mesh};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyKind, BodyModel, Shape};
use uvgraft_avatar::motion::{ClipOptions, GroundMode, Motion};
use uvgraft_figure::Figure;
use uvgraft_figure::motion::as_amass;
use uvgraft_gltf::scene::{PoseRequest, Scene};
use uvgraft_io::arrays::{self, NamedArrays, NumericArray};
use uvgraft_io::pair_file;
use uvgraft_tests::walkers;

use crate::bench::Bench;

/// The lowest vertex at rest, and in clips.
const AT_REST_M: f32 = 0.001;
const IN_CLIPS_M: f32 = 0.01;
const WHOSE: &str = "--author Nobody --license only-author";
const COMMAND: &str = "avatar demo.uvpair face.png --onto #c08a70 --size 16 --blend none --unit m";

fn save(bench: &Bench, name: &str, arrays: &NamedArrays) {
    arrays::save_npz(arrays, bench.path(name)).unwrap();
}

fn floats(shape: &[usize], values: Vec<f32>) -> NumericArray {
    NumericArray::new_f32(shape.to_vec(), values).unwrap()
}

/// The figure's pair, and a face of one colour.
fn demo() -> Bench {
    let bench = Bench::new();
    bench.paint("face.png", (8, 8), Channels::Rgb, &[200, 150, 120]);
    let figure = Figure::new();
    bench.save_pair("demo.uvpair", figure.head, figure.body, &figure.vertex_map);
    bench
}

/// Saves a model with the pair's triangles: a pair may have flipped quads' diagonals to match the
/// head.
fn save_model(bench: &Bench, name: &str, arrays: &NamedArrays) {
    let file = pair_file::read(bench.path("demo.uvpair")).unwrap();
    let faces = file.pair.target().faces();
    let corners = faces.as_flattened().iter().map(|&vertex| i64::from(vertex)).collect();
    let mut arrays = arrays.clone();
    arrays.insert("f", NumericArray::new_i64(vec![faces.len(), 3], corners).unwrap());
    save(bench, name, &arrays);
}

/// The lowest vertex of an avatar file.
fn lowest(scene: &Scene, posing: &PoseRequest) -> f32 {
    let drawn = scene.pose(posing).unwrap();
    let heights = drawn.iter().flat_map(|part| &part.positions).map(|place| place[1]);
    heights.fold(f32::MAX, f32::min)
}

fn scene(bench: &Bench, name: &str) -> Scene {
    Scene::load(bench.path(name)).unwrap()
}

/// The figure's walk performed by a person of a model, standing on the floor.
fn walk(model: &BodyModel, layout: &Mesh, seed: u32) -> NamedArrays {
    let figure = Figure::new().avatar();
    let clip = figure.clips.iter().find(|clip| clip.name == "walk").unwrap();
    let clip = walkers::forwards(clip);
    let arrays = as_amass(&figure.skeleton, &clip);
    let mut motion = NamedArrays::new();
    motion.insert("poses", floats(&[arrays.frames, 156], arrays.poses));
    motion.insert("trans", floats(&[arrays.frames, 3], arrays.trans));
    motion.insert("mocap_framerate", floats(&[], vec![30.0]));
    let betas = walkers::betas(seed);
    let shape = Shape { betas: betas.clone(), ..Shape::default() };
    let shaped = model.shaped(&shape).unwrap();
    let avatar: Avatar = shaped.avatar(layout.clone()).unwrap().standing().unwrap();
    let soles = avatar.soles();
    let options =
        ClipOptions { ground: GroundMode::Feet, soles: soles.as_ref(), ..ClipOptions::default() };
    let motion = Motion::from_arrays(&motion).unwrap();
    let (clip, _) = motion.clip(&avatar.skeleton, "walk", &options).unwrap();
    let moved = (glam::Vec3::new(3.0, 0.05, 1.0), 0.0);
    let mut recorded = walkers::recorded(&shaped, &avatar, &clip, moved, true);
    recorded.insert("betas", floats(&[betas.len()], betas));
    recorded
}

fn numbers(betas: &[f32]) -> String {
    betas.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

#[test]
fn every_body_stands_on_the_floor() {
    let bench = demo();
    let layout = Figure::new().body;
    let mut lines = Vec::new();
    for kind in [BodyKind::Smpl, BodyKind::SmplH, BodyKind::SmplX] {
        let arrays = walkers::model(kind);
        let model = BodyModel::from_arrays(&arrays).unwrap();
        save_model(&bench, "model.npz", &arrays);
        save(&bench, "walk.npz", &walk(&model, &layout, 1));
        for seed in [2, 3] {
            lines.push(format!(
                "--body model.npz --betas {} --motion walk.npz",
                numbers(&walkers::betas(seed))
            ));
        }
        for line in lines.drain(..) {
            stands(&bench, &line, kind.name());
        }
    }
    stands(&bench, "--body demo", "figure");
    stands(&bench, "--body demo --motion walk.npz", "figure with a motion");
}

/// Writes GLB and VRM, full and simplified, and checks where they stand.
fn stands(bench: &Bench, options: &str, what: &str) {
    let presets: &[&str] = if cfg!(feature = "simplify") { &["", "--preset quest"] } else { &[""] };
    for (preset, extension) in presets.iter().flat_map(|&preset| [(preset, "glb"), (preset, "vrm")])
    {
        let whose = if extension == "vrm" { WHOSE } else { "" };
        bench.make(&format!("{COMMAND} {options} {preset} {whose} -o me.{extension}"));
        let scene = scene(bench, &format!("me.{extension}"));
        let case = format!("{what} {preset} {extension}");
        let low = lowest(&scene, &PoseRequest::default());
        assert!(low.abs() < AT_REST_M, "{case}: {low}");
        let feet = ["leftFoot", "rightFoot"]
            .map(|bone| scene.bone(bone, &PoseRequest::default()).unwrap().unwrap());
        for axis in [0, 2] {
            assert!((feet[0][axis] + feet[1][axis]).abs() < 2e-3, "{case}: {feet:?}");
        }
        let rest = scene.bone("hips", &PoseRequest::default()).unwrap().unwrap();
        for (number, clip) in scene.clips().iter().enumerate() {
            if clip.name != "walk" {
                continue;
            }
            let at =
                |seconds| PoseRequest { clip: Some((number, seconds)), ..PoseRequest::default() };
            let first = scene.bone("hips", &at(0.0)).unwrap().unwrap();
            let jump = [0, 2].map(|axis: usize| (first[axis] - rest[axis]).abs());
            assert!(jump[0] < 0.05 && jump[1] < 0.05, "{case}: jumps by {jump:?}");
            for frame in 0..20 {
                // One foot is on the ground at any time.
                let low = lowest(&scene, &at(frame as f32 / 30.0));
                assert!(
                    low.abs() < IN_CLIPS_M + if preset.is_empty() { 0.0 } else { 0.005 },
                    "{case} frame {frame}: {low}"
                );
            }
        }
    }
}

#[test]
fn vrms_show_what_glbs_show_from_a_t_pose() {
    let bench = demo();
    for options in ["--body demo", "--body model.npz --motion walk.npz"] {
        if options.contains("model") {
            let arrays = walkers::model(BodyKind::SmplX);
            let model = BodyModel::from_arrays(&arrays).unwrap();
            save(&bench, "walk.npz", &walk(&model, &Figure::new().body, 1));
            save_model(&bench, "model.npz", &arrays);
        }
        bench.make(&format!("{COMMAND} {options} -o me.glb"));
        bench.make(&format!("{COMMAND} {options} {WHOSE} -o me.vrm"));
        let [glb, vrm] = ["me.glb", "me.vrm"].map(|name| scene(&bench, name));
        for clip in 0..glb.clips().len() {
            let posing = PoseRequest { clip: Some((clip, 0.4)), ..PoseRequest::default() };
            let (a, b) = (glb.pose(&posing).unwrap(), vrm.pose(&posing).unwrap());
            let (a, b) = (a[0].positions.as_flattened(), b[0].positions.as_flattened());
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(a.len() == b.len() && apart < 1e-5, "{options}: {apart} m");
        }
        let bone = |name: &str| {
            let place = vrm.bone(name, &PoseRequest::default()).unwrap().unwrap();
            glam::Vec3::from(place)
        };
        for (side, out) in [("left", glam::Vec3::X), ("right", glam::Vec3::NEG_X)] {
            let aside = out + glam::Vec3::Z;
            let mut bones = vec![
                ("UpperArm".to_owned(), "LowerArm".to_owned(), out),
                ("LowerArm".to_owned(), "Hand".to_owned(), out),
                ("Hand".to_owned(), "MiddleProximal".to_owned(), out),
                ("ThumbMetacarpal".to_owned(), "ThumbProximal".to_owned(), aside),
                ("ThumbProximal".to_owned(), "ThumbDistal".to_owned(), aside),
            ];
            for finger in ["Index", "Middle", "Ring", "Little"] {
                for [from, to] in [["Proximal", "Intermediate"], ["Intermediate", "Distal"]] {
                    bones.push((format!("{finger}{from}"), format!("{finger}{to}"), out));
                }
            }
            for (from, to, wanted) in bones {
                let along = bone(&format!("{side}{to}")) - bone(&format!("{side}{from}"));
                let off = along.angle_between(wanted).to_degrees();
                assert!(off < 0.1, "{options}: {side}{from} is {off}° off");
            }
        }
    }
}

#[test]
fn people_who_are_not_known_are_reported() {
    let bench = demo();
    let arrays = walkers::model(BodyKind::SmplH);
    let model = BodyModel::from_arrays(&arrays).unwrap();
    save_model(&bench, "model.npz", &arrays);
    save_model(&bench, "SMPLH_MALE.npz", &arrays);
    let walk = walk(&model, &Figure::new().body, 1);
    let said = |change: &dyn Fn(&mut NamedArrays), options: &str| {
        let mut walk = walk.clone();
        change(&mut walk);
        save(&bench, "walk.npz", &walk);
        let run = bench.run(&format!("{COMMAND} {options} --motion walk.npz -o me.glb"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        (run.stdout, run.stderr)
    };
    let (stdout, stderr) = said(&|_| {}, "--body model.npz");
    assert!(stdout.contains("walk: from the recorded person; feet planted in"), "{stdout}");
    assert!(
        stdout.contains("recorded ground at 5.") && !stderr.contains("note: walk"),
        "{stdout}{stderr}"
    );
    let by_feet = |(stdout, stderr): (String, String), why: &str| {
        assert!(stdout.contains("walk: from the avatar's feet"), "{stdout}");
        assert!(
            stderr.contains("walk.npz: falling back to --ground feet") && stderr.contains(why),
            "{stderr}"
        );
    };
    by_feet(said(&|walk| drop(walk.take("betas")), "--body model.npz"), "no betas");
    let female = |walk: &mut NamedArrays| walk.insert_text("gender", "female");
    by_feet(
        said(&female, "--body SMPLH_MALE.npz"),
        "uses the female model, but the body the male one",
    );
    by_feet(said(&female, "--body model.npz"), "neither the body's file nor its name");
    by_feet(said(&female, "--body demo"), "the demo figure");
    let of_smplx = |walk: &mut NamedArrays| walk.insert_text("surface_model_type", "smplx");
    by_feet(said(&of_smplx, "--body model.npz"), "for SMPL-X, but the body is SMPL-H");
    let male = |walk: &mut NamedArrays| walk.insert_text("gender", "b'male'");
    let (stdout, _) = said(&male, "--body SMPLH_MALE.npz");
    assert!(stdout.contains("from the recorded person"), "{stdout}");
    let (stdout, stderr) = said(&female, "--body model.npz --ground keep");
    assert!(
        stdout.contains("walk: translations as recorded") && !stderr.contains("note: walk"),
        "{stdout}"
    );
    let (stdout, _) = said(&|walk| drop(walk.take("trans")), "--body model.npz");
    assert!(stdout.contains("the recording has no translations"), "{stdout}");
    // A shape that no person has.
    let (_, stderr) = said(&|_| {}, "--body model.npz --betas 0,5.5,-7");
    assert!(stderr.contains("warning: --betas: coefficient 3 of 3 is -7"), "{stderr}");
    let lying = |walk: &mut NamedArrays| {
        walk.take("trans");
        let shape = walk.get("poses").unwrap().shape().to_vec();
        walk.insert("poses", floats(&shape, vec![0.0; shape.iter().product()]));
    };
    let (stdout, _) = said(&lying, "--body model.npz");
    assert!(stdout.contains("Y up"), "{stdout}");
    let unclear = |walk: &mut NamedArrays| {
        lying(walk);
        let shape = walk.get("poses").unwrap().shape().to_vec();
        let mut poses = vec![0.0; shape.iter().product()];
        poses.chunks_mut(shape[1]).for_each(|row| row[2] = 1.57);
        walk.insert("poses", floats(&shape, poses));
    };
    let (_, stderr) = said(&unclear, "--body model.npz");
    assert!(stderr.contains("walk.npz: cannot tell the up axis"), "{stderr}");
    let (_, stderr) = said(&unclear, "--body model.npz --up y");
    assert!(!stderr.contains("up axis"), "{stderr}");
    for option in ["--ground feet", "--up y"] {
        bench.refuse(&format!("{COMMAND} --body model.npz {option} -o me.glb"), &["--motion"]);
    }
}

#[test]
fn implausible_motions_are_reported() {
    let bench = demo();
    let arrays = walkers::model(BodyKind::SmplH);
    let model = BodyModel::from_arrays(&arrays).unwrap();
    save_model(&bench, "model.npz", &arrays);
    let walk = walk(&model, &Figure::new().body, 1);
    let run = |change: &dyn Fn(&mut NamedArrays), options: &str| {
        let mut walk = walk.clone();
        change(&mut walk);
        save(&bench, "walk.npz", &walk);
        let command = format!("{COMMAND} --body model.npz {options} --motion walk.npz -o me.glb");
        let run = bench.run(&command);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run
    };
    let mapped = |key: &str, change: &dyn Fn(usize, f32) -> f32, walk: &mut NamedArrays| {
        let array = walk.take(key).unwrap();
        let values =
            array.f32s().iter().enumerate().map(|(at, &value)| change(at, value)).collect();
        walk.insert(key, floats(array.shape(), values));
    };
    let quiet = run(&|_| {}, "");
    assert!(!quiet.stderr.contains("walk.npz"), "{}", quiet.stderr);
    for (scale, unit) in [(100.0, "centimetres"), (1000.0, "millimetres"), (39.37, "inches")] {
        let said = run(&|walk| mapped("trans", &|_, value| value * scale, walk), "").stderr;
        assert!(said.contains("warning: walk.npz: the hips ") && said.contains(unit), "{said}");
    }
    // Turned over about X: Y and Z change their signs.
    let said = run(&|_| {}, "--up -z").stderr;
    assert!(said.contains("upside down with -Z up; use --up z?"), "{said}");
    let rate = |walk: &mut NamedArrays| walk.insert("mocap_framerate", floats(&[], vec![1000.0]));
    let said = run(&rate, "").stderr;
    assert!(said.contains("walk.npz: recorded at 1000 frames per second"), "{said}");
    let rateless = |walk: &mut NamedArrays| drop(walk.take("mocap_framerate"));
    let said = run(&rateless, "--fps 30").stderr;
    assert!(said.contains("note: walk.npz: states no frame rate; using 30"), "{said}");
    let assumed = bench.bytes("me.glb");
    run(&|_| {}, "");
    assert!(assumed == bench.bytes("me.glb"), "the same rate, stated and given");
    let said = run(&|_| {}, "--fps 60").stderr;
    assert!(said.contains("walk.npz: --fps has no effect: the recording has 30"), "{said}");
    let smiling = |walk: &mut NamedArrays| walk.insert("expression", floats(&[2, 3], vec![0.5; 6]));
    let said = run(&smiling, "").stderr;
    assert!(said.contains("warning: walk.npz: not used") && said.contains("[2, 3]"), "{said}");
    let one = |walk: &mut NamedArrays| {
        for key in ["poses", "trans"] {
            let array = walk.take(key).unwrap();
            let columns = array.shape()[1];
            walk.insert(key, floats(&[1, columns], array.f32s()[..columns].to_vec()));
        }
    };
    assert!(run(&one, "").stderr.contains("walk.npz: one frame, so the animation is a pose"));
}

#[test]
fn video_captures_with_y_down_stand_upright() {
    let bench = demo();
    let arrays = walkers::model(BodyKind::SmplH);
    let model = BodyModel::from_arrays(&arrays).unwrap();
    save_model(&bench, "model.npz", &arrays);
    let walk = walk(&model, &Figure::new().body, 1);
    // From Z up to the axes of a camera in front: Y down, Z forwards.
    let axes = glam::Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    for (distance, options) in [(0.0, ""), (5.0, ""), (5.0, "--up -y"), (5.0, "--ground feet")] {
        let mut turned = walk.clone();
        let poses = turned.take("poses").unwrap();
        let mut values = poses.f32s().into_owned();
        let frames = poses.shape()[0];
        let mut places = turned.take("trans").unwrap().f32s().into_owned();
        let pelvis = {
            let betas = walk.get("betas").unwrap().f32s().into_owned();
            let shaped = model.shaped(&Shape { betas, ..Shape::default() }).unwrap();
            glam::Vec3::from(shaped.skeleton().joints()[0].position)
        };
        for (row, place) in values.chunks_mut(156).zip(places.chunks_mut(3)) {
            let root = glam::Quat::from_scaled_axis(glam::Vec3::from_slice(&row[..3]));
            row[..3].copy_from_slice(&(axes * root).to_scaled_axis().to_array());
            let hips = axes * (glam::Vec3::from_slice(place) + pelvis) - pelvis;
            place.copy_from_slice(&(hips + glam::Vec3::Z * distance).to_array());
        }
        turned.insert("poses", floats(&[frames, 156], values));
        turned.insert("trans", floats(&[frames, 3], places));
        save(&bench, "turned.npz", &turned);
        let run = bench
            .run(&format!("{COMMAND} --body model.npz --motion turned.npz {options} -o me.glb"));
        assert!(run.code == Some(0) && !run.stderr.contains("turned.npz"), "{}", run.stderr);
        assert!(run.stdout.contains(", -Y up"), "{}", run.stdout);
        let scene = scene(&bench, "me.glb");
        for frame in 0..20 {
            let posing =
                PoseRequest { clip: Some((0, frame as f32 / 30.0)), ..PoseRequest::default() };
            let low = lowest(&scene, &posing);
            assert!(low.abs() < IN_CLIPS_M, "{options} {frame}: {low}");
            let [head, foot] =
                ["head", "leftFoot"].map(|bone| scene.bone(bone, &posing).unwrap().unwrap()[1]);
            assert!(head - foot > 1.0, "{options} {frame}: {head} {foot}");
        }
    }
}

#[test]
fn clips_that_are_kept_far_away_are_reported() {
    let bench = demo();
    let arrays = walkers::model(BodyKind::SmplH);
    let model = BodyModel::from_arrays(&arrays).unwrap();
    save_model(&bench, "model.npz", &arrays);
    let walk = walk(&model, &Figure::new().body, 1);
    let run = |by: [f32; 3], options: &str| {
        let mut away = walk.clone();
        let mut places = away.take("trans").unwrap().f32s().into_owned();
        places.iter_mut().enumerate().for_each(|(at, value)| *value += by[at % 3]);
        away.insert("trans", floats(&[places.len() / 3, 3], places));
        save(&bench, "away.npz", &away);
        let command = format!("{COMMAND} --body model.npz {options} --motion away.npz -o me.glb");
        let run = bench.run(&command);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr
    };
    let said = run([37.0, 0.0, 0.0], "--ground keep");
    assert!(said.contains("note: away.npz: starts 40.0 m from the origin"), "{said}");
    assert!(said.contains("use --ground clip or feet to start on"), "{said}");
    let said = run([0.0, 0.0, 5.0], "--ground keep");
    assert!(said.contains("above where the avatar stands"), "{said}");
    for (by, options) in [
        ([0.0, 0.0, 0.0], "--ground keep"),
        ([4.0, -2.0, 0.1], "--ground keep"),
        ([37.0, 0.0, 0.0], ""),
        ([-370.0, 40.0, 5.0], "--ground feet"),
    ] {
        let said = run(by, options);
        assert!(!said.contains("away.npz: starts"), "{by:?} {options}: {said}");
        let scene = scene(&bench, "me.glb");
        let first = PoseRequest { clip: Some((0, 0.0)), ..PoseRequest::default() };
        let hips = scene.bone("hips", &first).unwrap().unwrap();
        let far = if options == "--ground keep" { 10.0 } else { 0.05 };
        assert!(hips[0].hypot(hips[2]) < far, "{by:?} {options}: {hips:?}");
    }
}

#[test]
fn what_a_model_lacks_or_has_too_much_of() {
    let bench = demo();
    let mut arrays = walkers::model(BodyKind::SmplH);
    assert!(arrays.get("posedirs").is_none() && arrays.get("hands_componentsl").is_none());
    arrays.insert("dd", floats(&[1, 3], vec![0.0; 3]));
    arrays.insert("allow_pickle", floats(&[], vec![1.0]));
    save_model(&bench, "model.npz", &arrays);
    let command = format!("{COMMAND} --body model.npz -o me.glb");
    let quiet = bench.run(&command);
    assert!(quiet.code == Some(0) && !quiet.stderr.contains("unused"), "{}", quiet.stderr);
    let said = bench.run(&format!("{command} --verbose"));
    assert!(said.stderr.contains("note: model.npz: unused: dd, allow_pickle"), "{}", said.stderr);
}

#[test]
fn correctives_of_any_shape_leave_the_rig_alone() {
    let bench = demo();
    let mut arrays = walkers::model(BodyKind::SmplX);
    let vertices = arrays.get("v_template").unwrap().shape()[0];
    let command = format!("{COMMAND} --body model.npz -o me.glb");
    let mut run_with = |shape: &[usize]| {
        arrays.insert("posedirs", floats(shape, vec![0.0; shape.iter().product()]));
        save_model(&bench, "model.npz", &arrays);
        bench.run(&command)
    };
    for shape in [[3 * vertices, 486], [486, 3 * vertices]] {
        let run = run_with(&shape);
        assert!(run.code == Some(0) && !run.stderr.contains("corrective"), "{run:?}");
    }
    for shape in [vec![vertices, 3, 93], vec![486 * vertices, 3], vec![vertices, 3, 207]] {
        let run = run_with(&shape);
        let said = format!(
            "note: model.npz: pose correctives are left out: `posedirs` must have shape \
             [{vertices}, 3, 486], got {shape:?}"
        );
        assert!(run.code == Some(0) && run.stderr.contains(&said), "{run:?}");
    }
}
