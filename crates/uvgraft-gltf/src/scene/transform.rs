//! Node transforms as in glTF, and conversions to affine maps.

use glam::{Affine3A, EulerRot, Mat3, Mat3A, Quat, Vec3, Vec3A};

/// A normalised quaternion; the identity if the length is 0 or not finite.
pub(crate) fn unit(q: [f32; 4]) -> Quat {
    let q = Quat::from_array(q);
    let length = q.length();
    if length > 0.0 && length.is_finite() { q / length } else { Quat::IDENTITY }
}

/// A rotation about X, then about the fixed Y, then about the fixed Z axis, in degrees.
pub(crate) fn from_degrees(angles: [f32; 3]) -> Quat {
    let [x, y, z] = angles.map(f32::to_radians);
    Quat::from_euler(EulerRot::ZYX, z, y, x)
}

/// The shortest-arc rotation from one direction to another, of any lengths.
pub(crate) fn between(from: Vec3, to: Vec3) -> Quat {
    Quat::from_rotation_arc(from.normalize_or_zero(), to.normalize_or_zero())
}

/// Translation, rotation and scale of a node, relative to its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalTransform {
    /// In the parent's units.
    pub translation: [f32; 3],
    /// A unit quaternion: x, y, z, w.
    pub rotation: [f32; 4],
    /// Along the node's own axes.
    pub scale: [f32; 3],
}

impl Default for LocalTransform {
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation: Quat::IDENTITY.to_array(), scale: [1.0; 3] }
    }
}

impl LocalTransform {
    /// The map from the node's space to its parent's.
    pub(crate) fn affine(&self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(
            self.scale.into(),
            Quat::from_array(self.rotation),
            self.translation.into(),
        )
    }

    /// The closest placement to a map, ignoring shear. Zero-length axes get scale 0.
    pub(crate) fn nearest(map: &Affine3A) -> Self {
        let axes = Mat3::from(map.matrix3);
        let mut scale = [axes.x_axis, axes.y_axis, axes.z_axis].map(Vec3::length);
        if axes.determinant() < 0.0 {
            scale[0] = -scale[0];
        }
        let unscaled =
            |k: usize| if scale[k] == 0.0 { axes.col(k) } else { axes.col(k) / scale[k] };
        let rotation = Quat::from_mat3(&Mat3::from_cols(unscaled(0), unscaled(1), unscaled(2)));
        Self {
            translation: map.translation.into(),
            rotation: unit(rotation.to_array()).to_array(),
            scale,
        }
    }
}

/// A map from a column-major 4 × 4 matrix; the last row is assumed to be 0, 0, 0, 1.
pub(crate) fn affine_from_columns(m: &[f32; 16]) -> Affine3A {
    let column = |k: usize| Vec3A::new(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
    Affine3A { matrix3: Mat3A::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// The transform of normals, up to length: they stay perpendicular to surfaces under `map`.
///
/// It is the cofactor matrix times the sign of the determinant: `|det map|` times the inverse
/// transpose, but it also exists for singular maps.
pub(crate) fn normal_matrix(map: &Mat3A) -> Mat3A {
    let [x, y, z] = [map.x_axis, map.y_axis, map.z_axis];
    let sign = if x.dot(y.cross(z)) < 0.0 { -1.0 } else { 1.0 };
    Mat3A::from_cols(y.cross(z) * sign, z.cross(x) * sign, x.cross(y) * sign)
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    fn near(a: Vec3, b: Vec3) -> bool {
        (a - b).length() < 1e-5
    }

    #[test]
    fn rotations_have_the_right_sign_and_order() {
        let v = from_degrees([0.0, 0.0, 90.0]) * vec3(1.0, 0.0, 0.0);
        assert!(near(v, vec3(0.0, 1.0, 0.0)), "{v:?}");
        // X rotates Y to Z; then Y rotates Z to X; then Z rotates X to Y.
        let v = from_degrees([90.0, 90.0, 90.0]) * vec3(0.0, 1.0, 0.0);
        assert!(near(v, vec3(0.0, 1.0, 0.0)), "{v:?}");
        let v = from_degrees([90.0, 90.0, 0.0]) * vec3(0.0, 1.0, 0.0);
        assert!(near(v, vec3(1.0, 0.0, 0.0)), "{v:?}");
    }

    #[test]
    fn degenerate_quaternions_are_the_identity() {
        for q in [[0.0; 4], [f32::NAN, 0.0, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0, 1.0]] {
            assert_eq!(unit(q), Quat::IDENTITY);
        }
        assert_eq!(unit([0.0, 0.0, 3.0, 4.0]), Quat::from_xyzw(0.0, 0.0, 0.6, 0.8));
    }

    #[test]
    fn a_matrix_decomposes_into_its_parts() {
        for angles in [[10.0, 20.0, 30.0], [170.0, 5.0, 0.0], [0.0, 179.0, 3.0], [0.0, 2.0, 178.0]]
        {
            let placement = LocalTransform {
                translation: [1.0, -2.0, 3.0],
                rotation: from_degrees(angles).into(),
                scale: [-2.0, 0.5, 3.0],
            };
            let map = placement.affine();
            let again = LocalTransform::nearest(&map).affine();
            assert!(again.abs_diff_eq(map, 1e-5), "{angles:?}");
        }
    }

    #[test]
    fn rotations_between_directions_even_opposite_ones() {
        for (from, to) in [
            (vec3(0.0, -2.0, 0.0), vec3(1.0, 0.0, 0.0)),
            (vec3(1.0, 0.0, 0.0), vec3(-3.0, 0.0, 0.0)),
            (vec3(0.0, 1.0, 0.0), vec3(0.0, 1.0, 0.0)),
        ] {
            let turned = between(from, to) * from.normalize_or_zero();
            assert!(near(turned, to.normalize_or_zero()), "{from:?} to {to:?} gave {turned:?}");
        }
    }
}
