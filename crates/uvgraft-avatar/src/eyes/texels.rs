//! The texels of some triangles and the places on the surface that they show.

use glam::Vec3;
use uvgraft::raster::ScanTriangle;
use uvgraft::{Mesh, Size};

/// Calls `visit` with each texel whose centre is on one of the triangles, or within `gutter` texels of one, and the
/// place that it shows. Beside triangles that is the place on their plane.
pub(super) fn each(
    mesh: &Mesh,
    faces: &[usize],
    size: Size,
    gutter: u32,
    mut visit: impl FnMut(u32, u32, Vec3),
) {
    let side = [size.width as f32, size.height as f32];
    let mut seen = std::collections::HashSet::new();
    // What is inside comes first, or a neighbour's gutter would have it.
    for grown in [0, gutter] {
        for &face in faces {
            let corners = mesh.uv_triangle(face).map(|[u, v]| [u * side[0], v * side[1]]);
            let [a, b, c] = corners;
            let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            if doubled == 0.0 {
                continue;
            }
            let places = mesh.faces()[face].map(|v| Vec3::from(mesh.positions()[v as usize]));
            let place = |x: u32, y: u32| {
                let [px, py] = [x as f32 + 0.5 - a[0], y as f32 + 0.5 - a[1]];
                let v = (px * (c[1] - a[1]) - py * (c[0] - a[0])) / doubled;
                let w = ((b[0] - a[0]) * py - (b[1] - a[1]) * px) / doubled;
                places[0] + (places[1] - places[0]) * v + (places[2] - places[0]) * w
            };
            let mut take = |x: u32, y: u32| {
                if seen.insert((x, y)) {
                    visit(x, y, place(x, y));
                }
            };
            let Some(scan) = ScanTriangle::new(corners.map(|at| at.map(f64::from)), size) else {
                continue;
            };
            for (y, span) in scan.spans(&(0..size.height)) {
                if grown == 0 {
                    span.for_each(|x| take(x, y));
                    continue;
                }
                let columns = span.start.saturating_sub(grown)..(span.end + grown).min(size.width);
                for row in y.saturating_sub(grown)..=(y + grown).min(size.height - 1) {
                    columns.clone().for_each(|x| take(x, row));
                }
            }
        }
    }
}
