//! Triangles on the screen: clipped, ready to be scanned, with barycentric weights for each sample.
//!
//! # Source
//! Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974; Olano and Greer, "Triangle Scan
//! Conversion using 2D Homogeneous Coordinates", 1997, for the barycentric weights.

use glam::Vec3;
use uvgraft::raster::ScanTriangle;
use uvgraft::{Size, threads};

use super::camera::{Camera, Homogeneous};
use super::geometry::{Face, Geometry};

/// A triangle on the screen, or a part of one that was clipped at the near plane.
#[derive(Debug)]
pub(crate) struct Projected {
    pub face: u32,
    pub scan: ScanTriangle,
    plane: Plane,
}

impl Projected {
    /// Depths at every `step`-th sample of a row, from `column` on.
    #[inline]
    pub fn depths(&self, column: u32, row: u32, step: u32) -> Ramp {
        self.plane.along(column, row, step)
    }
}

/// The parts of faces on the screen, in face order.
///
/// Faces are clipped at the near plane before the perspective divide: behind the camera `w` is
/// negative and points would be mirrored onto the screen. A clipped face has up to four corners and
/// is split into a fan.
///
/// - `homogeneous`: the camera's coordinates of all positions.
/// - `keep`: whether to draw a face.
pub(crate) fn project(
    camera: &Camera,
    geometry: &Geometry,
    homogeneous: &[Homogeneous],
    size: Size,
    keep: impl Fn(usize) -> bool + Sync,
) -> Vec<Projected> {
    /// Faces per task.
    const CHUNK: usize = 512;
    let Geometry { positions, faces, .. } = geometry;
    let near = camera.limits().0;
    let one = |index: usize, face: &Face, parts: &mut Vec<Projected>| {
        if !keep(index) {
            return;
        }
        let corners = face.vertices.map(|vertex| {
            let vertex = vertex as usize;
            Corner { at: homogeneous[vertex], p: positions[vertex] }
        });
        let (polygon, count) = clipped(corners, near);
        for k in 2..count {
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
    let mut all = Vec::with_capacity(chunks.iter().map(Vec::len).sum());
    chunks.into_iter().for_each(|mut parts| all.append(&mut parts));
    all
}

#[derive(Debug, Clone, Copy)]
struct Corner {
    at: Homogeneous,
    p: Vec3,
}

/// The part of a triangle in front of the near plane, and its number of corners: up to four.
fn clipped([a, b, c]: [Corner; 3], near: f64) -> ([Corner; 4], usize) {
    let (corners, mut polygon, mut count) = ([a, b, c], [a, b, c, a], 0);
    if corners.iter().all(|corner| corner.at[2] >= near) {
        return (polygon, 3);
    }
    let mut push = |corner| {
        polygon[count] = corner;
        count += 1;
    };
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let (da, db) = (a.at[2] - near, b.at[2] - near);
        if da >= 0.0 {
            push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            let t = da / (da - db);
            let mut at = [0, 1, 2].map(|k| a.at[k] + (b.at[k] - a.at[k]) * t);
            at[2] = near;
            push(Corner { at, p: a.p.lerp_monotonic(b.p, t as f32) });
        }
    }
    (polygon, count)
}

fn on_screen(camera: &Camera, corner: &Corner) -> [f64; 3] {
    let [x, y, w] = corner.at;
    [x / w, y / w, camera.depth_of(corner.p, w)]
}

/// Perspective-correct barycentric weights in a triangle, at and around a sample; they sum to 1.
///
/// Corner `a` has the weight `cross(b, c)`, divided by the sum of all three, where `a`, `b` and `c`
/// are homogeneous and relative to the sample. No perspective divide is needed, so this also holds
/// for faces that cross the camera plane. The products are affine in the sample's position.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights {
    here: [f64; 3],
    along_x: [f64; 3],
    along_y: [f64; 3],
}

impl Weights {
    pub fn new(corners: [Homogeneous; 3], [x, y]: [f64; 2]) -> Self {
        // Relative to the sample, so that no large values are subtracted from each other.
        let [a, b, c] = corners.map(|[cx, cy, w]| [cx - x * w, cy - y * w, w]);
        let pairs = [(b, c), (c, a), (a, b)];
        Self {
            here: pairs.map(|(p, q)| p[0] * q[1] - p[1] * q[0]),
            along_x: pairs.map(|(p, q)| p[1] * q[2] - p[2] * q[1]),
            along_y: pairs.map(|(p, q)| p[2] * q[0] - p[0] * q[2]),
        }
    }

