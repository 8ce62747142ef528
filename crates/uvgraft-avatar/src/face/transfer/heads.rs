//! Pairs of heads for transfers of movement: their surfaces alone, without bodies and layouts.

use glam::DVec3;
use uvgraft::correspond::{FindError, FindOptions, MethodFailure, find};
use uvgraft::{Anatomy, Mesh, Pair, Piece};

/// How far a head extends from the point between its eyes, in distances between them: down to the
/// base of the neck.
const REACH: f64 = 3.5;

/// Links two meshes by their heads, whatever their bodies, layouts, units and orientations are.
///
/// Methods are those of [`find()`], tried in the same order. The pair's meshes have the vertices and
/// triangles of the given ones, in the same order, and a layout in which all corners coincide: it
/// transfers movements, not textures. A mesh without a recognisable head is used as a whole.
///
/// # Errors
/// [`FindError`] if no method links the heads.
pub fn pair_heads(source: &Mesh, target: &Mesh) -> Result<Pair, FindError> {
    let [(from, source_faces), (to, target_faces)] = [head(source), head(target)];
    let found = find(from, to, &FindOptions::default())?.pair;
    let whole = |piece: Piece| Piece {
        source: source_faces[piece.source as usize],
        target: target_faces[piece.target as usize],
        ..piece
    };
    let [source, target] = [source, target].map(|mesh| without_layout(mesh, mesh.faces()));
    Pair::from_pieces(source, target, found.pieces().map(whole))
        .map_err(|_| FindError(vec![MethodFailure::Outside]))
}

/// The head alone, with all vertices, and which faces of the mesh it has.
fn head(mesh: &Mesh) -> (Mesh, Vec<u32>) {
    let all = || (0..mesh.faces().len() as u32).collect::<Vec<u32>>();
    let faces = Anatomy::find(mesh).map_or_else(
        |_| all(),
        |anatomy| {
            let frame = anatomy.frame();
            let near: Vec<bool> = mesh
                .positions()
                .iter()
                .map(|place| DVec3::from(frame.local(place.map(f64::from))).length() < REACH)
                .collect();
            let is_near = |face: &u32| {
                mesh.faces()[*face as usize].iter().all(|&vertex| near[vertex as usize])
            };
            all().into_iter().filter(is_near).collect()
        },
    );
    let faces = if faces.is_empty() { all() } else { faces };
    let chosen: Vec<[u32; 3]> = faces.iter().map(|&face| mesh.faces()[face as usize]).collect();
    (without_layout(mesh, &chosen), faces)
}

/// Some triangles of a mesh, with a single UV coordinate.
fn without_layout(mesh: &Mesh, faces: &[[u32; 3]]) -> Mesh {
    let corners = vec![[0; 3]; faces.len()];
    Mesh::from_triangles(mesh.positions().to_vec(), vec![[0.5; 2]], faces, &corners)
        .unwrap_or_else(|_| mesh.clone())
}
