//! The other side of a face: for each texel, the texel of its mirror image on the mesh.

use glam::DVec3;
use uvgraft::surface_index::SurfaceIndex;

use crate::head::Head;
use crate::layout_texels::LayoutTexels;

/// Where the mirror image of each triangle's corners is in the layout.
#[derive(Debug, Clone)]
pub(crate) struct Mirror {
    /// `[triangles]`: UV of the corners' mirror images; `None` where the layout is cut between
    /// them or there is nothing on the other side.
    corners: Vec<Option<[[f32; 2]; 3]>>,
}

impl Mirror {
    /// Mirrors the surface of a head at its midline.
    pub fn new(head: &Head) -> Self {
        /// Farthest that a mirror image may be from the surface, in eye distances. 9 mm where they
        /// are 63 mm apart.
        const REACH: f64 = 0.15;
        /// The layout is cut where corners are farther apart than this, as a multiple of the
        /// triangle's own extent. Origin not recorded.
        const CUT: f32 = 6.0;
        let frame = head.anatomy.frame();
        let index = SurfaceIndex::new(&head.mesh);
        let faces = head.mesh.faces();
        let uv = head.mesh.uv();
        let component = |face: u32| head.components.of_vertex[faces[face as usize][0] as usize];
        let skin = head.components.skin;
        // The nearest place is asked for a point slightly inside each corner's triangle, so that
        // corners of one triangle choose triangles of one island.
        let mirrored = |face: usize| {
            let corners = faces[face]
                .map(|vertex| glam::Vec3::from(head.mesh.positions()[vertex as usize]).as_dvec3());
            if component(face as u32) != skin {
                return None;
            }
            let center = corners.iter().sum::<DVec3>() / 3.0;
            let mut found = [[0.0_f32; 2]; 3];
            for (corner, found) in corners.into_iter().zip(&mut found) {
                let inner = corner + (center - corner) * 0.02;
                let [x, y, z] = frame.local(inner.to_array());
                let at = frame.world([-x, y, z]);
                let is_skin = |face: u32, _: [f64; 3]| component(face) == skin;
                let (place, _) = index.nearest(at, REACH * frame.unit, is_skin)?;
                let uv_face = head.mesh.uv_faces()[place.face as usize];
                for axis in 0..2 {
                    found[axis] = (0..3)
                        .map(|k| place.weights[k] as f32 * uv[uv_face[k] as usize][axis])
                        .sum();
                }
            }
            let own = extent(head.mesh.uv_triangle(face));
            (extent(found) <= CUT * own.max(1e-4)).then_some(found)
        };
        let corners = uvgraft::threads::map_indices(faces.len(), mirrored);
        Self { corners }
    }

    /// The UV of a texel's mirror image.
    pub fn uv(&self, texels: &LayoutTexels, texel: usize) -> Option<[f32; 2]> {
        let place = texels.place(texel)?;
        let corners = self.corners[place.face as usize]?;
        Some(std::array::from_fn(|axis| {
            (0..3).map(|k| place.weights[k] as f32 * corners[k][axis]).sum()
        }))
    }
}

/// The longer side of a triangle's bounding box.
fn extent(corners: [[f32; 2]; 3]) -> f32 {
    (0..2)
        .map(|axis| {
            let values = corners.map(|corner| corner[axis]);
            let (least, most) = values
                .iter()
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
            most - least
        })
        .fold(0.0, f32::max)
}
