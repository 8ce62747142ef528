//! Corrections of deformations: the smoothest ones after which linear conditions hold.
//!
//! With the screened Laplacian `A` and the areas `M` of the points, the correction `c` that minimises
//! `cᵀ A M⁻¹ A c` under conditions `B c = b` is `c = K Bᵀ (B K Bᵀ)⁻¹ b`, where `K = A⁻¹ M A⁻¹`: one
//! small dense system. A single Laplacian would leave a peak at each condition.

use glam::{DVec3, Vec3};
use nalgebra::{DMatrix, DVector};

use super::equations::Equations;
use crate::threads::map_indices;

/// A linear form of vertices' offsets: vertices, and the vectors whose dot products with their offsets
/// add up to a quantity.
pub type Row = Vec<(u32, [f32; 3])>;

/// Quantities by which a target can be corrected; see
/// [`DeformationTransfer::handles`](super::DeformationTransfer::handles).
#[derive(Debug, Clone)]
pub struct Handles {
    /// For each quantity, the displacement of every free point that changes it most smoothly.
    responses: Vec<Vec<[f64; 3]>>,
    /// The change of each quantity by each response.
    matrix: DMatrix<f64>,
}

impl Handles {
    /// Vertices that stay don't contribute.
    pub(super) fn new(
        equations: &Equations,
        rows: &[Row],
        point_of_vertex: &[Option<u32>],
    ) -> Self {
        let areas = equations.areas();
        let rows: Vec<Vec<(usize, DVec3)>> = rows
            .iter()
            .map(|row| {
                let entry = |&(vertex, axis): &(u32, [f32; 3])| {
                    let point = point_of_vertex.get(vertex as usize).copied().flatten()?;
                    Some((equations.row(point)?, Vec3::from(axis).as_dvec3()))
                };
                row.iter().filter_map(entry).collect()
            })
            .collect();
        let responses = map_indices(rows.len(), |index| response(equations, &rows[index], &areas));
        let change = |row: &[(usize, DVec3)], values: &[[f64; 3]]| {
            row.iter().map(|&(at, axis)| axis.dot(DVec3::from(values[at]))).sum::<f64>()
        };
        let matrix =
            DMatrix::from_fn(rows.len(), rows.len(), |i, j| change(&rows[i], &responses[j]));
        Self { responses, matrix }
    }

    /// The displacement of each row of the equations.
    pub(super) fn solve(&self, rows: usize, changes: &[Option<f32>]) -> Vec<[f64; 3]> {
        /// How much conditions may give way to smoothness, relative to one that is met alone: those
        /// that nearly repeat each other would fight otherwise.
        const GIVE: f64 = 1e-4;
        let given: Vec<(usize, f64)> = changes
            .iter()
            .take(self.responses.len())
            .enumerate()
            .filter_map(|(index, change)| Some((index, f64::from((*change)?))))
            .collect();
        let mut displacements = vec![[0.0; 3]; rows];
        if given.iter().all(|&(_, change)| change == 0.0) {
            return displacements;
        }
        let count = given.len();
        let mut matrix =
            DMatrix::from_fn(count, count, |i, j| self.matrix[(given[i].0, given[j].0)]);
        let give = GIVE * matrix.diagonal().sum() / count as f64;
        for index in 0..count {
            matrix[(index, index)] += give.max(f64::MIN_POSITIVE);
        }
        let wanted = DVector::from_fn(count, |index, _| given[index].1);
        let Some(factors) = matrix.cholesky() else { return displacements };
        for (&(index, _), share) in given.iter().zip(factors.solve(&wanted).iter()) {
            for (sum, value) in displacements.iter_mut().zip(&self.responses[index]) {
                (0..3).for_each(|k| sum[k] += share * value[k]);
            }
        }
        displacements
    }
}

/// `K` times one row.
fn response(equations: &Equations, row: &[(usize, DVec3)], areas: &[f64]) -> Vec<[f64; 3]> {
    let none = || vec![[0.0; 3]; equations.rows()];
    let mut right = none();
    for &(at, axis) in row {
        let axis = axis.to_array();
        (0..3).for_each(|k| right[at][k] += axis[k]);
    }
    let once = equations.factors().solve(&right).map(|mut values| {
        for (value, area) in values.iter_mut().zip(areas) {
            value.iter_mut().for_each(|value| *value *= area);
        }
        values
    });
    once.and_then(|values| equations.factors().solve(&values)).unwrap_or_else(none)
}
