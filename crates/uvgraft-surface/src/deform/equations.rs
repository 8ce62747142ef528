//! The Poisson equation of a transfer, factorised.

use glam::{DMat3, DVec3};

use super::gradients::OfFaces;
use super::reach::{COVERED, Reach};
use super::samples::{Sample, Samples};
use crate::sparse::Solver;
use crate::surface::Surface;

/// The least and the greatest weight of an edge in a triangle: slivers neither fall apart nor hold
/// others still. They are the cotangents of 89° and 14°.
const WEIGHTS: [f64; 2] = [0.02, 4.0];
/// How stiff a triangle without a counterpart is: it follows the others, and hardly holds them.
/// Origin not recorded.
const UNPAIRED: f64 = 0.05;

/// What binds displacements besides their gradients.
#[derive(Debug)]
pub(super) struct Screen<'a> {
    /// Above it, displacements decide.
    pub length: f64,
    /// Where displacements are known. Without, the whole surface is bound.
    pub samples: Option<&'a Samples>,
}

/// The equations of the free points.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    row_of_point: Vec<Option<usize>>,
    triangles: Vec<[u32; 3]>,
    /// The edges of each triangle: to the corner `k + 1` from `k`, at rest.
    edges: Vec<[DVec3; 3]>,
    /// Their weights.
    weights: Vec<[f64; 3]>,
    /// The weight of a known displacement, by area.
    masses: Vec<f64>,
    rows: usize,
    factors: Solver,
}

impl Equations {
    pub fn new(surface: &Surface, reach: &Reach, screen: &Screen<'_>) -> Self {
        let count = surface.triangles().len();
        let row_of_point =
            (0..surface.positions().len() as u32).map(|point| reach.row(point)).collect();
        let mut new = Self {
            row_of_point,
            triangles: surface.triangles().to_vec(),
            edges: Vec::with_capacity(count),
            weights: Vec::with_capacity(count),
            masses: Vec::with_capacity(count),
            rows: reach.rows(),
            factors: Solver::new(0, &[]),
        };
        for triangle in 0..count as u32 {
            let corners = surface.corners(triangle);
            let stiffness = screen.samples.map_or(1.0, |samples| {
                let covered = samples.covered(triangle);
                if covered < COVERED { UNPAIRED } else { covered.clamp(UNPAIRED, 1.0) }
            });
            new.edges.push([0, 1, 2].map(|k| corners[(k + 1) % 3] - corners[k]));
            new.weights.push([0, 1, 2].map(|k| stiffness * weight(corners, k)));
            new.masses.push(surface.area(triangle) / screen.length.powi(2));
        }
        new.factors = Solver::new(new.rows, &new.entries(screen));
        new
    }

    pub fn is_sound(&self) -> bool {
        self.factors.is_sound()
    }

    /// The points of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// The row of a point; `None` if it stays.
    pub fn row(&self, point: u32) -> Option<usize> {
        self.row_of_point[point as usize]
    }

    pub const fn factors(&self) -> &Solver {
        &self.factors
    }

