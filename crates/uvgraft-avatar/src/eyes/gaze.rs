//! An eyeball's gaze axis and the size of its iris, from its cornea.

use glam::Vec3;
use uvgraft::Mesh;

use super::eyeball::Eyeball;

/// Minimum bulge of a cornea, relative to the radius; less is due to the coarseness of a sphere.
const BULGE: f32 = 0.015;

/// How much more than its back an eyeball's front must bulge: coarse spheres are uneven all around.
const DISTINCT: f32 = 2.0;

/// Maximum angle between the eyes of a face at rest and straight ahead, in degrees.
const MAX_ASIDE: f32 = 25.0;

/// Angle between the iris' centre and its edge, seen from the centre of the eyeball, in degrees:
/// 5.9 mm at a radius of 12 mm. The extent of the bulge can change it only within this range.
const IRIS: f32 = 29.0;
const IRIS_RANGE: [f32; 2] = [24.0, 34.0];

/// An eyeball's gaze axis and iris.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gaze {
    pub center: Vec3,
    /// From the centre of the eyeball through that of the iris.
    pub axis: Vec3,
    /// The angle between the axis and the iris' edge, in radians.
    pub iris: f32,
}

impl Gaze {
    /// Falls back to +Z, which bodies at rest face, for eyes without a distinct cornea.
    pub fn new(mesh: &Mesh, eyeball: &Eyeball) -> Self {
        let offsets = || {
            let points = eyeball.vertices.iter().map(|&vertex| mesh.positions()[vertex as usize]);
            points.map(|point| Vec3::from(point) - eyeball.center)
        };
        let bulge = |offset: &Vec3| offset.length() / eyeball.radius - 1.0;
        let front = || offsets().filter(|offset| offset.z > 0.0);
        let most = front().map(|offset| bulge(&offset)).fold(0.0, f32::max);
        let behind = offsets().filter(|offset| offset.z <= 0.0).map(|offset| bulge(&offset));
        let behind = behind.fold(0.0, f32::max);
        let default = Self { center: eyeball.center, axis: Vec3::Z, iris: IRIS.to_radians() };
        if most < BULGE.max(DISTINCT * behind) {
            return default;
        }
        let cornea = || front().filter(|offset| bulge(offset) > 0.35 * most);
        let sum: Vec3 = cornea().map(|offset| offset.normalize() * bulge(&offset)).sum();
        let Some(axis) = sum.try_normalize() else { return default };
        if axis.angle_between(Vec3::Z) > MAX_ASIDE.to_radians() {
            return default;
        }
        let edge = cornea().map(|offset| offset.angle_between(axis)).fold(0.0, f32::max);
        let [least, greatest] = IRIS_RANGE.map(f32::to_radians);
        Self { axis, iris: edge.clamp(least, greatest), ..default }
    }

    /// Polar coordinates of a point: its angle from the axis in iris radii, and the angle around
    /// the axis, where 0 is to the person's left and a quarter turn is up.
    pub fn around(&self, point: Vec3) -> (f32, f32) {
        let direction = point - self.center;
        let left = Vec3::Y.cross(self.axis).normalize_or(Vec3::X);
        let up = self.axis.cross(left);
        let angle = direction.angle_between(self.axis);
        (angle / self.iris, direction.dot(up).atan2(direction.dot(left)))
    }
}
