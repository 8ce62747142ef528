//! Sparse symmetric positive definite systems: Cholesky factors of one matrix for many right-hand
//! sides.

use nalgebra::DMatrix;
use nalgebra_sparse::factorization::CscCholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix};

/// The factors of a matrix.
#[derive(Debug, Clone)]
pub(crate) struct SparseCholesky {
    /// The row of each equation in the factors, permuted to keep them sparse.
    permuted_row: Vec<usize>,
    /// `None` without rows, or if the matrix is not positive definite.
    factors: Option<CscCholesky<f64>>,
}

impl SparseCholesky {
    /// Factorises a matrix, in an order that keeps the factors sparse (approximate minimum degree).
    ///
    /// - `entries`: row, column and value. Both triangles; values at the same place add up.
    pub fn new(rows: usize, entries: &[(usize, usize, f64)]) -> Self {
        let matrix = |permute: &dyn Fn(usize) -> usize| {
            let mut permuted = CooMatrix::new(rows, rows);
            for &(row, column, value) in entries {
                permuted.push(permute(row), permute(column), value);
            }
            CscMatrix::from(&permuted)
        };
        let plain = matrix(&|row| row);
        let order =
            amd::order(rows, plain.col_offsets(), plain.row_indices(), &amd::Control::default());
        let permuted_row = order.map_or_else(|_| (0..rows).collect(), |(_, inverse, _)| inverse);
        let factors =
            (rows > 0).then(|| CscCholesky::factor(&matrix(&|row| permuted_row[row])).ok());
        Self { permuted_row, factors: factors.flatten() }
    }

    /// Whether there are factors; otherwise nothing is solved.
    pub const fn is_sound(&self) -> bool {
        self.factors.is_some()
    }

    /// Solves for several right-hand sides at once; `None` without factors.
    ///
    /// - `right`: `[rows]`, the right-hand sides of each equation.
    pub fn solve<const N: usize>(&self, right: &[[f64; N]]) -> Option<Vec<[f64; N]>> {
        let factors = self.factors.as_ref()?;
        let mut columns = DMatrix::zeros(self.permuted_row.len(), N);
        for (&row, values) in self.permuted_row.iter().zip(right) {
            for (column, &value) in values.iter().enumerate() {
                columns[(row, column)] = value;
            }
        }
        factors.solve_mut(&mut columns);
        let of_row = |&row: &usize| std::array::from_fn(|column| columns[(row, column)]);
        Some(self.permuted_row.iter().map(of_row).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_fulfil_the_equations() {
        // A chain of springs between two walls.
        let rows = 30;
        let mut entries: Vec<_> = (0..rows).map(|row| (row, row, 2.0)).collect();
        for row in 1..rows {
            entries.extend([(row, row - 1, -1.0), (row - 1, row, -1.0)]);
        }
        let right: Vec<[f64; 2]> = (0..rows).map(|row| [1.0, row as f64]).collect();
        let found = SparseCholesky::new(rows, &entries).solve(&right).unwrap();
        let mut product = vec![[0.0; 2]; rows];
        for &(row, column, value) in &entries {
            for k in 0..2 {
                product[row][k] += value * found[column][k];
            }
        }
        for (product, right) in product.iter().zip(&right) {
            assert!((0..2).all(|k| (product[k] - right[k]).abs() < 1e-9), "{product:?} {right:?}");
        }
    }

    #[test]
    fn without_rows_or_a_positive_definite_matrix_there_is_no_solution() {
        assert!(SparseCholesky::new(0, &[]).solve::<1>(&[]).is_none());
        let indefinite = SparseCholesky::new(2, &[(0, 0, 1.0), (1, 1, -1.0)]);
        assert!(!indefinite.is_sound());
        assert!(indefinite.solve(&[[1.0], [1.0]]).is_none());
    }
}
