//! Body models of the SMPL family with legs, soles and hands: the demo's figure as a model of each
//! kind, with shapes that vary what matters for standing and walking, and recordings of people with
//! such shapes.

use glam::{DMat4, DVec4, Quat, Vec3};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyKind, BodyModel, Shaped};
use uvgraft_avatar::rig::{Clip, HumanBone};
use uvgraft_figure::Figure;
use uvgraft_io::arrays::{NamedArrays, NumericArray};

use crate::bodies;

/// Shape components: size, legs, girth, shins, feet, arms, soles, and a bend to the side.
pub const SHAPES: usize = 8;
/// Position of the model's origin in the figure, so that the model does not stand on y = 0.
const ORIGIN: Vec3 = Vec3::new(0.02, 1.2, -0.05);
/// Number of vertices that a joint is regressed from.
const NEAR: usize = 400;

/// The arrays of a model file without pose correctives: the figure in T-pose, with the kind's
/// joints at the figure's bones of the same name.
///
/// # Panics
/// Never.
pub fn model(kind: BodyKind) -> NamedArrays {
    let figure = Figure::new().avatar();
    let positions: Vec<Vec3> =
        figure.mesh.positions().iter().map(|&place| Vec3::from(place) - ORIGIN).collect();
    let vertices = positions.len();
    let bones = bones(kind);
    let joints = bones.len();

    let mut arrays = NamedArrays::new();
    let mut floats = |name: &str, shape: &[usize], values: Vec<f32>| {
        let array = NumericArray::new_f32(shape.to_vec(), values);
        arrays.insert(name, array.expect("as many values as the shape says"));
    };
    let values = positions.iter().flat_map(Vec3::to_array).collect();
    floats("v_template", &[vertices, 3], values);
    let mut shapes = Vec::with_capacity(vertices * 3 * SHAPES);
    for &place in &positions {
        let offsets = offsets(place + ORIGIN);
        for axis in 0..3 {
            shapes.extend(offsets.iter().map(|offset| offset[axis]));
        }
    }
    floats("shapedirs", &[vertices, 3, SHAPES], shapes);
    let mut weights = vec![0.0; vertices * joints];
    for (vertex, row) in weights.chunks_mut(joints).enumerate() {
        for &(joint, weight) in figure.skin.of(vertex) {
            row[follower(&figure, usize::from(joint), &bones)] += weight;
        }
    }
    floats("weights", &[vertices, joints], weights);
    let mut regressor = vec![0.0; joints * vertices];
    for (joint, row) in regressor.chunks_mut(vertices).enumerate() {
        let bone = bones[joint].unwrap_or(HumanBone::LeftMiddleProximal);
        // SMPL's hand joints are not humanoid bones; the middle finger stands in for them.
        let bone = match (bones[joint], joint) {
            (None, 23) => HumanBone::RightMiddleProximal,
            _ => bone,
        };
        let number = figure.skeleton.human(bone).expect("a bone of the figure");
        let place = Vec3::from(figure.skeleton.joints()[number].position) - ORIGIN;
        for (vertex, part) in parts(place, &positions) {
            row[vertex] = part;
        }
    }
    floats("J_regressor", &[joints, vertices], regressor);

    let mut integers = |name: &str, shape: &[usize], values: Vec<i64>| {
        let array = NumericArray::new_i64(shape.to_vec(), values);
        arrays.insert(name, array.expect("as many values as the shape says"));
    };
    let parents = bodies::rest(kind).into_iter().map(|(parent, _)| parent);
    integers("kintree_table", &[2, joints], parents.chain(0..joints as i64).collect());
    let faces = figure.mesh.faces();
    let corners = faces.as_flattened().iter().map(|&vertex| i64::from(vertex)).collect();
    integers("f", &[faces.len(), 3], corners);
    arrays
}

/// The humanoid bone of each joint of a kind.
fn bones(kind: BodyKind) -> Vec<Option<HumanBone>> {
    let arrays = bodies::synthetic_model_with(kind, 2);
    let model = BodyModel::from_arrays(&arrays).expect("a sound model");
    let shaped = model.shaped(&uvgraft_avatar::body::Shape::default()).expect("its own shape");
    shaped.skeleton().joints().iter().map(|joint| joint.human).collect()
}

/// The joint of a kind for a joint of the figure: the same bone, or the nearest ancestor's.
fn follower(figure: &Avatar, joint: usize, bones: &[Option<HumanBone>]) -> usize {
    let joints = figure.skeleton.joints();
    let mut above = std::iter::successors(Some(joint), |&at| joints[at].parent);
    above
        .find_map(|at| bones.iter().position(|&bone| bone.is_some() && bone == joints[at].human))
        .unwrap_or(0)
}

