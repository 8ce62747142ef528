//! The equations of one registration step: displacements that reach their targets and stay smooth.
//!
//! Minimises `Σ wᵢ |dᵢ − tᵢ|² + ℓᵦ⁴ ∫ |Δd|² + ℓₘ² ∫ |∇d|²` over the displacements `d` of a
//! surface's points, with the cotangent Laplacian `L` and lumped masses `M`, so that lengths mean
//! the same however finely a mesh is divided: `(W + ℓᵦ⁴ L M⁻¹ L + ℓₘ² L) d = W t`. The term of
//! second derivatives (bending) is that of M. Botsch and O. Sorkine, "On linear variational surface
//! deformation methods", 2008. Coordinates are independent, so there is one unknown a point.

use glam::DVec3;
use nalgebra_sparse::factorization::CscCholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix};

use super::shape::Shape;

/// A sum of points that should come to a place: indices and weights, and where to.
#[derive(Debug, Clone)]
pub(crate) struct Anchor {
    pub points: [u32; 3],
    pub weights: [f64; 3],
    /// The displacement that the weighted sum should have.
    pub displacement: DVec3,
}

/// Stiffness as lengths, in the shape's unit: details smaller than them are smoothed away.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stiffness {
    pub bending: f64,
    pub membrane: f64,
}

/// The weight of a displacement of 0, relative to a point's mass: what nothing else holds stays.
const LEAST: f64 = 1e-6;

/// What does not change while a surface is registered.
#[derive(Debug)]
pub(crate) struct Equations {
    masses: Vec<f64>,
    laplacian: CscMatrix<f64>,
    bilaplacian: CscMatrix<f64>,
    permuted: Vec<usize>,
}

impl Equations {
    pub fn new(rest: &Shape) -> Self {
        /// Points with hardly any area would make bending stiff beyond measure around them.
        const LEAST_MASS: f64 = 0.05;
        let mut masses = rest.masses();
        let mean = masses.iter().sum::<f64>() / masses.len().max(1) as f64;
        for mass in &mut masses {
            *mass = mass.max(LEAST_MASS * mean).max(f64::MIN_POSITIVE);
        }
        let laplacian = laplacian(rest);
        let mut scaled = laplacian.clone();
        for mut column in scaled.col_iter_mut() {
            let (rows, values) = column.rows_and_values_mut();
            for (&row, value) in rows.iter().zip(values) {
                *value /= masses[row];
            }
        }
        let bilaplacian = &laplacian * &scaled;
        let order = amd::order(
            masses.len(),
            bilaplacian.col_offsets(),
            bilaplacian.row_indices(),
            &amd::Control::default(),
        );
        let permuted =
            order.map_or_else(|_| (0..masses.len()).collect(), |(_, inverse, _)| inverse);
        Self { masses, laplacian, bilaplacian, permuted }
    }

    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Factorises for one stiffness, with every point's weight equal to its mass.
    pub fn factorise(&self, stiffness: Stiffness) -> Option<Factors<'_>> {
        let mut entries = self.stiff(stiffness);
        for (row, &mass) in self.masses.iter().enumerate() {
            entries.push(self.permuted[row], self.permuted[row], mass);
        }
        let factors = CscCholesky::factor(&CscMatrix::from(&entries)).ok()?;
        let Stiffness { bending, membrane } = stiffness;
        let (bending, membrane) = (bending.powi(4), membrane.powi(2));
        Some(Factors { equations: self, bending, membrane, factors })
    }

    /// Solves once, exactly: where few points have a weight, iterations are slow to move the rest.
    /// Anchors count with the squares of their weights.
    pub fn solve(
        &self,
        stiffness: Stiffness,
        weights: &[f64],
        targets: &[DVec3],
        anchors: &[Anchor],
    ) -> Option<Vec<DVec3>> {
        let mut entries = self.stiff(stiffness);
        let permuted = &self.permuted;
        for (row, (&mass, &weight)) in self.masses.iter().zip(weights).enumerate() {
            entries.push(permuted[row], permuted[row], weight + LEAST * mass);
        }
        let mut right: Vec<DVec3> =
            weights.iter().zip(targets).map(|(&weight, &target)| target * weight).collect();
        for Anchor { points, weights, displacement } in anchors {
            let points = points.map(|point| point as usize);
            for k in 0..3 {
                right[points[k]] += *displacement * weights[k];
                for l in 0..3 {
                    let product = weights[k] * weights[l];
                    entries.push(permuted[points[k]], permuted[points[l]], product);
                }
            }
        }
        let factors = CscCholesky::factor(&CscMatrix::from(&entries)).ok()?;
        let solver = Factors { equations: self, bending: 0.0, membrane: 0.0, factors };
        Some(solver.precondition(&right))
    }

    /// The entries of `ℓᵦ⁴ L M⁻¹ L + ℓₘ² L`, in the order that keeps factors sparse.
    fn stiff(&self, stiffness: Stiffness) -> CooMatrix<f64> {
        let size = self.masses.len();
        let (bending, membrane) = (stiffness.bending.powi(4), stiffness.membrane.powi(2));
        let mut entries = CooMatrix::new(size, size);
        for (matrix, factor) in [(&self.bilaplacian, bending), (&self.laplacian, membrane)] {
            for (row, column, value) in matrix.triplet_iter() {
                entries.push(self.permuted[row], self.permuted[column], factor * value);
            }
        }
        entries
    }
}

