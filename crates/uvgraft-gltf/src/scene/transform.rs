//! Quaternions `[x, y, z, w]` and affine maps, as glTF uses them.

use glam::{Vec3, vec3};

/// A rotation of unit length: x, y, z, w.
pub(crate) type Quaternion = [f32; 4];

pub(crate) const NO_TURN: Quaternion = [0.0, 0.0, 0.0, 1.0];

/// First `b`, then `a`.
pub(crate) fn product(a: Quaternion, b: Quaternion) -> Quaternion {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

pub(crate) fn inverse([x, y, z, w]: Quaternion) -> Quaternion {
    [-x, -y, -z, w]
}

/// Unit length; what has none, or is no number, turns nothing.
pub(crate) fn normalized(q: Quaternion) -> Quaternion {
    let length = q.iter().map(|value| value * value).sum::<f32>().sqrt();
    if length > 0.0 && length.is_finite() { q.map(|value| value / length) } else { NO_TURN }
}

pub(crate) fn rotate(q: Quaternion, v: Vec3) -> Vec3 {
    let axis = vec3(q[0], q[1], q[2]);
    let twice = axis.cross(v) * 2.0;
    v + twice * q[3] + axis.cross(twice)
}

/// Along the shorter great circle, at even speed.
pub(crate) fn slerp(a: Quaternion, b: Quaternion, t: f32) -> Quaternion {
    let dot: f32 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let b = if dot < 0.0 { b.map(|value| -value) } else { b };
    let angle = dot.abs().min(1.0).acos();
    // Where the sine vanishes, the arc is a line.
    let (from, to) = if angle < 1e-3 {
        (1.0 - t, t)
    } else {
        (((1.0 - t) * angle).sin() / angle.sin(), (t * angle).sin() / angle.sin())
    };
    normalized([0, 1, 2, 3].map(|k| a[k] * from + b[k] * to))
}

/// Turns about X, then about the fixed Y, then about the fixed Z axis, in degrees.
pub(crate) fn from_degrees(angles: [f32; 3]) -> Quaternion {
    let [x, y, z] = angles.map(|angle| (0.5 * angle.to_radians()).sin_cos());
    let about_x = [x.0, 0.0, 0.0, x.1];
    let about_y = [0.0, y.0, 0.0, y.1];
    let about_z = [0.0, 0.0, z.0, z.1];
    product(about_z, product(about_y, about_x))
}

/// The smallest turn that takes one direction to another; both of any length.
pub(crate) fn between(from: Vec3, to: Vec3) -> Quaternion {
    let (from, to) = (from.normalize_or_zero(), to.normalize_or_zero());
    let axis = from.cross(to);
    let w = 1.0 + from.dot(to);
    if w < 1e-6 {
        // Opposite: half a turn about anything square to it.
        let side = if from.x.abs() < 0.7 { vec3(1.0, 0.0, 0.0) } else { vec3(0.0, 1.0, 0.0) };
        let axis = from.cross(side).normalize_or_zero();
        return [axis.x, axis.y, axis.z, 0.0];
    }
    normalized([axis.x, axis.y, axis.z, w])
}

/// Translation, rotation and scale of a node, relative to its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// In the parent's unit.
    pub translation: [f32; 3],
    /// A unit quaternion: x, y, z, w.
    pub rotation: [f32; 4],
    /// Along the node's own axes.
    pub scale: [f32; 3],
}

impl Default for Placement {
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation: NO_TURN, scale: [1.0; 3] }
    }
}

/// `p ↦ x·p.x + y·p.y + z·p.z + shift`: three columns and a shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Affine {
    pub columns: [Vec3; 3],
    pub shift: Vec3,
}

