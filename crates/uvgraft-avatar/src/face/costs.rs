//! Costs of moving the skin, as quadratic forms of the coefficients.

use glam::Vec3;
use nalgebra::{DMatrix, DVector};
use uvgraft::threads;

use super::Face;
use super::movement::{BlendBasis, local};
use super::targets::Zone;

/// Cost of a mean square millimetre of movement inside the expression's zone, and elsewhere.
const WITHIN: f64 = 0.1;
const ELSEWHERE: f64 = 20.0;
/// Costs are averaged over an even selection of the head's vertices; more would not change them.
const MAX_VERTICES: usize = 2500;

/// Sums of squared movement in mm², averaged over the vertices, as matrices.
pub(super) struct Costs {
    /// Of the movement of all vertices, of the mirrored movement, and mixed: `Dᵀ D`, `Bᵀ B` and
    /// `Bᵀ D`, where `D` maps coefficients to movements and `B` to mirrored ones.
    pub straight: DMatrix<f64>,
    pub mirrored: DMatrix<f64>,
    pub crossed: DMatrix<f64>,
    /// Of all vertices, weighted by zone: eyes, mouth, brows, any of these.
    zones: [DMatrix<f64>; 4],
}

impl Costs {
    pub(super) fn new(head: &Head, movements: &[BlendBasis], axes: &[Vec3; 3], mm: f32) -> Self {
        let along = |vertex: usize, axis: usize, movement: &BlendBasis| {
            axes[axis].dot(movement.offsets[head.vertices[vertex] as usize].into()) * mm
        };
        let column = |movement: usize, is_mirrored: bool| -> Vec<f32> {
            let movement = &movements[movement];
            let at = |vertex: usize, axis: usize| match (is_mirrored, axis) {
                (false, _) => along(vertex, axis, movement),
                (true, 0) => -along(head.mirror[vertex], 0, movement),
                (true, _) => along(head.mirror[vertex], axis, movement),
            };
            head.kept.iter().flat_map(|&vertex| [0, 1, 2].map(|axis| at(vertex, axis))).collect()
        };
        let count = movements.len();
        let table = threads::map_indices(count, |movement| column(movement, false));
        let mirrored = threads::map_indices(count, |movement| column(movement, true));
        let weighted = |weights: &[f32]| -> Vec<Vec<f32>> {
            let scaled =
                |column: &Vec<f32>| column.iter().zip(weights).map(|(a, w)| a * w).collect();
            table.iter().map(scaled).collect()
        };
        Self {
            straight: products(&table, &table, true),
            mirrored: products(&mirrored, &mirrored, true),
            crossed: products(&mirrored, &table, false),
            zones: head.zones().map(|zone| products(&weighted(&zone), &table, true)),
        }
    }

    /// The cost of movement for an expression in a zone: cheap inside it, expensive elsewhere.
    pub(super) fn moving(&self, zone: Zone) -> DMatrix<f64> {
        &self.straight * ELSEWHERE + self.within(zone) * (WITHIN - ELSEWHERE)
    }

    /// The part of the squared movement that lies in a zone.
    const fn within(&self, zone: Zone) -> &DMatrix<f64> {
        match zone {
            Zone::LeftEye | Zone::RightEye => &self.zones[0],
            Zone::Mouth => &self.zones[1],
            Zone::Brows => &self.zones[2],
            Zone::Face => &self.zones[3],
        }
    }

    /// Movement of the skin outside the zone: the root mean square over the head, in mm.
    pub(super) fn stray_mm(&self, zone: Zone, coefficients: &[f64]) -> f64 {
        let x = DVector::from_column_slice(coefficients);
        let elsewhere = &self.straight - self.within(zone);
        (elsewhere * &x).dot(&x).max(0.0).sqrt()
    }

    /// The squared difference between movements and their mirror images: |D x - B x|².
    pub(super) fn asymmetry(&self) -> DMatrix<f64> {
        &self.straight + &self.mirrored - &self.crossed - self.crossed.transpose()
    }
}

/// All products of the columns of two tables, averaged over the vertices.
fn products(a: &[Vec<f32>], b: &[Vec<f32>], is_symmetric: bool) -> DMatrix<f64> {
    let vertices = (a.first().map_or(0, Vec::len) / 3).max(1) as f64;
    let row = |at: usize| -> Vec<f64> {
        let until = if is_symmetric { at + 1 } else { b.len() };
        b[..until].iter().map(|column| dot(&a[at], column) / vertices).collect()
    };
    let rows = threads::map_indices(a.len(), row);
    DMatrix::from_fn(a.len(), b.len(), |at, to| {
        if is_symmetric && to > at { rows[to][at] } else { rows[at][to] }
    })
}

