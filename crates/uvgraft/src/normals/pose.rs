//! The local rotation from the source mesh's pose to the target's.

use glam::{DMat3, DVec3, Vec3};
use uvgraft_surface::pair::Oriented;
use uvgraft_surface::rotation::Correlation;
use uvgraft_surface::tangents::corner_positions;
use uvgraft_surface::threads::map_indices;

/// How much better a reflection must explain the edges than a rotation to be accepted: on nearly
/// flat sheets that bend, it does so by a little. Origin not recorded.
const MIRRORED: f64 = 1.1;

/// For each vertex of the target, the rotation that maps the source's surface to the
/// target's, after a reflection if the source is the target's mirror image.
///
/// It is the least-squares rotation from the linked edges of all triangles around the vertex to the
/// target's edges; scale does not matter. Collinear edges and slivers leave it underdetermined:
/// then it is the solution closest to the rotation of the whole mesh.
pub(super) struct Pose {
    is_mirrored: bool,
    rotations: Vec<DMat3>,
}

impl Pose {
    pub fn new(oriented: &Oriented<'_>) -> Self {
        let (from, to) = (oriented.from, oriented.to);
        let pieces = oriented.pieces.all();
        let sums = map_indices(pieces.len(), |index| {
            let piece = pieces[index];
            // Use the piece's mapping extrapolated to the whole face, weighted by the piece's share
            // of the area, so the result does not depend on where faces are cut.
            let source = corner_positions(from, piece.from as usize);
            let source = oriented.pieces.at_corners(piece, source.map(<[f64; 3]>::from));
            let source = source.map(DVec3::from);
            let target = corner_positions(to, piece.to as usize);
            let mut sum = Correlation::NONE;
            for k in 0..3 {
                let next = (k + 1) % 3;
                sum.add(source[next] - source[k], target[next] - target[k]);
            }
            sum.scaled(oriented.pieces.share(piece))
        });
        let mut around = vec![Correlation::NONE; to.positions().len()];
        let mut all = Correlation::NONE;
        for (piece, sum) in pieces.iter().zip(&sums) {
            for vertex in to.faces()[piece.to as usize] {
                around[vertex as usize].add_all(sum);
            }
            all.add_all(sum);
        }
        let is_mirrored = all.mirrored().rotation().1 > MIRRORED * all.rotation().1;
        let flat = |sum: &Correlation| if is_mirrored { sum.mirrored() } else { *sum };
        let (whole, _) = flat(&all).biased(DMat3::IDENTITY).rotation();
        let rotations = map_indices(around.len(), |vertex| {
            let sum = &around[vertex];
            if *sum == Correlation::NONE {
                return whole;
            }
            flat(sum).biased(whole).rotation().0
        });
        Self { is_mirrored, rotations }
    }

    /// Maps a direction at a vertex of the target from the source's space to the target's.
    pub fn rotate(&self, vertex: u32, direction: [f32; 3]) -> [f32; 3] {
        let mut direction = Vec3::from(direction).as_dvec3();
        if self.is_mirrored {
            direction.x = -direction.x;
        }
        (self.rotations[vertex as usize] * direction).as_vec3().to_array()
    }

    /// −1 if there is a reflection, which negates cross products, else 1.
    pub fn determinant(&self) -> f32 {
        if self.is_mirrored { -1.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};
    use uvgraft_surface::piece::Piece;

    use super::*;

    #[test]
    fn cuts_do_not_change_rotations() {
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
        // Only the second face is cut.
        let cut = [[a, b, inner], [b, c, inner], [c, a, inner]]
            .map(|part| Piece::part((1, part), (1, part)));
        let cut: Vec<Piece> = [whole[0]].into_iter().chain(cut).collect();
        let turned = |pieces: Vec<Piece>| {
            let pair = Pair::from_pieces(source.clone(), target.clone(), pieces).unwrap();
            let pose = Pose::new(&pair.oriented(Direction::Forward));
            [0, 1, 2, 3].map(|vertex| pose.rotate(vertex, [0.6, 0.0, 0.8]))
        };
        let (whole, cut) = (turned(whole.to_vec()), turned(cut));
        for (whole, cut) in whole.as_flattened().iter().zip(cut.as_flattened()) {
            assert!((whole - cut).abs() < 1e-6, "{whole} {cut}");
        }
        assert_ne!(whole[1], whole[3]);
    }

    #[test]
    fn mirrored_meshes_turn_cross_products_around() {
        let mesh = |side: f32| {
            // Three sides of a corner of a box, which no rotation turns into its mirror image.
            let corners = [[0.0, 0.0, 0.0], [side, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.3]];
            let uv = vec![[0.5, 0.5], [0.9, 0.1], [0.1, 0.1], [0.5, 0.9]];
            let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1]];
            Mesh::from_triangles(corners.to_vec(), uv, &faces, &faces).unwrap()
        };
        for (side, determinant) in [(1.0, 1.0), (-1.0, -1.0)] {
            let pieces = [0, 1, 2].map(|face| Piece::whole(face, face, [0, 1, 2]));
            let pair = Pair::from_pieces(mesh(1.0), mesh(side), pieces).unwrap();
            let pose = Pose::new(&pair.oriented(Direction::Forward));
            assert_eq!(pose.determinant(), determinant);
            let [a, b] = [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0]];
            let [turned_a, turned_b] = [a, b].map(|v| Vec3::from(pose.rotate(0, v)));
            let crossed = Vec3::from(pose.rotate(0, Vec3::from(a).cross(Vec3::from(b)).into()));
            let found = turned_a.cross(turned_b) * pose.determinant();
            assert!(found.abs_diff_eq(crossed, 1e-5), "{found} {crossed}");
            assert!((turned_a.x - side * a[0]).abs() < 1e-4, "{turned_a}");
        }
    }
}
