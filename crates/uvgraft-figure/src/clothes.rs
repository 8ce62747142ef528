//! Chest skin, shirt, sleeves, trousers and shoes as tubes around the trunk and limbs.

use std::f32::consts::TAU;

use glam::{Vec3, vec3};
use uvgraft::easing::mix;

use super::body_shape::{ARM, ARM_BACK, ARM_FRONT, SHOULDER, shirt, shoe, sleeve, trousers, trunk};
use super::head::{COLUMNS, azimuth};
use super::sdf::leave;
use super::surface::{BodyPart, Knot, PartKind, Side, Surface};
use crate::curve::curve;

/// A tube of `rings` rings, each with `around` vertices. `position` maps a turn in `0.0..1.0`,
/// counterclockwise seen from the tube's start, and the ring's index to a point. Returns the first
/// and last ring, both with the second corner at the chart seam.
pub(crate) fn tube(
    surface: &mut Surface,
    part: BodyPart,
    around: usize,
    rings: usize,
    position: impl Fn(f32, usize) -> Vec3,
) -> [Vec<Knot>; 2] {
    let mut first: Option<Vec<Knot>> = None;
    let mut last: Vec<Knot> = Vec::new();
    for ring in 0..rings {
        let along = mix(0.04, 0.96, ring as f32 / (rings - 1) as f32);
        let mut row: Vec<Knot> = (0..around)
            .map(|k| {
                let turn = k as f32 / around as f32;
                surface.knot(position(turn, ring), [turn, along])
            })
            .collect();
        row.push(Knot { at: [1.0, along], ..row[0] });
        if !last.is_empty() {
            surface.strip(part, &last, &row);
        }
        first.get_or_insert_with(|| row.clone());
        last = row;
    }
    [first.unwrap_or_default(), last]
}

/// Skin from the boundary at the base of the neck, given by column, to below the shirt's collar.
pub(crate) fn chest(surface: &mut Surface, rim: &[u32]) {
    const ROWS: usize = 6;
    let part = BodyPart { kind: PartKind::Chest, side: Side::Both };
    let inside = vec3(0.0, 130.0, -1.6);
    let mut last: Vec<Knot> = Vec::new();
    for row in 0..ROWS {
        let along = row as f32 / (ROWS - 1) as f32;
        let mut knots: Vec<Knot> = (0..COLUMNS)
            .map(|column| {
                let at = [column as f32 / COLUMNS as f32, along];
                let start = surface.positions[rim[column] as usize];
                if row == 0 {
                    return Knot { vertex: rim[column], at };
                }
                let around = azimuth(column);
                let end = vec3(around.sin(), 1.1, around.cos()).normalize_or_zero();
                let towards = (start - inside)
                    .normalize_or_zero()
                    .lerp_monotonic(end, along)
                    .normalize_or_zero();
                surface.knot(leave(trunk, inside, towards, 40.0), at)
            })
            .collect();
        knots.push(Knot { at: [1.0, along], ..knots[0] });
        if row > 0 {
            surface.strip(part, &last, &knots);
        }
        last = knots;
    }
}

/// Elevation of the rays to the shirt's collar, in degrees, by azimuth around the neck: 0 in front.
pub(crate) fn collar(around: f32) -> f32 {
    72.2 - 2.8 * around.cos() - 0.4 * (2.0 * around).cos()
}

/// Height of the shirt's hem.
pub(crate) const HEM: f32 = 86.5;
/// Origin of the rays that shape the shirt's upper part.
pub(crate) const SHIRT_CENTRE: Vec3 = vec3(0.0, 128.0, -1.6);

pub(crate) fn torso(surface: &mut Surface) {
    const COLLAR_ROWS: [(f32, f32); 5] =
        [(-3.5, -1.8), (0.0, 0.35), (-2.2, 0.5), (-4.4, 0.4), (-5.2, 0.0)];
    const SHOULDER_ROWS: usize = 17;
    const CHEST_ROWS: usize = 14;
    let part = BodyPart { kind: PartKind::Shirt, side: Side::Both };
    let rings = COLLAR_ROWS.len() + SHOULDER_ROWS + CHEST_ROWS + 1;
    tube(surface, part, 56, rings, |turn, ring| {
        // The chart seam is at the back.
        let around = TAU * (turn - 0.5);
        let towards = vec3(around.sin(), 0.0, around.cos());
        let fan = |degrees: f32, lift: f32| {
            let (up, out) = degrees.to_radians().sin_cos();
            let direction = towards * out + vec3(0.0, up, 0.0);
            leave(shirt, SHIRT_CENTRE, direction, 50.0) + direction * lift
        };
        if let Some(&(degrees, lift)) = COLLAR_ROWS.get(ring) {
            return fan(collar(around) + degrees, lift);
        }
        let ring = ring - COLLAR_ROWS.len();
        if ring < SHOULDER_ROWS {
            let t = (ring + 1) as f32 / SHOULDER_ROWS as f32;
            return fan(mix(collar(around) - 5.2, 0.0, t), 0.0);
        }
        let down = (ring + 1 - SHOULDER_ROWS) as f32 / CHEST_ROWS as f32;
        let y = mix(SHIRT_CENTRE.y, HEM, down.min(1.0));
        let p = leave(shirt, vec3(0.0, y, SHIRT_CENTRE.z), towards, 50.0);
        if down > 1.0 { p - towards * 1.2 + vec3(0.0, 1.0, 0.0) } else { p }
    });
}

