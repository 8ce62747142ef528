//! Joints of synthetic models, and the vertices' weights for them.

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft::anatomy::{Anatomy, Landmark};
use uvgraft_avatar::body::BodyKind;

/// Joints, weights `[V, J]` and regressor `[J, V]`, row-major.
pub(super) struct Rig {
    pub places: Vec<Vec3>,
    pub parents: Vec<Option<usize>>,
    pub weights: Vec<f32>,
    pub regressor: Vec<f32>,
}

/// Positions of SMPL-X's joints in its template, in centimetres, from slices through it: the body's
/// 22, and a hand's 15 (index, middle, pinky, ring, thumb). Left side only; the right one mirrors
/// it.
const CENTER: [(usize, [f32; 3]); 6] = [
    (0, [0.0, -36.0, 1.0]),
    (3, [0.0, -24.0, -1.0]),
    (6, [0.0, -12.0, 0.0]),
    (9, [0.0, -4.0, 0.0]),
    (12, [0.0, 15.0, -3.0]),
    (15, [0.0, 25.0, -1.0]),
];
const LEFT: [(usize, [f32; 3]); 8] = [
    (1, [6.5, -45.0, 0.0]),
    (4, [10.0, -82.0, -2.0]),
    (7, [10.0, -123.0, -5.0]),
    (10, [11.5, -129.5, 6.0]),
    (13, [5.0, 7.0, -2.0]),
    (16, [17.0, 6.0, -4.5]),
    (18, [43.0, 4.0, -6.5]),
    (20, [68.5, 4.5, -6.5]),
];
const LEFT_FINGERS: [[f32; 3]; 15] = [
    [78.0, 3.0, -3.5],
    [81.5, 2.0, -3.2],
    [84.0, 1.0, -3.0],
    [78.5, 3.0, -5.8],
    [82.0, 2.0, -5.8],
    [84.5, 1.0, -5.6],
    [76.5, 2.5, -10.0],
    [79.0, 1.5, -10.5],
    [81.0, 0.5, -11.0],
    [77.5, 3.0, -8.0],
    [81.0, 2.0, -8.3],
    [83.5, 1.0, -8.3],
    [71.5, 2.5, -3.5],
    [74.5, 1.5, -1.5],
    [77.0, 0.5, -0.5],
];

/// Joints of a kind on its template, with weights by distance from the bones.
pub(super) fn rig(kind: BodyKind, mesh: &Mesh, anatomy: &Anatomy) -> Rig {
    let (places, parents) = match kind {
        BodyKind::Flame => flame(anatomy),
        _ => smplx(anatomy),
    };
    let face = match kind {
        BodyKind::Flame => [1, 2, 3, 4],
        _ => [15, 22, 23, 24],
    };
    let weights = weights(mesh, anatomy, &places, &parents, face);
    let regressor = places.iter().flat_map(|&place| between(mesh, place)).collect();
    Rig { places, parents, weights, regressor }
}

fn smplx(anatomy: &Anatomy) -> (Vec<Vec3>, Vec<Option<usize>>) {
    let mut places = vec![Vec3::ZERO; 55];
    let cm = |place: [f32; 3]| Vec3::from(place) * 0.01;
    let mirrored = |place: Vec3| Vec3::new(-place.x, place.y, place.z);
    for (joint, place) in CENTER {
        places[joint] = cm(place);
    }
    for (joint, place) in LEFT {
        places[joint] = cm(place);
        places[joint + 1] = mirrored(cm(place));
    }
    for (finger, place) in LEFT_FINGERS.into_iter().enumerate() {
        places[25 + finger] = cm(place);
        places[40 + finger] = mirrored(cm(place));
    }
    let [jaw, left, right] = jaw_and_eyes(anatomy);
    places[22..25].copy_from_slice(&[jaw, left, right]);
    let body =
        [0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 15, 15, 15];
    let mut parents: Vec<Option<usize>> = body.into_iter().map(Some).collect();
    parents[0] = None;
    for first in [25, 40] {
        let wrist = if first == 25 { 20 } else { 21 };
        let finger = |at: usize| Some(if at.is_multiple_of(3) { wrist } else { first + at - 1 });
        parents.extend((0..15).map(finger));
    }
    (places, parents)
}

