//! Sparse symmetric positive definite systems: Cholesky factors of one matrix for many right-hand
//! sides.
//!
//! The multifrontal method: I. Duff and J. Reid, "The multifrontal solution of indefinite sparse
//! symmetric linear equations", 1983; J. Liu, "The multifrontal method for sparse matrix solution:
//! theory and practice", 1992. Columns whose factors have the same rows are eliminated together, as
//! dense matrices, which takes a fraction of the time that column by column would:
//!
//! - `matrix` puts the entries in order;
//! - `structure` finds these groups of columns, their rows and their tree;
//! - `fronts` eliminates them from the leaves of the tree to its root, several branches at once;
//! - `dense` is the arithmetic.
//!
//! How much factors take is known before they are computed (`structure`). On surfaces it grows little
//! faster than their points; where points are connected at random, factors fill up, and [`Solver`]
//! solves without them (`iterative`).
//!
//! Every sum has one order, and products are not fused, so factors are equal to the bit on any number
//! of threads and at any SIMD level.

mod dense;
mod fronts;
mod iterative;
mod matrix;
mod structure;

use std::sync::Arc;

use iterative::Iterative;
pub(crate) use matrix::Matrix;
use structure::{Limit, Structure, Tree};

/// Solves a system by factors, or without them where they would fill up; clones share what is
/// prepared.
#[derive(Debug, Clone)]
pub struct Solver(Method);

#[derive(Debug, Clone)]
enum Method {
    Direct(SparseCholesky),
    Iterative(Arc<Iterative>),
}

/// The factors of a matrix; clones share them.
#[derive(Debug, Clone)]
pub(crate) struct SparseCholesky(Arc<Factors>);

/// Factors would take more values, or multiplications, than those of any surface do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Filled;

#[derive(Debug)]
struct Factors {
    /// The row of each equation in the factors, permuted to keep them sparse.
    permuted_row: Vec<u32>,
    structure: Structure,
    /// `None` without rows, or if the matrix is not positive definite.
    values: Option<Vec<f64>>,
}

/// Whether a matrix of surfaces may have so many entries.
pub(crate) fn may_hold(rows: usize, entries: usize) -> bool {
    entries as u64 <= Limit::of(rows).values
}

/// An order of equations that keeps factors sparse (approximate minimum degree).
#[derive(Debug, Clone)]
pub(crate) struct Order(Vec<u32>);

impl Order {
    /// - `entries`: row and column of the entries that are not 0, in both triangles.
    pub fn new(rows: usize, entries: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let pattern = Matrix::new(rows, entries.map(|(row, column)| (row, column, 0.0)));
        let [starts, indices] = [&pattern.starts, &pattern.rows]
            .map(|values| values.iter().map(|&value| value as usize).collect::<Vec<_>>());
        let order = amd::order(rows, &starts, &indices, &amd::Control::default());
        Self(order.map_or_else(
            |_| (0..rows as u32).collect(),
            |(_, inverse, _)| inverse.into_iter().map(|row| row as u32).collect(),
        ))
    }
}

impl Solver {
    /// Prepares a system.
    ///
    /// - `entries`: row, column and value. Both triangles; values at the same place add up.
    pub fn new(rows: usize, entries: &[(u32, u32, f64)]) -> Self {
        Self(match SparseCholesky::new(rows, entries) {
            Ok(factors) => Method::Direct(factors),
            Err(Filled) => Method::Iterative(Arc::new(Iterative::new(rows, entries))),
        })
    }

    /// Whether anything can be solved: without rows, or where factors show that the matrix is not
    /// positive definite, nothing is.
    pub fn is_sound(&self) -> bool {
        match &self.0 {
            Method::Direct(factors) => factors.is_sound(),
            Method::Iterative(_) => true,
        }
    }

    /// Whether solutions are those of factors, to the last digits.
    pub const fn is_direct(&self) -> bool {
        matches!(self.0, Method::Direct(_))
    }

    /// Solves for several right-hand sides at once; `None` if [nothing can be](Self::is_sound).
    ///
    /// - `right`: `[rows]`, the right-hand sides of each equation.
    pub fn solve<const N: usize>(&self, right: &[[f64; N]]) -> Option<Vec<[f64; N]>> {
        match &self.0 {
            Method::Direct(factors) => factors.solve(right),
            Method::Iterative(system) => Some(system.solve(right)),
        }
    }
}

