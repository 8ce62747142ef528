//! Restricts a mesh to some of its parts.

use super::{Mesh, MeshError, MeshPart};

impl Mesh {
    /// Only the polygons of the parts that `keep` accepts, in the same order. Vertices and UV
    /// coordinates keep their indices, whether they are still used or not.
    ///
    /// # Errors
    /// [`MeshError::NoFaces`] if no polygon is left, as when the mesh has no parts.
    pub fn only_parts(&self, mut keep: impl FnMut(&MeshPart) -> bool) -> Result<Self, MeshError> {
        let (mut corners, mut sizes) = (Vec::new(), Vec::<u32>::new());
        let mut parts = Vec::new();
        for part in &self.parts {
            if !keep(part) {
                continue;
            }
            let start = sizes.len() as u32;
            // Parts are for information only, so their ranges may be wrong.
            let end = (part.polygons.end as usize).min(self.polygon_count());
            for polygon in part.polygons.start as usize..end {
                let of_polygon = self.polygon_corners(polygon);
                sizes.push(of_polygon.len() as u32);
                corners.extend(of_polygon);
            }
            let polygons = start..sizes.len() as u32;
            parts.push(MeshPart { polygons, ..part.clone() });
        }
        let (positions, uv) = (self.positions.clone(), self.uv.clone());
        Ok(Self::from_polygons(positions, uv, &corners, &sizes)?.with_parts(parts))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Corner;
    use super::*;

    #[test]
    fn vertices_and_polygons_survive() {
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        let corners =
            [0, 1, 2, 1, 2, 3, 0, 0, 2, 3].map(|index| Corner { vertex: index, uv: index });
        let part = |object: &str, polygons| MeshPart {
            object: object.to_owned(),
            polygons,
            ..MeshPart::default()
        };
        let mesh = Mesh::from_polygons(positions, uv, &corners, &[3, 4, 3]).unwrap();
        let mesh = mesh.with_parts(vec![part("a", 0..1), part("b", 1..2), part("a", 2..9)]);
        let b = mesh.only_parts(|part| part.object == "b").unwrap();
        assert_eq!((b.positions(), b.uv()), (mesh.positions(), mesh.uv()));
        assert_eq!(b.polygon_corners(0), corners[3..7]);
        assert_eq!(b.parts(), [part("b", 0..1)]);
        let a = mesh.only_parts(|part| part.object == "a").unwrap();
        assert_eq!(a.faces(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(a.parts(), [part("a", 0..1), part("a", 1..2)]);
        assert_eq!(mesh.only_parts(|_| false), Err(MeshError::NoFaces));
    }
}
