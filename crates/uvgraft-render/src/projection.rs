//! Triangles on the screen: clipped, ready to be scanned, with barycentric weights for each sample.
//!
//! # Source
//! Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974; Olano and Greer, "Triangle Scan
//! Conversion using 2D Homogeneous Coordinates", 1997, for the barycentric weights.

use glam::Vec3;
use uvgraft::raster::ScanTriangle;
use uvgraft::{Size, threads};

use super::camera::{Camera, Homogeneous};
use super::geometry::Face;

/// A triangle on the screen, or a part of one that was clipped at the near plane.
#[derive(Debug)]
pub(crate) struct Projected {
    pub face: u32,
    pub scan: ScanTriangle,
    plane: Plane,
}

impl Projected {
    pub fn depth(&self, x: u32, y: u32) -> f32 {
        self.plane.depth(x, y)
    }
}

/// The parts of faces on the screen, in face order.
///
/// Faces are clipped at the near plane before the perspective divide: behind the camera `w` is
/// negative and points would be mirrored onto the screen. A clipped face has up to four corners and
/// is split into a fan.
///
/// - `keep`: whether to draw a face.
pub(crate) fn project(
    camera: &Camera,
    positions: &[Vec3],
    faces: &[Face],
    size: Size,
    keep: impl Fn(usize) -> bool + Sync,
) -> Vec<Projected> {
    /// Faces per task.
    const CHUNK: usize = 512;
    let homogeneous =
        threads::map_indices(positions.len(), |vertex| camera.homogeneous(positions[vertex]));
    let near = camera.limits().0;
    let one = |index: usize, face: &Face, parts: &mut Vec<Projected>| {
        let corners = face.vertices.map(|vertex| {
            let vertex = vertex as usize;
            Corner { at: homogeneous[vertex], p: positions[vertex] }
        });
        let polygon = if keep(index) { clipped(corners, near) } else { Vec::new() };
        for k in 2..polygon.len() {
            let screen = [0, k - 1, k].map(|corner| on_screen(camera, &polygon[corner]));
            let flat = screen.map(|[x, y, _]| [x, y]);
            if !screen.iter().flatten().all(|value| value.is_finite()) {
                continue;
            }
            if let Some(scan) = ScanTriangle::new(flat, size) {
                parts.push(Projected { face: index as u32, scan, plane: Plane::new(screen) });
            }
        }
    };
    let chunks = threads::map_indices(faces.len().div_ceil(CHUNK), |chunk| {
        let mut parts = Vec::new();
        for (index, face) in faces.iter().enumerate().skip(chunk * CHUNK).take(CHUNK) {
            one(index, face, &mut parts);
        }
        parts
    });
    chunks.into_iter().flatten().collect()
}

#[derive(Debug, Clone, Copy)]
struct Corner {
    at: Homogeneous,
    p: Vec3,
}

/// The part of a triangle in front of the near plane, a polygon of up to four corners.
fn clipped(corners: [Corner; 3], near: f64) -> Vec<Corner> {
    if corners.iter().all(|corner| corner.at[2] >= near) {
        return corners.to_vec();
    }
    let mut polygon = Vec::with_capacity(4);
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let (da, db) = (a.at[2] - near, b.at[2] - near);
        if da >= 0.0 {
            polygon.push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            let t = da / (da - db);
            let mut at = [0, 1, 2].map(|k| a.at[k] + (b.at[k] - a.at[k]) * t);
            at[2] = near;
            polygon.push(Corner { at, p: a.p.lerp_monotonic(b.p, t as f32) });
        }
    }
    polygon
}

fn on_screen(camera: &Camera, corner: &Corner) -> [f64; 3] {
    let [x, y, w] = corner.at;
    [x / w, y / w, camera.depth_of(corner.p, w)]
}

/// Perspective-correct barycentric weights of the point that is visible at a sample; they sum to 1.
/// `None` where the triangle is seen edge-on.
///
/// Corner `a` has the weight `cross(b, c)`, divided by the sum of all three, where `a`, `b` and `c`
/// are homogeneous and relative to the sample. No perspective divide is needed, so this also holds
/// for faces that cross the camera plane.
pub(crate) fn weights(corners: [Homogeneous; 3], x: f64, y: f64) -> Option<[f32; 3]> {
    // Relative to the sample, so that no large values are subtracted from each other.
    let [a, b, c] = corners.map(|[cx, cy, w]| [cx - x * w, cy - y * w]);
    let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let parts = [cross(b, c), cross(c, a), cross(a, b)];
    let sum: f64 = parts.iter().sum();
    let weights = parts.map(|part| (part / sum) as f32);
    weights.iter().all(|weight| weight.is_finite()).then_some(weights)
}

