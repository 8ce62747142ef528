//! A depth map of the face, seen from the front.

use glam::DVec3;

use super::points::Points;

/// The side of a cell, in distances between the eyes: 1.3 mm where they are 63 mm apart.
const STEP: f64 = 0.02;
/// The lowest x and y of the grid, in the head's coordinates.
const LOW: [f64; 2] = [-1.5, -2.8];
const COLUMNS: usize = 150;
const ROWS: usize = 240;

/// The positions and normals of points in the head's coordinates.
pub(super) struct Local {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
}

/// A depth map over the plane of x and y: the foremost depth of each cell, and its component.
pub(super) struct Relief {
    depths: Vec<f32>,
    components: Vec<u32>,
}

impl Relief {
    /// Rasterises the triangles of the `wanted` components.
    pub fn new(points: &Points, at: &[DVec3], wanted: impl Fn(u32) -> bool) -> Self {
        let mut relief = Self {
            depths: vec![f32::NEG_INFINITY; COLUMNS * ROWS],
            components: vec![u32::MAX; COLUMNS * ROWS],
        };
        for triangle in &points.triangles {
            let corners = triangle.map(|point| at[point as usize]);
            let component = points.component[triangle[0] as usize];
            let is_far = corners.iter().all(|p| p.z < -1.4 || p.y < LOW[1] || p.y > 2.0);
            if !is_far && wanted(component) {
                relief.draw(corners, component);
            }
        }
        relief
    }

    fn draw(&mut self, corners: [DVec3; 3], component: u32) {
        // Cell centres are at integer coordinates.
        let [a, b, c] =
            corners.map(|p| [(p.x - LOW[0]) / STEP - 0.5, (p.y - LOW[1]) / STEP - 0.5, p.z]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area.abs() < 1e-9 {
            return;
        }
        let range = |k: usize, count: usize| {
            let low = a[k].min(b[k]).min(c[k]).ceil().max(0.0);
            let high = a[k].max(b[k]).max(c[k]).floor().min(count as f64 - 1.0);
            if low <= high { low as usize..high as usize + 1 } else { 0..0 }
        };
        for row in range(1, ROWS) {
            for column in range(0, COLUMNS) {
                let [x, y] = [column as f64, row as f64];
                let v = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
                let w = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
                if v < -1e-9 || w < -1e-9 || v + w > 1.0 + 1e-9 {
                    continue;
                }
                let depth = (a[2] + v * (b[2] - a[2]) + w * (c[2] - a[2])) as f32;
                let cell = row * COLUMNS + column;
                if depth > self.depths[cell] {
                    self.depths[cell] = depth;
                    self.components[cell] = component;
                }
            }
        }
    }

    fn cell(x: f64, y: f64) -> Option<usize> {
        let [column, row] = [(x - LOW[0]) / STEP, (y - LOW[1]) / STEP];
        let is_inside = column >= 0.0 && row >= 0.0;
        (is_inside && column < COLUMNS as f64 && row < ROWS as f64)
            .then(|| row as usize * COLUMNS + column as usize)
    }

    /// The foremost depth at a position; `None` where there is no surface.
    pub fn depth(&self, x: f64, y: f64) -> Option<f64> {
        let depth = f64::from(self.depths[Self::cell(x, y)?]);
        depth.is_finite().then_some(depth)
    }

    /// The mean depth of a position and its mirror image; that of one if only one has a surface.
    pub fn both(&self, x: f64, y: f64) -> Option<f64> {
        match (self.depth(x, y), self.depth(-x, y)) {
            (Some(a), Some(b)) => Some(0.5 * (a + b)),
            (a, b) => a.or(b),
        }
    }

    /// The least depth of the 3 × 3 cells around, so that points on a steep slope don't count
    /// as behind it; `None` where there is no surface.
    pub fn around(&self, x: f64, y: f64) -> Option<f64> {
        let around = (0..9).filter_map(|k| {
            let [dx, dy] = [f64::from(k % 3 - 1), f64::from(k / 3 - 1)];
            self.depth(x + dx * STEP, y + dy * STEP)
        });
        around.reduce(f64::min)
    }

    /// Heights and depths along a column, averaged over both sides, in ascending order of height.
    pub fn column(&self, x: f64, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        let count = ((high - low) / STEP) as usize;
        let heights = (0..=count).map(|k| low + k as f64 * STEP);
        heights.filter_map(|y| self.both(x, y).map(|depth| [y, depth])).collect()
    }

    /// The surface points of the cells within a radius of a centre.
    pub fn within(&self, center: [f64; 2], radius: f64) -> Vec<DVec3> {
        let steps = (radius / STEP) as i32;
        let mut found = Vec::new();
        for j in -steps..=steps {
            for i in -steps..=steps {
                let [dx, dy] = [f64::from(i) * STEP, f64::from(j) * STEP];
                if dx.hypot(dy) <= radius
                    && let Some(cell) = Self::cell(center[0] + dx, center[1] + dy)
                    && self.depths[cell].is_finite()
                {
                    let [column, row] = [cell % COLUMNS, cell / COLUMNS];
                    let x = LOW[0] + (column as f64 + 0.5) * STEP;
                    let y = LOW[1] + (row as f64 + 0.5) * STEP;
                    found.push(DVec3::new(x, y, f64::from(self.depths[cell])));
                }
            }
        }
        found
    }

    /// The component that covers most of the lower face.
    pub fn skin(&self, count: usize) -> Option<u32> {
        let mut cells = vec![0u32; count];
        for row in 0..ROWS {
            let y = LOW[1] + (row as f64 + 0.5) * STEP;
            for column in 0..COLUMNS {
                let x = LOW[0] + (column as f64 + 0.5) * STEP;
                let component = self.components[row * COLUMNS + column];
                if (-1.0..-0.1).contains(&y) && x.abs() < 0.5 && component != u32::MAX {
                    cells[component as usize] += 1;
                }
            }
        }
        let best = (0..count).max_by_key(|&component| cells[component])?;
        (cells[best] > 0).then_some(best as u32)
    }

    /// Whether a component is the only one visible.
    pub fn is_all(&self, component: u32) -> bool {
        self.components.iter().all(|&found| found == component || found == u32::MAX)
    }

    /// The fraction of the face's disc that has a surface.
    pub fn coverage(&self) -> f64 {
        let found = self.within([0.0, -0.45], 0.9).len() as f64;
        found * STEP * STEP / (std::f64::consts::PI * 0.81)
    }

    /// The mean difference in depth between both sides of the face.
    pub fn asymmetry(&self) -> f64 {
        let points = self.within([0.0, -0.4], 0.8);
        let differences: Vec<f64> = points
            .iter()
            .filter_map(|point| Some((self.depth(-point.x, point.y)? - point.z).abs().min(0.5)))
            .collect();
        if differences.is_empty() {
            return f64::INFINITY;
        }
        differences.iter().sum::<f64>() / differences.len() as f64
    }
}
