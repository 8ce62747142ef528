//! Body models and motions against the Python package `smplx`: `fixtures/bodies.json`.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::collections::BTreeMap;
use std::io::Cursor;

use uvgraft::Mesh;
use uvgraft_avatar::body::{BodyError, BodyKind, BodyModel, BodyPose, Gender, Hand, Shape};
use uvgraft_avatar::motion::{ClipOptions, GroundMode, Motion, MotionError, UpAxis};
use uvgraft_avatar::rig::{ExpressionPreset, HumanBone, Pose};
use uvgraft_io::arrays::{self, NamedArrays, NumericArray};
use uvgraft_tests::{bodies, real};

/// In metres. Both implementations compute in 32-bit floats and sum in different orders; the
/// fixtures are rounded to a micrometre. The largest difference found was 1.3 µm.
const TOLERANCE_M: f32 = 1e-5;

fn model(kind: BodyKind) -> BodyModel {
    BodyModel::from_arrays(&bodies::synthetic_model(kind)).unwrap()
}

/// The largest difference between coordinates, in metres.
fn farthest(found: impl IntoIterator<Item = [f32; 3]>, wanted_um: &[i32]) -> f32 {
    let found: Vec<f32> = found.into_iter().flatten().collect();
    assert_eq!(found.len(), wanted_um.len());
    let apart =
        |(found, &wanted): (&f32, &i32)| (f64::from(*found) - f64::from(wanted) / 1e6).abs();
    found.iter().zip(wanted_um).map(apart).fold(0.0, f64::max) as f32
}

/// `count` evenly spaced points, as in the fixtures.
fn some(points: &[[f32; 3]], count: usize) -> Vec<[f32; 3]> {
    (0..count).map(|at| points[at * points.len() / count]).collect()
}

#[test]
fn poses_equal_those_of_smplx() {
    let mut largest: BTreeMap<String, f32> = BTreeMap::new();
    let mut models: BTreeMap<(String, usize), BodyModel> = BTreeMap::new();
    for case in bodies::fixtures().cases {
        let kind = bodies::kind(&case.kind);
        let model = models.entry((case.kind.clone(), case.columns)).or_insert_with(|| {
            BodyModel::from_arrays(&bodies::synthetic_model_with(kind, case.columns)).unwrap()
        });
        assert_eq!(model.kind(), kind);
        let shape = bodies::shape(case.seed, case.betas, case.expression);
        let shaped = model.shaped(&shape).unwrap();
        let pose = bodies::posed_hands(model, &case).to_pose();
        let joints = farthest(shaped.joints(&pose).unwrap(), &case.joints);
        let posed = some(&shaped.posed(&pose).unwrap(), case.vertices.len() / 3);
        let vertices = farthest(posed, &case.vertices);
        let case = format!("{} {}", case.kind, case.seed);
        assert!(joints < TOLERANCE_M, "joints of {case}: {joints}");
        assert!(vertices < TOLERANCE_M, "vertices of {case}: {vertices}");
        let largest = largest.entry(kind.name().to_owned()).or_default();
        *largest = largest.max(joints).max(vertices);
    }
    println!("largest differences in metres: {largest:?}");
    assert_eq!(largest.len(), BodyKind::ALL.len(), "each kind was compared");
}

