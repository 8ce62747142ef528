//! Which texels of a texture something is about.

use std::ops::Range;

use super::SamplingMap;
use super::coverage::Coverage;
use crate::texture::Size;

/// Texels of a texture, row by row as sorted ranges of columns that do not touch.
#[derive(Debug, Clone)]
pub(crate) struct Region {
    size: Size,
    rows: Vec<Vec<Range<u32>>>,
}

impl Region {
    /// What a layout covers.
    pub fn covered(coverage: &Coverage) -> Self {
        let row = |row| joined(coverage.row(row).iter().map(|span| span.start..span.end));
        Self { size: coverage.size(), rows: (0..coverage.size().height).map(row).collect() }
    }

    /// What linked triangles own, as far as their faces are wanted.
    pub fn linked(map: &SamplingMap, wanted: impl Fn(u32) -> bool) -> Self {
        let row = |row| {
            let runs = map.row(row).iter().filter(|run| !map.is_gutter(**run));
            let runs = runs.filter(|run| wanted(map.patches()[run.patch as usize].face));
            joined(runs.map(|run| run.x..run.x + run.len))
        };
        Self { size: map.size(), rows: (0..map.size().height).map(row).collect() }
    }

    pub fn size(&self) -> Size {
        self.size
    }

    /// All rows, from the top.
    pub fn rows(&self) -> &[Vec<Range<u32>>] {
        &self.rows
    }

    /// How many texels there are.
    pub fn texels(&self) -> usize {
        self.rows.iter().flatten().map(ExactSizeIterator::len).sum()
    }

    /// Adds the columns of a row that are not in it.
    pub fn gaps(&self, row: usize, gaps: &mut Vec<Range<u32>>) {
        push_gaps(self.rows[row].iter().cloned(), self.size.width, gaps);
    }
}

/// Adds what sorted ranges leave of `0..width`.
pub(super) fn push_gaps(
    ranges: impl Iterator<Item = Range<u32>>,
    width: u32,
    gaps: &mut Vec<Range<u32>>,
) {
    let mut end = 0;
    for range in ranges {
        if end < range.start {
            gaps.push(end..range.start);
        }
        end = range.end;
    }
    if end < width {
        gaps.push(end..width);
    }
}

/// Sorted ranges with neighbours joined.
fn joined(ranges: impl Iterator<Item = Range<u32>>) -> Vec<Range<u32>> {
    let mut rows: Vec<Range<u32>> = Vec::new();
    for range in ranges {
        match rows.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => rows.push(range),
        }
    }
    rows
}