    /// The mass of each free point: a third of its triangles.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.rows];
        for (points, mass) in self.triangles.iter().zip(&self.masses) {
            for row in points.iter().filter_map(|&point| self.row(point)) {
                areas[row] += mass / 3.0;
            }
        }
        areas
    }

    /// The matrix.
    fn entries(&self, screen: &Screen<'_>) -> Vec<(u32, u32, f64)> {
        const WHOLE: [Sample; 1] =
            [Sample { source: 0, share: 1.0, at: [1.0 / 3.0; 3], from: [0.0; 3] }];
        let mut entries = Vec::with_capacity(self.triangles.len() * 18);
        // Points of which nothing else is known.
        let least = self.masses.iter().sum::<f64>() / self.masses.len().max(1) as f64 * 1e-9;
        entries.extend((0..self.rows as u32).map(|row| (row, row, least.max(f64::MIN_POSITIVE))));
        for (triangle, points) in self.triangles.iter().enumerate() {
            let rows = points.map(|point| self.row(point).map(|row| row as u32));
            if rows.iter().all(Option::is_none) {
                continue;
            }
            for k in 0..3 {
                let (a, b) = (rows[k], rows[(k + 1) % 3]);
                let weight = self.weights[triangle][k];
                if points[k] == points[(k + 1) % 3] {
                    continue;
                }
                entries.extend([a, b].into_iter().flatten().map(|row| (row, row, weight)));
                if let (Some(a), Some(b)) = (a, b) {
                    entries.extend([(a, b, -weight), (b, a, -weight)]);
                }
            }
            let samples = screen.samples.map_or(&WHOLE[..], |all| all.of(triangle as u32));
            for sample in samples {
                let mass = self.masses[triangle] * sample.share;
                for (k, row) in rows.iter().enumerate() {
                    for (l, column) in rows.iter().enumerate() {
                        if let (&Some(row), &Some(column)) = (row, column) {
                            entries.push((row, column, mass * sample.at[k] * sample.at[l]));
                        }
                    }
                }
            }
        }
        entries
    }

    /// The displacement of every point.
    ///
    /// - `gradients`: of the source's faces.
    /// - `displacement`: of a place in a source face, as it should be in the target.
    pub fn solve(
        &self,
        samples: &Samples,
        gradients: &OfFaces,
        displacement: impl Fn(u32, [f64; 3]) -> DVec3,
    ) -> Vec<DVec3> {
        let mut right = vec![[0.0; 3]; self.rows];
        let mut add = |row: Option<usize>, value: DVec3| {
            if let Some(row) = row {
                let value = value.to_array();
                (0..3).for_each(|k| right[row][k] += value[k]);
            }
        };
        for (triangle, points) in self.triangles.iter().enumerate() {
            let rows = points.map(|point| self.row(point));
            let of = samples.of(triangle as u32);
            if of.is_empty() || rows.iter().all(Option::is_none) {
                continue;
            }
            let gradient = mean_gradient(of, gradients);
            for k in 0..3 {
                let pull = gradient * self.edges[triangle][k] * self.weights[triangle][k];
                add(rows[(k + 1) % 3], pull);
                add(rows[k], -pull);
            }
            for sample in of {
                let mass = self.masses[triangle] * sample.share;
                let to = displacement(sample.source, sample.from) * mass;
                (0..3).for_each(|k| add(rows[k], to * sample.at[k]));
            }
        }
        let solution = self.factors.solve(&right).unwrap_or_else(|| vec![[0.0; 3]; self.rows]);
        self.to_points(&solution)
    }

    /// Values of rows at the points; zero at those that stay.
    pub fn to_points(&self, rows: &[[f64; 3]]) -> Vec<DVec3> {
        let of = |row: &Option<usize>| row.map_or(DVec3::ZERO, |row| DVec3::from(rows[row]));
        self.row_of_point.iter().map(of).collect()
    }
}

/// The mean over the parts of a triangle, by area.
fn mean_gradient(samples: &[Sample], gradients: &OfFaces) -> DMat3 {
    let mut sum = DMat3::ZERO;
    let mut covered = 0.0;
    for sample in samples {
        covered += sample.share;
        if let Some(gradient) = gradients[sample.source as usize] {
            sum += gradient * sample.share;
        }
    }
    if covered > 0.0 { sum * covered.recip() } else { sum }
}

/// Half the cotangent of the angle opposite to the edge from corner `k` to the next, within
/// [`WEIGHTS`].
fn weight(corners: [DVec3; 3], k: usize) -> f64 {
    let apex = corners[(k + 2) % 3];
    let (a, b) = (corners[k] - apex, corners[(k + 1) % 3] - apex);
    let area = a.cross(b).length();
    let cotangent = if area > 0.0 { a.dot(b) / area } else { f64::INFINITY };
    (0.5 * cotangent).clamp(WEIGHTS[0], WEIGHTS[1])
}
