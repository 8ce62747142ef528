//! The values of islands that lost an overlap, at the texels they share with the winner.

use std::ops::Range;

use uvgraft_surface::islands::Islands;
use uvgraft_surface::pair::Pair;
use uvgraft_surface::threads::map_indices_with;

use super::precedence::Precedence;
use super::rows::{BLOCK_ROWS, Draft, RowLists};
use super::{MapOptions, MapStats, Run, SamplingMap, build};

impl SamplingMap {
    /// Source positions of overlapping texels if the last of their owners had them rather than the
    /// first: the map with the island order of `options` reversed, restricted to the texels for
    /// which both maps have a position, but in different islands. `None` if there are none.
    ///
    /// These are the texels that islands share, with the fringe and the gutter around them. The
    /// mean of what both maps read there blends, for instance, two eyes on one disc, with an edge
    /// as clean as that of either eye. Its [`MapStats`] count these texels alone.
    ///
    /// - `pair`, `options`: those that this map was built with.
    pub fn beneath(&self, pair: &Pair, options: &MapOptions) -> Option<Self> {
        if self.stats().overlapping == 0 {
            return None;
        }
        let to = pair.to(self.direction());
        let (direction, size) = (self.direction(), self.size());
        let oriented = pair.oriented(direction);
        let precedence = || Precedence::of(&oriented, options.prefer).reversed();
        let mut last = build::build(&oriented, direction, size, options.gutter_px, precedence);
        let islands = Islands::new(to);
        let island = |map: &Self, run: &Run| {
            islands.of_faces()[map.patches()[run.patch as usize].face as usize]
        };
        let blocks = size.height.div_ceil(BLOCK_ROWS) as usize;
        let parts = map_indices_with(blocks, Draft::<Run>::new, |draft, block| {
            draft.clear();
            let mut stats = MapStats { linked: 0, gutter: 0, covered: 0, overlapping: 0 };
            let first = block as u32 * BLOCK_ROWS;
            for row in first..(first + BLOCK_ROWS).min(size.height) {
                for_each_shared(self.row(row), last.row(row), |ours, theirs, texels| {
                    if island(self, ours) == island(&last, theirs) {
                        return;
                    }
                    let count =
                        if last.is_gutter(*theirs) { &mut stats.gutter } else { &mut stats.linked };
                    *count += texels.len();
                    let (x, len) = (texels.start, texels.end - texels.start);
                    draft.items.push(Run { x, len, patch: theirs.patch });
                });
                draft.end_row();
            }
            (draft.block(), stats)
        });
        let mut stats = MapStats { linked: 0, gutter: 0, covered: 0, ..self.stats() };
        for (_, part) in &parts {
            stats.linked += part.linked;
            stats.gutter += part.gutter;
        }
        stats.covered = stats.linked;
        last.runs = RowLists::new(parts.into_iter().map(|(block, _)| block).collect());
        last.stats = stats;
        (stats.linked + stats.gutter > 0).then_some(last)
    }
}

