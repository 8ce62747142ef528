//! The texels of some triangles, with the surface points they show.

use glam::Vec3;
use uvgraft::raster::ScanTriangle;
use uvgraft::{Mesh, Size};

/// Calls `visit` once for each texel whose centre is inside one of the triangles, or
/// within `gutter` texels of one, with the surface point it shows. Texels of the gutter
/// get the point on the triangle's plane.
pub(super) fn each(
    mesh: &Mesh,
    faces: &[usize],
    size: Size,
    gutter: u32,
    mut visit: impl FnMut(u32, u32, Vec3),
) {
    let side = [size.width as f32, size.height as f32];
    let mut seen = std::collections::HashSet::new();
    // Inner texels come first, or the gutter of a neighbouring triangle would claim them.
    for grown in [0, gutter] {
        for &face in faces {
            let corners = mesh.uv_triangle(face).map(|[u, v]| [u * side[0], v * side[1]]);
            let [a, b, c] = corners;
            let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            if doubled == 0.0 {
                continue;
            }
            let points = mesh.faces()[face].map(|v| Vec3::from(mesh.positions()[v as usize]));
            let point = |x: u32, y: u32| {
                let [px, py] = [x as f32 + 0.5 - a[0], y as f32 + 0.5 - a[1]];
                let v = (px * (c[1] - a[1]) - py * (c[0] - a[0])) / doubled;
                let w = ((b[0] - a[0]) * py - (b[1] - a[1]) * px) / doubled;
                points[0] + (points[1] - points[0]) * v + (points[2] - points[0]) * w
            };
            let mut visit_once = |x: u32, y: u32| {
                if seen.insert((x, y)) {
                    visit(x, y, point(x, y));
                }
            };
            let Some(scan) = ScanTriangle::new(corners.map(|at| at.map(f64::from)), size) else {
                continue;
            };
            for (y, span) in scan.spans(&(0..size.height)) {
                if grown == 0 {
                    span.for_each(|x| visit_once(x, y));
                    continue;
                }
                let columns = span.start.saturating_sub(grown)..(span.end + grown).min(size.width);
                for row in y.saturating_sub(grown)..=(y + grown).min(size.height - 1) {
                    columns.clone().for_each(|x| visit_once(x, row));
                }
            }
        }
    }
}