#[test]
fn motions_equal_those_of_smplx() {
    let all = ClipOptions {
        fps: None,
        ground: GroundMode::Keep,
        up: Some(UpAxis::Z),
        ..ClipOptions::default()
    };
    for case in bodies::fixtures().clips {
        let kind = bodies::kind(&case.kind);
        let model = model(kind);
        let motion = Motion::from_arrays(&bodies::synthetic_motion(kind, case.frames)).unwrap();
        let betas = motion.betas().unwrap().to_vec();
        let shaped = model.shaped(&Shape { betas, expression: Vec::new() }).unwrap();
        let (clip, report) = motion.clip(shaped.skeleton(), "walk", &all).unwrap();
        assert_eq!((clip.poses.len(), report.scale), (case.frames, 1.0));
        assert!(report.missing.is_empty() && report.still.is_empty(), "{report:?}");
        assert_eq!(clip.times[1], 1.0 / 120.0);
        // The exported rig has Y up, the fixtures Z.
        let z_up = |[x, y, z]: [f32; 3]| [x, -z, y];
        let (mut joints, mut vertices) = (0.0_f32, 0.0_f32);
        let frames = shaped.posed_frames(&clip.poses).unwrap();
        for (frame, (pose, posed)) in clip.poses.iter().zip(&frames).enumerate() {
            let played = shaped.skeleton().motions(pose).unwrap();
            let rest = shaped.skeleton().joints();
            let played = rest.iter().zip(played).map(|(joint, to)| to.point(joint.position));
            joints = joints.max(farthest(played.map(z_up), &case.joints[frame]));
            let found = some(posed, case.vertices[frame].len() / 3).into_iter().map(z_up);
            vertices = vertices.max(farthest(found, &case.vertices[frame]));
        }
        println!("{}: joints {joints} m, vertices {vertices} m", case.kind);
        assert!(
            joints < TOLERANCE_M && vertices < TOLERANCE_M,
            "{} {joints} {vertices}",
            case.kind
        );
    }
}

#[test]
fn posing_equals_the_reference_on_any_number_of_threads() {
    let model = model(BodyKind::Flame);
    let shaped = model.shaped(&bodies::shape(3, 20, 5)).unwrap();
    let poses: Vec<Pose> =
        (0..11).map(|seed| bodies::pose(BodyKind::Flame, seed).to_pose()).collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shaped.posed_frames(&poses).unwrap())
    };
    let together = run(1);
    assert!(together == run(2) && together == run(5));
    for (pose, together) in poses.iter().zip(&together) {
        assert_eq!(&shaped.posed(pose).unwrap(), together);
        let plain = shaped.posed_reference(pose).unwrap();
        let apart = |(a, b): (&f32, &f32)| (a - b).abs();
        let pairs = together.as_flattened().iter().zip(plain.as_flattened());
        // Blended matrices against blended points, metres from the origin, in 32-bit floats.
        assert!(pairs.map(apart).fold(0.0, f32::max) < 2e-6);
    }
}

#[test]
fn at_rest_a_template_stays_and_its_joints_are_between_its_vertices() {
    let arrays = bodies::synthetic_model(BodyKind::Smpl);
    let model = BodyModel::from_arrays(&arrays).unwrap();
    let shaped = model.shaped(&Shape::default()).unwrap();
    let template = arrays.get("v_template").unwrap().f32s();
    assert_eq!(shaped.positions().as_flattened(), &template[..]);
    let rest = shaped.posed(&BodyPose::rest(&model).to_pose()).unwrap();
    let apart = |(a, b): (&f32, &f32)| (a - b).abs();
    let farthest = rest.as_flattened().iter().zip(&template[..]).map(apart).fold(0.0, f32::max);
    // Weights sum to 1 up to rounding.
    assert!(farthest < 1e-6, "{farthest}");
    // One beta of 2 moves the first coordinate by twice its component.
    let shape = Shape { betas: vec![0.0, 2.0], expression: Vec::new() };
    let component = arrays.get("shapedirs").unwrap().f32s()[1];
    let moved = model.shaped(&shape).unwrap().positions()[0][0];
    assert_eq!(moved, template[0] + 2.0 * component);
    // The head's joint lies within the cloud around it, which has a radius of 6 cm.
    let head = shaped.skeleton().human(HumanBone::Head).unwrap();
    let [x, y, z] = shaped.skeleton().joints()[head].position;
    let near = |found: f32, wanted: f32| (found - wanted).abs() < 0.06;
    assert!(near(x, 0.0) && near(y, 0.370) && near(z, 0.035), "{x} {y} {z}");
}

