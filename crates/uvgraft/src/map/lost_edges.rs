//! Boundary edges of islands whose inner side belongs to another island.

use uvgraft_surface::threads::map_indices;

use super::coverage::{Coverage, LayoutTriangles};
use super::precedence::Precedence;

impl LayoutTriangles {
    /// For each boundary edge, whether another island owns the texels on its inner side, so that a
    /// gutter along the edge would show an island that is itself hidden.
    ///
    /// If islands are ranked in the order of their faces, no search is needed: where boundaries
    /// coincide, the first edge counts as the nearest, and it belongs to the owner.
    pub fn lost_edges(&self, precedence: &Precedence) -> Vec<bool> {
        let border = precedence.islands().boundary_edges();
        if precedence.by_face {
            return vec![false; border.len()];
        }
        let coverage = Coverage::new(self, precedence);
        if coverage.clashes.is_empty() {
            return vec![false; border.len()];
        }
        map_indices(border.len(), |index| {
            let edge = border[index];
            let island = precedence.of_faces()[edge.face as usize];
            let corners = self.corners_px(edge.face as usize);
            let corners = [0, 1, 2].map(|k| corners[(usize::from(edge.corner) + k) % 3]);
            let wins = |owner: u32| coverage.clashes.binary_search(&(owner, island)).is_ok();
            // The texel itself or one of its neighbours, because of the winner's fringe.
            let is_lost = |point: [f64; 2]| {
                (0..9).any(|k| {
                    let beside = [point[0] + f64::from(k % 3 - 1), point[1] + f64::from(k / 3 - 1)];
                    coverage
                        .owner(beside)
                        .is_some_and(|face| wins(precedence.of_faces()[face as usize]))
                })
            };
            inside(corners).into_iter().all(is_lost)
        })
    }
}

/// Points inside a triangle along its edge from the first to the second corner: one texel away from
/// the edge, or a third of the way to the third corner if that is nearer.
fn inside([from, to, opposite]: [[f64; 2]; 3]) -> [[f64; 2]; 3] {
    const DEPTH_PX: f64 = 1.0;
    let along = [to[0] - from[0], to[1] - from[1]];
    let across = [opposite[0] - from[0], opposite[1] - from[1]];
    let height = (along[0] * across[1] - along[1] * across[0]).abs() / along[0].hypot(along[1]);
    let share = (DEPTH_PX / height).min(1.0 / 3.0);
    [0.25, 0.5, 0.75].map(|t| {
        [0, 1].map(|axis| {
            let on_edge = from[axis] + t * along[axis];
            on_edge + share * (opposite[axis] - on_edge)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_a_texel_or_a_third_inside() {
        // A base of four texels on a slant, whose third corner is far or near.
        let (from, to) = ([3.0, 2.0], [6.2, 4.4]);
        for (height, depth) in [(10.0, 1.0), (1.5, 0.5)] {
            let opposite = [3.0 - 0.6 * height, 2.0 + 0.8 * height];
            for corners in [[from, to, opposite], [to, from, opposite]] {
                let points = inside(corners);
                for (point, t) in points.into_iter().zip([0.25, 0.5, 0.75]) {
                    let [along, across] = [[0.8, 0.6], [-0.6, 0.8]].map(|axis| {
                        (point[0] - from[0]) * axis[0] + (point[1] - from[1]) * axis[1]
                    });
                    let t = if corners[0] == from { t } else { 1.0 - t };
                    let wanted = 4.0 * t * (1.0 - depth / height);
                    assert!((across - depth).abs() < 1e-9 && (along - wanted).abs() < 1e-9);
                }
            }
        }
    }
}
