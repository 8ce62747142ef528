//! Which triangle is seen at each sample of a picture.

use uvgraft::Size;
use uvgraft::raster::ScanTriangle;

/// No triangle.
pub const NOTHING: u32 = u32::MAX;

/// The nearest triangle at each sample.
#[derive(Debug, Clone)]
pub struct Visible {
    pub size: Size,
    pub faces: Vec<u32>,
    pub depths: Vec<f32>,
}

impl Visible {
    pub fn new(size: Size) -> Self {
        let count = size.texels();
        Self { size, faces: vec![NOTHING; count], depths: vec![f32::INFINITY; count] }
    }

    /// Draws a triangle with corners `[x, y, distance]` in samples.
    pub fn draw(&mut self, face: u32, corners: [[f64; 3]; 3]) {
        if corners.iter().any(|corner| corner[2] <= 0.0) {
            return;
        }
        let Some(scan) = ScanTriangle::new(corners.map(|[x, y, _]| [x, y]), self.size) else {
            return;
        };
        for (row, span) in scan.rows().map(|row| (row, scan.span(row))) {
            for column in span {
                let at = (row * self.size.width + column) as usize;
                let weights = weights(corners, f64::from(column) + 0.5, f64::from(row) + 0.5);
                let depth = (0..3).map(|k| weights[k] * corners[k][2]).sum::<f64>() as f32;
                if depth < self.depths[at] {
                    (self.faces[at], self.depths[at]) = (face, depth);
                }
            }
        }
    }
}

/// Perspective weights of a triangle's corners at a sample.
pub fn weights([a, b, c]: [[f64; 3]; 3], x: f64, y: f64) -> [f64; 3] {
    let edge = |p: [f64; 3], q: [f64; 3]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    let weights = [edge(b, c) / a[2], edge(c, a) / b[2], edge(a, b) / c[2]];
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}
