//! Tangent frames for normal maps: the directions along U and against V at each vertex.
//!
//! They are computed for each pose from positions and texture coordinates: angle-weighted means
//! over the triangles around a vertex, made orthogonal to the normal at each pixel. This is what
//! MikkTSpace does, except for the way it groups triangles.
//!
//! # Source
//! Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section 4.

use glam::Vec3;

use super::geometry::Geometry;
use super::surface::Surface;

/// Direction along U, not normalised, and the handedness: 1 or -1, the side on which V goes up.
pub(crate) type Tangent = (Vec3, f32);

/// A tangent for each vertex; empty if no surface has a normal map.
pub(crate) fn tangents(geometry: &Geometry, surfaces: &[Surface]) -> Vec<Tangent> {
    if surfaces.iter().all(|surface| surface.material.normal.is_none()) {
        return Vec::new();
    }
    let mut sums = vec![[Vec3::default(); 2]; geometry.positions.len()];
    for (face, corners) in geometry.faces.iter().enumerate() {
        let Some(normal) = surfaces[corners.surface as usize].material.normal else { continue };
        let uv = geometry.corner_uv(face, normal.texture.coordinates);
        let points = geometry.corners(face);
        let Some(along) = directions(points, uv) else { continue };
        for k in 0..3 {
            let (a, b) = (points[(k + 1) % 3] - points[k], points[(k + 2) % 3] - points[k]);
            let angle = a.cross(b).length().atan2(a.dot(b));
            let sum = &mut sums[corners.vertices[k] as usize];
            *sum = [0, 1].map(|at| sum[at] + along[at] * angle);
        }
    }
    sums.into_iter()
        .zip(&geometry.normals)
        .map(|([u, v], normal)| (u, if normal.cross(u).dot(v) < 0.0 { -1.0 } else { 1.0 }))
        .collect()
}

/// Unit vectors along U and against V in a triangle; `None` if its UV triangle has no area.
fn directions([a, b, c]: [Vec3; 3], uv: [[f32; 2]; 3]) -> Option<[Vec3; 2]> {
    let (ab, ac) = (b - a, c - a);
    let step = |k: usize, axis: usize| uv[k][axis] - uv[0][axis];
    let ([bu, bv], [cu, cv]) = ([step(1, 0), step(1, 1)], [step(2, 0), step(2, 1)]);
    let area = bu * cv - cu * bv;
    if area == 0.0 || !area.is_finite() {
        return None;
    }
    let along_u = (ab * cv - ac * bv) * area.signum();
    let along_v = (ac * bu - ab * cu) * area.signum();
    Some([along_u.normalize_or_zero(), -along_v.normalize_or_zero()])
}

/// A normal-map value transformed from tangent space to world space.
///
/// - `normal`: unit normal of the surface.
pub(crate) fn bumped(bump: Vec3, normal: Vec3, (along, side): Tangent) -> Vec3 {
    let along = (along - normal * normal.dot(along)).normalize_or_zero();
    let up = normal.cross(along) * side;
    let bumped = along * bump.x + up * bump.y + normal * bump.z;
    // A map value of zero leaves the normal unchanged.
    if bumped.dot(bumped) > 0.0 { bumped.normalize_or_zero() } else { normal }
}
