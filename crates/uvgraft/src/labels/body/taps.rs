//! Filter taps along an axis, continued across UV seams.

use std::ops::Range;

use uvgraft_surface::threads::map_indices;

use crate::layout_grid::{LayoutGrid, NONE};
use crate::texture::Size;

/// The neighbour of a texel along an axis: `near` if it is on the island, else the texel
/// across the UV seam, else the texel itself.
pub(super) fn next_texel(grid: &LayoutGrid, texel: u32, near: u32) -> u32 {
    if near != NONE {
        return near;
    }
    grid.across(texel).next().unwrap_or(texel)
}

/// The two texels before and the two after each texel along an axis.
#[derive(Debug, Clone)]
pub(super) struct Taps {
    pub rows: Vec<RowTaps>,
}

/// The taps of a row of texels.
#[derive(Debug, Clone, Default)]
pub(super) struct RowTaps {
    /// Columns of texels whose taps are all on the same island.
    pub runs: Vec<Range<u32>>,
    /// Columns of the others, with their taps.
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

/// The taps of a texel; `None` if all are on its island.
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