#[test]
fn hands_are_posed_by_components() {
    let arrays = bodies::synthetic_model(BodyKind::SmplH);
    let model = BodyModel::from_arrays(&arrays).unwrap();
    assert_eq!([Hand::Left, Hand::Right].map(|side| model.hand_components(side)), [45, 45]);
    let components = arrays.get("hands_componentsr").unwrap().f32s();
    let turns = model.hand_turns(Hand::Right, &[2.0, 0.0, -1.0]).unwrap();
    assert!((turns[1][2] - (2.0 * components[5] - components[2 * 45 + 5])).abs() < 1e-6);
    let pose = BodyPose::rest(&model).with_hand(&model, Hand::Right, &[2.0, 0.0, -1.0]).unwrap();
    let pose = pose.with_hand_means(&model).unwrap();
    let mean = model.hand_mean(Hand::Right).unwrap();
    assert_eq!(pose.turns[37 + 1][2], turns[1][2] + mean[1][2]);
    assert_eq!(pose.turns[22], model.hand_mean(Hand::Left).unwrap()[0]);
    assert_eq!(pose.turns[21], [0.0; 3]);
    let error = model.hand_turns(Hand::Left, &[0.0; 46]).unwrap_err().to_string();
    assert_eq!(error, "this SMPL-H model takes at most 45 hand components, got 46");
    let mut short = BodyPose::rest(&model);
    short.turns.pop();
    assert!(matches!(short.with_hand_means(&model), Err(BodyError::Count { found: 51, .. })));
}

#[test]
fn expressions_are_found_in_every_form_of_file() {
    let kind = BodyKind::Flame;
    let counts = |arrays: &NamedArrays| {
        let model = BodyModel::from_arrays(arrays).unwrap();
        (model.betas(), model.expressions())
    };
    assert_eq!(counts(&bodies::synthetic_model(kind)), (300, 100));
    assert_eq!(counts(&bodies::synthetic_model_with(kind, 20)), (10, 10));
    assert_eq!(counts(&bodies::synthetic_model_with(kind, 13)), (10, 3));
    let mut apart = bodies::synthetic_model_with(kind, 30);
    let expressions = bodies::synthetic_model_with(kind, 7).get("shapedirs").unwrap().clone();
    apart.insert("exprdirs", expressions);
    assert_eq!(counts(&apart), (30, 7));
    assert_eq!(counts(&bodies::synthetic_model(BodyKind::SmplH)), (16, 0));
    let model = BodyModel::from_arrays(&apart).unwrap();
    let shape = Shape { betas: vec![0.0; 31], expression: Vec::new() };
    let error = model.shaped(&shape).unwrap_err().to_string();
    assert_eq!(error, "this FLAME model takes at most 30 betas, got 31");
    let shape = Shape { betas: Vec::new(), expression: vec![0.0, f32::NAN] };
    let error = model.shaped(&shape).unwrap_err().to_string();
    assert_eq!(error, "expression coefficients must be finite, got NaN at index 1");
}

