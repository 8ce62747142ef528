//! The rotation that takes one set of edges to another best.
//!
//! Based on Horn, "Closed-form solution of absolute orientation using unit quaternions" (1987): the
//! rotation with the least squared error is the eigenvector of a symmetric 4×4 matrix with the
//! largest eigenvalue. Unlike a singular value decomposition it never gives a reflection, and
//! edges in one plane determine it. Eigenvectors are Jacobi's, as there is nothing to gain.

use crate::vector::Vector;

/// Columns are by the coordinates that come in, rows by those that come out.
pub(crate) type Matrix = [Vector; 3];

pub(crate) const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// More sweeps than any 4×4 matrix takes.
const MOST_SWEEPS: usize = 32;

/// Sums of products of edges, `[to][from]`: all that the best rotation depends on.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Correlation([Vector; 3]);

impl Correlation {
    pub fn add(&mut self, from: Vector, to: Vector) {
        for (row, to) in self.0.iter_mut().zip(to) {
            for (sum, from) in row.iter_mut().zip(from) {
                *sum += to * from;
            }
        }
    }

    pub fn add_all(&mut self, other: &Self) {
        for (sum, value) in self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()) {
            *sum += value;
        }
    }

    /// The same, counting only in part.
    pub fn scaled(&self, share: f64) -> Self {
        Self(self.0.map(|row| row.map(|value| value * share)))
    }

    /// The same with `x` mirrored in what comes in.
    pub fn mirrored(&self) -> Self {
        Self(self.0.map(|[x, y, z]| [-x, y, z]))
    }

    /// The same, with a little of another rotation, which decides what edges leave open: all within
    /// a line leave the turn around it, none leave everything.
    pub fn leaning(&self, to: &Matrix) -> Self {
        const SHARE: f64 = 1e-6;
        let size: f64 = self.0.as_flattened().iter().map(|value| value.abs()).sum();
        if !(size.is_finite() && size > 0.0) {
            return Self(*to);
        }
        let mut sum = *self;
        for (sum, value) in sum.0.as_flattened_mut().iter_mut().zip(to.as_flattened()) {
            *sum = *sum / size + SHARE * value;
        }
        sum
    }

    /// The best rotation, and how much of the edges it makes agree.
    pub fn rotation(&self) -> (Matrix, f64) {
        let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = self.0;
        let matrix = [
            [xx + yy + zz, yz - zy, zx - xz, xy - yx],
            [yz - zy, xx - yy - zz, xy + yx, zx + xz],
            [zx - xz, xy + yx, yy - xx - zz, yz + zy],
            [xy - yx, zx + xz, yz + zy, zz - xx - yy],
        ];
        let (agreement, [w, x, y, z]) = largest_eigenvector(matrix);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        (rotation, agreement)
    }
}

pub(crate) fn rotated(matrix: &Matrix, vector: Vector) -> Vector {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

/// The largest eigenvalue of a symmetric matrix and its eigenvector, of length 1.
fn largest_eigenvector(mut a: [[f64; 4]; 4]) -> (f64, [f64; 4]) {
    // Columns are eigenvectors in the making.
    let mut vectors = [[0.0; 4]; 4];
    for (k, row) in vectors.iter_mut().enumerate() {
        row[k] = 1.0;
    }
    for _ in 0..MOST_SWEEPS {
        let mut is_done = true;
        for p in 0..3 {
            for q in p + 1..4 {
                let off = a[p][q];
                // Not where it is no number, either.
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
    let mut best = 0;
    for k in 1..4 {
        if a[k][k] > a[best][best] {
            best = k;
        }
    }
    (a[best][best], vectors.map(|row| row[best]))
}

/// One step of Jacobi's: makes the element at `(p, q)` zero.
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
    use crate::vector::{cross, direction, dot};

    /// A rotation by Rodrigues' formula.
    fn around(axis: Vector, angle: f64) -> impl Fn(Vector) -> Vector {
        let axis = direction(axis).unwrap();
        let (sin, cos) = angle.sin_cos();
        move |v| {
            let (across, along) = (cross(axis, v), dot(axis, v) * (1.0 - cos));
            [0, 1, 2].map(|k| v[k] * cos + across[k] * sin + axis[k] * along)
        }
    }

    fn correlation(edges: &[Vector], turn: impl Fn(Vector) -> Vector) -> Correlation {
        let mut sum = Correlation::default();
        for &edge in edges {
            sum.add(edge, turn(edge));
        }
        sum
    }

    const SPACE: [Vector; 3] = [[1.0, 0.2, 0.0], [0.0, 2.0, -0.3], [0.5, 0.0, 1.0]];

    #[test]
    fn finds_the_rotation_of_edges_in_space_and_in_a_plane() {
        for angle in [0.1, 1.0, 2.0, 3.0, std::f64::consts::PI] {
            for axis in [[1.0, 2.0, 3.0], [0.0, 0.0, 1.0], [-1.0, 0.1, 0.0]] {
                for edges in [&SPACE[..], &SPACE[..2]] {
                    let turn = around(axis, angle);
                    // Sizes of the meshes do not matter.
                    let sum = correlation(edges, |edge| turn(edge).map(|value| value * 7e-4));
                    let (found, _) = sum.leaning(&IDENTITY).rotation();
                    for test in SPACE {
                        let (found, wanted) = (rotated(&found, test), turn(test));
                        for k in 0..3 {
                            // A share of 10⁻⁶ leans to the identity.
                            assert!((found[k] - wanted[k]).abs() < 1e-4, "{found:?} {wanted:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn equal_edges_are_not_turned_at_all() {
        let same = |edge: Vector| edge;
        for edges in [&SPACE[..], &SPACE[..2], &SPACE[..1], &[]] {
            let (found, _) = correlation(edges, same).leaning(&IDENTITY).rotation();
            assert_eq!(found, IDENTITY);
        }
    }

    #[test]
    fn reflections_agree_better_when_mirrored_back() {
        let sum = correlation(&SPACE, |[x, y, z]| [x, y, -z]);
        let (rotation, agreement) = sum.mirrored().rotation();
        assert!(agreement > 1.1 * sum.rotation().1);
        // Mirrored in x and turned by a half circle around y is mirrored in z.
        assert!((rotated(&rotation, [-1.0, 2.0, 3.0])[2] + 3.0).abs() < 1e-9, "{rotation:?}");
    }

    #[test]
    fn what_is_no_number_is_no_trouble() {
        let mut sum = Correlation::default();
        sum.add([f64::NAN, 1.0, 0.0], [1.0; 3]);
        assert_eq!(sum.leaning(&IDENTITY).rotation().0, IDENTITY);
        let mut sum = Correlation::default();
        sum.add([1e200; 3], [1e200; 3]);
        assert_eq!(sum.leaning(&IDENTITY).rotation().0, IDENTITY);
    }
}
