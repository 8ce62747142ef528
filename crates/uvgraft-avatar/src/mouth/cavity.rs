//! The walls of a mouth: rings that continue from the rim behind the lips to a closed back.

use std::f32::consts::PI;

use glam::Vec3;
use uvgraft::easing::smoothstep;

use super::frame::Frame;
use super::piece::{Chart, Knot, Piece, Point};
use super::rim::Rim;
use crate::Avatar;
use crate::ray::intersect;

/// Distance of the teeth behind the innermost part of the lips, in millimetres.
const BEHIND_LIPS_MM: f32 = 1.8;

/// Maximum share of the distance from the centre of the mouth to the outer skin that
/// walls may take up.
const MAX_SHARE: f32 = 0.82;
/// Minimum distance of walls from the outer skin along that line, in millimetres.
const SKIN_MM: f32 = 4.0;

/// Dimensions of the mouth that all parts are fitted to.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// Positions of the rim's vertices, in mouth coordinates.
    pub rim: Vec<Vec3>,
    /// For each of them the angle around the mouth: π in the right corner, π/2 in the middle of the
    /// upper lip, 0 in the left corner, -π/2 in the middle of the lower lip.
    pub angles: Vec<f32>,
    /// Position of the front of the upper incisors.
    pub front_z: f32,
    /// Half the outer width of the upper arch of teeth.
    pub half_width: f32,
    /// Depth of the arch.
    pub depth: f32,
    /// Heights of roof and floor.
    pub roof_y: f32,
    pub floor_y: f32,
    /// Triangles of the head around the mouth, in mouth coordinates.
    skin: Vec<[Vec3; 3]>,
}

impl Fit {
    pub fn new(avatar: &Avatar, rim: &Rim, frame: &Frame) -> Self {
        const NEAR_MM: f32 = 130.0;
        let positions = avatar.mesh.positions();
        let points: Vec<Vec3> =
            rim.vertices.iter().map(|&vertex| frame.local(positions[vertex as usize])).collect();
        let is_central = |point: &&Vec3| point.x.abs() < 9.0;
        let innermost = points.iter().filter(is_central).map(|point| point.z).fold(0.0, f32::min);
        let most = |of: fn(&Vec3) -> f32| points.iter().map(of).fold(f32::NEG_INFINITY, f32::max);
        let reach = most(|point| point.x.abs());
        let near = avatar.mesh.faces().iter().zip(&rim.is_sack).filter(|(_, is_sack)| !**is_sack);
        let skin = near
            .map(|(face, _)| face.map(|vertex| frame.local(positions[vertex as usize])))
            .filter(|corners| corners.iter().all(|corner| corner.length() < NEAR_MM));
        Self {
            angles: angles(&points, rim.upper),
            front_z: innermost - BEHIND_LIPS_MM,
            half_width: (0.96 * reach).clamp(18.0, 26.0),
            depth: (1.5 * reach).clamp(30.0, 40.0),
            roof_y: most(|point| point.y).max(9.0) + 8.0,
            floor_y: -most(|point| -point.y).max(11.0) - 6.0,
            skin: skin.collect(),
            rim: points,
        }
    }

    /// Moves a point of a wall inwards if it is too close to the outer skin.
    fn within(&self, point: Vec3) -> Vec3 {
        let from = Vec3::new(0.0, 0.0, point.z.min(self.front_z));
        let Some(direction) = (point - from).try_normalize() else { return point };
        // The ray may pass through the lips; what matters is where it finally leaves the head.
        let out = self.skin.iter().filter_map(|corners| exits(from, direction, corners));
        let out = out.fold(0.0, f32::max);
        let length = (point - from).length();
        if out == 0.0 || length <= 0.0 {
            return point;
        }
        from + direction * length.min(MAX_SHARE * out).min((out - SKIN_MM).max(0.0))
    }
}

/// Angles around the mouth, proportional to the arc length along the rim.
fn angles(points: &[Vec3], upper: usize) -> Vec<f32> {
    let count = points.len();
    let step = |k: usize| points[(k + 1) % count].distance(points[k]);
    let total = |steps: std::ops::Range<usize>| steps.map(step).sum::<f32>().max(f32::MIN_POSITIVE);
    let (over, under) = (total(0..upper), total(upper..count));
    let (mut angles, mut along) = (Vec::with_capacity(count), 0.0);
    for k in 0..count {
        angles.push(if k < upper {
            PI * (1.0 - along / over)
        } else {
            -PI * (along - over) / under
        });
        along += step(k);
    }
    angles
}