fn flame(anatomy: &Anatomy) -> (Vec<Vec3>, Vec<Option<usize>>) {
    let at = |x, y, z| world(anatomy, [x, y, z]);
    let [jaw, left, right] = jaw_and_eyes(anatomy);
    let places = vec![at(0.0, -2.6, -1.6), at(0.0, -1.2, -1.1), jaw, left, right];
    (places, vec![None, Some(0), Some(1), Some(1), Some(1)])
}

/// Jaw, left and right eye. The jaw rotates about its hinges, slightly in front of and below the
/// ear openings.
fn jaw_and_eyes(anatomy: &Anatomy) -> [Vec3; 3] {
    let eye = |landmark| point(anatomy, landmark);
    [world(anatomy, [0.0, -0.75, -0.95]), eye(Landmark::LeftEye), eye(Landmark::RightEye)]
}

fn point(anatomy: &Anatomy, landmark: Landmark) -> Vec3 {
    let place = anatomy.point(landmark).expect("a template with a whole face");
    Vec3::from(place.map(|value| value as f32))
}

fn world(anatomy: &Anatomy, local: [f64; 3]) -> Vec3 {
    Vec3::from(anatomy.frame().world(local).map(|value| value as f32))
}

/// Skinning weights: the inverse sixth power of the distance from each joint's bones, for the four
/// nearest joints. Above the neck the skull takes over, and the jaw for lower lip and chin;
/// eyeballs follow their own joints rigidly.
fn weights(
    mesh: &Mesh,
    anatomy: &Anatomy,
    places: &[Vec3],
    parents: &[Option<usize>],
    [head, jaw, left_eye, right_eye]: [usize; 4],
) -> Vec<f32> {
    let count = places.len();
    let is_face = |joint: usize| [jaw, left_eye, right_eye].contains(&joint);
    let mut weights = vec![0.0; mesh.positions().len() * count];
    let eyeballs = eyeballs(mesh, anatomy);
    let upper = super::lips::upper(mesh, anatomy);
    for (vertex, row) in weights.chunks_mut(count).enumerate() {
        let place = Vec3::from(mesh.positions()[vertex]);
        if let Some(side) = eyeballs[vertex] {
            row[[left_eye, right_eye][side]] = 1.0;
            continue;
        }
        for joint in (0..count).filter(|&joint| !is_face(joint)) {
            let start = places[joint];
            let ends: Vec<Vec3> = (0..count)
                .filter(|&child| parents[child] == Some(joint) && !is_face(child))
                .map(|child| places[child])
                .collect();
            let ends =
                if ends.is_empty() { vec![end(joint, start, parents, places)] } else { ends };
            let near = ends.iter().map(|&end| distance(place, start, end)).fold(9.0, f32::min);
            // 3 mm is far below a skull's size, so that only adjacent bones share a vertex.
            row[joint] = (near + 0.003).powi(-6);
        }
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| row[b].total_cmp(&row[a]));
        order[4..].iter().for_each(|&joint| row[joint] = 0.0);
        let sum: f32 = row.iter().sum();
        row.iter_mut().for_each(|weight| *weight /= sum);
        let local = anatomy.frame().local(mesh.positions()[vertex].map(f64::from));
        // Above the neck, vertices follow the skull alone, and those of the chin the jaw.
        let skull = ramp(-2.5, -1.8, local[1] - 0.5 * local[2].clamp(-1.5, 0.0))
            * ramp(1.9, 1.4, local[0].abs());
        let skull = skull as f32;
        row.iter_mut().for_each(|weight| *weight *= 1.0 - skull);
        row[head] += skull;
        let share = jaw_share(local, f64::from(upper[vertex])) as f32;
        row.iter_mut().for_each(|weight| *weight *= 1.0 - share);
        row[jaw] = share;
    }
    weights
}

