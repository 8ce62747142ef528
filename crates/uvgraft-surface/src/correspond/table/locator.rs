//! Finds the triangle of a UV layout at a UV coordinate.

use crate::mesh::{Mesh, doubled_area};
use crate::piece::{Weights, wide};

/// Maximum number of cells along a side.
const MAX_SIDE: usize = 1024;

/// The triangles of a mesh's layout in a uniform grid of cells. Triangles without area are left out.
#[derive(Debug, Clone)]
pub struct UvLocator {
    /// `[faces]` corners in UV space.
    triangles: Vec<[[f64; 2]; 3]>,
    origin: [f64; 2],
    /// Cells per unit.
    scale: [f64; 2],
    side: usize,
    /// `side² + 1` offsets into `faces`.
    starts: Vec<u32>,
    /// The triangles whose bounding boxes meet each cell, cell by cell, ascending.
    faces: Vec<u32>,
}

/// The place in a layout that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// The face.
    pub face: u32,
    /// Barycentric weights of its corners, not negative; they add up to 1.
    pub weights: Weights,
    /// Distance to the face in UV space, 0 inside.
    pub distance: f64,
}

impl UvLocator {
    /// Indexes the layout of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let count = mesh.faces().len();
        let mut triangles: Vec<_> = (0..count).map(|face| wide(mesh.uv_triangle(face))).collect();
        let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
        for corner in triangles.as_flattened() {
            for axis in 0..2 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
            }
        }
        let mut side = ((count as f64).sqrt() as usize).clamp(1, MAX_SIDE);
        loop {
            let extent = |axis: usize| (high[axis] - low[axis]).max(f64::MIN_POSITIVE);
            let scale = [0, 1].map(|axis| side as f64 / extent(axis));
            let mut locator =
                Self { triangles, origin: low, scale, side, starts: Vec::new(), faces: Vec::new() };
            // Many large triangles would be in every cell: larger cells bound that.
            let entries: usize = (0..count).map(|face| locator.cells_of(face).count()).sum();
            if side == 1 || entries <= 16 * count + 1024 {
                locator.fill();
                return locator;
            }
            triangles = locator.triangles;
            side /= 2;
        }
    }

    /// The lowest face at a UV coordinate; outside all faces the nearest within `limit`, in UV units.
    pub fn locate(&self, uv: [f64; 2], limit: f64) -> Option<Located> {
        if !uv.iter().all(|value| value.is_finite()) {
            return None;
        }
        let around = |reach: f64| {
            let low = self.cell(uv.map(|value| value - reach));
            self.cells(low, self.cell(uv.map(|value| value + reach)))
        };
        for cell in around(0.0) {
            for &face in self.faces_in(cell) {
                if let Some(weights) = self.weights(face, uv).filter(is_inside) {
                    return Some(Located { face, weights: clamped(weights), distance: 0.0 });
                }
            }
        }
        let faces = around(limit.max(0.0)).flat_map(|cell| self.faces_in(cell));
        let found = faces.filter_map(|&face| self.nearest(face, uv));
        let nearer =
            |a: &Located, b: &Located| a.distance.total_cmp(&b.distance).then(a.face.cmp(&b.face));
        found.filter(|located| located.distance <= limit).min_by(nearer)
    }

    /// Barycentric weights of a UV coordinate with regard to a face, negative outside of it; `None` for
    /// a face without area.
    pub fn weights(&self, face: u32, uv: [f64; 2]) -> Option<Weights> {
        let [a, b, c] = self.triangles[face as usize];
        let area = doubled_area([a, b, c]);
        if area == 0.0 {
            return None;
        }
        let (v, w) = (doubled_area([a, uv, c]) / area, doubled_area([a, b, uv]) / area);
        let weights = [1.0 - v - w, v, w];
        weights.iter().all(|weight| weight.is_finite()).then_some(weights)
    }

    /// The UV coordinates of a face's corners.
    pub(super) fn corners(&self, face: u32) -> [[f64; 2]; 3] {
        self.triangles[face as usize]
    }

    /// The point of a face that is nearest to a UV coordinate outside of it.
    fn nearest(&self, face: u32, uv: [f64; 2]) -> Option<Located> {
        self.weights(face, uv)?;
        let corners = self.triangles[face as usize];
        let side = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let along = [b[0] - a[0], b[1] - a[1]];
            let from = [uv[0] - a[0], uv[1] - a[1]];
            let length = along[0] * along[0] + along[1] * along[1];
            let at = ((from[0] * along[0] + from[1] * along[1]) / length).clamp(0.0, 1.0);
            let at = if at.is_finite() { at } else { 0.0 };
            let mut weights = [0.0; 3];
            weights[k] = 1.0 - at;
            weights[(k + 1) % 3] = at;
            let distance = (from[0] - at * along[0]).hypot(from[1] - at * along[1]);
            Located { face, weights, distance }
        };
        (0..3).map(side).min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    fn fill(&mut self) {
        let mut starts = vec![0_u32; self.side * self.side + 1];
        let with_area = |face: &usize| doubled_area(self.triangles[*face]) != 0.0;
        for face in (0..self.triangles.len()).filter(with_area) {
            self.cells_of(face).for_each(|cell| starts[cell + 1] += 1);
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut faces = vec![0; starts[self.side * self.side] as usize];
        let mut next = starts.clone();
        for face in (0..self.triangles.len()).filter(with_area) {
            for cell in self.cells_of(face) {
                faces[next[cell] as usize] = face as u32;
                next[cell] += 1;
            }
        }
        (self.starts, self.faces) = (starts, faces);
    }

    fn faces_in(&self, cell: usize) -> &[u32] {
        &self.faces[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// The cell of a UV coordinate, or the nearest one.
    fn cell(&self, uv: [f64; 2]) -> [usize; 2] {
        [0, 1].map(|axis| {
            // Casts saturate, and NaN becomes 0.
            let at = ((uv[axis] - self.origin[axis]) * self.scale[axis]) as usize;
            at.min(self.side - 1)
        })
    }

    fn cells_of(&self, face: usize) -> impl Iterator<Item = usize> + use<> {
        let [a, b, c] = self.triangles[face];
        let of =
            |pick: fn(f64, f64) -> f64| [0, 1].map(|axis| pick(pick(a[axis], b[axis]), c[axis]));
        self.cells(self.cell(of(f64::min)), self.cell(of(f64::max)))
    }

    fn cells(&self, low: [usize; 2], high: [usize; 2]) -> impl Iterator<Item = usize> + use<> {
        let side = self.side;
        (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| y * side + x))
    }
}

fn is_inside(weights: &Weights) -> bool {
    // Within rounding, so that a point on an edge is inside of one of its triangles.
    weights.iter().all(|&weight| weight >= -1e-9)
}

/// Weights without negative ones.
pub(super) fn clamped(weights: Weights) -> Weights {
    let weights = weights.map(|weight| weight.max(0.0));
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(uv: Vec<[f32; 2]>, faces: &[[u32; 3]]) -> Mesh {
        Mesh::from_triangles(vec![[0.0; 3]; uv.len()], uv, faces, faces).unwrap()
    }

    #[test]
    fn agrees_with_a_search_of_all_triangles() {
        let mut random = fastrand::Rng::with_seed(3);
        let uv: Vec<[f32; 2]> = (0..600).map(|_| [random.f32(), random.f32() * 0.3]).collect();
        let faces: Vec<[u32; 3]> = (0..200)
            .map(|face| {
                let near = |k: u32| (face * 3 + k) % 600;
                [near(0), near(1), near(2)]
            })
            .collect();
        let locator = UvLocator::new(&mesh(uv, &faces));
        for _ in 0..2000 {
            let uv = [random.f64() * 1.4 - 0.2, random.f64() * 0.6 - 0.15];
            let inside =
                (0..200).find(|&face| locator.weights(face, uv).is_some_and(|w| is_inside(&w)));
            let all = (0..200).filter_map(|face| locator.nearest(face, uv));
            let nearest = all.min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap();
            match (locator.locate(uv, 0.1), inside) {
                (Some(found), Some(face)) => assert_eq!((found.face, found.distance), (face, 0.0)),
                (Some(found), None) => assert_eq!(found.distance, nearest.distance),
                (None, inside) => assert!(inside.is_none() && nearest.distance > 0.1),
            }
        }
    }

    #[test]
    fn what_has_no_area_is_never_found() {
        let flat = mesh(vec![[0.5, 0.5], [0.5, 0.5], [0.7, 0.7]], &[[0, 1, 2], [0, 0, 0]]);
        assert_eq!(UvLocator::new(&flat).locate([0.5, 0.5], 1.0), None);
        let far = mesh(vec![[-3e38, 0.0], [3e38, 0.0], [0.0, 3e38]], &[[0, 1, 2]]);
        let far = UvLocator::new(&far);
        for uv in [[f64::NAN, 0.0], [f64::INFINITY, 0.0], [1e308, -1e308], [0.0, 1.0]] {
            let _ = far.locate(uv, f64::INFINITY);
        }
    }

    #[test]
    fn large_triangles_do_not_fill_every_cell() {
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let locator = UvLocator::new(&mesh(uv, &[[0, 1, 2]; 20_000]));
        assert!(locator.faces.len() <= 16 * 20_000 + 1024, "{}", locator.faces.len());
        assert_eq!(locator.locate([0.2, 0.2], 0.0).unwrap().face, 0);
    }
}
