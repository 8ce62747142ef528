//! The true movements of a face: smooth, each given by a formula.
//!
//! Positions are in the head's coordinates: 1 is the distance between the eyes' centres, about 64
//! mm.

use glam::{Quat, Vec3};
use uvgraft::Mesh;
use uvgraft::anatomy::{Anatomy, Landmark};

/// A named movement.
#[derive(Debug, Clone)]
pub struct Truth {
    /// Its name.
    pub name: &'static str,
    /// Offset of each vertex, in the mesh's unit.
    pub offsets: Vec<[f32; 3]>,
}

/// Landmarks of a face, in the head's coordinates.
struct Face {
    mouth: Vec3,
    corner: Vec3,
    chin: Vec3,
    brow: Vec3,
    eye_radius: f32,
}

/// The offset of a skin point, given its position and its side of the lips: from 1 at the base of
/// the nose to -1 at the chin (see `lips::upper`).
type BlendBasis = fn(&Face, Vec3, f32) -> Vec3;

const MOVEMENTS: [(&str, BlendBasis); 20] = [
    ("blink left", |face, p, _| lids(face, p, 1.0, 1.0)),
    ("blink right", |face, p, _| lids(face, p, -1.0, 1.0)),
    ("squint", |face, p, _| lids(face, p, 1.0, 0.3) + lids(face, p, -1.0, 0.3)),
    ("eyes wide", |face, p, _| lids(face, p, 1.0, -0.25) + lids(face, p, -1.0, -0.25)),
    ("smile left", |face, p, _| corner(face, p, 1.0, Vec3::new(0.10, 0.11, -0.03))),
    ("smile right", |face, p, _| corner(face, p, -1.0, Vec3::new(0.10, 0.11, -0.03))),
    ("frown left", |face, p, _| corner(face, p, 1.0, Vec3::new(0.0, -0.10, 0.0))),
    ("frown right", |face, p, _| corner(face, p, -1.0, Vec3::new(0.0, -0.10, 0.0))),
    ("pucker", |face, p, _| {
        let near = blob(p - face.mouth, 0.38);
        Vec3::new(-0.32 * p.x * near, 0.0, 0.13 * near)
    }),
    ("stretch", |face, p, _| {
        corner(face, p, 1.0, Vec3::new(0.12, 0.0, -0.05))
            + corner(face, p, -1.0, Vec3::new(0.12, 0.0, -0.05))
    }),
    ("upper lip up", |face, p, upper| Vec3::Y * 0.09 * lip(face, p, upper)),
    ("lower lip down", |face, p, upper| Vec3::NEG_Y * 0.10 * lip(face, p, -upper)),
    ("inner brows up", |face, p, _| brow(face, p, 0.22, 0.11, 0.0)),
    ("outer brow up left", |face, p, _| brow(face, p, 0.75, 0.10, 1.0)),
    ("outer brow up right", |face, p, _| brow(face, p, 0.75, 0.10, -1.0)),
    ("brow down left", |face, p, _| {
        brow(face, p, 0.25, -0.09, 1.0) - Vec3::X * 0.5 * brow(face, p, 0.25, 0.09, 1.0).y
    }),
    ("brow down right", |face, p, _| {
        brow(face, p, 0.25, -0.09, -1.0) + Vec3::X * 0.5 * brow(face, p, 0.25, 0.09, -1.0).y
    }),
    ("cheeks puffed", |face, p, _| {
        let out = |s: f32| blob(p - Vec3::new(s * 0.65, face.mouth.y + 0.1, 0.2), 0.25) * s;
        Vec3::new(0.1 * (out(1.0) + out(-1.0)), 0.0, 0.04 * (out(1.0) - out(-1.0)))
    }),
    ("chin sideways", |face, p, _| Vec3::X * 0.1 * blob(p - face.chin, 0.4)),
    ("nose wrinkled", |face, p, _| {
        Vec3::Y * 0.06 * blob(p - Vec3::new(0.0, 0.6 * face.mouth.y, 0.5), 0.2)
    }),
];

