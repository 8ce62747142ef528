//! Symmetry planes of a mesh.

use std::collections::HashMap;

use glam::DVec3;
use nalgebra::{Matrix3, Vector3};

use super::points::{Points, bounds};
use crate::directions::direction;

/// A plane through `point` at right angles to `normal`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub point: DVec3,
    pub normal: DVec3,
    /// Fraction of points that have a mirror image, `0.0..=1.0`.
    pub mirrored: f64,
}

/// Least fraction of mirrored points for a plane to be considered. Origin not recorded.
pub(super) const MIN_MIRRORED: f64 = 0.7;

/// Candidates for symmetry planes, best first: planes through the centre normal to the mesh's axes
/// and to its principal axes, each refined to align points with their mirror images.
pub(super) fn planes(points: &Points, wanted: impl Fn(u32) -> bool) -> Vec<Plane> {
    let cloud = Cloud::new(points, wanted);
    let mut normals = DVec3::AXES.to_vec();
    normals.extend(cloud.principal_axes());
    let mut planes: Vec<Plane> = Vec::new();
    for normal in normals {
        let start = Plane { point: cloud.center, normal, mirrored: 0.0 };
        let Some(plane) = cloud.refined(start) else { continue };
        let is_known = |known: &&Plane| known.normal.dot(plane.normal).abs() > 0.995;
        if !planes.iter().any(|known| is_known(&known)) {
            planes.push(plane);
        }
    }
    planes.sort_by(|a, b| b.mirrored.total_cmp(&a.mirrored));
    planes
}

/// A sample of the points in a grid of cells, for nearest-neighbour queries.
struct Cloud {
    points: Vec<DVec3>,
    cells: HashMap<[i32; 3], Vec<u32>>,
    cell: f64,
    center: DVec3,
    matrix: Matrix3<f64>,
}

impl Cloud {
    fn new(all: &Points, wanted: impl Fn(u32) -> bool) -> Self {
        const MAX: usize = 6_000;
        let wanted = |point: u32| wanted(all.component[point as usize]);
        let points: Vec<DVec3> = (0..)
            .zip(&all.positions)
            .filter_map(|(point, &position)| wanted(point).then_some(position))
            .collect();
        let stride = points.len().div_ceil(MAX).max(1);
        let points: Vec<DVec3> = points.into_iter().step_by(stride).collect();
        let triangles: Vec<[u32; 3]> =
            all.triangles.iter().filter(|triangle| wanted(triangle[0])).copied().collect();
        let [low, high] = bounds(&all.positions, &triangles);
        let cell = high.distance(low) * 0.015;
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (index, point) in (0..).zip(&points) {
            cells.entry(cell_of(*point, cell)).or_default().push(index);
        }
        // Weighted by area, or a head with many small triangles would outweigh the rest.
        let (mut area, mut center, mut matrix) = (0.0, DVec3::ZERO, Matrix3::zeros());
        for &triangle in triangles.iter().step_by(triangles.len().div_ceil(40_000).max(1)) {
            let [a, b, c] = all.corners(triangle);
            let weight = (b - a).cross(c - a).length();
            let middle = (a + b + c) / 3.0;
            area += weight;
            center += middle * weight;
            matrix += squared(middle - low) * weight;
        }
        let center = center / area.max(f64::MIN_POSITIVE);
        let matrix = matrix / area.max(f64::MIN_POSITIVE) - squared(center - low);
        Self { points, cells, cell, center, matrix }
    }

    fn principal_axes(&self) -> Vec<DVec3> {
        if !self.matrix.iter().all(|x| x.is_finite()) {
            return Vec::new();
        }
        let eigen = self.matrix.symmetric_eigen();
        eigen.eigenvectors.column_iter().map(|axis| DVec3::new(axis[0], axis[1], axis[2])).collect()
    }

    /// The nearest point, if it is closer than the side of a cell.
    fn nearest(&self, to: DVec3) -> Option<DVec3> {
        let [i, j, k] = cell_of(to, self.cell);
        let mut best: Option<(f64, DVec3)> = None;
        for offset in 0..27 {
            let key = [i + offset % 3 - 1, j + offset / 3 % 3 - 1, k + offset / 9 - 1];
            for &point in self.cells.get(&key).into_iter().flatten() {
                let at = self.points[point as usize];
                let distance = at.distance(to);
                if distance < self.cell && best.is_none_or(|best| distance < best.0) {
                    best = Some((distance, at));
                }
            }
        }
        best.map(|(_, at)| at)
    }

    /// Refines a plane to align points with their mirror images. `None` if fewer than a quarter
    /// match.
    ///
    /// Like iterative closest point (Besl & McKay 1992): each round pairs samples with the points
    /// nearest to their mirror images, then fits the plane to the pairs. Its point is the mean of
    /// their midpoints, its normal the main eigenvector of `Σ (a - b)(a - b)ᵀ`.
    fn refined(&self, mut plane: Plane) -> Option<Plane> {
        const SAMPLES: usize = 300;
        let stride = self.points.len().div_ceil(SAMPLES);
        let rounds = 5;
        for round in 0..rounds {
            let (mut count, mut found) = (0, Vec::new());
            for &point in self.points.iter().step_by(stride) {
                let height = (point - plane.point).dot(plane.normal);
                let mirrored = point + plane.normal * (-2.0 * height);
                count += 1;
                found.extend(self.nearest(mirrored).map(|partner| (point, partner)));
            }
            plane.mirrored = found.len() as f64 / f64::from(count.max(1));
            if plane.mirrored < 0.25 || round + 1 == rounds {
                break;
            }
            let mut matrix = Matrix3::zeros();
            let mut middle = DVec3::ZERO;
            for &(a, b) in &found {
                matrix += squared(a - b);
                middle = middle + a * 0.5 + b * 0.5;
            }
            plane.point = middle / found.len() as f64;
            if !matrix.iter().all(|x| x.is_finite()) {
                return None;
            }
            // The differences of mirror images are all parallel to the normal.
            let eigen = matrix.symmetric_eigen();
            let column = eigen.eigenvectors.column(eigen.eigenvalues.imax());
            plane.normal = direction(DVec3::new(column[0], column[1], column[2]))?;
        }
        (plane.mirrored >= 0.25).then_some(plane)
    }
}

fn cell_of(point: DVec3, cell: f64) -> [i32; 3] {
    (point / cell).floor().as_ivec3().to_array()
}

/// The outer product of a vector with itself.
fn squared(offset: DVec3) -> Matrix3<f64> {
    let column = Vector3::from(offset.to_array());
    column * column.transpose()
}