impl SparseCholesky {
    /// Factorises a matrix, in an order that keeps the factors sparse.
    ///
    /// - `entries`: row, column and value. Both triangles; values at the same place add up.
    ///
    /// # Errors
    /// [`Filled`].
    pub fn new(rows: usize, entries: &[(u32, u32, f64)]) -> Result<Self, Filled> {
        let order = Order::new(rows, entries.iter().map(|&(row, column, _)| (row, column)));
        Self::ordered(&order, entries)
    }

    /// Factorises a matrix in a given order.
    ///
    /// - `entries`: as in [`SparseCholesky::new`].
    ///
    /// # Errors
    /// [`Filled`].
    pub fn ordered(Order(order): &Order, entries: &[(u32, u32, f64)]) -> Result<Self, Filled> {
        let rows = order.len();
        let permuted = |permuted_row: &[u32]| {
            let lower = entries.iter().filter_map(|&(row, column, value)| {
                let [row, column] = [row, column].map(|at| permuted_row[at as usize]);
                (column <= row).then_some((row, column, value))
            });
            Matrix::new(rows, lower)
        };
        let tree = Tree::new(&permuted(order), Limit::of(rows)).ok_or(Filled)?;
        let permuted_row: Vec<u32> = order.iter().map(|&row| tree.number[row as usize]).collect();
        // Permuted again: the tree renumbers columns so that those of a group are consecutive.
        let matrix = permuted(&permuted_row);
        let structure = Structure::new(&tree, &matrix);
        let values = if rows > 0 { fronts::factorise(&structure, &matrix) } else { None };
        Ok(Self(Arc::new(Factors { permuted_row, structure, values })))
    }

    /// Whether there are factors; otherwise nothing is solved.
    pub fn is_sound(&self) -> bool {
        self.0.values.is_some()
    }