/// The equations for one stiffness.
pub(crate) struct Factors<'a> {
    equations: &'a Equations,
    bending: f64,
    membrane: f64,
    factors: CscCholesky<f64>,
}

impl Factors<'_> {
    /// Solves by conjugate gradients with the factors as preconditioner, from an earlier solution.
    ///
    /// - `weights`, `targets`: of each point, and where it should be displaced to.
    pub fn solve(
        &self,
        weights: &[f64],
        targets: &[DVec3],
        anchors: &[Anchor],
        anchor_weight: f64,
        start: &[DVec3],
    ) -> Vec<DVec3> {
        /// Iterations and the relative residual at which they end: far below what a step changes.
        const ITERATIONS: usize = 30;
        const TOLERANCE: f64 = 1e-4;
        let apply = |values: &[DVec3]| {
            let mut result = self.smoothness(values);
            for (index, value) in result.iter_mut().enumerate() {
                *value += values[index] * (weights[index] + LEAST * self.equations.masses[index]);
            }
            for Anchor { points, weights, .. } in anchors {
                let sum: DVec3 = (0..3).map(|k| values[points[k] as usize] * weights[k]).sum();
                for k in 0..3 {
                    result[points[k] as usize] += sum * (weights[k] * anchor_weight);
                }
            }
            result
        };
        let mut right: Vec<DVec3> =
            weights.iter().zip(targets).map(|(&weight, &target)| target * weight).collect();
        for Anchor { points, weights, displacement } in anchors {
            for k in 0..3 {
                right[points[k] as usize] += *displacement * (weights[k] * anchor_weight);
            }
        }
        conjugate_gradients(
            apply,
            |values| self.precondition(values),
            &right,
            start,
            |step, norm| step < ITERATIONS && norm > TOLERANCE,
        )
    }

    /// `(ℓᵦ⁴ L M⁻¹ L + ℓₘ² L) values`.
    fn smoothness(&self, values: &[DVec3]) -> Vec<DVec3> {
        let product = |matrix: &CscMatrix<f64>, values: &[DVec3]| {
            let mut result = vec![DVec3::ZERO; values.len()];
            for (column, lane) in matrix.col_iter().enumerate() {
                for (&row, &value) in lane.row_indices().iter().zip(lane.values()) {
                    result[row] += values[column] * value;
                }
            }
            result
        };
        let mut first = product(&self.equations.laplacian, values);
        let membrane = first.clone();
        for (value, &mass) in first.iter_mut().zip(&self.equations.masses) {
            *value /= mass;
        }
        let mut result = product(&self.equations.laplacian, &first);
        for (value, membrane) in result.iter_mut().zip(membrane) {
            *value = *value * self.bending + membrane * self.membrane;
        }
        result
    }

    /// `(L Lᵀ)⁻¹ values` with the Cholesky factor `L`. The library solves coordinate by coordinate,
    /// and reads the factor three times for it.
    fn precondition(&self, values: &[DVec3]) -> Vec<DVec3> {
        let permuted = &self.equations.permuted;
        let mut solution = vec![DVec3::ZERO; values.len()];
        for (&at, &value) in permuted.iter().zip(values) {
            solution[at] = value;
        }
        let lower = self.factors.l();
        // Row indices ascend, so the diagonal comes first.
        let column = |index: usize| {
            let (offsets, rows, values) = lower.csc_data();
            let range = offsets[index]..offsets[index + 1];
            let (rows, values) = (&rows[range.clone()], &values[range]);
            (values[0], rows[1..].iter().zip(&values[1..]))
        };
        for index in 0..solution.len() {
            let (diagonal, below) = column(index);
            let value = solution[index] / diagonal;
            solution[index] = value;
            for (&row, &factor) in below {
                solution[row] -= value * factor;
            }
        }
        for index in (0..solution.len()).rev() {
            let (diagonal, below) = column(index);
            let sum: DVec3 = below.map(|(&row, &factor)| solution[row] * factor).sum();
            solution[index] = (solution[index] - sum) / diagonal;
        }
        permuted.iter().map(|&at| solution[at]).collect()
    }
}

