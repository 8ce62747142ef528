//! The equations of one registration step: displacements that reach their targets and stay smooth.
//!
//! Minimises `Σ wᵢ |dᵢ − tᵢ|² + ℓᵦ⁴ ∫ |Δd|² + ℓₘ² ∫ |∇d|²` over the displacements `d` of a
//! surface's points, with the cotangent Laplacian `L` and lumped masses `M`, so that lengths mean
//! the same however finely a mesh is divided: `(W + ℓᵦ⁴ L M⁻¹ L + ℓₘ² L) d = W t`. The term of
//! second derivatives (bending) is that of M. Botsch and O. Sorkine, "On linear variational surface
//! deformation methods", 2008. Coordinates are independent, so there is one unknown a point.

use glam::DVec3;

use super::shape::Shape;
use crate::sparse::{Filled, Matrix, Order, SparseCholesky, may_hold};

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
    smoothness: Result<Smoothness, Filled>,
}

/// The matrices of what is smooth, and the order that keeps their factors sparse.
#[derive(Debug)]
struct Smoothness {
    laplacian: Matrix,
    bilaplacian: Matrix,
    order: Order,
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
        let smoothness = Smoothness::new(rest, &masses);
        Self { masses, smoothness }
    }

    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Factorises for one stiffness, with every point's weight equal to its mass; `None` if the equations
    /// have no solution.
    ///
    /// # Errors
    /// [`Filled`] for triangles that are connected like no surface.
    pub fn factorise(&self, stiffness: Stiffness) -> Result<Option<Factors<'_>>, Filled> {
        let smoothness = self.smoothness.as_ref().map_err(|&filled| filled)?;
        let mut entries = smoothness.stiff(stiffness);
        entries.extend((0..).zip(&self.masses).map(|(row, &mass)| (row, row, mass)));
        let factors = SparseCholesky::ordered(&smoothness.order, &entries)?;
        let Stiffness { bending, membrane } = stiffness;
        let (bending, membrane) = (bending.powi(4), membrane.powi(2));
        let masses = &self.masses;
        let is_sound = factors.is_sound();
        Ok(is_sound.then_some(Factors { masses, smoothness, bending, membrane, factors }))
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
        let smoothness = self.smoothness.as_ref().ok()?;
        let mut entries = smoothness.stiff(stiffness);
        let own = (0..).zip(self.masses.iter().zip(weights));
        entries.extend(own.map(|(row, (&mass, &weight))| (row, row, weight + LEAST * mass)));
        let mut right: Vec<DVec3> =
            weights.iter().zip(targets).map(|(&weight, &target)| target * weight).collect();
        for Anchor { points, weights, displacement } in anchors {
            for k in 0..3 {
                right[points[k] as usize] += *displacement * weights[k];
                for l in 0..3 {
                    entries.push((points[k], points[l], weights[k] * weights[l]));
                }
            }
        }
        solved(&SparseCholesky::ordered(&smoothness.order, &entries).ok()?, &right)
    }
}

impl Smoothness {
    fn new(rest: &Shape, masses: &[f64]) -> Result<Self, Filled> {
        let laplacian = laplacian(rest);
        // A point with many neighbours makes each of them depend on every other.
        let products = (0..masses.len()).map(|point| laplacian.column(point).0.len().pow(2)).sum();
        if !may_hold(masses.len(), products) {
            return Err(Filled);
        }
        let bilaplacian = bilaplacian(&laplacian, masses);
        let places = bilaplacian.entries().map(|(row, column, _)| (row, column));
        let order = Order::new(masses.len(), places);
        Ok(Self { laplacian, bilaplacian, order })
    }

    /// The entries of `ℓᵦ⁴ L M⁻¹ L + ℓₘ² L`.
    fn stiff(&self, stiffness: Stiffness) -> Vec<(u32, u32, f64)> {
        let (bending, membrane) = (stiffness.bending.powi(4), stiffness.membrane.powi(2));
        let all = [(&self.bilaplacian, bending), (&self.laplacian, membrane)];
        let entries = all.into_iter().flat_map(|(matrix, factor)| {
            matrix.entries().map(move |(row, column, value)| (row, column, factor * value))
        });
        entries.collect()
    }
}

/// The equations for one stiffness.
pub(crate) struct Factors<'a> {
    masses: &'a [f64],
    smoothness: &'a Smoothness,
    bending: f64,
    membrane: f64,
    factors: SparseCholesky,
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
            let mut result = self.smoothed(values);
            for (index, value) in result.iter_mut().enumerate() {
                *value += values[index] * (weights[index] + LEAST * self.masses[index]);
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
            |values| solved(&self.factors, values).unwrap_or_default(),
            &right,
            start,
            |step, norm| step < ITERATIONS && norm > TOLERANCE,
        )
    }

    /// `(ℓᵦ⁴ L M⁻¹ L + ℓₘ² L) values`.
    fn smoothed(&self, values: &[DVec3]) -> Vec<DVec3> {
        let product = |matrix: &Matrix, values: &[DVec3]| {
            let mut result = vec![DVec3::ZERO; values.len()];
            for (row, column, value) in matrix.entries() {
                result[row as usize] += values[column as usize] * value;
            }
            result
        };
        let mut first = product(&self.smoothness.laplacian, values);
        let membrane = first.clone();
        for (value, &mass) in first.iter_mut().zip(self.masses) {
            *value /= mass;
        }
        let mut result = product(&self.smoothness.laplacian, &first);
        for (value, membrane) in result.iter_mut().zip(membrane) {
            *value = *value * self.bending + membrane * self.membrane;
        }
        result
    }
}

fn solved(factors: &SparseCholesky, right: &[DVec3]) -> Option<Vec<DVec3>> {
    let right: Vec<[f64; 3]> = right.iter().map(DVec3::to_array).collect();
    Some(factors.solve(&right)?.into_iter().map(DVec3::from).collect())
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
fn laplacian(shape: &Shape) -> Matrix {
    /// The cotangents of 89° and 14°.
    const WEIGHTS: [f64; 2] = [0.02, 4.0];
    let size = shape.points.len();
    let mut entries = Vec::new();
    for triangle in 0..shape.triangles.len() {
        let corners = shape.corners(triangle);
        let points = shape.triangles[triangle];
        for k in 0..3 {
            let (a, b) = (points[k], points[(k + 1) % 3]);
            if a == b {
                continue;
            }
            let apex = corners[(k + 2) % 3];
            let (one, other) = (corners[k] - apex, corners[(k + 1) % 3] - apex);
            let area = one.cross(other).length();
            let cotangent = if area > 0.0 { one.dot(other) / area } else { WEIGHTS[1] };
            let weight = 0.5 * cotangent.clamp(WEIGHTS[0], WEIGHTS[1]);
            entries.extend([(a, a, weight), (b, b, weight), (a, b, -weight), (b, a, -weight)]);
        }
    }
    Matrix::new(size, entries.iter().copied())
}

/// `L M⁻¹ L`.
fn bilaplacian(laplacian: &Matrix, masses: &[f64]) -> Matrix {
    let products = laplacian.entries().flat_map(|(between, column, value)| {
        let scaled = value / masses[between as usize];
        let (rows, values) = laplacian.column(between as usize);
        rows.iter().zip(values).map(move |(&row, value)| (row, column, value * scaled))
    });
    Matrix::new(laplacian.columns(), products)
}
