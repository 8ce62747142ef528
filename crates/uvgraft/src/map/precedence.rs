//! Precedence among overlapping islands: which of them owns the texels that they share.

use uvgraft_surface::islands::Islands;
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::pair::Oriented;

/// Which of several islands that cover the same texels owns them, together with a fringe around it:
/// where two eyes share a disc, one eye is shown whole.
///
/// Left and right are decided by the mean `x` of the corners of an island's triangles, in the
/// target mesh: `x` grows to the left of a person facing `+z`, as in FLAME, SMPL-X and VRM 1.0.
/// Islands with equal means are ordered by face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[non_exhaustive]
pub enum Prefer {
    /// The one with the lowest face.
    #[default]
    First,
    /// The one with the greatest mean `x`: the person's left.
    Left,
    /// The one with the least mean `x`: the person's right.
    Right,
}

uvgraft_surface::choices!(Prefer {
    First => "first", "The island whose faces come first in the mesh";
    Left => "left", "The island on the person's left (largest x)";
    Right => "right", "The island on the person's right (smallest x)";
});

/// The islands of a layout and their ranks, which decide who owns shared texels.
pub(crate) struct Precedence {
    islands: Islands,
    /// A distinct rank for each island; the lowest rank owns.
    ranks: Vec<u32>,
    /// Whether each triangle has no counterpart; empty if all have one.
    is_unlinked: Vec<bool>,
    /// Whether islands are ranked in the order of their faces, as their edges are.
    pub by_face: bool,
}

impl Precedence {
    pub fn new(mesh: &Mesh, prefer: Prefer) -> Self {
        let islands = Islands::new(mesh);
        let mut order: Vec<u32> = (0..islands.count() as u32).collect();
        if prefer != Prefer::First {
            let x = mean_x(mesh, &islands);
            let x = |island: &u32| x[*island as usize];
            order.sort_by(|a, b| match prefer {
                Prefer::Left => x(b).total_cmp(&x(a)),
                _ => x(a).total_cmp(&x(b)),
            });
        }
        let mut ranks = vec![0; order.len()];
        for (rank, &island) in (0..).zip(&order) {
            ranks[island as usize] = rank;
        }
        Self { islands, ranks, is_unlinked: Vec::new(), by_face: prefer == Prefer::First }
    }

    /// Of the layout that pieces fill. Triangles without a counterpart come last, whatever their island:
    /// what is not linked takes no texel from what is.
    pub fn of(oriented: &Oriented<'_>, prefer: Prefer) -> Self {
        let pieces = &oriented.pieces;
        let faces = 0..oriented.to.faces().len();
        let mut is_unlinked: Vec<bool> =
            faces.map(|face| pieces.of_face(face).is_empty()).collect();
        if !is_unlinked.contains(&true) {
            is_unlinked = Vec::new();
        }
        Self { is_unlinked, ..Self::new(oriented.to, prefer) }
    }

    /// Reverses the order of islands. Within islands the lowest face stays first.
    pub fn reversed(mut self) -> Self {
        let last = (self.ranks.len() as u32).saturating_sub(1);
        self.ranks.iter_mut().for_each(|rank| *rank = last - *rank);
        self.by_face = false;
        self
    }

    /// The islands.
    pub fn islands(&self) -> &Islands {
        &self.islands
    }

    /// The island of each triangle.
    pub fn of_faces(&self) -> &[u32] {
        self.islands.of_faces()
    }

    /// Sort key of a face: of the faces that cover a texel, the one with the lowest key owns it.
    pub fn rank(&self, face: u32) -> (bool, u32, u32) {
        let is_unlinked = self.is_unlinked.get(face as usize).is_some_and(|&it| it);
        (is_unlinked, self.ranks[self.of_faces()[face as usize] as usize], face)
    }
}

/// The mean `x` of the corners of each island's triangles.
fn mean_x(mesh: &Mesh, islands: &Islands) -> Vec<f64> {
    let mut sums = vec![(0.0, 0_u32); islands.count()];
    for (face, &island) in mesh.faces().iter().zip(islands.of_faces()) {
        let (sum, count) = &mut sums[island as usize];
        for &vertex in face {
            *sum += f64::from(mesh.positions()[vertex as usize][0]);
            *count += 1;
        }
    }
    // Sums that begin with 0.0 are never -0.0, which would count as less.
    sums.into_iter().map(|(sum, count)| sum / f64::from(count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A separate triangle for each mean `x`.
    fn islands_at<const N: usize>(x: [f32; N]) -> Mesh {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let positions = x.iter().flat_map(|&x| corners.map(|[_, y]| [x, y, 0.0])).collect();
        let uv = x.iter().flat_map(|_| corners).collect();
        let faces: Vec<[u32; 3]> = (0..N as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    #[test]
    fn islands_come_by_face_or_by_x() {
        let mesh = islands_at([-3.0, 5.0, -3.0, 9.0]);
        let ranks = |prefer| Precedence::new(&mesh, prefer).ranks;
        assert_eq!(ranks(Prefer::First), [0, 1, 2, 3]);
        let zeros = Precedence::new(&islands_at([0.0, -0.0, 0.0]), Prefer::Left);
        assert_eq!(zeros.ranks, [0, 1, 2]);
        assert_eq!(ranks(Prefer::Left), [2, 1, 3, 0]);
        assert_eq!(ranks(Prefer::Right), [0, 2, 1, 3]);
        let last = Precedence::new(&mesh, Prefer::Left).reversed();
        assert_eq!(last.ranks, [1, 2, 0, 3]);
        assert!(last.rank(1) > last.rank(0) && last.rank(1) < last.rank(3));
    }
}