impl Affine {
    pub const IDENTITY: Self = Self {
        columns: [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)],
        shift: vec3(0.0, 0.0, 0.0),
    };

    /// Nothing at all: where sums of maps start.
    pub const ZERO: Self = Self { columns: [vec3(0.0, 0.0, 0.0); 3], shift: vec3(0.0, 0.0, 0.0) };

    /// From sixteen values by columns; the last row is taken for 0, 0, 0, 1.
    pub fn from_columns(m: &[f32; 16]) -> Self {
        let column = |k: usize| vec3(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
        Self { columns: [column(0), column(1), column(2)], shift: column(3) }
    }

    pub fn of(placement: &Placement) -> Self {
        let axes = Self::IDENTITY.columns.map(|axis| rotate(placement.rotation, axis));
        let [x, y, z] = placement.scale;
        Self {
            columns: [axes[0] * x, axes[1] * y, axes[2] * z],
            shift: placement.translation.into(),
        }
    }

    pub fn direction(&self, v: Vec3) -> Vec3 {
        self.columns[0] * v.x + self.columns[1] * v.y + self.columns[2] * v.z
    }

    pub fn point(&self, p: Vec3) -> Vec3 {
        self.direction(p) + self.shift
    }

    /// First `other`, then this.
    pub fn after(&self, other: &Self) -> Self {
        Self {
            columns: other.columns.map(|column| self.direction(column)),
            shift: self.point(other.shift),
        }
    }

    pub fn plus(&self, other: &Self, weight: f32) -> Self {
        let mut sum = *self;
        for (column, more) in sum.columns.iter_mut().zip(other.columns) {
            *column = *column + more * weight;
        }
        sum.shift = sum.shift + other.shift * weight;
        sum
    }

    pub fn determinant(&self) -> f32 {
        let [x, y, z] = self.columns;
        x.dot(y.cross(z))
    }

    /// The map of normals, up to their length: they stay square to what this map turns and stretches.
    pub fn of_normals(&self) -> [Vec3; 3] {
        let [x, y, z] = self.columns;
        let sign = if self.determinant() < 0.0 { -1.0 } else { 1.0 };
        [y.cross(z) * sign, z.cross(x) * sign, x.cross(y) * sign]
    }

    /// The nearest thing to this map that has no shear.
    pub fn placement(&self) -> Placement {
        let mut scale = self.columns.map(Vec3::length);
        if self.determinant() < 0.0 {
            scale[0] = -scale[0];
        }
        let mut axes = self.columns;
        for (axis, scale) in axes.iter_mut().zip(scale) {
            *axis = if scale == 0.0 { *axis } else { *axis * (1.0 / scale) };
        }
        Placement { translation: self.shift.into(), rotation: rotation_of(axes), scale }
    }
}

/// The rotation whose axes these are.
///
/// # Source
/// Shepperd, "Quaternion from Rotation Matrix", 1978: the largest component is found first, so that
/// nothing small is divided by.
fn rotation_of([x, y, z]: [Vec3; 3]) -> Quaternion {
    let squares = [
        1.0 + x.x - y.y - z.z,
        1.0 - x.x + y.y - z.z,
        1.0 - x.x - y.y + z.z,
        1.0 + x.x + y.y + z.z,
    ];
    let largest = (0..4).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
    let (xy, yz, zx) = (x.y + y.x, y.z + z.y, z.x + x.z);
    let (dx, dy, dz) = (y.z - z.y, z.x - x.z, x.y - y.x);
    let square = squares[largest];
    normalized(match largest {
        0 => [square, xy, zx, dx],
        1 => [xy, square, yz, dy],
        2 => [zx, yz, square, dz],
        _ => [dx, dy, dz, square],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Vec3, b: Vec3) -> bool {
        (a - b).length() < 1e-5
    }

    #[test]
    fn turns_go_the_right_way_round_in_the_right_order() {
        let v = rotate(from_degrees([0.0, 0.0, 90.0]), vec3(1.0, 0.0, 0.0));
        assert!(near(v, vec3(0.0, 1.0, 0.0)), "{v:?}");
        // X takes Y to Z; then Y takes Z to X; then Z takes X to Y.
        let v = rotate(from_degrees([90.0, 90.0, 90.0]), vec3(0.0, 1.0, 0.0));
        assert!(near(v, vec3(0.0, 1.0, 0.0)), "{v:?}");
        let v = rotate(from_degrees([90.0, 90.0, 0.0]), vec3(0.0, 1.0, 0.0));
        assert!(near(v, vec3(1.0, 0.0, 0.0)), "{v:?}");
    }

    #[test]
    fn slerp_goes_the_short_way_at_even_speed() {
        let quarter = from_degrees([0.0, 90.0, 0.0]);
        for end in [quarter, quarter.map(|value| -value)] {
            let third = slerp(NO_TURN, end, 1.0 / 3.0);
            let wanted = from_degrees([0.0, 30.0, 0.0]);
            assert!(third.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{third:?}");
        }
    }

    #[test]
    fn a_matrix_gives_back_what_it_was_made_of() {
        for angles in [[10.0, 20.0, 30.0], [170.0, 5.0, 0.0], [0.0, 179.0, 3.0], [0.0, 2.0, 178.0]]
        {
            let placement = Placement {
                translation: [1.0, -2.0, 3.0],
                rotation: from_degrees(angles),
                scale: [-2.0, 0.5, 3.0],
            };
            let again = Affine::of(&Affine::of(&placement).placement());
            for (a, b) in again.columns.into_iter().zip(Affine::of(&placement).columns) {
                assert!(near(a, b), "{angles:?}");
            }
        }
    }

    #[test]
    fn directions_are_taken_to_each_other_even_opposite_ones() {
        for (from, to) in [
            (vec3(0.0, -2.0, 0.0), vec3(1.0, 0.0, 0.0)),
            (vec3(1.0, 0.0, 0.0), vec3(-3.0, 0.0, 0.0)),
            (vec3(0.0, 1.0, 0.0), vec3(0.0, 1.0, 0.0)),
        ] {
            let turned = rotate(between(from, to), from.normalize_or_zero());
            assert!(near(turned, to.normalize_or_zero()), "{from:?} to {to:?} gave {turned:?}");
        }
    }
}