/// Dot product in eight partial sums, which the compiler vectorises.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    let (a, rest_a) = a.as_chunks::<8>();
    let (b, rest_b) = b.as_chunks::<8>();
    let mut sums = [0.0_f32; 8];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest = rest_a.iter().zip(rest_b).map(|(a, b)| f64::from(a * b));
    sums.iter().map(|&sum| f64::from(sum)).sum::<f64>() + rest.sum::<f64>()
}

/// The vertices of the head.
pub(super) struct Head {
    vertices: Vec<u32>,
    /// In head coordinates.
    positions: Vec<Vec3>,
    /// For each of them the vertex closest to its mirror image, as an index into the list.
    mirror: Vec<usize>,
    /// Those that costs are averaged over.
    kept: Vec<usize>,
    mouth: Vec3,
    eyes: [Vec3; 2],
}

impl Head {
    /// - `rest`: vertex positions at rest.
    pub(super) fn new(face: &Face, rest: &[[f32; 3]]) -> Self {
        const REACH: f32 = 2.2;
        let positions = rest.iter().map(|&point| Vec3::from(local(face, point.into())));
        let near = (0..).zip(positions).filter(|(_, point)| point.length() < REACH);
        let (vertices, positions): (Vec<u32>, Vec<Vec3>) = near.unzip();
        let mirror = mirror(&positions);
        let step = vertices.len().div_ceil(MAX_VERTICES).max(1);
        let kept = (0..vertices.len()).step_by(step).collect();
        let lips = face.lips.iter().map(|lip| Vec3::from(local(face, lip.upper.of(rest))));
        let mouth = lips.sum::<Vec3>() / face.lips.len() as f32;
        let eyes = [face.eyes[0].center, face.eyes[1].center];
        Self { vertices, positions, mirror, kept, mouth, eyes }
    }

    /// Soft weights in `0.0..=1.0` for each coordinate of the kept vertices: near the eyes, the
    /// mouth, the brows, and any of these.
    fn zones(&self) -> [Vec<f32>; 4] {
        let soft = |square: f32| (-square).exp();
        let eye = |p: &Vec3| {
            let near = self.eyes.map(|eye| (*p - eye).length_squared() / 0.16);
            soft(near[0].min(near[1]).powi(2))
        };
        let mouth = |p: &Vec3| {
            let d = *p - self.mouth;
            soft((d.x * d.x / 0.5 + d.y * d.y / 0.36 + d.z * d.z / 0.5).powi(2))
        };
        let brows = |p: &Vec3| {
            let d = *p - Vec3::new(0.0, 0.45, self.eyes[0].z + 0.2);
            soft((d.x * d.x / 1.2 + d.y * d.y / 0.14 + d.z * d.z / 0.6).powi(2))
        };
        let of = |zone: &dyn Fn(&Vec3) -> f32| {
            self.kept.iter().flat_map(|&vertex| [zone(&self.positions[vertex]); 3]).collect()
        };
        [of(&eye), of(&mouth), of(&brows), of(&|p| eye(p).max(mouth(p)).max(brows(p)))]
    }
}

/// For each point the index of the one closest to its mirror image.
fn mirror(positions: &[Vec3]) -> Vec<usize> {
    // Sorted by height, so that only a few candidates have to be tested.
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|&a, &b| positions[a].y.total_cmp(&positions[b].y));
    let nearest = |point: &Vec3| {
        let mirrored = Vec3::new(-point.x, point.y, point.z);
        let split = order.partition_point(|&at| positions[at].y < mirrored.y);
        let (mut best, mut least) = (0, f32::INFINITY);
        let mut visit = |at: usize| {
            let square = positions[at].distance_squared(mirrored);
            if square < least {
                (best, least) = (at, square);
            }
            (positions[at].y - mirrored.y).powi(2) > least
        };
        // Until the difference in height alone exceeds the best distance.
        let _ = order[split..].iter().any(|&at| visit(at));
        let _ = order[..split].iter().rev().any(|&at| visit(at));
        best
    };
    positions.iter().map(nearest).collect()
}
