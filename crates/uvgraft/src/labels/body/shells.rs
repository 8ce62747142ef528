//! Contacts between the shells (connected components) of a body mesh.
//!
//! Sleeves, hands or a neck may be separate shells whose open edges lie against another
//! shell or reach into it. They aren't connected on the surface, though colours show
//! whether skin continues there, as they do at UV seams.

use std::collections::{HashMap, HashSet};

use glam::Vec3;
use uvgraft_surface::disjoint::DisjointSets;
use uvgraft_surface::edges::{Edges, NO_HALF_EDGE};
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::threads::map_indices;

use crate::layout_grid::{self, LayoutGrid, ends_uv};

type Cell = [i32; 3];

/// Limit of the samples along open edges: hair strands and leaves may be thousands of shells.
const MAX_SAMPLES: usize = 20_000;

/// A sample on a shell's surface.
struct Sample {
    texel: u32,
    at: Vec3,
    shell: u32,
}

/// Pairs of adjacent texels of different shells: each at an open edge of one, with the
/// nearest of another.
#[derive(Debug, Clone, Default)]
pub(super) struct Contacts {
    /// In both directions, sorted.
    pairs: Vec<(u32, u32)>,
}

impl Contacts {
    /// - `edges`: the mesh's edges.
    /// - `reach`: largest distance of a contact, in the mesh's unit.
    pub fn new(mesh: &Mesh, edges: &Edges, grid: &LayoutGrid, reach: f64) -> Self {
        let shells = shells(edges);
        if shells.iter().all(|shell| *shell == shells[0]) {
            return Self::default();
        }
        let all = open_edges(mesh, grid, edges, &shells);
        let step = all.len().div_ceil(MAX_SAMPLES).max(1);
        let samples: Vec<Sample> = all.into_iter().step_by(step).collect();
        let reach = reach as f32;
        let cell = |at: Vec3| (at / reach).floor().as_ivec3().to_array();
        let wanted: HashSet<Cell> =
            samples.iter().flat_map(|sample| around(cell(sample.at))).collect();
        let near = texels_in(mesh, grid, &shells, &wanted, cell);
        let nearest = map_indices(samples.len(), |index| {
            let sample = &samples[index];
            let mut least = (reach * reach).next_up();
            let mut nearest = None;
            for other in around(cell(sample.at)).filter_map(|cell| near.get(&cell)).flatten() {
                let squared = other.at.distance_squared(sample.at);
                if squared < least && other.shell != sample.shell {
                    (least, nearest) = (squared, Some((sample.texel, other.texel)));
                }
            }
            nearest
        });
        let both = nearest.into_iter().flatten().flat_map(|(a, b)| [(a, b), (b, a)]);
        let mut pairs: Vec<(u32, u32)> = both.collect();
        pairs.sort_unstable();
        pairs.dedup();
        Self { pairs }
    }

    /// Whether a texel has a contact.
    pub fn has(&self, texel: u32) -> bool {
        self.of(texel).next().is_some()
    }

    /// The texels of other shells in contact with a texel.
    pub fn of(&self, texel: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.pairs.partition_point(|&(from, _)| from < texel);
        let others = self.pairs[first..].iter().take_while(move |&&(from, _)| from == texel);
        others.map(|&(_, to)| to)
    }
}

/// The shell of each triangle, as its lowest point's index.
fn shells(edges: &Edges) -> Vec<u32> {
    let mut sets = DisjointSets::new(edges.vertex_count as u32);
    for &[a, b, c] in &edges.vertices {
        sets.join(a, b);
        sets.join(a, c);
    }
    edges.vertices.iter().map(|corners| sets.root(corners[0])).collect()
}

/// Samples along all open edges, one per texel along the edge.
fn open_edges(mesh: &Mesh, grid: &LayoutGrid, edges: &Edges, shells: &[u32]) -> Vec<Sample> {
    let mut samples = Vec::new();
    let open = (0u32..).zip(&edges.opposite).filter(|(_, opposite)| **opposite == NO_HALF_EDGE);
    for (half, _) in open {
        let (face, corner) = (half as usize / 3, half as usize % 3);
        let ends = ends_uv(mesh, half);
        let corners = mesh.faces()[face];
        let [from, to] = [corners[corner], corners[(corner + 1) % 3]]
            .map(|vertex| Vec3::from(mesh.positions()[vertex as usize]));
        for along in grid.places_along(&[ends]) {
            if let Some(texel) = grid.near(mesh, ends, face as u32, along) {
                let at = from.lerp_monotonic(to, along as f32);
                samples.push(Sample { texel, at, shell: shells[face] });
            }
        }
    }
    samples
}

