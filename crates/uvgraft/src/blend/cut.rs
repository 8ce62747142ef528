//! The target mesh, with triangles cut along a region's boundary.

use std::collections::HashMap;

use uvgraft_surface::mesh::{Mesh, MeshError};

use super::Blend;

/// A mesh and which of its triangles are in a region.
#[derive(Debug, Clone, PartialEq)]
pub struct CutMesh {
    /// The target mesh, with more triangles.
    pub mesh: Mesh,
    /// `[triangles]`: whether each is in the region.
    pub inside: Vec<bool>,
}

/// A corner of a triangle: its position, UV coordinate and signed distance from the boundary.
#[derive(Debug, Clone, Copy)]
struct Corner {
    point: u32,
    position: [f32; 3],
    uv: [f32; 2],
    inside: f32,
}

impl Blend {
    /// Cuts the target mesh so that the boundary follows edges, for code that compares both sides
    /// of it, such as `uvgraft_metrics::seams::measure`. Other triangles are unchanged, but their
    /// order is not.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] if there would be too many triangles.
    pub fn cut(&self) -> Result<CutMesh, MeshError> {
        let (mesh, surface) = (self.domain.mesh(), self.domain.surface());
        let mut builder = MeshBuilder::default();
        for (face, points) in surface.triangles().iter().enumerate() {
            let uv = mesh.uv_triangle(face);
            let corners = [0, 1, 2].map(|k| Corner {
                point: points[k],
                position: mesh.positions()[mesh.faces()[face][k] as usize],
                uv: uv[k],
                inside: self.inside[points[k] as usize],
            });
            let is_out = corners.map(|corner| corner.inside < 0.0);
            // The corner that is alone on its side, if the boundary passes through the triangle.
            let count = is_out.iter().filter(|&&is_out| is_out).count();
            let alone = is_out.iter().position(|&is_out| is_out == (count == 1));
            match alone.filter(|_| self.touched[face] && (1..3).contains(&count)) {
                None => builder.push(corners, self.touched[face] && count == 0),
                Some(first) => {
                    let [a, b, c] = [0, 1, 2].map(|k| corners[(first + k) % 3]);
                    let (ab, ac) = (crossing(a, b), crossing(a, c));
                    builder.push([a, ab, ac], a.inside >= 0.0);
                    builder.push([ab, b, c], a.inside < 0.0);
                    builder.push([ab, c, ac], a.inside < 0.0);
                }
            }
        }
        let MeshBuilder { positions, uv, faces, uv_faces, inside, .. } = builder;
        let mesh = Mesh::from_triangles(positions, uv, &faces, &uv_faces)?;
        Ok(CutMesh { mesh, inside })
    }
}

/// Where the boundary crosses an edge: bit-identical for both triangles at the edge.
fn crossing(a: Corner, b: Corner) -> Corner {
    let (a, b) = if a.point < b.point { (a, b) } else { (b, a) };
    let t = a.inside / (a.inside - b.inside);
    let mix = |a: f32, b: f32| a + (b - a) * t;
    Corner {
        point: u32::MAX,
        position: [0, 1, 2].map(|axis| mix(a.position[axis], b.position[axis])),
        uv: [0, 1].map(|axis| mix(a.uv[axis], b.uv[axis])),
        inside: 0.0,
    }
}

/// A mesh under construction.
#[derive(Default)]
struct MeshBuilder {
    positions: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    faces: Vec<[u32; 3]>,
    uv_faces: Vec<[u32; 3]>,
    inside: Vec<bool>,
    known_positions: HashMap<[u32; 3], u32>,
    known_uv: HashMap<[u32; 2], u32>,
}

impl MeshBuilder {
    fn push(&mut self, corners: [Corner; 3], inside: bool) {
        let Self { positions, uv, known_positions, known_uv, .. } = self;
        self.faces.push(corners.map(|corner| {
            *known_positions.entry(corner.position.map(f32::to_bits)).or_insert_with(|| {
                positions.push(corner.position);
                positions.len() as u32 - 1
            })
        }));
        self.uv_faces.push(corners.map(|corner| {
            *known_uv.entry(corner.uv.map(f32::to_bits)).or_insert_with(|| {
                uv.push(corner.uv);
                uv.len() as u32 - 1
            })
        }));
        self.inside.push(inside);
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};
    use uvgraft_surface::surface::Surface;

    use super::super::{BlendDomain, BlendOptions, Growth};

    #[test]
    fn the_boundary_becomes_edges() {
        // Four squares in a row, all but the last one linked, shrunk by half a square.
        let positions: Vec<[f32; 3]> =
            (0..10).map(|k| [(k / 2) as f32, (k % 2) as f32, 0.0]).collect();
        let uv = positions.iter().map(|&[x, y, _]| [x * 0.2, y * 0.2]).collect::<Vec<_>>();
        let faces: Vec<[u32; 3]> = (0..4)
            .flat_map(|k| [[2 * k, 2 * k + 1, 2 * k + 2], [2 * k + 1, 2 * k + 3, 2 * k + 2]])
            .collect();
        let whole = Mesh::from_triangles(positions.clone(), uv.clone(), &faces, &faces).unwrap();
        let part = Mesh::from_triangles(positions, uv, &faces[..6], &faces[..6]).unwrap();
        let pair = Pair::by_vertex_map(part, whole, &(0..10).collect::<Vec<_>>()).unwrap();
        let domain = BlendDomain::new(pair, Direction::Forward);
        let narrowed = domain.linked().grown(Growth::Length(-0.5));
        let blend = super::Blend::new(&narrowed, BlendOptions::default()).unwrap();
        let cut = blend.cut().unwrap();
        let surface = Surface::new(&cut.mesh);
        let area = |wanted: bool| {
            let faces = (0..).zip(&cut.inside).filter(|(_, inside)| **inside == wanted);
            faces.map(|(face, _)| surface.area(face)).sum::<f64>()
        };
        assert!((area(true) - 2.5).abs() < 1e-6 && (area(false) - 1.5).abs() < 1e-6);
        // Each triangle is on its side, and none has lost its orientation.
        for (face, &inside) in cut.mesh.faces().iter().zip(&cut.inside) {
            let [a, b, c] = face.map(|vertex| cut.mesh.positions()[vertex as usize]);
            assert_eq!((a[0] + b[0] + c[0]) / 3.0 < 2.5, inside);
            assert!((b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]));
        }
        let on_rim = cut.mesh.positions().iter().filter(|[x, ..]| (x - 2.5).abs() < 1e-6);
        // The boundary crosses three edges.
        assert_eq!(on_rim.count(), 3);
    }
}
