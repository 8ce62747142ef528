//! Solutions without factors: conjugate gradients, scaled by the diagonal (M. Hestenes and E. Stiefel,
//! "Methods of conjugate gradients for solving linear systems", 1952).
//!
//! A step costs as much as the matrix has entries, so that systems whose factors would fill up are
//! solved in time that grows with their size.

use super::matrix::Matrix;

/// A symmetric positive definite matrix.
#[derive(Debug)]
pub(crate) struct Iterative {
    matrix: Matrix,
    /// The inverse of each value on the diagonal; 0 where it is not positive.
    scales: Vec<f64>,
}

/// Steps at most. Graphs whose factors fill up have short paths between any two points, along which values
/// spread in few steps.
const STEPS: usize = 1000;

/// The residual, relative to the right-hand side, that is a solution: colours have 16 bits.
const TOLERANCE: f64 = 1e-9;

impl Iterative {
    /// - `entries`: row, column and value. Both triangles; values at the same place add up.
    pub fn new(rows: usize, entries: &[(u32, u32, f64)]) -> Self {
        let matrix = Matrix::new(rows, entries.iter().copied());
        let mut scales = vec![0.0; rows];
        for (row, column, value) in matrix.entries() {
            if row == column && value > 0.0 {
                scales[row as usize] = value.recip();
            }
        }
        Self { matrix, scales }
    }

    /// Solves for several right-hand sides at once, each with steps of its own.
    ///
    /// - `right`: `[rows]`, the right-hand sides of each equation.
    pub fn solve<const N: usize>(&self, right: &[[f64; N]]) -> Vec<[f64; N]> {
        let mut solution = vec![[0.0; N]; right.len()];
        let mut residual = right.to_vec();
        let least = dot(right, right).map(|squared| squared * TOLERANCE * TOLERANCE);
        let mut search = self.scaled(&residual);
        let mut energy = dot(&residual, &search);
        for _ in 0..STEPS {
            let left = dot(&residual, &residual);
            if (0..N).all(|k| left[k] <= least[k]) {
                break;
            }
            let applied = self.applied(&search);
            // A right-hand side that is solved stays.
            let length = ratio(energy, dot(&search, &applied));
            for row in 0..solution.len() {
                for k in 0..N {
                    solution[row][k] += search[row][k] * length[k];
                    residual[row][k] -= applied[row][k] * length[k];
                }
            }
            let conditioned = self.scaled(&residual);
            let next = dot(&residual, &conditioned);
            let turn = ratio(next, energy);
            for (search, conditioned) in search.iter_mut().zip(conditioned) {
                for k in 0..N {
                    search[k] = conditioned[k] + search[k] * turn[k];
                }
            }
            energy = next;
        }
        solution
    }

    /// The product with the matrix, whose columns are its rows.
    fn applied<const N: usize>(&self, values: &[[f64; N]]) -> Vec<[f64; N]> {
        let product = |row: usize| {
            let mut sums = [0.0; N];
            let (columns, factors) = self.matrix.column(row);
            for (&column, factor) in columns.iter().zip(factors) {
                for (sum, value) in sums.iter_mut().zip(values[column as usize]) {
                    *sum += factor * value;
                }
            }
            sums
        };
        (0..values.len()).map(product).collect()
    }

    fn scaled<const N: usize>(&self, values: &[[f64; N]]) -> Vec<[f64; N]> {
        let all = values.iter().zip(&self.scales);
        all.map(|(value, scale)| value.map(|value| value * scale)).collect()
    }
}

fn dot<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (a, b) in a.iter().zip(b) {
        (0..N).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums
}

fn ratio<const N: usize>(above: [f64; N], below: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| if below[k] > 0.0 { above[k] / below[k] } else { 0.0 })
}
