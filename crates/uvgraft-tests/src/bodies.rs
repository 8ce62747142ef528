//! Synthetic body models of the real kinds and sizes, parameters and motions for them, all from
//! integer arithmetic, and the results of the Python package `smplx` for them.
//!
//! `fixtures/bodies.py` repeats the arithmetic, so no model needs to be stored.

use std::collections::HashMap;

use serde::Deserialize;
use uvgraft_avatar::body::{BodyKind, BodyModel, BodyPose, Hand, Shape};
use uvgraft_io::arrays::{NamedArrays, NumericArray};

use crate::pictures::hashed;

const TEMPLATE: u32 = 10;
const SHAPES: u32 = 11;
const POSES: u32 = 12;
const WEIGHTS: u32 = 13;
const REGRESSOR: u32 = 14;
const HANDS: u32 = 15;
const MEANS: u32 = 16;
const BETAS: u32 = 20;
const EXPRESSION: u32 = 21;
const TURNS: u32 = 22;
const FINGERS: u32 = 23;
const PLACE: u32 = 24;
const MOTION: u32 = 25;
const PATH: u32 = 26;

/// One set of parameters and smplx's result for it, in micrometres.
#[derive(Debug, Deserialize)]
pub struct Case {
    /// The model, by its name in smplx.
    pub kind: String,
    /// Number of shape components in the model's arrays.
    pub columns: usize,
    /// Seed of the parameters.
    pub seed: u32,
    /// Number of betas.
    pub betas: usize,
    /// Number of expression coefficients.
    pub expression: usize,
    /// Number of PCA coefficients that pose each hand; `None` if the joints do.
    pub hand_components: Option<usize>,
    /// Whether the hands' mean poses are left out.
    pub flat_hand_mean: bool,
    /// Positions of all joints.
    pub joints: Vec<i32>,
    /// Positions of evenly spaced vertices.
    pub vertices: Vec<i32>,
}

/// A motion and smplx's positions of joints and vertices in each frame, in micrometres, Z up.
#[derive(Debug, Deserialize)]
pub struct MotionCase {
    /// The model, by its name in smplx.
    pub kind: String,
    /// Number of frames.
    pub frames: usize,
    /// Positions of all joints in each frame.
    pub joints: Vec<Vec<i32>>,
    /// Positions of evenly spaced vertices in each frame.
    pub vertices: Vec<Vec<i32>>,
}

/// The file that `fixtures/bodies.py` writes.
#[derive(Debug, Deserialize)]
pub struct Fixtures {
    /// Single poses.
    pub cases: Vec<Case>,
    /// Motions.
    pub clips: Vec<MotionCase>,
}

/// The results of `smplx`.
///
/// # Panics
/// If the file is not in the script's format.
pub fn fixtures() -> Fixtures {
    let json = include_str!("../fixtures/bodies.json");
    serde_json::from_str(json).expect("fixtures as the script writes them")
}

/// The kind by its name in smplx.
///
/// # Panics
/// If the name is unknown.
pub fn kind(name: &str) -> BodyKind {
    let kind = BodyKind::ALL.into_iter().find(|&kind| key(kind) == name);
    kind.expect("one of the names that the script writes")
}

fn key(kind: BodyKind) -> &'static str {
    ["smpl", "smplh", "smplx", "flame"][kind as usize]
}

/// Parents of a kind's joints, and their rest positions in millimetres.
pub(crate) fn rest(kind: BodyKind) -> Vec<(i64, [i64; 3])> {
    type Entry = (String, i64, i64, i64, i64);
    let json = include_str!("../fixtures/bodies_rest.json");
    let all: HashMap<String, Vec<Entry>> =
        serde_json::from_str(json).expect("a table of joints for each kind");
    all[key(kind)].iter().map(|&(_, parent, x, y, z)| (parent, [x, y, z])).collect()
}

