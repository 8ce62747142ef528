//! Where an eyeball looks, and how large its iris is, by its cornea.

use glam::Vec3;
use uvgraft::Mesh;

use super::eyeball::Eyeball;

/// How far a cornea bulges at least, in parts of the radius; less is how coarse a sphere is.
const BULGE: f32 = 0.015;

/// How far eyes of a face at rest may look aside, in degrees.
const MOST_ASIDE: f32 = 25.0;

/// The angle between an iris' middle and its edge, seen from the middle of the eyeball, in degrees: 5.9 mm of
/// 12 mm. What bulges says more only within some degrees of that.
const IRIS: f32 = 29.0;
const IRIS_RANGE: [f32; 2] = [24.0, 34.0];

/// An eyeball's axis and iris.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gaze {
    pub center: Vec3,
    /// From the middle of the eyeball through that of the iris.
    pub axis: Vec3,
    /// The angle between the axis and the iris' edge, in radians.
    pub iris: f32,
}

impl Gaze {
    /// Bodies at rest face +Z, and so do eyes without a cornea.
    pub fn new(mesh: &Mesh, eyeball: &Eyeball) -> Self {
        let offsets = || {
            let places = eyeball.vertices.iter().map(|&vertex| mesh.positions()[vertex as usize]);
            places.map(|place| Vec3::from(place) - eyeball.center)
        };
        let bulge = |offset: &Vec3| offset.length() / eyeball.radius - 1.0;
        let front = || offsets().filter(|offset| offset.z > 0.0);
        let most = front().map(|offset| bulge(&offset)).fold(0.0, f32::max);
        let default = Self { center: eyeball.center, axis: Vec3::Z, iris: IRIS.to_radians() };
        if most < BULGE {
            return default;
        }
        let cornea = || front().filter(|offset| bulge(offset) > 0.35 * most);
        let sum: Vec3 = cornea().map(|offset| offset.normalize() * bulge(&offset)).sum();
        let Some(axis) = sum.try_normalize() else { return default };
        if axis.angle_between(Vec3::Z) > MOST_ASIDE.to_radians() {
            return default;
        }
        let edge = cornea().map(|offset| offset.angle_between(axis)).fold(0.0, f32::max);
        let [least, greatest] = IRIS_RANGE.map(f32::to_radians);
        Self { axis, iris: edge.clamp(least, greatest), ..default }
    }

    /// How far a place is from the axis, in irises, and where around it: 0 to the person's left, a quarter turn
    /// up.
    pub fn around(&self, place: Vec3) -> (f32, f32) {
        let direction = place - self.center;
        let left = Vec3::Y.cross(self.axis).normalize_or(Vec3::X);
        let up = self.axis.cross(left);
        let angle = direction.angle_between(self.axis);
        (angle / self.iris, direction.dot(up).atan2(direction.dot(left)))
    }
}
