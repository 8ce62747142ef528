//! The walls of a mouth: rings that go on from the rim behind the lips to a closed back.

use std::f32::consts::PI;

use glam::Vec3;
use uvgraft::easing::smoothstep;

use super::frame::Frame;
use super::piece::{Chart, Knot, Piece, Point};
use super::rim::Rim;
use crate::Avatar;
use crate::ray::meets;

/// How far teeth are behind the innermost of the lips, in millimetres.
const BEHIND_LIPS_MM: f32 = 1.8;

/// How much of the way from the middle of the mouth to the skin outside walls may take.
const MOST_OF_WAY: f32 = 0.82;
/// What walls leave to the skin outside, in millimetres, measured along that way.
const SKIN_MM: f32 = 4.0;

/// What all parts are fitted to.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// The rim's places, in the mouth's coordinates.
    pub rim: Vec<Vec3>,
    /// Of each, the angle around the mouth: π in the right corner, π/2 in the middle of the upper lip, 0 in the
    /// left corner, -π/2 in the middle of the lower lip.
    pub angles: Vec<f32>,
    /// Where the front of the upper incisors is.
    pub front_z: f32,
    /// Half the width of the upper arch of teeth, outside.
    pub half_width: f32,
    /// How far the arch goes back.
    pub depth: f32,
    /// Roof and floor.
    pub roof_y: f32,
    pub floor_y: f32,
    /// Triangles of the head around the mouth, in the mouth's coordinates.
    skin: Vec<[Vec3; 3]>,
}

impl Fit {
    pub fn new(avatar: &Avatar, rim: &Rim, frame: &Frame) -> Self {
        const NEAR_MM: f32 = 130.0;
        let positions = avatar.mesh.positions();
        let places: Vec<Vec3> =
            rim.vertices.iter().map(|&vertex| frame.local(positions[vertex as usize])).collect();
        let middle = |place: &&Vec3| place.x.abs() < 9.0;
        let innermost = places.iter().filter(middle).map(|place| place.z).fold(0.0, f32::min);
        let most = |of: fn(&Vec3) -> f32| places.iter().map(of).fold(f32::NEG_INFINITY, f32::max);
        let reach = most(|place| place.x.abs());
        let near = avatar.mesh.faces().iter().zip(&rim.is_sack).filter(|(_, is_sack)| !**is_sack);
        let skin = near
            .map(|(face, _)| face.map(|vertex| frame.local(positions[vertex as usize])))
            .filter(|corners| corners.iter().all(|corner| corner.length() < NEAR_MM));
        Self {
            angles: angles(&places, rim.upper),
            front_z: innermost - BEHIND_LIPS_MM,
            half_width: (0.96 * reach).clamp(18.0, 26.0),
            depth: (1.5 * reach).clamp(30.0, 40.0),
            roof_y: most(|place| place.y).max(9.0) + 8.0,
            floor_y: -most(|place| -place.y).max(11.0) - 6.0,
            skin: skin.collect(),
            rim: places,
        }
    }

    /// A place of a wall, no nearer to the skin outside than walls may be.
    fn within(&self, place: Vec3) -> Vec3 {
        let from = Vec3::new(0.0, 0.0, place.z.min(self.front_z));
        let Some(direction) = (place - from).try_normalize() else { return place };
        // The way out may pass through the lips: what counts is where it leaves the head.
        let out = self.skin.iter().filter_map(|corners| leaves(from, direction, corners));
        let out = out.fold(0.0, f32::max);
        let length = (place - from).length();
        if out == 0.0 || length <= 0.0 {
            return place;
        }
        from + direction * length.min(MOST_OF_WAY * out).min((out - SKIN_MM).max(0.0))
    }
}

/// Angles around the mouth by the way along the rim.
fn angles(places: &[Vec3], upper: usize) -> Vec<f32> {
    let count = places.len();
    let step = |k: usize| places[(k + 1) % count].distance(places[k]);
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

/// How far along a ray it leaves through a triangle, seen from whose inside it comes.
fn leaves(from: Vec3, direction: Vec3, corners: &[Vec3; 3]) -> Option<f32> {
    let &[a, b, c] = corners;
    let is_outwards = (b - a).cross(c - a).dot(direction) > 0.0;
    is_outwards.then(|| meets(from, direction, corners))?.map(|met| met.distance)
}

/// A ring of the walls.
struct Ring {
    /// Half its width, in parts of the arch's.
    width: f32,
    /// Roof and floor, in parts of the fit's.
    height: f32,
    /// How far it is behind the front of the teeth; the rim's own curve fades out.
    back_mm: f32,
    /// How much of the rim's curve is left.
    curve: f32,
    /// How far it follows the lips.
    lips: f32,
}

const RINGS: [Ring; 4] = [
    Ring { width: 1.14, height: 1.0, back_mm: 4.0, curve: 0.8, lips: 0.3 },
    Ring { width: 1.28, height: 1.0, back_mm: 20.0, curve: 0.25, lips: 0.05 },
    Ring { width: 1.12, height: 0.9, back_mm: 38.0, curve: 0.0, lips: 0.0 },
    Ring { width: 0.62, height: 0.62, back_mm: 50.0, curve: 0.0, lips: 0.0 },
];

/// The walls, seen from within the mouth.
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
    let middle = piece.point(Point { place: back, lower: 0.4, rim: None });
    // From within, the rim is seen from behind: along it columns go to the left.
    piece.grid(&rows, true);
    let last = rows.last().cloned().unwrap_or_default();
    for pair in last.windows(2) {
        let first = piece.corners.len() as u32;
        let s = 0.5 * (pair[0].1[0] + pair[1].1[0]);
        piece.corners.extend([pair[0], pair[1], (middle, [s, 1.0])]);
        piece.faces.push([first + 1, first, first + 2]);
    }
    piece
}

fn wall(fit: &Fit, ring: usize, k: usize) -> Point {
    let (rim, angle) = (fit.rim[k], fit.angles[k]);
    let (sin, cos) = angle.sin_cos();
    // Round corners: walls are fuller than an ellipse.
    let full = |value: f32| value.signum() * value.abs().powf(0.75);
    let lower = 0.5 - 0.5 * sin.signum() * smoothstep(0.0, 0.6, sin.abs());
    if ring == 1 {
        let place = rim + Vec3::new(1.5 * cos, 3.5 * full(sin), -1.2);
        return Point { place: fit.within(place), lower, rim: Some((k, 0.75)) };
    }
    let Ring { width, height, back_mm, curve, lips } = RINGS[ring - 2];
    let y = if sin > 0.0 { fit.roof_y } else { -fit.floor_y };
    let z = fit.front_z - back_mm + curve * (rim.z - fit.front_z).min(0.0);
    let place = Vec3::new(width * fit.half_width * full(cos), height * y * full(sin), z);
    Point { place: fit.within(place), lower, rim: Some((k, lips)) }
}
