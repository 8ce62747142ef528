//! Rotations: matrices by rows, axis-angle, and the continuous form with six numbers.

/// A 3×3 matrix by rows.
pub(super) type Matrix3 = [[f64; 3]; 3];

/// The largest difference of `R Rᵀ` from the identity. Files have 32-bit floats.
const TOLERANCE: f64 = 1e-3;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length > 1e-8 && length.is_finite()).then(|| a.map(|value| value / length))
}

/// The matrix of a rotation stored as six numbers; `None` if they are not independent.
///
/// # Source
/// Zhou et al., "On the Continuity of Rotation Representations in Neural Networks", CVPR 2019, with
/// the layout of PyTorch3D's `rotation_6d_to_matrix`: the numbers are the first two rows before
/// they are made orthonormal.
pub(super) fn from_six(six: [f64; 6]) -> Option<Matrix3> {
    let [a, b, c, d, e, f] = six;
    let first = unit([a, b, c])?;
    let along = dot(first, [d, e, f]);
    let second = unit([d - along * first[0], e - along * first[1], f - along * first[2]])?;
    Some([first, second, cross(first, second)])
}

/// Whether a matrix turns without scaling, shearing or mirroring.
pub(super) fn is_rotation(m: &Matrix3) -> bool {
    let near = |found: f64, wanted: f64| (found - wanted).abs() <= TOLERANCE;
    let rows = (0..3).all(|i| (0..=i).all(|j| near(dot(m[i], m[j]), f64::from(i == j))));
    rows && dot(cross(m[0], m[1]), m[2]) > 0.0
}

pub(super) fn transposed(m: &Matrix3) -> Matrix3 {
    [0, 1, 2].map(|column| [m[0][column], m[1][column], m[2][column]])
}

pub(super) fn turned(m: &Matrix3, point: [f64; 3]) -> [f64; 3] {
    m.map(|row| dot(row, point))
}

/// The axis-angle form of a rotation, with an angle in `0..=π`.
///
/// By way of the quaternion whose largest component is found first, which stays accurate near half
/// a turn.
pub(super) fn axis_angle(m: &Matrix3) -> [f64; 3] {
    let trace = m[0][0] + m[1][1] + m[2][2];
    let diagonal = [m[0][0], m[1][1], m[2][2]];
    // Four times the square of w, x, y and z.
    let [x, y, z] = diagonal.map(|value| 1.0 + 2.0 * value - trace);
    let squares = [1.0 + trace, x, y, z];
    let largest = (0..4).fold(0, |best, at| if squares[at] > squares[best] { at } else { best });
    let twice = squares[largest].max(0.0).sqrt();
    let (sums, differences) = (
        [m[2][1] + m[1][2], m[0][2] + m[2][0], m[1][0] + m[0][1]],
        [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]],
    );
    // Each component times twice the largest.
    let [w, x, y, z] = match largest {
        0 => [twice * twice, differences[0], differences[1], differences[2]],
        1 => [differences[0], twice * twice, sums[2], sums[1]],
        2 => [differences[1], sums[2], twice * twice, sums[0]],
        _ => [differences[2], sums[1], sums[0], twice * twice],
    }
    .map(|value| value / (2.0 * twice));
    let (w, axis) = if w < 0.0 { (-w, [-x, -y, -z]) } else { (w, [x, y, z]) };
    let sine = dot(axis, axis).sqrt();
    if sine < 1e-12 {
        return [0.0; 3];
    }
    let angle = 2.0 * sine.atan2(w);
    axis.map(|value| value / sine * angle)
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
        // About z, x goes to y: by columns.
        let quarter = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(is_rotation(&quarter));
        assert_near(axis_angle(&quarter), [0.0, 0.0, FRAC_PI_2]);
        assert_near(axis_angle(&transposed(&quarter)), [0.0, 0.0, -FRAC_PI_2]);
        for axis in 0..3 {
            let mut half = [[0.0; 3]; 3];
            for at in 0..3 {
                half[at][at] = if at == axis { 1.0 } else { -1.0 };
            }
            let mut wanted = [0.0; 3];
            wanted[axis] = PI;
            assert_near(axis_angle(&half), wanted);
        }
        assert_near(axis_angle(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), [0.0; 3]);
    }

    #[test]
    fn small_angles_keep_their_digits() {
        // cos 1e-4 = 1 - 5e-9, sin 1e-4 = 1e-4 - 1.7e-13, about x.
        let (sine, cosine) = 1e-4_f64.sin_cos();
        let small = [[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]];
        assert_near(axis_angle(&small), [1e-4, 0.0, 0.0]);
    }

    #[test]
    fn six_numbers_are_two_rows() {
        // Neither of unit length nor at right angles.
        let found = from_six([0.0, -2.0, 0.0, 3.0, 5.0, 0.0]).unwrap();
        assert_eq!(found, [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(from_six([1.0, 0.0, 0.0, 2.0, 0.0, 0.0]), None);
        assert_eq!(from_six([0.0; 6]), None);
        assert_eq!(from_six([f64::NAN; 6]), None);
    }

    #[test]
    fn mirrors_and_scales_are_not_rotations() {
        let diagonal = |x, y, z| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
        assert!(is_rotation(&diagonal(-1.0, -1.0, 1.0)));
        for other in [diagonal(-1.0, 1.0, 1.0), diagonal(2.0, 2.0, 2.0), diagonal(0.0, 0.0, 0.0)] {
            assert!(!is_rotation(&other));
        }
        assert!(!is_rotation(&[[f64::NAN; 3]; 3]));
    }
}
