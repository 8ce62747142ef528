//! The least-squares rotation between two sets of corresponding edges.
//!
//! Based on Horn, "Closed-form solution of absolute orientation using unit quaternions" (1987): the
//! unit quaternion of the rotation with the least squared error is the eigenvector with the largest
//! eigenvalue of a symmetric 4×4 matrix. Unlike a singular value decomposition, this never yields a
//! reflection, and coplanar edges suffice.
//!
//! Eigenvectors are computed by Jacobi's method, here rather than by nalgebra, whose last bits differ:
//! registrations enlarge those of a rotation, since points choose partners. With nalgebra's, a face on
//! a registered body changed by up to 42 levels at half a percent of its texels, and was no closer.

use glam::{DMat3, DMat4, DVec3};

/// More sweeps than any 4×4 matrix needs.
const MAX_SWEEPS: usize = 32;

/// The correlation matrix `Σ to · fromᵀ` of corresponding edges, which determines the best
/// rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correlation(DMat3);

impl Correlation {
    /// The correlation of no edges.
    pub const NONE: Self = Self(DMat3::ZERO);

    /// Adds an edge and the one that corresponds.
    pub fn add(&mut self, from: DVec3, to: DVec3) {
        self.0 += DMat3::from_cols(to * from.x, to * from.y, to * from.z);
    }

    /// Adds the edges of another correlation.
    pub fn add_all(&mut self, other: &Self) {
        self.0 += other.0;
    }

    /// The same, weighted by `share`.
    pub fn scaled(&self, share: f64) -> Self {
        Self(self.0 * share)
    }

    /// The same, with the `x` of the source edges mirrored.
    pub fn mirrored(&self) -> Self {
        Self(DMat3 { x_axis: -self.0.x_axis, ..self.0 })
    }

    /// The same, normalised and slightly biased towards the rotation `to`, which decides what the
    /// edges leave undetermined: the angle around a line if all are collinear, everything if there
    /// are none.
    pub fn biased(&self, to: DMat3) -> Self {
        const SHARE: f64 = 1e-6;
        let size: f64 = self.0.to_rows_array().iter().map(|value| value.abs()).sum();
        if !(size.is_finite() && size > 0.0) {
            return Self(to);
        }
        Self(self.0 / size + to * SHARE)
    }

    /// The best rotation `R`, and the agreement `Σ to · (R from)` that it achieves, which is the
    /// largest eigenvalue of Horn's matrix.
    pub fn rotation(&self) -> (DMat3, f64) {
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = self.0.to_cols_array_2d();
        let matrix = [
            [xx + yy + zz, yz - zy, zx - xz, xy - yx],
            [yz - zy, xx - yy - zz, xy + yx, zx + xz],
            [zx - xz, xy + yx, yy - xx - zz, yz + zy],
            [xy - yx, zx + xz, yz + zy, zz - xx - yy],
        ];
        let (agreement, [w, x, y, z]) = largest_eigenvector(matrix);
        let rotation = DMat3::from_cols_array_2d(&[
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]);
        (rotation, agreement)
    }
}

/// The largest eigenvalue of a symmetric matrix and its unit eigenvector, by cyclic Jacobi
/// rotations.
fn largest_eigenvector(mut a: [[f64; 4]; 4]) -> (f64, [f64; 4]) {
    // The columns converge to the eigenvectors.
    let mut vectors = DMat4::IDENTITY.to_cols_array_2d();
    for _ in 0..MAX_SWEEPS {
        let mut is_done = true;
        for p in 0..3 {
            for q in p + 1..4 {
                let off = a[p][q];
                // False for NaN, which ends the sweeps.
                if off.abs() > f64::EPSILON * 0.01 * (a[p][p].abs() + a[q][q].abs()) {
                    rotate(&mut a, &mut vectors, p, q);
                    is_done = false;
                }
            }
        }
        if is_done {
            break;
        }
    }
    let best = (1..4).fold(0, |best, k| if a[k][k] > a[best][best] { k } else { best });
    (a[best][best], vectors.map(|row| row[best]))
}

/// One Jacobi rotation: makes the element at `(p, q)` zero.
fn rotate(a: &mut [[f64; 4]; 4], vectors: &mut [[f64; 4]; 4], p: usize, q: usize) {
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    for row in a.iter_mut().chain(vectors) {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for k in 0..4 {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn correlation(edges: &[DVec3], turn: impl Fn(DVec3) -> DVec3) -> Correlation {
        let mut sum = Correlation::NONE;
        for &edge in edges {
            sum.add(edge, turn(edge));
        }
        sum
    }

    const SPACE: [DVec3; 3] =
        [DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.0, 2.0, -0.3), DVec3::new(0.5, 0.0, 1.0)];

    #[test]
    fn finds_the_rotation_of_edges_in_space_and_in_a_plane() {
        for angle in [0.1, 1.0, 2.0, 3.0, std::f64::consts::PI] {
            for axis in [[1.0, 2.0, 3.0], [0.0, 0.0, 1.0], [-1.0, 0.1, 0.0]] {
                for edges in [&SPACE[..], &SPACE[..2]] {
                    let turn = DMat3::from_axis_angle(DVec3::from(axis).normalize(), angle);
                    // The scale of the meshes does not matter.
                    let sum = correlation(edges, |edge| turn * edge * 7e-4);
                    let (found, _) = sum.biased(DMat3::IDENTITY).rotation();
                    for test in SPACE {
                        let (found, wanted) = (found * test, turn * test);
                        // The bias towards the identity is 10⁻⁶.
                        assert!(found.abs_diff_eq(wanted, 1e-4), "{found} {wanted}");
                    }
                }
            }
        }
    }

    #[test]
    fn equal_edges_give_the_identity() {
        let same = |edge: DVec3| edge;
        for edges in [&SPACE[..], &SPACE[..2], &SPACE[..1], &[]] {
            let (found, _) = correlation(edges, same).biased(DMat3::IDENTITY).rotation();
            assert_eq!(found, DMat3::IDENTITY);
        }
    }

    #[test]
    fn reflections_agree_better_when_mirrored_back() {
        let sum = correlation(&SPACE, |edge| edge.with_z(-edge.z));
        let (rotation, agreement) = sum.mirrored().rotation();
        assert!(agreement > 1.1 * sum.rotation().1);
        // Mirroring in x and rotating by 180° around y equals mirroring in z.
        assert!(((rotation * DVec3::new(-1.0, 2.0, 3.0)).z + 3.0).abs() < 1e-9, "{rotation:?}");
    }

    #[test]
    fn non_finite_edges_give_the_fallback() {
        let mut sum = Correlation::NONE;
        sum.add(DVec3::new(f64::NAN, 1.0, 0.0), DVec3::ONE);
        assert_eq!(sum.biased(DMat3::IDENTITY).rotation().0, DMat3::IDENTITY);
        let mut sum = Correlation::NONE;
        sum.add(DVec3::splat(1e200), DVec3::splat(1e200));
        assert_eq!(sum.biased(DMat3::IDENTITY).rotation().0, DMat3::IDENTITY);
    }
}