/// The covered texels whose surface points lie in `wanted` cells, by cell.
fn texels_in(
    mesh: &Mesh,
    grid: &LayoutGrid,
    shells: &[u32],
    wanted: &HashSet<Cell>,
    cell: impl Fn(Vec3) -> Cell + Sync,
) -> HashMap<Cell, Vec<Sample>> {
    let reaches_in = map_indices(mesh.faces().len(), |face| {
        let corners =
            mesh.faces()[face].map(|vertex| cell(mesh.positions()[vertex as usize].into()));
        let [low, high] = [i32::min, i32::max]
            .map(|best| [0, 1, 2].map(|k| best(best(corners[0][k], corners[1][k]), corners[2][k])));
        is_near_any(low, high, wanted)
    });
    let axes = [0, 1, 2].map(|k| mesh.positions().iter().map(|at| at[k]).collect::<Vec<f32>>());
    let width = grid.size().width as usize;
    let rows = map_indices(grid.size().height as usize, |y| {
        let is_near = |&texel: &usize| {
            let face = grid.faces()[texel];
            face != layout_grid::NONE && reaches_in[face as usize]
        };
        let samples = (y * width..(y + 1) * width).filter(is_near).map(|texel| {
            let at = Vec3::from([0, 1, 2].map(|k| grid.at_texel(mesh, &axes[k], texel)));
            let shell = shells[grid.faces()[texel] as usize];
            (cell(at), Sample { texel: texel as u32, at, shell })
        });
        samples.filter(|(cell, _)| wanted.contains(cell)).collect::<Vec<_>>()
    });
    let mut found: HashMap<Cell, Vec<Sample>> = HashMap::new();
    for (cell, sample) in rows.into_iter().flatten() {
        found.entry(cell).or_default().push(sample);
    }
    found
}

/// Whether any cell of a box is wanted; conservatively true for boxes of more than 64 cells.
fn is_near_any(low: Cell, high: Cell, wanted: &HashSet<Cell>) -> bool {
    const MAX: i64 = 64;
    let sides = [0, 1, 2].map(|k| i64::from(high[k]) - i64::from(low[k]) + 1);
    let count = sides.into_iter().fold(1, i64::saturating_mul);
    count > MAX
        || (low[0]..=high[0]).any(|x| {
            (low[1]..=high[1]).any(|y| (low[2]..=high[2]).any(|z| wanted.contains(&[x, y, z])))
        })
}

/// A cell and its 26 neighbours.
fn around([x, y, z]: Cell) -> impl Iterator<Item = Cell> {
    (-1..=1).flat_map(move |dx| {
        (-1..=1).flat_map(move |dy| {
            (-1..=1)
                .map(move |dz| [x.saturating_add(dx), y.saturating_add(dy), z.saturating_add(dz)])
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Size;

    /// Two coplanar unit squares, each in its own half of the layout.
    fn squares(gap: f32) -> Mesh {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]];
        let positions = [0.0, 1.0 + gap].map(|x| corners.map(|[u, v]| [x + u, v, 0.0])).concat();
        let uv = [0.05, 0.55].map(|x| corners.map(|[u, v]| [x + 0.4 * u, 0.9 * v])).concat();
        let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    fn contacts(gap: f32) -> (LayoutGrid, Contacts) {
        let mesh = squares(gap);
        let edges = Edges::new(&mesh);
        let grid = LayoutGrid::with_edges(&mesh, &edges, Size::square(64));
        let contacts = Contacts::new(&mesh, &edges, &grid, 0.2);
        (grid, contacts)
    }

    #[test]
    fn shells_touch_where_they_are_close() {
        let (grid, contacts) = contacts(0.05);
        assert!(contacts.pairs.len() > 50, "{} pairs", contacts.pairs.len());
        for &(from, to) in &contacts.pairs {
            assert!(contacts.of(to).any(|back| back == from));
            let [from, to] = [from, to]
                .map(|texel| (grid.faces()[texel as usize] < 2, texel % 64, i64::from(texel / 64)));
            assert_ne!(from.0, to.0, "one shell");
            // Each is at its shell's edge, and both are at the same height.
            let [(_, left, a), (_, right, b)] = if from.0 { [from, to] } else { [to, from] };
            assert!(left >= 24 && right <= 40 && (a - b).abs() <= 8, "{left} {a}, {right} {b}");
        }
        let inside = 32 * 64 + 8;
        assert!(!contacts.has(inside));
    }

    #[test]
    fn far_shells_and_single_ones_have_none() {
        assert!(contacts(0.3).1.pairs.is_empty());
        assert!(contacts(0.0).1.pairs.is_empty(), "welded");
    }
}