    /// Weights at a distance from the sample; `None` where the triangle is seen edge-on.
    #[inline]
    pub fn at(&self, [dx, dy]: [f64; 2]) -> Option<[f32; 3]> {
        let part = |k: usize| self.here[k] + dx * self.along_x[k] + dy * self.along_y[k];
        let parts = [part(0), part(1), part(2)];
        let share = 1.0 / (parts[0] + parts[1] + parts[2]);
        let weights = parts.map(|part| (part * share) as f32);
        weights.iter().all(|weight| weight.is_finite()).then_some(weights)
    }
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

    #[inline]
    fn along(&self, column: u32, row: u32, step: u32) -> Ramp {
        let dx = f64::from(column) + 0.5 - self.origin[0];
        let dy = f64::from(row) + 0.5 - self.origin[1];
        Ramp {
            start: (self.origin[2] + dx * self.slope[0] + dy * self.slope[1]) as f32,
            slope: (self.slope[0] * f64::from(step)) as f32,
            range: self.range.map(|depth| depth as f32),
        }
    }
}

/// Depth along a row of samples. Only its start is computed in double precision: within one row of
/// one triangle, single precision suffices, and a processor does four or more samples at once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ramp {
    start: f32,
    slope: f32,
    range: [f32; 2],
}

impl Ramp {
    #[inline]
    pub fn at(&self, index: i32) -> f32 {
        let depth = self.start + self.slope * index as f32;
        let [low, high] = self.range;
        // Comparisons instead of `max` and `min`, whose handling of NaN costs as much again.
        let depth = if depth > low { depth } else { low };
        if depth < high { depth } else { high }
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::camera::Perspective;

    fn parts(
        camera: &Camera,
        positions: &[Vec3],
        faces: &[Face],
        size: Size,
        keep: impl Fn(usize) -> bool + Sync,
    ) -> Vec<Projected> {
        let (positions, faces) = (positions.to_vec(), faces.to_vec());
        let geometry = Geometry { positions, faces, ..Geometry::default() };
        project(camera, &geometry, &camera.all_homogeneous(&geometry.positions), size, keep)
    }

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
        let [a, b, c] = Weights::new(corners, [100.0; 2]).at([0.0; 2]).unwrap();
        assert!(
            (a - 0.75).abs() < 1e-6 && (b - 0.25).abs() < 1e-6 && c.abs() < 1e-6,
            "{a} {b} {c}"
        );
        assert_eq!(Weights::new([corners[0]; 3], [100.0; 2]).at([0.0; 2]), None);
        // The same from a neighbouring sample.
        let around = Weights::new(corners, [103.0, 98.5]).at([-3.0, 1.5]).unwrap();
        assert!((0..3).all(|k| (around[k] - [a, b, c][k]).abs() < 1e-6), "{around:?}");
    }

    #[test]
    fn depth_is_the_inverse_of_the_distance_everywhere_on_a_triangle() {
        let size = Size::square(200);
        let camera = camera(size);
        let positions = [vec3(-1.0, -1.0, -2.0), vec3(3.0, -1.0, -6.0), vec3(-1.0, 1.0, -2.0)];
        let faces = [Face { vertices: [0, 1, 2], uv: [0; 3], surface: 0 }];
        let projected = parts(&camera, &positions, &faces, size, |_| true);
        let corners = positions.map(|p| camera.homogeneous(p));
        let mut seen = 0;
        for part in &projected {
            for row in part.scan.rows() {
                for column in part.scan.span(row) {
                    let at = [column, row].map(|at| f64::from(at) + 0.5);
                    let w = Weights::new(corners, at).at([0.0; 2]).unwrap();
                    let z: f32 = (0..3).map(|k| w[k] * positions[k].z).sum();
                    let depth = part.depths(column, row, 1).at(0);
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
        let projected = parts(&camera, &positions, &faces, size, |_| true);
        // The four corners make two triangles, which cover everything below the far
        // edge at sample 102.
        assert_eq!(projected.len(), 2);
        let covers =
            |x: u32, y: u32| projected.iter().filter(|part| part.scan.span(y).contains(&x)).count();
        assert_eq!([90, 110, 150, 199].map(|y| covers(100, y)), [0, 1, 1, 1]);
        let behind = positions.map(|p| vec3(p.x, p.y, p.z + 60.0));
        assert!(parts(&camera, &behind, &faces, size, |_| true).is_empty());
        assert!(parts(&camera, &positions, &faces, size, |_| false).is_empty());
    }
}
