//! How the source mesh is posed relative to the target's.

use crate::pair::Oriented;
use crate::rotation::{Correlation, IDENTITY, Matrix, rotated};
use crate::tangents::corner_positions;
use crate::threads::map_indices;
use crate::vector::sub;

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
    rotations: Vec<Matrix>,
}

impl Pose {
    pub fn new(oriented: &Oriented<'_>) -> Self {
        let (from, to) = (oriented.from, oriented.to);
        let mut around = vec![Correlation::default(); to.positions().len()];
        let mut all = Correlation::default();
        for &piece in oriented.pieces.all() {
            let source = corner_positions(from, piece.from as usize);
            let source = oriented.pieces.at_outline(piece, source);
            let target = corner_positions(to, piece.to as usize);
            let target = oriented.pieces.outline(piece, target);
            let mut sum = Correlation::default();
            for k in 0..3 {
                let next = (k + 1) % 3;
                sum.add(sub(source[next], source[k]), sub(target[next], target[k]));
            }
            for vertex in to.faces()[piece.to as usize] {
                around[vertex as usize].add_all(&sum);
            }
            all.add_all(&sum);
        }
        let is_mirrored = all.mirrored().rotation().1 > MIRRORED * all.rotation().1;
        let flat = |sum: &Correlation| if is_mirrored { sum.mirrored() } else { *sum };
        let (whole, _) = flat(&all).leaning(&IDENTITY).rotation();
        let rotations = map_indices(around.len(), |vertex| {
            let sum = &around[vertex];
            if *sum == Correlation::default() {
                return whole;
            }
            flat(sum).leaning(&whole).rotation().0
        });
        Self { is_mirrored, rotations }
    }

    /// A direction at a vertex of the target, from the source's space to the target's.
    pub fn turned(&self, vertex: u32, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let x = if self.is_mirrored { -x } else { x };
        let rotation = &self.rotations[vertex as usize];
        rotated(rotation, [x, y, z].map(f64::from)).map(|value| value as f32)
    }

    /// −1 if there is a reflection, which turns products of vectors around; else 1.
    pub fn determinant(&self) -> f32 {
        if self.is_mirrored { -1.0 } else { 1.0 }
    }
}