fn ramp(from: f64, to: f64, at: f64) -> f64 {
    let t = ((at - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Share of the jaw in the weights of the head: lower lip and chin, up to the line between the
/// lips.
fn jaw_share([x, y, z]: [f64; 3], upper: f64) -> f64 {
    // Lips stretch at the corners and part between them.
    let width = 0.02 + 0.5 * ramp(0.25, 0.6, x.abs());
    let line = ramp(width, -width, upper);
    let front = ramp(-1.6, -0.5, z) * ramp(-2.1, -1.5, y);
    line * front
}

/// For each vertex, the eyeball it is part of, if any; 0 is the left one.
pub(super) fn eyeballs(mesh: &Mesh, anatomy: &Anatomy) -> Vec<Option<usize>> {
    let centers = [Landmark::LeftEye, Landmark::RightEye].map(|eye| point(anatomy, eye));
    let radius = 0.26 * anatomy.frame().unit as f32;
    let mut sets = uvgraft::disjoint::DisjointSets::new(mesh.positions().len() as u32);
    for &[a, b, c] in mesh.faces() {
        sets.join(a, b);
        sets.join(b, c);
    }
    let roots: Vec<u32> =
        (0..mesh.positions().len() as u32).map(|vertex| sets.root(vertex)).collect();
    let mut inside = std::collections::HashMap::new();
    for (vertex, root) in roots.iter().enumerate() {
        let place = Vec3::from(mesh.positions()[vertex]);
        let near = centers.map(|center| place.distance(center) < radius);
        let entry = inside.entry(*root).or_insert([true; 2]);
        *entry = [entry[0] && near[0], entry[1] && near[1]];
    }
    roots.iter().map(|root| inside[root].iter().position(|&inside| inside)).collect()
}

/// Where the bone of a leaf joint ends: a short extension away from the parent.
fn end(joint: usize, start: Vec3, parents: &[Option<usize>], places: &[Vec3]) -> Vec3 {
    let from = parents[joint].map_or(start - Vec3::Y, |parent| places[parent]);
    // The head's bone points up rather than along the neck.
    let (along, length) =
        if joint == 15 || places.len() == 5 { (Vec3::Y, 0.15) } else { (start - from, 0.03) };
    start + along.normalize_or_zero() * length
}

fn distance(place: Vec3, start: Vec3, end: Vec3) -> f32 {
    let along = end - start;
    let t = ((place - start).dot(along) / along.length_squared().max(1e-9)).clamp(0.0, 1.0);
    place.distance(start + along * t)
}

/// Weights of nearby vertices that sum to 1 and reproduce a point: the least-squares solution.
fn between(mesh: &Mesh, place: Vec3) -> Vec<f32> {
    const NEAR: usize = 48;
    let positions = mesh.positions();
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|&a, &b| {
        let from = |vertex: usize| Vec3::from(positions[vertex]).distance_squared(place);
        from(a).total_cmp(&from(b)).then(a.cmp(&b))
    });
    order.truncate(NEAR);
    // Weights 1/n + d·g with the offsets d from the mean, where (Σ d dᵀ) g = place - mean.
    let mean = order.iter().map(|&at| Vec3::from(positions[at])).sum::<Vec3>() / NEAR as f32;
    let mut spread = glam::Mat3::from_diagonal(Vec3::splat(1e-9));
    for &at in &order {
        let d = Vec3::from(positions[at]) - mean;
        spread += glam::Mat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    let gradient = spread.inverse() * (place - mean);
    let mut parts = vec![0.0; positions.len()];
    for &at in &order {
        parts[at] = 1.0 / NEAR as f32 + (Vec3::from(positions[at]) - mean).dot(gradient);
    }
    parts
}

/// Ten smooth shape components: size, stoutness, legs, arms, and waves along the body.
pub(super) fn shapes(mesh: &Mesh) -> Vec<Vec<[f32; 3]>> {
    let wave = |component: usize, [x, y, z]: [f32; 3]| match component {
        0 => [0.03 * x, 0.03 * y, 0.03 * z],
        1 => [0.04 * x / (1.0 + 20.0 * x * x), 0.0, 0.06 * z],
        2 => [0.0, 0.06 * (y + 0.4).min(0.0), 0.0],
        3 => [0.02 * x.signum() * (x.abs() - 0.2).max(0.0), 0.0, 0.0],
        _ => {
            let phase = component as f32;
            let swell = 0.003 * (5.0 * y + phase).sin();
            [swell * (4.0 * x).tanh(), 0.002 * (3.0 * y * phase).sin(), swell * (9.0 * z).tanh()]
        }
    };
    let of = |component| mesh.positions().iter().map(|&place| wave(component, place)).collect();
    (0..10).map(of).collect()
}