#[test]
fn broken_models_are_refused() {
    let base = bodies::synthetic_model_with(BodyKind::Flame, 2);
    let refused = |key: &str, array: NumericArray| {
        let mut arrays = base.clone();
        arrays.insert(key, array);
        BodyModel::from_arrays(&arrays).unwrap_err().to_string()
    };
    let zeros = |shape: &[usize]| {
        NumericArray::new_f32(shape.to_vec(), vec![0.0; shape.iter().product()]).unwrap()
    };
    let error = BodyModel::from_arrays(&NamedArrays::new()).unwrap_err().to_string();
    assert!(error.starts_with("not a body model: no array `kintree_table`"), "{error}");
    let error = refused("v_template", zeros(&[5023, 2]));
    assert_eq!(error, "`v_template` must have shape [vertices, 3], got [5023, 2]");
    let error = refused("weights", zeros(&[5022, 5]));
    assert_eq!(error, "`weights` must have shape [5023, 5], got [5022, 5]");
    let error = refused("weights", zeros(&[5023, 5]));
    assert_eq!(error, "vertex 0 has no weights");
    let error = refused("J_regressor", zeros(&[5023, 5]));
    assert_eq!(error, "`J_regressor` must have shape [5, 5023], got [5023, 5]");
    let error = refused("shapedirs", zeros(&[5023, 3, 0]));
    assert_eq!(error, "`shapedirs` must have shape [5023, 3, components], got [5023, 3, 0]");
    for key in ["v_template", "shapedirs", "posedirs", "J_regressor", "weights"] {
        let array = base.get(key).unwrap();
        let mut values = array.f32s().into_owned();
        values[77] = f32::NAN;
        let error = refused(key, NumericArray::new_f32(array.shape().to_vec(), values).unwrap());
        assert_eq!(error, format!("`{key}` must be finite, got NaN at index 77"));
    }
    let integers =
        |shape: &[usize], values: Vec<i64>| NumericArray::new_i64(shape.to_vec(), values).unwrap();
    let error = refused("f", integers(&[1, 3], vec![0, 1, 5023]));
    assert_eq!(
        error,
        "`f` must hold indices of at least 0 and less than 5023, got 5023 at index 2"
    );
    let error = refused("f", integers(&[1, 3], vec![0, -1, 2]));
    assert_eq!(error, "`f` must hold indices of at least 0 and less than 5023, got -1 at index 1");
    let halves = NumericArray::new_f32(vec![1, 3], vec![0.5; 3]).unwrap();
    assert_eq!(refused("f", halves), "`f` must hold integers");
    let error = refused("kintree_table", integers(&[2, 6], vec![0; 12]));
    assert!(error.starts_with("`kintree_table` must have 24 (SMPL)"), "{error}");
    let tree = |parents: [i64; 5]| integers(&[2, 5], parents.into_iter().chain(0..5).collect());
    let error = refused("kintree_table", tree([-1, 0, 3, 1, 1]));
    assert_eq!(error, "`kintree_table`: the parent of joint 2 (jaw) of FLAME must be 1, got 3");
    let error = refused("kintree_table", integers(&[2, 5], vec![-1, 0, 1, 1, 1, 0, 2, 1, 3, 4]));
    assert!(error.starts_with("`kintree_table` must hold indices"), "{error}");
    assert!(error.ends_with("got 2 at index 6"), "{error}");
    // All encodings of a root without a parent.
    for root in [-1, 0, 0xffff_ffff] {
        let mut arrays = base.clone();
        arrays.insert("kintree_table", tree([root, 0, 1, 1, 1]));
        BodyModel::from_arrays(&arrays).unwrap();
    }
}

/// A mesh of a model's triangles, reordered and each starting at its next corner, with its own
/// layout.
fn mesh(model: &BodyModel) -> Mesh {
    let turned: Vec<[u32; 3]> =
        model.triangles().iter().rev().map(|&[a, b, c]| [b, c, a]).collect();
    let uv: Vec<[f32; 2]> =
        (0..model.vertices()).map(|vertex| [vertex as f32 / 1e5, 0.5]).collect();
    Mesh::from_triangles(vec![[0.0; 3]; model.vertices()], uv, &turned, &turned).unwrap()
}

#[test]
fn a_mesh_of_the_same_triangles_becomes_an_avatar() {
    let model = model(BodyKind::SmplX);
    let shaped = model.shaped(&bodies::shape(1, 10, 0)).unwrap();
    let mesh = mesh(&model);
    let avatar = shaped.avatar(mesh.clone()).unwrap();
    avatar.check().unwrap();
    assert_eq!(avatar.mesh.positions(), shaped.positions());
    assert_eq!((avatar.mesh.uv(), avatar.mesh.faces()), (mesh.uv(), mesh.faces()));
    assert!(avatar.skeleton.missing_bones().is_empty());
    assert_eq!((avatar.morphs.len(), avatar.expressions.len()), (0, 0));
}