/// The arrays of a model file: real keys, sizes and ranges; the shape is only a cloud of points
/// around each joint.
///
/// # Panics
/// Never.
pub fn synthetic_model(kind: BodyKind) -> NamedArrays {
    let components = match kind {
        BodyKind::Smpl => 10,
        BodyKind::SmplH => 16,
        BodyKind::SmplX | BodyKind::Flame => 400,
    };
    synthetic_model_with(kind, components)
}

/// [`synthetic_model`] with only the first `components` shape components.
///
/// # Panics
/// Never.
pub fn synthetic_model_with(kind: BodyKind, components: usize) -> NamedArrays {
    let all = match kind {
        BodyKind::Smpl => 10,
        BodyKind::SmplH => 16,
        BodyKind::SmplX | BodyKind::Flame => 400,
    };
    let (seed, n, rest) = (kind as u32, kind.vertex_count(), rest(kind));
    let joints = rest.len();
    let draw = |at: usize, purpose| hashed(at as i64, i64::from(seed), 0, purpose);
    let mut arrays = NamedArrays::new();
    let mut floats = |name: &str, shape: &[usize], values: Vec<f32>| {
        let array = NumericArray::new_f32(shape.to_vec(), values);
        arrays.insert(name, array.expect("as many values as the shape says"));
    };

    let place = |at: usize| {
        let (_, rest_mm) = rest[at / 3 * joints / n];
        let micrometres = rest_mm[at % 3] * 1000 + draw(at, TEMPLATE) % 120_001 - 60_000;
        (micrometres as f64 / 1e6) as f32
    };
    floats("v_template", &[n, 3], (0..n * 3).map(place).collect());
    let row = |row: usize| row * all..row * all + components;
    let shapes = (0..n * 3).flat_map(row).map(|at| between(at, SHAPES, seed, 0, 4000, 1e6));
    floats("shapedirs", &[n, 3, components], shapes.collect());
    let features = 9 * (joints - 1);
    let poses = (0..n * 3 * features).map(|at| between(at, POSES, seed, 0, 2000, 1e6));
    floats("posedirs", &[n, 3, features], poses.collect());

    let mut weights = vec![0.0; n * joints];
    for (vertex, weights) in weights.chunks_mut(joints).enumerate() {
        let draw: [i64; 4] = std::array::from_fn(|k| draw(vertex * 4 + k, WEIGHTS));
        let (own, above) = (512 + draw[0] % 256, 128 + draw[0] / 256 % 64);
        let other = (1024 - own - above) / 2;
        let owner = vertex * joints / n;
        let drawn = |draw: i64| (draw % joints as i64) as usize;
        for (joint, part) in [
            (owner, own),
            (rest[owner].0.max(0) as usize, above),
            (drawn(draw[1]), other),
            (drawn(draw[2]), 1024 - own - above - other),
        ] {
            weights[joint] += part as f32 / 1024.0;
        }
    }
    floats("weights", &[n, joints], weights);

    let mut regressor = vec![0.0; joints * n];
    for at in 0..joints * 16 {
        let joint = at / 16;
        let first = (joint * n).div_ceil(joints);
        let vertex = first + draw(at, REGRESSOR) as usize % (n / joints);
        regressor[joint * n + vertex] += 64.0 / 1024.0;
    }
    floats("J_regressor", &[joints, n], regressor);

    if matches!(kind, BodyKind::SmplH | BodyKind::SmplX) {
        for (side, second) in [("l", 0), ("r", 1)] {
            let components = (0..45 * 45).map(|at| between(at, HANDS, seed, second, 1000, 5000.0));
            floats(&format!("hands_components{side}"), &[45, 45], components.collect());
            let mean = (0..45).map(|at| between(at, MEANS, seed, second, 300, 1000.0));
            floats(&format!("hands_mean{side}"), &[45], mean.collect());
        }
    }

    let mut integers = |name: &str, shape: &[usize], values: Vec<i64>| {
        let array = NumericArray::new_i64(shape.to_vec(), values);
        arrays.insert(name, array.expect("as many values as the shape says"));
    };
    // The root's parent as in the published files: -1 as an unsigned 32-bit integer.
    let parents = rest.iter().map(|&(parent, _)| if parent < 0 { 0xffff_ffff } else { parent });
    integers("kintree_table", &[2, joints], parents.chain(0..joints as i64).collect());
    let triangles = match kind {
        BodyKind::Smpl | BodyKind::SmplH => 13_776,
        BodyKind::SmplX => 20_908,
        BodyKind::Flame => 9976,
    };
    let corners = |face: usize| [face % n, (face + 1) % n, (face + 2 + face / n) % n];
    let corners = (0..triangles).flat_map(corners).map(|vertex| vertex as i64);
    integers("f", &[triangles, 3], corners.collect());
    arrays
}

