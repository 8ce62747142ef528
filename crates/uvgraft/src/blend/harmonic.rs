//! Harmonic extension: values given at some points of a surface, extended over the others as
//! smoothly as possible.
//!
//! At every free point the extension is the weighted mean of its neighbours,
//! `Σⱼ wᵢⱼ (uᵢ - uⱼ) = 0`, where `wᵢⱼ` is half the sum of the cotangents of the angles opposite to
//! the edge (U. Pinkall and K. Polthier, "Computing discrete minimal surfaces and their
//! conjugates", 1993). Weights are kept positive, so that no value leaves the range of the given
//! ones.

use glam::DVec3;
use uvgraft_surface::sparse::Solver;
use uvgraft_surface::surface::Surface;

/// The least and the greatest weight of an edge. Unclamped, it is negative where the two angles
/// opposite to the edge add up to more than half a turn, and unbounded where they are sharp.
const WEIGHTS: [f64; 2] = [1e-3, 1e3];

/// Stands for the index of a point that has no value or row.
const NONE: u32 = u32::MAX;

/// The prepared equations for one set of fixed points.
#[derive(Debug, Clone)]
pub(super) struct Harmonic {
    /// The row of each free point in the equations; [`NONE`] for others.
    row_of_point: Vec<u32>,
    /// Row of a free point, index of the fixed value next to it, and the edge's weight.
    given: Vec<(u32, u32, f64)>,
    equations: Solver,
}

impl Harmonic {
    /// Prepares the extension over the points of the triangles marked in `faces`, from the `fixed`
    /// points. Points that no path of edges joins to a fixed one get no value.
    pub fn new(surface: &Surface, faces: &[bool], fixed: &[u32]) -> Self {
        let points = surface.positions().len();
        let mut given_of_point = vec![NONE; points];
        for (&point, index) in fixed.iter().zip(0..) {
            given_of_point[point as usize] = index;
        }
        // Rows that no given value reaches would make the matrix singular.
        let row_of_point = reachable(surface, faces, fixed, &given_of_point);
        let free = row_of_point.iter().filter(|&&row| row != NONE).count();
        let mut diagonal = vec![0.0; free];
        let mut between = Vec::new();
        let mut given = Vec::new();
        for (a, b, weight) in edges(surface, faces) {
            for (from, to) in [(a, b), (b, a)] {
                let row = row_of_point[from as usize];
                if row == NONE {
                    continue;
                }
                diagonal[row as usize] += weight;
                let value = given_of_point[to as usize];
                if value == NONE {
                    between.push((row, row_of_point[to as usize], -weight));
                } else {
                    given.push((row, value, weight));
                }
            }
        }
        let diagonal = (0..).zip(diagonal).map(|(row, value)| (row, row, value));
        let entries: Vec<(u32, u32, f64)> = diagonal.chain(between).collect();
        // Weights are positive and every row is connected to a given value, so the matrix is
        // positive definite.
        let equations = Solver::new(free, &entries);
        Self { row_of_point, given, equations }
    }

    /// The value at every point of the surface; `None` if it is fixed, or if no path leads to a
    /// fixed point.
    ///
    /// - `values`: of the fixed points, in the order in which they were given.
    pub fn extend<const N: usize>(&self, values: &[[f64; N]]) -> Vec<Option<[f64; N]>> {
        let rows = self.row_of_point.iter().filter(|&&row| row != NONE).count();
        let mut right = vec![[0.0; N]; rows];
        for &(row, value, weight) in &self.given {
            for (right, value) in right[row as usize].iter_mut().zip(&values[value as usize]) {
                *right += weight * value;
            }
        }
        let mut solution = self.equations.solve(&right);
        if let Some(solution) = solution.as_mut().filter(|_| !self.equations.is_direct()) {
            // A mean of neighbours leaves the range of the given values nowhere; steps towards it may.
            let (least, most) = ranges(values);
            for value in solution {
                *value = std::array::from_fn(|k| value[k].max(least[k]).min(most[k]));
            }
        }
        let of_row =
            |&row: &u32| solution.as_ref().filter(|_| row != NONE).map(|all| all[row as usize]);
        self.row_of_point.iter().map(of_row).collect()
    }
}

/// The least and the greatest of each value.
fn ranges<const N: usize>(values: &[[f64; N]]) -> ([f64; N], [f64; N]) {
    let start = ([f64::INFINITY; N], [f64::NEG_INFINITY; N]);
    values.iter().fold(start, |(least, most), value| {
        let least = std::array::from_fn(|k| least[k].min(value[k]));
        (least, std::array::from_fn(|k| most[k].max(value[k])))
    })
}

/// Assigns rows to the free points that are connected to a fixed one.
fn reachable(surface: &Surface, faces: &[bool], fixed: &[u32], given: &[u32]) -> Vec<u32> {
    let mut row_of_point = vec![NONE; given.len()];
    let mut rows = 0;
    let mut next: Vec<u32> = fixed.to_vec();
    while let Some(point) = next.pop() {
        for &triangle in surface.around(point) {
            if !faces[triangle as usize] {
                continue;
            }
            for &other in &surface.triangles()[triangle as usize] {
                if given[other as usize] == NONE && row_of_point[other as usize] == NONE {
                    row_of_point[other as usize] = rows;
                    rows += 1;
                    next.push(other);
                }
            }
        }
    }
    row_of_point
}