/// A cloud of vertices shows no face, so its components are exported as morphs.
#[test]
fn components_are_morphs_where_no_face_can_be_measured() {
    let model = model(BodyKind::SmplX);
    let shaped = model.shaped(&bodies::shape(1, 10, 0)).unwrap();
    let mut avatar = shaped.avatar(mesh(&model)).unwrap();
    let reported = shaped.add_expressions(&mut avatar).unwrap();
    assert!(reported.unmeasured.is_some());
    let names: Vec<&str> = avatar.morphs.iter().map(|morph| morph.name.as_str()).take(11).collect();
    assert_eq!((names[0], names[9], names[10]), ("expression_00", "expression_09", "jaw_open"));
    // A weight of 1 is a coefficient of 1, except for the joints that move with it.
    let mut expression = vec![0.0; 4];
    expression[3] = 1.0;
    let smiling = Shape { expression, ..bodies::shape(1, 10, 0) };
    let smiling = model.shaped(&smiling).unwrap();
    let mut morphed = avatar.mesh.positions().to_vec();
    avatar.morphs[3].add(1.0, &mut morphed);
    let apart = |(a, b): (&f32, &f32)| (a - b).abs();
    let pairs = morphed.as_flattened().iter().zip(smiling.positions().as_flattened());
    assert!(pairs.map(apart).fold(0.0, f32::max) < 2e-6);
    // The jaw opened by its morph equals the jaw opened by its joint.
    let aa = &avatar.expressions[0];
    assert_eq!((aa.preset, &aa.morphs[..]), (Some(ExpressionPreset::Aa), &[(10, 1.0)][..]));
    let mut open = BodyPose::rest(&model);
    open.turns[22] = [0.25, 0.0, 0.0];
    let open = shaped.posed(&open.to_pose()).unwrap();
    let mut morphed = avatar.mesh.positions().to_vec();
    avatar.morphs[10].add(1.0, &mut morphed);
    let pairs = morphed.as_flattened().iter().zip(open.as_flattened());
    assert!(pairs.map(apart).fold(0.0, f32::max) < 2e-6);
}

/// The published mesh, with a synthetic model of its triangles.
#[test]
fn the_real_mesh_becomes_an_avatar() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let mesh = pair.target();
    let mut arrays = bodies::synthetic_model_with(BodyKind::SmplX, 20);
    let corners = mesh.faces().as_flattened().iter().map(|&vertex| i64::from(vertex)).collect();
    let triangles = NumericArray::new_i64(vec![mesh.faces().len(), 3], corners).unwrap();
    arrays.insert("f", triangles);
    let model = BodyModel::from_arrays(&arrays).unwrap();
    let shaped = model.shaped(&Shape::default()).unwrap();
    let avatar = shaped.avatar(mesh.clone()).unwrap();
    avatar.check().unwrap();
    assert_eq!(avatar.mesh.uv_faces(), mesh.uv_faces());
}

#[test]
fn models_and_motions_come_from_files() {
    let kind = BodyKind::Flame;
    let arrays = bodies::synthetic_model_with(kind, 20);
    let mut bytes = Vec::new();
    arrays::write_npz(&arrays, Cursor::new(&mut bytes)).unwrap();
    let read = BodyModel::from_arrays(&arrays::parse(&bytes).unwrap()).unwrap();
    let pose = bodies::pose(kind, 1).to_pose();
    let shape = bodies::shape(1, 10, 10);
    let posed = |model: &BodyModel| model.shaped(&shape).unwrap().posed(&pose).unwrap();
    assert_eq!(posed(&read), posed(&BodyModel::from_arrays(&arrays).unwrap()));
    let mut arrays = bodies::synthetic_motion(BodyKind::Smpl, 4);
    arrays.insert_text("gender", "female");
    let mut bytes = Vec::new();
    arrays::write_npz(&arrays, Cursor::new(&mut bytes)).unwrap();
    let read = Motion::from_arrays(&arrays::parse(&bytes).unwrap()).unwrap();
    assert_eq!(read, Motion::from_arrays(&arrays).unwrap());
    assert_eq!((read.gender(), read.rate()), (Some(Gender::Female), 120.0));
}

