//! What a camera sees of a mesh: the nearest triangle at each pixel, and its distance.

use uvgraft::Size;
use uvgraft::raster::ScanTriangle;

/// No triangle.
pub const NOTHING: u32 = u32::MAX;

/// The nearest triangle at each pixel.
#[derive(Debug, Clone)]
pub struct DepthMap {
    size: Size,
    faces: Vec<u32>,
    /// Distance along the optical axis; infinite where there is nothing.
    depths: Vec<f32>,
}

impl DepthMap {
    /// Draws triangles, of which the nearest win.
    ///
    /// - `projected`: `[vertices]` of pixel x and y and a positive distance along the optical axis.
    ///   Triangles with a corner behind the camera are left out.
    pub fn new(size: Size, projected: &[[f64; 3]], faces: &[[u32; 3]]) -> Self {
        let mut map = Self {
            size,
            faces: vec![NOTHING; size.texels()],
            depths: vec![f32::INFINITY; size.texels()],
        };
        for (number, face) in (0..).zip(faces) {
            let corners = face.map(|vertex| projected[vertex as usize]);
            if corners.iter().all(|corner| corner[2] > 0.0 && corner[0].is_finite()) {
                map.draw(number, corners);
            }
        }
        map
    }

    fn draw(&mut self, number: u32, corners: [[f64; 3]; 3]) {
        let Some(scan) = ScanTriangle::new(corners.map(|[x, y, _]| [x, y]), self.size) else {
            return;
        };
        // The reciprocal of the distance is linear in the image.
        let Some(plane) = Plane::through(corners.map(|[x, y, z]| [x, y, 1.0 / z])) else { return };
        for row in scan.rows() {
            let start = row as usize * self.size.width as usize;
            for x in scan.span(row) {
                let near = plane.at(f64::from(x) + 0.5, f64::from(row) + 0.5);
                let depth = (1.0 / near) as f32;
                let at = start + x as usize;
                if near > 0.0 && depth < self.depths[at] {
                    (self.depths[at], self.faces[at]) = (depth, number);
                }
            }
        }
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The triangle at a pixel, [`NOTHING`] beside the mesh and outside the image.
    pub fn face(&self, x: i64, y: i64) -> u32 {
        self.index(x, y).map_or(NOTHING, |at| self.faces[at])
    }

    /// The distance at a pixel; infinite beside the mesh and outside the image.
    pub fn depth(&self, x: i64, y: i64) -> f32 {
        self.index(x, y).map_or(f32::INFINITY, |at| self.depths[at])
    }

    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        let is_inside = x < self.size.width && y < self.size.height;
        is_inside.then(|| y as usize * self.size.width as usize + x as usize)
    }
}

/// A value that is linear over the image.
#[derive(Debug, Clone, Copy)]
struct Plane([f64; 3]);

impl Plane {
    fn through([a, b, c]: [[f64; 3]; 3]) -> Option<Self> {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let x = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) / area;
        let y = ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) / area;
        let plane = [x, y, a[2] - x * a[0] - y * a[1]];
        plane.iter().all(|value| value.is_finite()).then_some(Self(plane))
    }

    fn at(self, x: f64, y: f64) -> f64 {
        self.0[0] * x + self.0[1] * y + self.0[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_triangle_wins_at_every_pixel() {
        // A tilted triangle that crosses a plane at distance 2, whichever is drawn first.
        let projected = [
            [0.0, 0.0, 1.0],
            [8.0, 0.0, 4.0],
            [0.0, 8.0, 1.0],
            [0.0, 0.0, 2.0],
            [8.0, 0.0, 2.0],
            [0.0, 8.0, 2.0],
        ];
        for faces in [[[0, 1, 2], [3, 4, 5]], [[3, 4, 5], [0, 1, 2]]] {
            let map = DepthMap::new(Size::square(8), &projected, &faces);
            let tilted = faces.iter().position(|face| face[0] == 0).unwrap() as u32;
            // 1 / z falls from 1 to 1/4 over 8 pixels, and is 1/2 after 5 1/3.
            for x in 0..7_i64 {
                assert_eq!(map.face(x, 0) == tilted, x < 5, "{x}");
            }
            assert!((map.depth(4, 0) - 1.0 / (1.0 - 4.5 * 0.75 / 8.0)).abs() < 1e-5);
            assert_eq!(
                (map.face(7, 7), map.face(-1, 0), map.face(0, 8)),
                (NOTHING, NOTHING, NOTHING)
            );
            assert_eq!(map.depth(7, 7), f32::INFINITY);
        }
    }

    #[test]
    fn triangles_behind_the_camera_are_not_drawn() {
        let projected = [[0.0, 0.0, 1.0], [8.0, 0.0, -1.0], [0.0, 8.0, 1.0]];
        let map = DepthMap::new(Size::square(8), &projected, &[[0, 1, 2]]);
        assert_eq!(map.face(0, 0), NOTHING);
    }
}
