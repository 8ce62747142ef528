//! Ray-triangle intersection.

use glam::Vec3;

/// An intersection of a ray with a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter: the distance from the origin in units of the direction's length; above 0.
    pub distance: f32,
    /// Barycentric coordinates of the point; they sum to 1.
    pub weights: [f32; 3],
}

/// Intersects a ray with a triangle, from either side.
///
/// Based on Möller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997.
pub fn intersect(origin: Vec3, direction: Vec3, &[a, b, c]: &[Vec3; 3]) -> Option<TriangleHit> {
    let (p, q) = (b - a, c - a);
    let across = direction.cross(q);
    let determinant = p.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let from = origin - a;
    let u = from.dot(across) / determinant;
    let turned = from.cross(p);
    let v = direction.dot(turned) / determinant;
    let distance = q.dot(turned) / determinant;
    let is_met = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0;
    is_met.then_some(TriangleHit { distance, weights: [1.0 - u - v, u, v] })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [Vec3; 3] =
        [Vec3::new(0.0, 0.0, 2.0), Vec3::new(4.0, 0.0, 2.0), Vec3::new(0.0, 4.0, 2.0)];

    #[test]
    fn a_ray_meets_a_triangle_before_it() {
        let ahead = |x, y, z: f32| intersect(Vec3::new(x, y, 0.0), Vec3::Z * z, &TRIANGLE);
        let found = ahead(1.0, 2.0, 0.5).unwrap();
        assert_eq!((found.distance, found.weights), (4.0, [0.25, 0.25, 0.5]));
        // From behind as well.
        let turned = [TRIANGLE[0], TRIANGLE[2], TRIANGLE[1]];
        let found = intersect(Vec3::new(1.0, 2.0, 0.0), Vec3::Z, &turned).unwrap();
        assert_eq!((found.distance, found.weights), (2.0, [0.25, 0.5, 0.25]));
        assert_eq!(ahead(3.0, 2.0, 1.0), None);
        assert_eq!(ahead(1.0, 2.0, -1.0), None);
        assert_eq!(intersect(Vec3::ZERO, Vec3::X, &TRIANGLE), None);
    }
}
