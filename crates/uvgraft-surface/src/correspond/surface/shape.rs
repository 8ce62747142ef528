//! A mesh as registration sees it: welded points, triangles and normals, in one common unit.

use std::sync::Arc;

use glam::DVec3;

use crate::surface::Surface;
use crate::triangle_tree::{Effort, TriangleTree};

/// Triangles over points.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// The surface, with every point moved by `place`.
    pub fn new(surface: &Surface, place: impl Fn(DVec3) -> DVec3) -> Self {
        Self {
            points: surface.positions().iter().map(|&point| place(point)).collect(),
            triangles: surface.triangles().to_vec(),
        }
    }

    /// The triangles that are not left out, and the points that these have.
    ///
    /// - `left_out`: as many as triangles.
    pub fn without(&self, left_out: &[bool]) -> Self {
        let mut number = vec![u32::MAX; self.points.len()];
        let mut shape = Self { points: Vec::new(), triangles: Vec::new() };
        for (points, _) in self.triangles.iter().zip(left_out).filter(|(_, is_out)| !**is_out) {
            shape.triangles.push(points.map(|point| {
                let number = &mut number[point as usize];
                if *number == u32::MAX {
                    *number = shape.points.len() as u32;
                    shape.points.push(self.points[point as usize]);
                }
                *number
            }));
        }
        shape
    }

    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|point| self.points[point as usize])
    }

    /// Twice the area of a triangle, along its normal.
    pub fn area_vector(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// The unit normal of each triangle; zero for degenerate ones.
    pub fn face_normals(&self) -> Vec<DVec3> {
        (0..self.triangles.len()).map(|face| self.area_vector(face).normalize_or_zero()).collect()
    }

    /// The unit normal at each point, the mean over its triangles by area.
    pub fn normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.points.len()];
        for (triangle, points) in self.triangles.iter().enumerate() {
            let vector = self.area_vector(triangle);
            for &point in points {
                normals[point as usize] += vector;
            }
        }
        normals.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    /// A third of the area around each point.
    pub fn masses(&self) -> Vec<f64> {
        let mut masses = vec![0.0; self.points.len()];
        for (triangle, points) in self.triangles.iter().enumerate() {
            let share = self.area_vector(triangle).length() / 6.0;
            for &point in points {
                masses[point as usize] += share;
            }
        }
        masses
    }

    /// For each directed side `3 * triangle + corner`, whether no other triangle shares the edge.
    pub fn open_sides(&self) -> Vec<bool> {
        let mut sides: Vec<(u32, u32, usize)> = Vec::with_capacity(self.triangles.len() * 3);
        for (triangle, points) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (points[k], points[(k + 1) % 3]);
                sides.push((a.min(b), a.max(b), 3 * triangle + k));
            }
        }
        sides.sort_unstable();
        let mut is_open = vec![false; sides.len()];
        for group in sides.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            if let &[(.., side)] = group {
                is_open[side] = true;
            }
        }
        is_open
    }

    /// - `effort`: of its searches, together with others.
    pub fn tree(&self, effort: &Arc<Effort>) -> TriangleTree {
        let corners = (0..self.triangles.len()).map(|triangle| self.corners(triangle)).collect();
        TriangleTree::new(corners).with_effort(effort)
    }
}
