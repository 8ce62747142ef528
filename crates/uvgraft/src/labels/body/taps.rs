//! Which texels filters along an axis read, over UV seams too.

use std::ops::Range;

use crate::layout_grid::{LayoutGrid, NONE};
use crate::texture::Size;
use crate::threads::map_indices;

/// What is beside a texel along an axis: beyond an island's edge what is across the seam, or itself.
pub(super) fn next_texel(grid: &LayoutGrid, texel: u32, near: u32) -> u32 {
    if near != NONE {
        return near;
    }
    grid.across(texel).next().unwrap_or(texel)
}

/// Which texels are the two before and the two behind each one along an axis.
#[derive(Debug, Clone)]
pub(super) struct Taps {
    pub rows: Vec<RowTaps>,
}

/// Those of a row.
#[derive(Debug, Clone, Default)]
pub(super) struct RowTaps {
    /// Columns of texels whose taps are all on their island.
    pub runs: Vec<Range<u32>>,
    /// Columns of others, and their taps.
    pub others: Vec<(u32, [u32; 5])>,
}

impl Taps {
    pub fn new(grid: &LayoutGrid, axis: usize) -> Self {
        let Size { width, height } = grid.size();
        let of_row = |y: usize| {
            let mut row = RowTaps::default();
            for x in 0..width {
                let texel = y as u32 * width + x;
                if grid.faces()[texel as usize] == NONE {
                    continue;
                }
                match (taps(grid, texel, axis), row.runs.last_mut()) {
                    (None, Some(run)) if run.end == x => run.end = x + 1,
                    (None, _) => row.runs.push(x..x + 1),
                    (Some(taps), _) => row.others.push((x, taps)),
                }
            }
            row
        };
        Self { rows: map_indices(height as usize, of_row) }
    }
}

/// The taps of a texel; nothing if all are on its island.
fn taps(grid: &LayoutGrid, texel: u32, axis: usize) -> Option<[u32; 5]> {
    let [before, behind] = [2 * axis, 2 * axis + 1];
    let ends = [before, behind].map(|side| grid.along::<2>(texel, side));
    if ends.iter().all(Option::is_some) {
        return None;
    }
    let side = |side: usize| {
        let near = grid.beside(texel)[side];
        let first = next_texel(grid, texel, near);
        let second = if near == NONE { NONE } else { grid.beside(near)[side] };
        [first, if second == NONE { first } else { second }]
    };
    let ([b, a], [d, e]) = (side(before), side(behind));
    Some([a, b, texel, d, e])
}