/// All movements of a mesh's face.
pub(super) fn truths(mesh: &Mesh, anatomy: &Anatomy) -> Vec<Truth> {
    let frame = anatomy.frame();
    let local = |place: [f64; 3]| Vec3::from(frame.local(place).map(|value| value as f32));
    let at = |landmark| local(anatomy.point(landmark).expect("a template with a whole face"));
    let face = Face {
        mouth: at(Landmark::Mouth),
        corner: at(Landmark::LeftMouthCorner),
        chin: at(Landmark::Chin),
        brow: at(Landmark::BrowCenter),
        eye_radius: eye_radius(mesh, anatomy),
    };
    let places: Vec<Vec3> = mesh.positions().iter().map(|p| local(p.map(f64::from))).collect();
    let axes = frame.axes.map(|axis| Vec3::from(axis.map(|value| value as f32)));
    let upper = super::lips::upper(mesh, anatomy);
    let eyeballs = super::joints::eyeballs(mesh, anatomy);
    let offset = |movement: BlendBasis, vertex: usize| {
        if eyeballs[vertex].is_some() {
            return [0.0; 3];
        }
        let local = movement(&face, places[vertex], upper[vertex]) * frame.unit as f32;
        (axes[0] * local.x + axes[1] * local.y + axes[2] * local.z).into()
    };
    let vertices = 0..places.len();
    let truth = |(name, movement)| Truth {
        name,
        offsets: vertices.clone().map(|vertex| offset(movement, vertex)).collect(),
    };
    MOVEMENTS.into_iter().map(truth).collect()
}

/// Radius of an eyeball: the median distance from the left eye's centre to the eye area's vertices
/// around it.
fn eye_radius(mesh: &Mesh, anatomy: &Anatomy) -> f32 {
    let eyes = anatomy.area(uvgraft::anatomy::Area::Eyes);
    let center = anatomy.point(Landmark::LeftEye).expect("an eye").map(|value| value as f32);
    let of = |(vertex, place): (usize, &[f32; 3])| {
        let from = Vec3::from(*place).distance(Vec3::from(center)) / anatomy.frame().unit as f32;
        (eyes[vertex] > 0.5 && from < 0.3).then_some(from)
    };
    let mut all: Vec<f32> = mesh.positions().iter().enumerate().filter_map(of).collect();
    all.sort_by(f32::total_cmp);
    all[all.len() / 2]
}

fn blob(offset: Vec3, width: f32) -> f32 {
    (-offset.length_squared() / (2.0 * width * width)).exp()
}

fn smooth(from: f32, to: f32, at: f32) -> f32 {
    let t = ((at - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Rotates the lids of an eye about its centre until they meet, at `share` 1; negative values open
/// them.
fn lids(face: &Face, p: Vec3, side: f32, share: f32) -> Vec3 {
    /// Angle of the lid margins at the centre of the eye, and of the falloff beyond, in degrees.
    const MARGIN: f32 = 20.0;
    const BEYOND: f32 = 25.0;
    let q = p - Vec3::new(0.5 * side, 0.0, 0.0);
    let distance = q.length() / face.eye_radius;
    if distance > 1.9 || q.z < 0.0 {
        return Vec3::ZERO;
    }
    // The inner corner is closer to the centre of the eye than the outer one.
    let across = (q.x * side / q.length()).asin().to_degrees() - 5.0;
    let open = (1.0 - (across / 52.0).powi(2)).max(0.0).sqrt();
    let elevation = q.y.atan2(q.z).to_degrees();
    let meet = -0.65 * MARGIN * open;
    let (margin, outwards) =
        if elevation > 0.0 { (MARGIN * open, 1.0) } else { (-MARGIN * open, -1.0) };
    let beyond = (elevation - margin) * outwards;
    let follows = smooth(BEYOND, 0.0, beyond) * smooth(1.9, 1.3, distance);
    let turn = (meet - margin) * follows * share;
    // Lids slide slightly forward over the cornea.
    let turned = Quat::from_rotation_x(-turn.to_radians()) * q;
    turned * (1.0 + 0.04 * follows * share.max(0.0)) - q
}

/// Moves a corner of the mouth; `by` is given for the left one.
fn corner(face: &Face, p: Vec3, side: f32, by: Vec3) -> Vec3 {
    let at = Vec3::new(side * face.corner.x, face.corner.y, face.corner.z);
    Vec3::new(side * by.x, by.y, by.z) * blob(p - at, 0.24)
}

/// Weight of a lip's movement, where `side` is above 0 on that lip. It vanishes at the corners.
fn lip(face: &Face, p: Vec3, side: f32) -> f32 {
    let q = p - face.mouth;
    let on_side = smooth(-0.02, 0.02, side);
    let across = (1.0 - (q.x / face.corner.x).powi(2)).max(0.0);
    on_side * across * (-q.y * q.y / 0.05 - (q.z / 0.5).powi(2)).exp()
}

/// Moves the brows up by `by` around a distance from the midline, on one side or, if `side` is 0,
/// on both.
fn brow(face: &Face, p: Vec3, out: f32, by: f32, side: f32) -> Vec3 {
    let on = if side == 0.0 { 1.0 } else { smooth(-0.1, 0.1, side * p.x) };
    let q = Vec3::new(p.x.abs() - out, 0.7 * (p.y - face.brow.y), 0.3 * (p.z - face.brow.z));
    Vec3::Y * by * on * blob(q, 0.2) * smooth(0.12, 0.3, p.y)
}
