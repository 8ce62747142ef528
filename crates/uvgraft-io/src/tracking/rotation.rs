//! Rotations as files have them: axis-angle, and the continuous form with six numbers.

use glam::{DMat3, DQuat, DVec3};

/// The largest difference of `R Rᵀ` from the identity. Files have 32-bit floats.
const TOLERANCE: f64 = 1e-3;

/// A rotation stored as six numbers; `None` if they are not independent.
///
/// # Source
/// Zhou et al., "On the Continuity of Rotation Representations in Neural Networks", CVPR 2019, with
/// the layout of PyTorch3D's `rotation_6d_to_matrix`: the numbers are the first two rows before
/// they are made orthonormal.
pub(super) fn from_six([a, b, c, d, e, f]: [f64; 6]) -> Option<DMat3> {
    let unit = |row: DVec3| {
        let length = row.length();
        (length > 1e-8 && length.is_finite()).then(|| row / length)
    };
    let first = unit(DVec3::new(a, b, c))?;
    let second = DVec3::new(d, e, f);
    let second = unit(second - first * first.dot(second))?;
    Some(DMat3::from_cols(first, second, first.cross(second)).transpose())
}

/// Whether a matrix turns without scaling, shearing or mirroring.
pub(super) fn is_rotation(matrix: &DMat3) -> bool {
    (*matrix * matrix.transpose()).abs_diff_eq(DMat3::IDENTITY, TOLERANCE)
        && matrix.determinant() > 0.0
}

/// The axis-angle form of a rotation, with an angle in `0..=π`.
pub(super) fn axis_angle(rotation: &DMat3) -> [f64; 3] {
    let turn = DQuat::from_mat3(rotation);
    // The same rotation, the shorter way round.
    let turn = if turn.w < 0.0 { -turn } else { turn };
    turn.to_scaled_axis().to_array()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn assert_near(found: [f64; 3], wanted: [f64; 3]) {
        let far = found.iter().zip(wanted).any(|(found, wanted)| (found - wanted).abs() > 1e-9);
        assert!(!far, "{found:?}, wanted {wanted:?}");
    }

    #[test]
    fn a_quarter_and_half_a_turn() {
        // About z, x goes to y.
        let quarter = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
        assert!(is_rotation(&quarter));
        assert_near(axis_angle(&quarter), [0.0, 0.0, FRAC_PI_2]);
        assert_near(axis_angle(&quarter.transpose()), [0.0, 0.0, -FRAC_PI_2]);
        for axis in 0..3 {
            let (mut diagonal, mut wanted) = ([-1.0; 3], [0.0; 3]);
            (diagonal[axis], wanted[axis]) = (1.0, PI);
            assert_near(axis_angle(&DMat3::from_diagonal(diagonal.into())), wanted);
        }
        assert_near(axis_angle(&DMat3::IDENTITY), [0.0; 3]);
    }

    #[test]
    fn small_angles_keep_their_digits() {
        // cos 1e-4 = 1 - 5e-9, sin 1e-4 = 1e-4 - 1.7e-13, about x.
        let (sine, cosine) = 1e-4_f64.sin_cos();
        let small = DMat3::from_cols(
            DVec3::X,
            DVec3::new(0.0, cosine, sine),
            DVec3::new(0.0, -sine, cosine),
        );
        assert_near(axis_angle(&small), [1e-4, 0.0, 0.0]);
    }

    #[test]
    fn six_numbers_are_two_rows() {
        // Neither of unit length nor at right angles.
        let found = from_six([0.0, -2.0, 0.0, 3.0, 5.0, 0.0]).unwrap();
        assert_eq!(found, DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z));
        assert_eq!(from_six([1.0, 0.0, 0.0, 2.0, 0.0, 0.0]), None);
        assert_eq!(from_six([0.0; 6]), None);
        assert_eq!(from_six([f64::NAN; 6]), None);
    }

    #[test]
    fn mirrors_and_scales_are_not_rotations() {
        let diagonal = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
        assert!(is_rotation(&diagonal(-1.0, -1.0, 1.0)));
        for other in [diagonal(-1.0, 1.0, 1.0), diagonal(2.0, 2.0, 2.0), diagonal(0.0, 0.0, 0.0)] {
            assert!(!is_rotation(&other));
        }
        assert!(!is_rotation(&DMat3::NAN));
    }
}