/// The left sleeve, from inside the shirt to its hem.
pub(crate) fn left_sleeve(surface: &mut Surface) {
    const ALONG: [f32; 11] = [-3.5, -1.0, 1.5, 4.0, 7.0, 10.0, 13.0, 16.0, 18.6, 20.0, 20.2];
    let part = BodyPart { kind: PartKind::Sleeve, side: Side::Left };
    tube(surface, part, 28, ALONG.len() + 1, |turn, ring| {
        // The chart seam is underneath.
        let (sin, cos) = (TAU * (turn - 0.25)).sin_cos();
        let towards = ARM_FRONT * cos + ARM_BACK * sin;
        let hem = ring >= ALONG.len() - 1;
        let along = ALONG[ring.min(ALONG.len() - 1)] - if ring == ALONG.len() { 1.5 } else { 0.0 };
        // Rays end at the tube's radius: towards the chest the sleeve's surface is inside the
        // shirt.
        let reach = curve(&[(0.0, 6.6), (20.0, 7.2)], along);
        let p = leave(sleeve, SHOULDER + ARM * along, towards, reach);
        // The root is sunk into the shirt, so that the shirt's own surface is in front there.
        let sunk = if hem { 0.55 } else { curve(&[(-3.5, 1.6), (-1.0, 0.8), (3.0, 0.0)], along) };
        p - towards * sunk
    });
}

/// The left trouser leg with its half of the hips; both halves meet at the centre plane.
pub(crate) fn left_leg(surface: &mut Surface) {
    const RINGS: usize = 31;
    let part = BodyPart { kind: PartKind::Leg, side: Side::Left };
    tube(surface, part, 30, RINGS, |turn, ring| {
        // The chart seam is on the inside of the leg.
        let (sin, cos) = (TAU * (turn - 0.25)).sin_cos();
        let towards = vec3(sin, 0.0, cos);
        let down = (ring as f32 / (RINGS - 2) as f32).min(1.0);
        let y = mix(98.0, 4.0, down);
        let axis = curve(&[(4.0, 9.9), (50.0, 9.3), (90.0, 8.4)], y);
        let depth = curve(&[(4.0, -1.9), (50.0, 0.2), (90.0, -0.9)], y);
        let reach = if towards.x < 0.0 { (axis / -towards.x).min(30.0) } else { 30.0 };
        let p = leave(trousers, vec3(axis, y, depth), towards, reach);
        if ring == RINGS - 1 { p - towards + vec3(0.0, 1.2, 0.0) } else { p }
    });
}

/// The left shoe.
pub(crate) fn left_shoe(surface: &mut Surface) {
    const ALONG: [f32; 17] = [
        -7.9, -7.2, -6.0, -4.4, -2.4, 0.0, 2.2, 4.4, 6.6, 8.6, 10.4, 12.0, 13.4, 14.8, 15.9, 16.6,
        17.0,
    ];
    let part = BodyPart { kind: PartKind::Shoe, side: Side::Left };
    let turned = |p: Vec3| {
        let (sin, cos) = 0.13_f32.sin_cos();
        let q = p - vec3(10.2, 0.0, -3.0);
        vec3(10.2 + q.x * cos + q.z * sin, q.y, -3.0 - q.x * sin + q.z * cos)
    };
    let [heel, toe] = tube(surface, part, 26, ALONG.len(), |turn, ring| {
        let (sin, cos) = (TAU * (turn + 0.5)).sin_cos();
        let centre = vec3(10.2, 1.6, ALONG[ring]);
        turned(leave(shoe, centre, vec3(sin, cos, 0.0), 12.0))
    });
    let heel_tip = surface.knot(turned(vec3(10.2, 1.7, -8.1)), [0.5, 0.0]);
    surface.cap_above(part, heel_tip, &heel);
    let toe_tip = surface.knot(turned(vec3(10.4, 1.6, 17.3)), [0.5, 1.0]);
    surface.cap_below(part, &toe, toe_tip);
}