/// Offsets of a point of the figure by the shape components, in metres. All are linear within
/// limbs.
fn offsets(place: Vec3) -> [Vec3; SHAPES] {
    let [x, y, z] = place.to_array();
    let below = |height: f32| (y - height).min(0.0);
    let arm = (x.abs() - 0.2).max(0.0).copysign(x);
    [
        place * 0.04,
        Vec3::Y * below(0.9) * 0.05,
        Vec3::new(x * 0.04, 0.0, z * 0.08),
        Vec3::Y * below(0.5) * 0.06,
        Vec3::Z * (z + 0.03) * if y < 0.1 { 0.08 } else { 0.0 },
        Vec3::X * arm * 0.05,
        Vec3::Y * below(0.07) * 0.15,
        Vec3::X * (y - 0.9) * 0.01,
    ]
}

/// Weights of vertices that sum to 1 and reproduce a point: the smallest such.
fn parts(place: Vec3, positions: &[Vec3]) -> Vec<(usize, f32)> {
    let mut near: Vec<usize> = (0..positions.len()).collect();
    let distance = |&at: &usize| positions[at].distance_squared(place);
    near.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    near.truncate(NEAR);
    // With a row (x, y, z, 1) of A per vertex, the shortest w with Aᵀ w = b is A (AᵀA)⁻¹ b.
    let row = |at: usize| (positions[at] - place).extend(1.0).as_dvec4();
    // Regularised, since AᵀA is singular if all vertices lie in one plane.
    let mut square = DMat4::IDENTITY * 1e-9;
    for &at in &near {
        let row = row(at);
        square += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w);
    }
    let solved = square.inverse() * DVec4::W;
    near.iter().map(|&at| (at, row(at).dot(solved) as f32)).collect()
}

/// A clip in AMASS's format, as if recorded of somebody: Z up, or Y up.
///
/// - `shaped`: the person, in the model's space.
/// - `clip`: a clip of an avatar of that person, which stands on the floor at any position.
/// - `moved`: offset of the recording's origin from the clip's, and its rotation about the
///   vertical, in radians.
///
/// # Panics
/// If the clip does not belong to the person.
pub fn recorded(
    shaped: &Shaped<'_>,
    avatar: &Avatar,
    clip: &Clip,
    moved: (Vec3, f32),
    z_up: bool,
) -> NamedArrays {
    let joints = shaped.skeleton().joints().len();
    let axes =
        if z_up { Quat::from_rotation_x(std::f32::consts::FRAC_PI_2) } else { Quat::IDENTITY };
    let turn = axes * Quat::from_rotation_y(moved.1);
    let hips = Vec3::from(avatar.skeleton.joints()[0].position);
    let pelvis = Vec3::from(shaped.skeleton().joints()[0].position);
    let (mut poses, mut places) = (Vec::new(), Vec::new());
    for pose in &clip.poses {
        assert_eq!(pose.rotations.len(), joints, "the person's clip");
        for (joint, &rotation) in pose.rotations.iter().enumerate() {
            let rotation = Quat::from_array(rotation);
            let rotation = if joint == 0 { turn * rotation } else { rotation };
            let shortest = if rotation.w < 0.0 { -rotation } else { rotation };
            poses.extend(shortest.to_scaled_axis().to_array());
        }
        let place = turn * (hips + Vec3::from(pose.translation)) + axes * moved.0 - pelvis;
        places.extend(place.to_array());
    }
    let frames = clip.poses.len();
    let mut arrays = NamedArrays::new();
    let table = |columns: usize, values| {
        NumericArray::new_f32(vec![frames, columns], values).expect("as many values")
    };
    arrays.insert("poses", table(3 * joints, poses));
    arrays.insert("trans", table(3, places));
    let rate = f64::from((frames.max(2) - 1) as f32 / clip.seconds().max(1e-3)).round();
    let rate = NumericArray::new_f64(vec![], vec![rate]).expect("one value");
    arrays.insert("mocap_framerate", rate);
    arrays
}

/// A clip of the figure that travels: the walk, which is in place, moves forwards at the speed of
/// its treadmill; the other clips stay in place.
pub fn forwards(clip: &Clip) -> Clip {
    const BELT: f32 = 1.12 / 1.2;
    let mut clip = clip.clone();
    if clip.name == "walk" {
        for (pose, time) in clip.poses.iter_mut().zip(&clip.times) {
            pose.translation[2] += BELT * time;
        }
    }
    clip
}

/// Coefficients from a seed, each from -2 to 2.
pub fn betas(seed: u32) -> Vec<f32> {
    bodies::shape(seed, SHAPES, 0).betas
}