/// Calls `visit` with every two runs of two sorted lists that overlap, and the texels that they
/// share.
fn for_each_shared(a: &[Run], b: &[Run], mut visit: impl FnMut(&Run, &Run, Range<u32>)) {
    let mut first = 0;
    for run in a {
        first += b[first..].partition_point(|other| other.x + other.len <= run.x);
        let end = run.x + run.len;
        for other in b[first..].iter().take_while(|other| other.x < end) {
            visit(run, other, run.x.max(other.x)..end.min(other.x + other.len));
        }
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::Direction;

    use super::*;
    use crate::map::Prefer;
    use crate::texture::Size;

    /// Squares of two triangles each, given by left, top, right and bottom, and by their position
    /// in `x`.
    fn squares(squares: &[([f32; 4], f32)]) -> Mesh {
        let (mut uv, mut positions, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        for (square, &([left, top, right, bottom], x)) in (0..).zip(squares) {
            uv.extend([[left, top], [right, top], [right, bottom], [left, bottom]]);
            positions.extend([[x - 1.0, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0], [x + 1.0; 3]]);
            faces.extend([[0, 1, 2], [0, 2, 3]].map(|face| face.map(|k: u32| k + square * 4)));
        }
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    const SHARED: [f32; 4] = [0.25, 0.25, 0.5, 0.5];

    /// Two coincident squares, the second shifted by a fraction of a texel at size 64; one
    /// that covers them in part; and one by itself. Everything is linked, each square to a
    /// square of its own.
    fn pair(moved: f32) -> Pair {
        let second = [SHARED[0] + moved, SHARED[1], SHARED[2] + moved, SHARED[3]];
        let target = squares(&[
            (SHARED, -3.0),
            (second, 5.0),
            ([0.4, 0.4, 0.7, 0.7], -3.0),
            ([0.8, 0.05, 0.95, 0.2], 9.0),
        ]);
        let places = [0.0, 0.3, 0.5, 0.7].map(|x| ([x, 0.1, x + 0.2, 0.3], 0.0));
        Pair::by_vertex_map(squares(&places), target, &(0..16).collect::<Vec<i64>>()).unwrap()
    }

    fn map(pair: &Pair, prefer: Prefer) -> SamplingMap {
        let options = MapOptions { prefer, ..MapOptions::with_gutter(4) };
        SamplingMap::new(pair, Direction::Forward, Size::square(64), &options)
    }

    /// The square that owns each texel, row by row.
    fn squares_of(map: &SamplingMap) -> Vec<Option<u32>> {
        let mut found = vec![None; map.size().texels()];
        for row in 0..map.size().height {
            for run in map.row(row) {
                let start = (row * map.size().width + run.x) as usize;
                let square = map.patches()[run.patch as usize].face / 2;
                found[start..start + run.len as usize].fill(Some(square));
            }
        }
        found
    }

    #[test]
    fn one_island_is_seen_with_its_gutter() {
        for moved in [0.0, 0.1 / 64.0, -0.1 / 64.0] {
            let pair = pair(moved);
            let found = [Prefer::Left, Prefer::Right].map(|prefer| squares_of(&map(&pair, prefer)));
            let count = |found: &[Option<u32>], square| {
                found.iter().filter(|&&found| found == Some(square)).count()
            };
            // The first square has all of its 16 by 16 texels and more around them; not even the
            // gutter of the other is left.
            assert!(count(&found[0], 1) > 400 && count(&found[0], 0) == 0, "{moved}");
            assert!(count(&found[1], 0) > 400 && count(&found[1], 1) == 0, "{moved}");
            for (left, right) in found[0].iter().zip(&found[1]) {
                assert!(left == right || *left == Some(1) || *right == Some(0), "{moved}");
            }
        }
        // Here the square with the lowest face is the right one.
        let first = squares_of(&map(&pair(0.0), Prefer::First));
        assert_eq!(first, squares_of(&map(&pair(0.0), Prefer::Right)));
    }

    #[test]
    fn beneath_reads_what_the_last_owner_reads() {
        let pair = pair(0.0);
        for prefer in [Prefer::First, Prefer::Left, Prefer::Right] {
            let options = MapOptions { prefer, ..MapOptions::with_gutter(4) };
            let above = map(&pair, prefer);
            let precedence = || Precedence::new(pair.target(), prefer).reversed();
            let size = above.size();
            let oriented = pair.oriented(Direction::Forward);
            let last = build::build(&oriented, Direction::Forward, size, 4, precedence);
            let beneath = above.beneath(&pair, &options).unwrap();
            let [above, all, found] = [&above, &last, &beneath].map(squares_of);
            let mut differing = 0;
            for ((above, all), &found) in above.iter().zip(all).zip(&found) {
                let wanted = all.filter(|_| above.is_some() && *above != all);
                assert_eq!(found, wanted, "{prefer:?}");
                differing += usize::from(found.is_some());
            }
            let stats = beneath.stats();
            assert_eq!(stats.linked + stats.gutter, differing);
            // Everything that the coincident squares share is present, and some texels around it.
            assert!((16..32).all(|y| (16..32).all(|x| found[y * 64 + x].is_some())), "{prefer:?}");
            assert!(differing > 256, "{prefer:?} {stats:?}");
            // Source positions are those of the unrestricted map.
            for row in 0..size.height {
                for run in beneath.row(row) {
                    let inside =
                        |whole: &&Run| whole.x <= run.x && run.x + run.len <= whole.x + whole.len;
                    let whole = last.row(row).iter().find(inside).unwrap();
                    assert_eq!(whole.patch, run.patch);
                }
            }
        }
        let alone = squares(&[(SHARED, 0.0)]);
        let alone = Pair::by_vertex_map(alone.clone(), alone, &[0, 1, 2, 3]).unwrap();
        let options = MapOptions::with_gutter(4);
        assert!(map(&alone, Prefer::First).beneath(&alone, &options).is_none());
    }

    #[test]
    fn shared_texels_of_runs() {
        let run = |x, len, patch| Run { x, len, patch };
        let a = [run(0, 4, 0), run(4, 6, 1), run(20, 2, 2)];
        let b = [run(2, 3, 3), run(6, 1, 4), run(8, 13, 5)];
        let mut found = Vec::new();
        for_each_shared(&a, &b, |a, b, texels| found.push((a.patch, b.patch, texels)));
        assert_eq!(
            found,
            [(0, 3, 2..4), (1, 3, 4..5), (1, 4, 6..7), (1, 5, 8..10), (2, 5, 20..21)]
        );
    }
}