    /// Solves for several right-hand sides at once; `None` without factors.
    ///
    /// - `right`: `[rows]`, the right-hand sides of each equation.
    pub fn solve<const N: usize>(&self, right: &[[f64; N]]) -> Option<Vec<[f64; N]>> {
        let Factors { permuted_row, structure, values } = &*self.0;
        let values = values.as_ref()?;
        let mut solution = vec![[0.0; N]; permuted_row.len()];
        for (&row, &value) in permuted_row.iter().zip(right) {
            solution[row as usize] = value;
        }
        fronts::solve(structure, values, &mut solution);
        Some(permuted_row.iter().map(|&row| solution[row as usize]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The greatest difference between the product of a matrix with a solution and the right-hand
    /// side.
    fn residual<const N: usize>(
        entries: &[(u32, u32, f64)],
        found: &[[f64; N]],
        right: &[[f64; N]],
    ) -> f64 {
        let mut rest = right.to_vec();
        for &(row, column, value) in entries {
            for k in 0..N {
                rest[row as usize][k] -= value * found[column as usize][k];
            }
        }
        rest.as_flattened().iter().fold(0.0, |most, rest| rest.abs().max(most))
    }

    fn symmetric(rows: u32, edges: impl Iterator<Item = (u32, u32, f64)>) -> Vec<(u32, u32, f64)> {
        let mut entries: Vec<_> = (0..rows).map(|row| (row, row, 1e-3)).collect();
        for (a, b, weight) in edges {
            entries.extend([(a, a, weight), (b, b, weight), (a, b, -weight), (b, a, -weight)]);
        }
        entries
    }

    fn check(rows: u32, entries: &[(u32, u32, f64)]) {
        let mut rng = fastrand::Rng::with_seed(6);
        let right: Vec<[f64; 2]> = (0..rows).map(|row| [rng.f64(), f64::from(row % 7)]).collect();
        let found = SparseCholesky::new(rows as usize, entries).unwrap().solve(&right).unwrap();
        let residual = residual(entries, &found, &right);
        assert!(residual < 1e-7, "{rows} rows: {residual}");
    }

    #[test]
    fn solutions_fulfil_the_equations() {
        let mut rng = fastrand::Rng::with_seed(2);
        // A chain, a star, isolated rows, and rows that are all connected: more of them than are
        // eliminated at once.
        for rows in [1, 2, 5, 8, 9, 30, 500] {
            check(rows, &symmetric(rows, (1..rows).map(|row| (row, row - 1, 1.0))));
            check(rows, &symmetric(rows, (1..rows).map(|row| (0, row, 2.0))));
            check(rows, &symmetric(rows, std::iter::empty()));
        }
        for rows in [7, 64, 65, 150] {
            let all = (0..rows).flat_map(|a| (0..a).map(move |b| (a, b)));
            check(rows, &symmetric(rows, all.map(|(a, b)| (a, b, rng.f64()))));
        }
        // Random graphs, of several components and with edges that occur twice.
        for round in 0..60 {
            let rows = rng.u32(1..400);
            let edges: Vec<_> = (0..rows * (1 + round % 4))
                .map(|_| (rng.u32(..rows), rng.u32(..rows), rng.f64()))
                .filter(|(a, b, _)| a != b)
                .collect();
            check(rows, &symmetric(rows, edges.into_iter()));
        }
    }

    /// A grid of squares with diagonals and random weights.
    fn grid(side: u32) -> Vec<(u32, u32, f64)> {
        let mut rng = fastrand::Rng::with_seed(3);
        let all = (0..side * side).flat_map(|at| {
            let (x, y) = (at % side, at / side);
            [(1, 0), (0, 1), (1, 1)]
                .into_iter()
                .filter(move |(dx, dy)| x + dx < side && y + dy < side)
                .map(move |(dx, dy)| (at, at + dx + dy * side))
        });
        symmetric(side * side, all.map(|(a, b)| (a, b, 0.1 + rng.f64())))
    }

    /// Every row connected to four others anywhere.
    fn random(rows: u32) -> Vec<(u32, u32, f64)> {
        let mut rng = fastrand::Rng::with_seed(8);
        let edges = (0..4 * rows).map(|k| (k / 4, rng.u32(..rows), 0.1 + rng.f64()));
        symmetric(rows, edges.filter(|(a, b, _)| a != b).collect::<Vec<_>>().into_iter())
    }

    #[test]
    fn factors_that_would_fill_up_are_not_computed() {
        let rows = 12_000;
        let entries = random(rows);
        assert_eq!(SparseCholesky::new(rows as usize, &entries).err(), Some(Filled));
        // Conjugate gradients find the solution, of each right-hand side.
        let solver = Solver::new(rows as usize, &entries);
        assert!(!solver.is_direct() && solver.is_sound());
        let right: Vec<[f64; 3]> = (0..rows)
            .map(|row| [f64::from(row % 7) - 3.0, 0.0, f64::from(u8::from(row == 9))])
            .collect();
        let found = solver.solve(&right).unwrap();
        assert!(residual(&entries, &found, &right) < 1e-6);
        assert!(found.iter().all(|values| values[1] == 0.0));
        assert_eq!(solver.solve(&right).unwrap(), found);
        // A surface with as many points is factorised, and one point that all others are connected to
        // fills nothing up.
        assert!(Solver::new(110 * 110, &grid(110)).is_direct());
        let star = symmetric(rows, (1..rows).map(|row| (0, row, 1.0)));
        assert!(Solver::new(rows as usize, &star).is_direct());
    }

    #[test]
    fn grids_are_solved() {
        for side in [12, 50, 150] {
            check(side * side, &grid(side));
        }
    }

    #[test]
    #[cfg_attr(target_family = "wasm", ignore = "starts threads")]
    fn factors_do_not_depend_on_threads() {
        let (side, entries) = (150, grid(150));
        let factors = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let factors = pool.install(|| SparseCholesky::new(side * side, &entries).unwrap());
            factors.0.values.clone().unwrap()
        };
        let one = factors(1);
        for threads in [2, 3, 8] {
            let same = factors(threads).iter().zip(&one).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "{threads} threads");
        }
    }

    #[test]
    fn without_rows_or_a_positive_definite_matrix_there_is_no_solution() {
        assert!(SparseCholesky::new(0, &[]).unwrap().solve::<1>(&[]).is_none());
        for value in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
            let indefinite = SparseCholesky::new(2, &[(0, 0, 1.0), (1, 1, value)]).unwrap();
            assert!(!indefinite.is_sound(), "{value}");
            assert!(indefinite.solve(&[[1.0], [1.0]]).is_none());
        }
        // Without the small entries on its diagonal, the matrix of a graph is singular.
        let mut entries = grid(40);
        entries.extend((0..1600).map(|row| (row, row, -1.0)));
        assert!(!SparseCholesky::new(1600, &entries).unwrap().is_sound());
    }
}
