//! Planes that mirror a mesh onto itself.

use std::collections::HashMap;

use nalgebra::Matrix3;

use super::points::Points;
use crate::vector::{Vector, direction, dot, norm, plus, sub};

/// A plane through `point` at right angles to `normal`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub point: Vector,
    pub normal: Vector,
    /// The share of points that have a mirror image, `0.0..=1.0`.
    pub mirrored: f64,
}

/// Planes that mirror at least this share of the points are worth a look.
pub(super) const LEAST_MIRRORED: f64 = 0.7;

/// Candidates are the planes through the centre along the mesh's axes and along its principal axes, each
/// moved to where points and the mirror images of others meet. The best comes first.
pub(super) fn planes(points: &Points) -> Vec<Plane> {
    let cloud = Cloud::new(points);
    let mut normals: Vec<Vector> = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    normals.extend(cloud.principal_axes());
    let mut planes: Vec<Plane> = Vec::new();
    for normal in normals {
        let start = Plane { point: cloud.center, normal, mirrored: 0.0 };
        let Some(plane) = cloud.refined(start) else { continue };
        let is_known = |known: &&Plane| dot(known.normal, plane.normal).abs() > 0.995;
        if !planes.iter().any(|known| is_known(&known)) {
            planes.push(plane);
        }
    }
    planes.sort_by(|a, b| b.mirrored.total_cmp(&a.mirrored));
    planes
}

/// Some of the points, findable by place.
struct Cloud {
    points: Vec<Vector>,
    cells: HashMap<[i32; 3], Vec<u32>>,
    cell: f64,
    center: Vector,
    matrix: Matrix3<f64>,
}

impl Cloud {
    fn new(all: &Points) -> Self {
        const MOST: usize = 6_000;
        let stride = all.positions.len().div_ceil(MOST);
        let points: Vec<Vector> = all.positions.iter().step_by(stride).copied().collect();
        let cell = all.diagonal() * 0.015;
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (index, point) in (0..).zip(&points) {
            cells.entry(point.map(|x| (x / cell).floor() as i32)).or_default().push(index);
        }
        // Weighed by area, or a head of many small triangles would outweigh the rest.
        let (mut area, mut center, mut matrix) = (0.0, [0.0; 3], Matrix3::zeros());
        for &triangle in all.triangles.iter().step_by(all.triangles.len().div_ceil(40_000)) {
            let [a, b, c] = all.corners(triangle);
            let weight = norm(crate::vector::cross(sub(b, a), sub(c, a)));
            let middle = plus(plus(a, 1.0, b), 1.0, c).map(|x| x / 3.0);
            area += weight;
            center = plus(center, weight, middle);
            let offset = nalgebra::Vector3::from(sub(middle, all.bounds[0]));
            matrix += offset * offset.transpose() * weight;
        }
        let center = center.map(|x| x / area.max(f64::MIN_POSITIVE));
        let offset = nalgebra::Vector3::from(sub(center, all.bounds[0]));
        let matrix = matrix / area.max(f64::MIN_POSITIVE) - offset * offset.transpose();
        Self { points, cells, cell, center, matrix }
    }

    fn principal_axes(&self) -> Vec<Vector> {
        if !self.matrix.iter().all(|x| x.is_finite()) {
            return Vec::new();
        }
        let eigen = self.matrix.symmetric_eigen();
        eigen.eigenvectors.column_iter().map(|axis| [axis[0], axis[1], axis[2]]).collect()
    }

    fn nearest(&self, to: Vector) -> Option<Vector> {
        let [i, j, k] = to.map(|x| (x / self.cell).floor() as i32);
        let mut best: Option<(f64, Vector)> = None;
        for offset in 0..27 {
            let key = [i + offset % 3 - 1, j + offset / 3 % 3 - 1, k + offset / 9 - 1];
            for &point in self.cells.get(&key).into_iter().flatten() {
                let at = self.points[point as usize];
                let distance = norm(sub(at, to));
                if distance < self.cell && best.is_none_or(|best| distance < best.0) {
                    best = Some((distance, at));
                }
            }
        }
        best.map(|(_, at)| at)
    }

    /// Moves a plane to where points and mirror images meet, as ICP does. `None` if they hardly do.
    fn refined(&self, mut plane: Plane) -> Option<Plane> {
        const SAMPLES: usize = 300;
        let stride = self.points.len().div_ceil(SAMPLES);
        let rounds = 5;
        for round in 0..rounds {
            let (mut count, mut found) = (0, Vec::new());
            for &point in self.points.iter().step_by(stride) {
                let height = dot(sub(point, plane.point), plane.normal);
                let mirrored = plus(point, -2.0 * height, plane.normal);
                count += 1;
                found.extend(self.nearest(mirrored).map(|partner| (point, partner)));
            }
            plane.mirrored = found.len() as f64 / f64::from(count.max(1));
            if plane.mirrored < 0.25 || round + 1 == rounds {
                break;
            }
            let mut matrix = Matrix3::zeros();
            let mut middle = [0.0; 3];
            for (a, b) in &found {
                let offset = nalgebra::Vector3::from(sub(*a, *b));
                matrix += offset * offset.transpose();
                middle = plus(plus(middle, 0.5, *a), 0.5, *b);
            }
            plane.point = middle.map(|x| x / found.len() as f64);
            if !matrix.iter().all(|x| x.is_finite()) {
                return None;
            }
            // Differences of mirror images all lie along the normal.
            let eigen = matrix.symmetric_eigen();
            let column = eigen.eigenvectors.column(eigen.eigenvalues.imax());
            plane.normal = direction([column[0], column[1], column[2]])?;
        }
        (plane.mirrored >= 0.25).then_some(plane)
    }
}