/// A pseudo-random number in `-most..=most`, divided by `unit`.
fn between(at: usize, purpose: u32, first: u32, second: u32, most: i64, unit: f64) -> f32 {
    let draw = hashed(at as i64, i64::from(first), i64::from(second), purpose);
    ((draw % (2 * most + 1) - most) as f64 / unit) as f32
}

/// A shape from a seed.
pub fn shape(seed: u32, betas: usize, expression: usize) -> Shape {
    let values = |count: usize, purpose| {
        (0..count).map(|at| between(at, purpose, seed, 0, 2000, 1000.0)).collect()
    };
    Shape { betas: values(betas, BETAS), expression: values(expression, EXPRESSION) }
}

/// A pose from a seed; the root has the largest rotation.
pub fn pose(kind: BodyKind, seed: u32) -> BodyPose {
    let turn = |joint: usize| {
        let (second, most) = if joint == 0 { (1, 2000) } else { (0, 600) };
        std::array::from_fn(|axis| between(3 * joint + axis, TURNS, seed, second, most, 1000.0))
    };
    BodyPose {
        translation: std::array::from_fn(|axis| between(axis, PLACE, seed, 0, 1000, 1000.0)),
        turns: (0..kind.joint_count()).map(turn).collect(),
    }
}

/// The pose of a case, including its hands.
///
/// # Panics
/// If the model lacks components that the case needs.
pub fn posed_hands(model: &BodyModel, case: &Case) -> BodyPose {
    let mut pose = pose(model.kind(), case.seed);
    if let Some(count) = case.hand_components {
        for (side, second) in [(Hand::Left, 0), (Hand::Right, 1)] {
            let value = |at| between(at, FINGERS, case.seed, second, 1000, 1000.0);
            let coefficients: Vec<f32> = (0..count).map(value).collect();
            pose = pose.with_hand(model, side, &coefficients).expect("as many components");
        }
    }
    if case.flat_hand_mean { pose } else { pose.with_hand_means(model).expect("the model's pose") }
}

/// A motion in AMASS's format, Z up, 120 frames a second, linear between keys eight frames apart.
///
/// # Panics
/// Never.
pub fn synthetic_motion(kind: BodyKind, frames: usize) -> NamedArrays {
    let path = |columns: usize, purpose, most: i64, unit: f64| {
        let key = |key: usize, column: usize| {
            hashed((key * columns + column) as i64, 0, 0, purpose) % (2 * most + 1) - most
        };
        let value = |at: usize| {
            let (frame, column) = (at / columns, at % columns);
            let part = (frame % 8) as i64;
            let sum = key(frame / 8, column) * (8 - part) + key(frame / 8 + 1, column) * part;
            (sum as f64 / (8.0 * unit)) as f32
        };
        let values = (0..frames * columns).map(value).collect();
        NumericArray::new_f32(vec![frames, columns], values).expect("as many values")
    };
    let mut arrays = NamedArrays::new();
    arrays.insert("poses", path(3 * kind.joint_count(), MOTION, 500, 1000.0));
    arrays.insert("trans", path(3, PATH, 1500, 1000.0));
    let rate = NumericArray::new_f64(vec![], vec![120.0]).expect("one value");
    arrays.insert("mocap_framerate", rate);
    let betas = shape(1, 10, 0).betas;
    arrays.insert("betas", NumericArray::new_f32(vec![10], betas).expect("ten values"));
    arrays
}
