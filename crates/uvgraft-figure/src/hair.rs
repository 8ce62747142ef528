//! The hair as a volume: a shell over the skull, thick on top and swept to one side, that dips
//! under the skin along the hairline.

use std::f32::consts::{PI, TAU};

use glam::{Vec3, vec3};
use uvgraft::easing::{bell, mix, smoothstep};

use super::features::disc;
use super::head_shape::skin;
use super::sdf::leave;
use super::surface::{BodyPart, PartKind, Side, Surface};
use crate::curve::curve;

const CENTRE: Vec3 = vec3(0.0, 2.0, -1.0);
/// Each lock has four columns, so that the boundaries of locks are mesh edges.
const AROUND: usize = 4 * LOCKS;
const LOCKS: usize = 20;
const RINGS: usize = 14;

/// Direction of a point from inside the skull, in spherical coordinates.
#[derive(Clone, Copy)]
pub(crate) struct Bearing {
    /// Azimuth: 0 in front, positive to the figure's left.
    pub around: f32,
    /// Polar angle from straight up.
    pub polar: f32,
}

impl Bearing {
    pub fn of(p: Vec3) -> Self {
        let q = (p - CENTRE).normalize_or_zero();
        Self { around: q.x.atan2(q.z), polar: q.y.clamp(-1.0, 1.0).acos() }
    }

    fn direction(self) -> Vec3 {
        let (sin, cos) = self.polar.sin_cos();
        vec3(sin * self.around.sin(), cos, sin * self.around.cos())
    }

    /// Polar angle relative to the hairline: 0 at the crown, 1 at the hairline.
    pub fn reach(self) -> f32 {
        self.polar / hairline(self.around)
    }

    /// Coordinate across the strands; neighbouring locks differ by 1.
    pub fn lock(self) -> f32 {
        let sweep = 1.5 * bell(self.around, 1.1) * smoothstep(0.25, 1.0, self.polar);
        LOCKS as f32 * (self.around / TAU) + 1.8 * sweep + 0.4 * self.polar
    }
}

/// Polar angle at which the hair ends.
fn hairline(around: f32) -> f32 {
    let degrees = curve(
        &[
            (0.0, 59.0),
            (25.0, 60.0),
            (42.0, 66.0),
            (55.0, 82.0),
            (66.0, 108.0),
            (74.0, 112.0),
            (82.0, 97.0),
            (94.0, 88.0),
            (106.0, 98.0),
            (118.0, 122.0),
            (150.0, 138.0),
            (180.0, 141.0),
        ],
        // Bearings slightly beyond the back wrap around to the other side.
        (PI - (around.abs() - PI).abs()).to_degrees(),
    );
    degrees.to_radians()
}

/// 1 at the centre of a lock and 0 at its edge, from the coordinate across the strands.
pub(crate) fn lock_middle(lock: f32) -> f32 {
    let t = (lock - lock.floor()) * 2.0 - 1.0;
    1.0 - t * t
}

/// The bearing with a lock coordinate at a radius of the disc, by bisection.
fn on_lock(lock: f32, radius: f32) -> Bearing {
    let at = |around: f32| Bearing { around, polar: radius * hairline(around) };
    let (mut low, mut high) = (-1.5 * PI, 1.5 * PI);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if at(middle).lock() < lock {
            low = middle;
        } else {
            high = middle;
        }
    }
    at(low)
}

pub(crate) fn shell() -> Surface {
    let mut surface = Surface::default();
    let part = BodyPart { kind: PartKind::Hair, side: Side::Both };
    let radii: Vec<f32> = (1..=RINGS).map(|k| k as f32 / RINGS as f32).collect();
    disc(&mut surface, part, AROUND, &radii, |radius, angle| {
        // On the disc the angle runs from the figure's left over its back.
        let mut around = PI * 0.5 + angle;
        if around > PI {
            around -= TAU;
        }
        let mut bearing = on_lock(LOCKS as f32 * around / TAU, radius);
        let around = bearing.around;
        let middle = lock_middle(bearing.lock() + 1e-3);
        let fringe = 0.03 + 0.07 * bell(around, 0.8);
        bearing.polar *= 1.0 + fringe * (middle - 0.5) * radius.powi(4);
        let surface = leave(skin, CENTRE, bearing.direction(), 16.0);
        let towards = bearing.direction();
        let degrees = bearing.polar.to_degrees();
        let full = mix(0.85, 1.9, smoothstep(100.0, 30.0, degrees))
            + 1.6 * bell(around - 0.25, 0.8) * smoothstep(12.0, 42.0, degrees)
            + 0.35 * smoothstep(2.0, 3.0, around.abs()) * smoothstep(140.0, 90.0, degrees);
        let edge = (1.0 - radius.powi(6)).max(0.0).sqrt();
        let groove = 0.3 * (1.0 - middle * smoothstep(0.05, 0.5, radius));
        surface + towards * ((full - groove) * edge - 0.3 * smoothstep(0.85, 1.0, radius))
    });
    surface
}