/// The edges of the triangles marked in `faces`, with their weights: half the sum of the cotangents
/// of the angles opposite to each, within [`WEIGHTS`].
fn edges(surface: &Surface, faces: &[bool]) -> Vec<(u32, u32, f64)> {
    let mut edges = Vec::with_capacity(faces.len() * 3);
    for (triangle, _) in (0u32..).zip(faces).filter(|(_, is_in)| **is_in) {
        let points = surface.triangles()[triangle as usize];
        let corners = surface.corners(triangle);
        for k in 0..3 {
            let (a, b) = (points[k], points[(k + 1) % 3]);
            if a != b {
                edges.push((a.min(b), a.max(b), 0.5 * cotangent(corners, (k + 2) % 3)));
            }
        }
    }
    edges.sort_unstable_by_key(|&(a, b, _)| (a, b));
    let merged = edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)).map(|same| {
        // Summed in an order that does not depend on the unstable sort.
        let mut weights: Vec<f64> = same.iter().map(|&(.., weight)| weight).collect();
        weights.sort_unstable_by(f64::total_cmp);
        (same[0].0, same[0].1, weights.iter().sum::<f64>().clamp(WEIGHTS[0], WEIGHTS[1]))
    });
    merged.collect()
}

/// The cotangent of the angle at a corner of a triangle; the greatest weight if it is degenerate,
/// so that points that coincide or lie on a line hold together.
fn cotangent(corners: [DVec3; 3], corner: usize) -> f64 {
    let [a, b] = [1, 2].map(|k| corners[(corner + k) % 3] - corners[corner]);
    let doubled_area = a.cross(b).length();
    let most = WEIGHTS[1];
    if doubled_area > 0.0 { (a.dot(b) / doubled_area).clamp(-most, most) } else { most }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;

    use super::*;

    /// A sheet of squares with jittered corners.
    fn sheet(side: u32) -> Surface {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut positions = Vec::new();
        for y in 0..=side {
            for x in 0..=side {
                let at = [x, y].map(|k| {
                    let inner = if k == 0 || k == side { 0.0 } else { 0.4 };
                    f64::from(k) + (rng.f64() - 0.5) * inner
                });
                positions.push([at[0] as f32, at[1] as f32, 0.0]);
            }
        }
        let mut faces = Vec::new();
        for y in 0..side {
            for x in 0..side {
                let [a, b, c, d] =
                    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (y + dy) * (side + 1) + x + dx);
                faces.extend([[a, b, d], [a, d, c]]);
            }
        }
        let uv = vec![[0.0; 2]; positions.len()];
        Surface::new(&Mesh::from_triangles(positions, uv, &faces, &faces).unwrap())
    }

    #[test]
    fn linear_values_stay_linear_and_others_within_bounds() {
        let side = 12;
        let surface = sheet(side);
        let is_rim = |point: u32| {
            let (x, y) = (point % (side + 1), point / (side + 1));
            x == 0 || y == 0 || x == side || y == side
        };
        let all = vec![true; surface.triangles().len()];
        let fixed: Vec<u32> =
            (0..surface.positions().len() as u32).filter(|&p| is_rim(p)).collect();
        let harmonic = Harmonic::new(&surface, &all, &fixed);
        let mut rng = fastrand::Rng::with_seed(4);
        let values: Vec<[f64; 2]> = fixed
            .iter()
            .map(|&point| {
                let DVec3 { x, y, .. } = surface.positions()[point as usize];
                [2.0 * x - 3.0 * y + 1.0, rng.f64()]
            })
            .collect();
        let found = harmonic.extend(&values);
        for (point, found) in (0u32..).zip(found) {
            assert_eq!(found.is_none(), is_rim(point));
            let Some(found) = found else { continue };
            let DVec3 { x, y, .. } = surface.positions()[point as usize];
            // Exact except at edges whose weight had to be made positive; values range from -35 to 25.
            assert!((found[0] - (2.0 * x - 3.0 * y + 1.0)).abs() < 0.3, "{found:?} at {x}, {y}");
            assert!((0.0..=1.0).contains(&found[1]));
        }
    }

    #[test]
    fn constants_stay_constant_and_detached_points_get_none() {
        let surface = sheet(6);
        let mut faces = vec![true; surface.triangles().len()];
        // The last row of squares is cut off.
        faces[5 * 12..].fill(false);
        let found = Harmonic::new(&surface, &faces, &[0]).extend(&[[0.25]]);
        for (point, found) in found.iter().enumerate().skip(1) {
            if point < 6 * 7 {
                assert!((found.unwrap()[0] - 0.25).abs() < 1e-9);
            } else {
                assert_eq!(*found, None);
            }
        }
        assert!(Harmonic::new(&surface, &faces, &[]).extend::<1>(&[]).iter().all(Option::is_none));
    }
}