#[test]
fn other_meshes_are_refused() {
    let model = model(BodyKind::Flame);
    let shaped = model.shaped(&Shape::default()).unwrap();
    let good = mesh(&model);
    let mut faces = good.faces().to_vec();
    faces[0] = [0, 100, 200];
    faces[1] = [0, 100, 201];
    let uv = good.uv().to_vec();
    let other = Mesh::from_triangles(good.positions().to_vec(), uv, &faces, &faces).unwrap();
    let error = shaped.avatar(other).unwrap_err().to_string();
    assert_eq!(
        error,
        "the mesh does not match this FLAME model: 2 of its 9976 triangles are missing in the model, and 2 of the model's 9976 triangles are missing in the mesh"
    );
    let small = Mesh::from_triangles(vec![[0.0; 3]; 3], vec![[0.0; 2]], &[[0, 1, 2]], &[[0; 3]]);
    let error = shaped.avatar(small.unwrap()).unwrap_err().to_string();
    assert_eq!(error, "must have 5023 vertices in the mesh, got 3");
}

#[test]
fn the_error_without_correctives_is_measured() {
    let mut arrays = bodies::synthetic_model(BodyKind::Smpl);
    let motion = Motion::from_arrays(&bodies::synthetic_motion(BodyKind::Smpl, 5)).unwrap();
    let apart = |arrays: &NamedArrays| {
        let model = BodyModel::from_arrays(arrays).unwrap();
        let shaped = model.shaped(&Shape::default()).unwrap();
        let (clip, _) = motion
            .clip(shaped.skeleton(), "c", &ClipOptions { fps: None, ..ClipOptions::default() })
            .unwrap();
        let avatar = shaped.avatar(mesh(&model)).unwrap();
        assert!(avatar.morphs.is_empty());
        shaped.deviation(&avatar, &clip).unwrap()
    };
    let with = apart(&arrays);
    // 207 features of about 0.15, each ±2 mm at random: centimetres in total.
    assert!(with.mean_mm > 1.0 && with.max_mm > with.mean_mm && with.max_mm < 100.0, "{with:?}");
    let shape = [6890, 3, 207];
    let none = NumericArray::new_f32(shape.to_vec(), vec![0.0; 6890 * 3 * 207]).unwrap();
    arrays.insert("posedirs", none);
    let without = apart(&arrays);
    // Rounding, metres from the origin.
    assert!(without.max_mm < 0.005, "{without:?}");
}

#[test]
fn motions_of_smaller_bodies_play_on_larger_ones() {
    let smplx = model(BodyKind::SmplX);
    let shaped = smplx.shaped(&Shape::default()).unwrap();
    let options = ClipOptions { fps: None, ..ClipOptions::default() };
    for (kind, missing, still) in
        [(BodyKind::Smpl, vec!["left_hand", "right_hand"], 33), (BodyKind::SmplH, vec![], 3)]
    {
        let motion = Motion::from_arrays(&bodies::synthetic_motion(kind, 3)).unwrap();
        let (clip, report) = motion.clip(shaped.skeleton(), "c", &options).unwrap();
        assert_eq!((report.missing, report.still.len()), (missing, still));
        // Finger joints of SMPL-H come three joints later in SMPL-X.
        let own = model(kind).shaped(&Shape::default()).map(|own| own.skeleton().clone()).unwrap();
        let (own, _) = motion.clip(&own, "c", &options).unwrap();
        for (clip, own) in clip.poses.iter().zip(&own.poses) {
            assert_eq!(clip.rotations[..22], own.rotations[..22]);
            if kind == BodyKind::SmplH {
                assert_eq!(clip.rotations[25..], own.rotations[22..]);
            }
        }
    }
    let flame = model(BodyKind::Flame);
    let head = flame.shaped(&Shape::default()).unwrap();
    let motion = Motion::from_arrays(&bodies::synthetic_motion(BodyKind::SmplH, 3)).unwrap();
    let error = motion.clip(head.skeleton(), "c", &options).unwrap_err();
    assert!(matches!(error, MotionError::OtherSkeleton { .. }));
    assert_eq!(
        error.to_string(),
        "the skeleton of a motion of 52 joints must have hips, spine, leftUpperLeg, rightUpperLeg, got `global` and 4 more joints"
    );
}