/// Where a ray from the inside leaves through a triangle, as a distance along the ray.
fn exits(from: Vec3, direction: Vec3, corners: &[Vec3; 3]) -> Option<f32> {
    let &[a, b, c] = corners;
    let is_outwards = (b - a).cross(c - a).dot(direction) > 0.0;
    is_outwards.then(|| intersect(from, direction, corners))?.map(|hit| hit.distance)
}

/// Shape of a ring of the walls.
struct Ring {
    /// Width, relative to the arch's.
    width: f32,
    /// Height, relative to roof and floor.
    height: f32,
    /// Distance behind the front of the teeth.
    back_mm: f32,
    /// Share of the rim's curve in depth, which fades out towards the back.
    curve: f32,
    /// Share of the lips' motion.
    lips: f32,
}

const RINGS: [Ring; 4] = [
    Ring { width: 1.14, height: 1.0, back_mm: 4.0, curve: 0.8, lips: 0.3 },
    Ring { width: 1.28, height: 1.0, back_mm: 20.0, curve: 0.25, lips: 0.05 },
    Ring { width: 1.12, height: 0.9, back_mm: 38.0, curve: 0.0, lips: 0.0 },
    Ring { width: 0.62, height: 0.62, back_mm: 50.0, curve: 0.0, lips: 0.0 },
];

/// The walls, facing the inside of the mouth.
pub(super) fn piece(fit: &Fit) -> Piece {
    let mut piece = Piece::new(Chart::Cavity);
    let count = fit.rim.len();
    let rings = RINGS.len() + 2;
    let s = |k: usize| k as f32 / count as f32;
    let t = |ring: usize| ring as f32 / rings as f32;
    let mut rows: Vec<Vec<(Knot, [f32; 2])>> =
        vec![(0..=count).map(|k| (Knot::Rim(k % count), [s(k), 0.0])).collect()];
    for ring in 1..rings {
        let knots: Vec<Knot> = (0..count).map(|k| piece.point(wall(fit, ring, k))).collect();
        rows.push((0..=count).map(|k| (knots[k % count], [s(k), t(ring)])).collect());
    }
    let back = Vec3::new(0.0, 0.2 * fit.floor_y, fit.front_z - 53.0);
    let center = piece.point(Point { position: back, lower: 0.4, rim: None });
    // From the inside the rim is seen from behind, so columns run to the left.
    piece.grid(&rows, true);
    let last = rows.last().cloned().unwrap_or_default();
    for pair in last.windows(2) {
        let first = piece.corners.len() as u32;
        let s = 0.5 * (pair[0].1[0] + pair[1].1[0]);
        piece.corners.extend([pair[0], pair[1], (center, [s, 1.0])]);
        piece.faces.push([first + 1, first, first + 2]);
    }
    piece
}

fn wall(fit: &Fit, ring: usize, k: usize) -> Point {
    let (rim, angle) = (fit.rim[k], fit.angles[k]);
    let (sin, cos) = angle.sin_cos();
    // The walls are superellipses, fuller than an ellipse.
    let full = |value: f32| value.signum() * value.abs().powf(0.75);
    let lower = 0.5 - 0.5 * sin.signum() * smoothstep(0.0, 0.6, sin.abs());
    if ring == 1 {
        let point = rim + Vec3::new(1.5 * cos, 3.5 * full(sin), -1.2);
        return Point { position: fit.within(point), lower, rim: Some((k, 0.75)) };
    }
    let Ring { width, height, back_mm, curve, lips } = RINGS[ring - 2];
    let y = if sin > 0.0 { fit.roof_y } else { -fit.floor_y };
    let z = fit.front_z - back_mm + curve * (rim.z - fit.front_z).min(0.0);
    let point = Vec3::new(width * fit.half_width * full(cos), height * y * full(sin), z);
    Point { position: fit.within(point), lower, rim: Some((k, lips)) }
}
