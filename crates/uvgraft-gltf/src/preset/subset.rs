//! An avatar with a subset of its triangles, or with new triangles between its vertices.

use uvgraft::{Mesh, MeshError};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::Morph;

/// Triangles of an avatar's vertices and UV coordinates.
pub(super) struct Triangles<'a> {
    pub faces: &'a [[u32; 3]],
    pub uv_faces: &'a [[u32; 3]],
    /// See [`Avatar::materials`].
    pub materials: Vec<u8>,
}

/// Replaces an avatar's triangles, and removes unused vertices and UV coordinates. The others keep
/// their order, position, weights and offsets. Names of mesh parts are lost.
///
/// # Errors
/// [`MeshError::NoFaces`] if there are no triangles.
pub(super) fn with_faces(avatar: Avatar, triangles: Triangles<'_>) -> Result<Avatar, MeshError> {
    let Triangles { faces, uv_faces, materials } = triangles;
    let mesh = &avatar.mesh;
    let (vertices, vertex_numbers) = used(faces, mesh.positions().len());
    let (coordinates, uv_numbers) = used(uv_faces, mesh.uv().len());
    let renumbered = |faces: &[[u32; 3]], numbers: &[u32]| -> Vec<[u32; 3]> {
        faces.iter().map(|face| face.map(|index| numbers[index as usize])).collect()
    };
    let positions = vertices.iter().map(|&vertex| mesh.positions()[vertex as usize]).collect();
    let uv = coordinates.iter().map(|&index| mesh.uv()[index as usize]).collect();
    let (faces, uv_faces) = (renumbered(faces, &vertex_numbers), renumbered(uv_faces, &uv_numbers));
    let mesh = Mesh::from_triangles(positions, uv, &faces, &uv_faces)?;
    let skin = avatar.skin.of_vertices(&vertices);
    let kept = |morph: Morph| {
        let offsets = morph.offsets.into_iter();
        let renumbered = offsets.map(|(vertex, offset)| (vertex_numbers[vertex as usize], offset));
        Morph { offsets: renumbered.filter(|&(vertex, _)| vertex != GONE).collect(), ..morph }
    };
    let morphs = avatar.morphs.into_iter().map(kept).collect();
    Ok(Avatar { mesh, materials, skin, morphs, ..avatar })
}

/// Per-vertex values without those of unused vertices.
#[cfg(feature = "simplify")]
pub(super) fn kept<T: Copy>(faces: &[[u32; 3]], values: &[T]) -> Vec<T> {
    used(faces, values.len()).0.into_iter().map(|vertex| values[vertex as usize]).collect()
}

const GONE: u32 = u32::MAX;

/// The used indices, in ascending order, and the new index of each old one.
fn used(faces: &[[u32; 3]], count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut numbers = vec![GONE; count];
    for &index in faces.as_flattened() {
        numbers[index as usize] = 0;
    }
    let mut kept = Vec::new();
    for (index, number) in (0..).zip(&mut numbers) {
        if *number != GONE {
            *number = kept.len() as u32;
            kept.push(index);
        }
    }
    (kept, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glb::testing::tube;

    #[test]
    fn kept_vertices_are_unchanged() {
        let avatar = tube();
        let (faces, uv_faces) = (avatar.mesh.faces(), avatar.mesh.uv_faces());
        // Everything except the first ring of squares: the lowest 8 vertices and 9 coordinates go.
        let triangles = |from: usize| Triangles {
            faces: &faces[from..],
            uv_faces: &uv_faces[from..],
            materials: Vec::new(),
        };
        let upper = with_faces(avatar.clone(), triangles(16)).unwrap();
        upper.check().unwrap();
        assert_eq!(upper.mesh.positions(), &avatar.mesh.positions()[8..]);
        assert_eq!(upper.mesh.uv(), &avatar.mesh.uv()[9..]);
        assert_eq!(upper.skin.of(3), avatar.skin.of(11));
        assert_eq!(upper.morphs[0].offsets, [(12, [0.0, 0.02, 0.01])]);
        assert_eq!(
            with_faces(avatar.clone(), triangles(faces.len())).unwrap_err(),
            MeshError::NoFaces
        );
    }
}