/// Preconditioned conjugate gradients for the three coordinates at once.
///
/// - `goes_on`: from the number of steps and the residual relative to the right-hand side.
fn conjugate_gradients(
    apply: impl Fn(&[DVec3]) -> Vec<DVec3>,
    precondition: impl Fn(&[DVec3]) -> Vec<DVec3>,
    right: &[DVec3],
    start: &[DVec3],
    goes_on: impl Fn(usize, f64) -> bool,
) -> Vec<DVec3> {
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| *a * *b).sum::<DVec3>();
    // One step length for each coordinate; a coordinate that is solved stays.
    let ratio = |above: DVec3, below: DVec3| {
        DVec3::from_array([0, 1, 2].map(|k| if below[k] > 0.0 { above[k] / below[k] } else { 0.0 }))
    };
    let mut solution = start.to_vec();
    let mut residual: Vec<DVec3> =
        right.iter().zip(apply(&solution)).map(|(&right, applied)| right - applied).collect();
    let scale = dot(right, right).element_sum().sqrt().max(f64::MIN_POSITIVE);
    let mut search = precondition(&residual);
    let mut energy = dot(&residual, &search);
    let mut step = 0;
    while goes_on(step, dot(&residual, &residual).element_sum().sqrt() / scale) {
        let applied = apply(&search);
        let length = ratio(energy, dot(&search, &applied));
        for index in 0..solution.len() {
            solution[index] += search[index] * length;
            residual[index] -= applied[index] * length;
        }
        let conditioned = precondition(&residual);
        let next = dot(&residual, &conditioned);
        let turn = ratio(next, energy);
        for (search, conditioned) in search.iter_mut().zip(conditioned) {
            *search = conditioned + *search * turn;
        }
        energy = next;
        step += 1;
    }
    solution
}

/// The cotangent Laplacian, positive semidefinite: weights are kept positive and bounded, so that
/// slivers neither pull points over each other nor hold them apart.
fn laplacian(shape: &Shape) -> CscMatrix<f64> {
    const WEIGHTS: [f64; 2] = [0.02, 4.0];
    let size = shape.points.len();
    let mut entries = CooMatrix::new(size, size);
    for triangle in 0..shape.triangles.len() {
        let corners = shape.corners(triangle);
        let points = shape.triangles[triangle];
        for k in 0..3 {
            let (a, b) = (points[k] as usize, points[(k + 1) % 3] as usize);
            if a == b {
                continue;
            }
            let apex = corners[(k + 2) % 3];
            let (one, other) = (corners[k] - apex, corners[(k + 1) % 3] - apex);
            let area = one.cross(other).length();
            let cotangent = if area > 0.0 { one.dot(other) / area } else { WEIGHTS[1] };
            let weight = 0.5 * cotangent.clamp(WEIGHTS[0], WEIGHTS[1]);
            entries.push(a, a, weight);
            entries.push(b, b, weight);
            entries.push(a, b, -weight);
            entries.push(b, a, -weight);
        }
    }
    CscMatrix::from(&entries)
}
