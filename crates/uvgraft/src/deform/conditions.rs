//! Corrections of deformations: the smoothest ones after which linear conditions hold.
//!
//! With the screened Laplacian `A` and the areas `M` of the points, the correction `c` that minimises
//! `cᵀ A M⁻¹ A c` under conditions `B c = b` is `c = K Bᵀ (B K Bᵀ)⁻¹ b`, where `K = A⁻¹ M A⁻¹`: one
//! small dense system. A single Laplacian would leave a peak at each condition.

use glam::{DVec3, Vec3};
use nalgebra::{DMatrix, DVector};

use super::equations::Equations;
use crate::threads::map_indices;

/// A linear condition on the offsets of a target's vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// Vertices, and the vectors whose dot products with their offsets add up to a quantity.
    pub row: Vec<(u32, [f32; 3])>,
    /// The value that the quantity should have.
    pub value: f32,
}

/// The displacement of every point; conditions on points that stay are ignored.
pub(super) fn solve(
    equations: &Equations,
    conditions: &[Condition],
    point_of_vertex: &[Option<u32>],
) -> Vec<DVec3> {
    /// How much conditions may give way to smoothness, relative to one that is met alone: those that
    /// nearly repeat each other would fight otherwise.
    const GIVE: f64 = 1e-4;
    let areas = equations.areas();
    let rows: Vec<Vec<(usize, DVec3)>> = conditions
        .iter()
        .map(|condition| {
            let entry = |&(vertex, axis): &(u32, [f32; 3])| {
                let point = point_of_vertex.get(vertex as usize).copied().flatten()?;
                Some((equations.row(point)?, Vec3::from(axis).as_dvec3()))
            };
            condition.row.iter().filter_map(entry).collect()
        })
        .collect();
    let responses = map_indices(rows.len(), |index| response(equations, &rows[index], &areas));
    let count = rows.len();
    let product = |row: &[(usize, DVec3)], values: &[[f64; 3]]| {
        row.iter().map(|&(at, axis)| axis.dot(DVec3::from(values[at]))).sum::<f64>()
    };
    let mut matrix = DMatrix::from_fn(count, count, |i, j| product(&rows[i], &responses[j]));
    let give = GIVE * matrix.diagonal().sum() / count.max(1) as f64;
    for index in 0..count {
        matrix[(index, index)] += give.max(f64::MIN_POSITIVE);
    }
    let wanted = DVector::from_fn(count, |index, _| f64::from(conditions[index].value));
    let mut correction = vec![[0.0; 3]; equations.rows()];
    if let Some(factors) = matrix.cholesky() {
        let shares = factors.solve(&wanted);
        for (response, share) in responses.iter().zip(shares.iter()) {
            for (sum, value) in correction.iter_mut().zip(response) {
                (0..3).for_each(|k| sum[k] += share * value[k]);
            }
        }
    }
    equations.to_points(&correction)
}

/// `K` times one condition.
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
