//! How the source mesh is posed relative to the target's.

use glam::{DMat3, DVec3, Vec3};

use crate::pair::Oriented;
use crate::rotation::Correlation;
use crate::tangents::corner_positions;
use crate::threads::map_indices;

/// A reflection has to explain the edges by so much better than a rotation to be believed: in sheets
/// that are nearly flat it does by a little, as they bend.
const MIRRORED: f64 = 1.1;

/// For each vertex of the target the rotation that takes the source's surface to the target's, after
/// a reflection if the source is the target's mirror image.
///
/// The linked edges of all triangles around the vertex are taken to the target's with the least squared
/// error; sizes do not matter. Edges within a line, and slivers, leave a rotation open: it is
/// the one closest to that of the whole mesh.
pub(super) struct Pose {
    is_mirrored: bool,
    rotations: Vec<DMat3>,
}

impl Pose {
    pub fn new(oriented: &Oriented<'_>) -> Self {
        let (from, to) = (oriented.from, oriented.to);
        let mut around = vec![Correlation::NONE; to.positions().len()];
        let mut all = Correlation::NONE;
        for &piece in oriented.pieces.all() {
            // The edges of all of the face, as the piece has them, and no more than its share of them: so it does
            // not matter where faces are cut.
            let source = corner_positions(from, piece.from as usize);
            let source = oriented.pieces.at_corners(piece, source.map(<[f64; 3]>::from));
            let source = source.map(DVec3::from);
            let target = corner_positions(to, piece.to as usize);
            let mut sum = Correlation::NONE;
            for k in 0..3 {
                let next = (k + 1) % 3;
                sum.add(source[next] - source[k], target[next] - target[k]);
            }
            let sum = sum.scaled(oriented.pieces.share(piece));
            for vertex in to.faces()[piece.to as usize] {
                around[vertex as usize].add_all(&sum);
            }
            all.add_all(&sum);
        }
        let is_mirrored = all.mirrored().rotation().1 > MIRRORED * all.rotation().1;
        let flat = |sum: &Correlation| if is_mirrored { sum.mirrored() } else { *sum };
        let (whole, _) = flat(&all).leaning(DMat3::IDENTITY).rotation();
        let rotations = map_indices(around.len(), |vertex| {
            let sum = &around[vertex];
            if *sum == Correlation::NONE {
                return whole;
            }
            flat(sum).leaning(whole).rotation().0
        });
        Self { is_mirrored, rotations }
    }

    /// A direction at a vertex of the target, from the source's space to the target's.
    pub fn turned(&self, vertex: u32, direction: [f32; 3]) -> [f32; 3] {
        let mut direction = Vec3::from(direction).as_dvec3();
        if self.is_mirrored {
            direction.x = -direction.x;
        }
        (self.rotations[vertex as usize] * direction).as_vec3().to_array()
    }

    /// −1 if there is a reflection, which turns products of vectors around; else 1.
    pub fn determinant(&self) -> f32 {
        if self.is_mirrored { -1.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::pair::{Direction, Pair};
    use crate::piece::Piece;

    #[test]
    fn cuts_turn_nothing() {
        let uv = vec![[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let mesh = |heights: [f32; 4]| {
            let places = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].into_iter().zip(heights);
            let positions = places.map(|([x, y], height)| [x, y, height]).collect();
            Mesh::from_triangles(positions, uv.clone(), &faces, &faces).unwrap()
        };
        let (source, target) = (mesh([0.0, 0.4, -0.2, 0.7]), mesh([0.3, 0.0, 0.5, 0.0]));
        let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let inner = [0.7, 0.2, 0.1];
        let whole = [0, 1].map(|face| Piece::whole(face, face, [0, 1, 2]));
        // The second face only.
        let cut = [[a, b, inner], [b, c, inner], [c, a, inner]]
            .map(|part| Piece::part((1, part), (1, part)));
        let cut: Vec<Piece> = [whole[0]].into_iter().chain(cut).collect();
        let turned = |pieces: Vec<Piece>| {
            let pair = Pair::from_pieces(source.clone(), target.clone(), pieces).unwrap();
            let pose = Pose::new(&pair.oriented(Direction::Forward));
            [0, 1, 2, 3].map(|vertex| pose.turned(vertex, [0.6, 0.0, 0.8]))
        };
        let (whole, cut) = (turned(whole.to_vec()), turned(cut));
        for (whole, cut) in whole.as_flattened().iter().zip(cut.as_flattened()) {
            assert!((whole - cut).abs() < 1e-6, "{whole} {cut}");
        }
        assert_ne!(whole[1], whole[3]);
    }
}
