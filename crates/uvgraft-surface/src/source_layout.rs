//! A pair's target mesh with the UV layout of its source: a body whose head keeps the UV
//! coordinates of the separate head mesh, so the head's texture needs no resampling.

use std::sync::Arc;

use crate::mesh::{Mesh, MeshError, doubled_area};
use crate::pair::{Direction, Pair};
use crate::piece::{Extent, Piece, wide};
use crate::surface::Surface;

/// Triangles whose thickness (height over longest side) is smaller in the source than in the
/// target by more than this factor are left out: the inside of a closed mouth is nearly a line
/// in a head's layout, and a few texels would be smeared across all of it.
const MAX_THINNING: f64 = 8.0;

/// Some triangles of a pair's target in the UV layout of its source.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SourceLayout {
    /// Maps the source to the target's surface in the source's layout. Triangles that are not part
    /// of the layout are collapsed to a point in UV space.
    pub pair: Arc<Pair>,
    /// `[target triangles]`: true for those that are part of the layout.
    pub faces: Vec<bool>,
    /// The fraction of the chosen triangles' surface area that they cover.
    pub share: f64,
}

impl SourceLayout {
    /// Copies UV coordinates from the source to the linked triangles of the target, in
    /// [`Direction::Forward`].
    ///
    /// - `chosen`: `[target triangles]`; those that correspond to one whole source triangle,
    ///   and are not much thinner there, become part of the layout.
    ///
    /// Returns `None` if no triangle qualifies: meshes with different topology are linked by parts
    /// of triangles.
    ///
    /// # Errors
    /// [`MeshError`] if there are too many UV coordinates.
    ///
    /// # Panics
    /// If the length of `chosen` is not the number of target triangles.
    pub fn new(pair: &Pair, chosen: &[bool]) -> Result<Option<Self>, MeshError> {
        let (source, target) = (pair.source(), pair.target());
        assert_eq!(chosen.len(), target.faces().len(), "one for each triangle of the target");
        let pieces = pair.face_pieces(Direction::Forward);
        let is_alone = |piece: &Piece| pieces.of_face(piece.target as usize).len() == 1;
        let mut uv = source.uv().to_vec();
        let unset = uv.len() as u32;
        uv.push([0.0; 2]);
        let mut uv_faces = vec![[unset; 3]; target.faces().len()];
        let mut kept = Vec::new();
        for piece in pair.pieces().filter(|piece| chosen[piece.target as usize]) {
            let Extent::Whole(corners) = piece.extent else { continue };
            if is_alone(&piece) && !is_thin(&piece, target, source) {
                let from = source.uv_faces()[piece.source as usize];
                uv_faces[piece.target as usize] = corners.map(|corner| from[usize::from(corner)]);
                kept.push(piece);
            }
        }
        let faces: Vec<bool> = uv_faces.iter().map(|corners| corners[0] != unset).collect();
        let surface = Surface::new(target);
        let area = |of: &[bool]| -> f64 {
            (0..).zip(of).filter(|(_, is_in)| **is_in).map(|(face, _)| surface.area(face)).sum()
        };
        let share = area(&faces) / area(chosen).max(f64::MIN_POSITIVE);
        let mesh =
            Mesh::from_triangles(target.positions().to_vec(), uv, target.faces(), &uv_faces)?;
        // Linked triangles lie in both unit squares, so the copied coordinates do too.
        let pair = Pair::from_pieces(source.clone(), mesh, kept).ok();
        Ok(pair.map(|pair| Self { pair: Arc::new(pair), faces, share }))
    }
}

/// Whether a triangle is much thinner in the source's UV layout than in the target's.
fn is_thin(piece: &Piece, target: &Mesh, source: &Mesh) -> bool {
    let thickness = |corners: [[f64; 2]; 3]| {
        let longest = (0..3)
            .map(|k| {
                let [a, b] = [corners[k], corners[(k + 1) % 3]];
                (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
            })
            .fold(0.0, f64::max);
        if longest > 0.0 { doubled_area(corners).abs() / longest } else { 0.0 }
    };
    let [to, from] = [(target, piece.target), (source, piece.source)]
        .map(|(mesh, face)| thickness(wide(mesh.uv_triangle(face as usize))));
    from <= 0.0 || to > MAX_THINNING * from
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three triangles in a fan; in the source the last one is nearly degenerate.
    fn meshes() -> (Mesh, Mesh) {
        let positions =
            vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4]];
        let mesh = |uv: Vec<[f32; 2]>| {
            Mesh::from_triangles(positions.clone(), uv, &faces, &faces).unwrap()
        };
        let source = vec![[0.5, 0.9], [0.9, 0.9], [0.9, 0.5], [0.5, 0.5], [0.498, 0.498]];
        let target = vec![[0.2, 0.4], [0.4, 0.4], [0.4, 0.2], [0.2, 0.2], [0.0, 0.2]];
        (mesh(source), mesh(target))
    }

    #[test]
    fn triangles_take_the_coordinates_of_the_source() {
        let (source, target) = meshes();
        let pair = Pair::by_vertex_map(source.clone(), target, &[0, 1, 2, 3, 4]).unwrap();
        let own = SourceLayout::new(&pair, &[true, false, true]).unwrap().unwrap();
        // The second is not chosen, the third is too thin.
        assert_eq!(own.faces, [true, false, false]);
        assert!((own.share - 0.5).abs() < 1e-9, "{}", own.share);
        assert_eq!(own.pair.piece_count(), 1);
        assert_eq!(own.pair.target().uv_triangle(0), source.uv_triangle(0));
        assert_eq!(own.pair.target().uv_triangle(1), [[0.0; 2]; 3]);
        assert!(SourceLayout::new(&pair, &[false; 3]).unwrap().is_none());
    }

    #[test]
    fn parts_of_triangles_are_left_out() {
        let (source, target) = meshes();
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.5]];
        let part = Piece::part((0, corners), (0, corners));
        let whole = Piece::whole(1, 1, [0, 1, 2]);
        let pair = Pair::from_pieces(source, target, [part, whole]).unwrap();
        let own = SourceLayout::new(&pair, &[true; 3]).unwrap().unwrap();
        assert_eq!(own.faces, [false, true, false]);
    }
}