/// Depth as an affine function of the sample, clamped to the range of the corners: the slope of a
/// sliver seen edge-on is noise.
#[derive(Debug)]
struct Plane {
    origin: [f64; 3],
    slope: [f64; 2],
    range: [f64; 2],
}

impl Plane {
    fn new([a, b, c]: [[f64; 3]; 3]) -> Self {
        let minus = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
        let (ab, ac) = (minus(b), minus(c));
        let area = ab[0] * ac[1] - ab[1] * ac[0];
        let slope =
            [(ab[2] * ac[1] - ac[2] * ab[1]) / area, (ac[2] * ab[0] - ab[2] * ac[0]) / area];
        let range = [a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2])];
        Self { origin: a, slope, range }
    }

    fn depth(&self, x: u32, y: u32) -> f32 {
        let (dx, dy) = (f64::from(x) + 0.5 - self.origin[0], f64::from(y) + 0.5 - self.origin[1]);
        let depth = self.origin[2] + dx * self.slope[0] + dy * self.slope[1];
        depth.max(self.range[0]).min(self.range[1]) as f32
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::camera::Perspective;

    /// A camera at the origin that looks along -Z; at distance 1, one unit is 100 samples.
    fn camera(size: Size) -> Camera {
        let fov_y = 2.0 * (0.5 * size.height as f32 / 100.0).atan().to_degrees();
        let (eye, target, up) = ([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
        let camera = Perspective { eye, target, up, fov_y, near: 0.5, far: 100.0 };
        Camera::perspective(&camera, size)
    }

    #[test]
    fn the_screen_midpoint_is_nearer_than_half() {
        let size = Size::square(200);
        let camera = camera(size);
        // From (-1, 0, -2) at sample 50 to (3, 0, -6) at sample 150: the point at the centre of the
        // screen, x = 0, is a quarter of the way along.
        let corners = [vec3(-1.0, 0.0, -2.0), vec3(3.0, 0.0, -6.0), vec3(-1.0, 1.0, -2.0)];
        let corners = corners.map(|p| camera.homogeneous(p));
        let [a, b, c] = weights(corners, 100.0, 100.0).unwrap();
        assert!(
            (a - 0.75).abs() < 1e-6 && (b - 0.25).abs() < 1e-6 && c.abs() < 1e-6,
            "{a} {b} {c}"
        );
        assert_eq!(weights([corners[0]; 3], 100.0, 100.0), None);
    }

    #[test]
    fn depth_is_the_inverse_of_the_distance_everywhere_on_a_triangle() {
        let size = Size::square(200);
        let camera = camera(size);
        let positions = [vec3(-1.0, -1.0, -2.0), vec3(3.0, -1.0, -6.0), vec3(-1.0, 1.0, -2.0)];
        let faces = [Face { vertices: [0, 1, 2], uv: [0; 3], surface: 0 }];
        let projected = project(&camera, &positions, &faces, size, |_| true);
        let corners = positions.map(|p| camera.homogeneous(p));
        let mut seen = 0;
        for part in &projected {
            for row in part.scan.rows() {
                for column in part.scan.span(row) {
                    let at = [column, row].map(|at| f64::from(at) + 0.5);
                    let w = weights(corners, at[0], at[1]).unwrap();
                    let z: f32 = (0..3).map(|k| w[k] * positions[k].z).sum();
                    let depth = part.depth(column, row);
                    assert!((depth * -z - 1.0).abs() < 1e-5, "{column} {row}: {depth} {z}");
                    seen += 1;
                }
            }
        }
        assert!(seen > 2000, "{seen}");
    }

    #[test]
    fn faces_are_clipped_at_the_near_plane() {
        let size = Size::square(200);
        let camera = camera(size);
        // A floor at y = -1 from far ahead to behind the camera.
        let positions = [vec3(-50.0, -1.0, -50.0), vec3(50.0, -1.0, -50.0), vec3(0.0, -1.0, 50.0)];
        let faces = [Face { vertices: [0, 1, 2], uv: [0; 3], surface: 0 }];
        let projected = project(&camera, &positions, &faces, size, |_| true);
        // The four corners make two triangles, which cover everything below the far
        // edge at sample 102.
        assert_eq!(projected.len(), 2);
        let covers =
            |x: u32, y: u32| projected.iter().filter(|part| part.scan.span(y).contains(&x)).count();
        assert_eq!([90, 110, 150, 199].map(|y| covers(100, y)), [0, 1, 1, 1]);
        let behind = positions.map(|p| vec3(p.x, p.y, p.z + 60.0));
        assert!(project(&camera, &behind, &faces, size, |_| true).is_empty());
        assert!(project(&camera, &positions, &faces, size, |_| false).is_empty());
    }
}
