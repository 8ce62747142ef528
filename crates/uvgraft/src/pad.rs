//! Padding of a source texture: what filters read beside its islands.
//!
//! A filter near an island's edge reads texels outside the island, where a texture may hold
//! anything. They are given the value of the nearest texel inside first.

use std::ops::Range;

use crate::map::Region;
use crate::texture::{Size, Texels, Texture};
use crate::threads::map_indices;

/// Which texels outside the islands take whose value, for one layout and size.
#[derive(Debug, Clone)]
pub struct Padding {
    size: Size,
    /// Texel number outside, and the texel number inside whose value it takes.
    copies: Vec<[u32; 2]>,
}

impl Padding {
    /// For texels within `radius` of one in the region.
    pub(crate) fn new(region: &Region, radius: u32) -> Self {
        let size = region.size();
        const ROWS: usize = 64;
        let blocks = map_indices((size.height as usize).div_ceil(ROWS), |block| {
            let mut copies = Vec::new();
            let mut nearest = vec![Nearest::NONE; size.width as usize];
            let mut gaps = Vec::new();
            for row in block * ROWS..((block + 1) * ROWS).min(size.height as usize) {
                gaps.clear();
                region.gaps(row, &mut gaps);
                let rows = region.rows();
                pad_row(row, &gaps, rows, radius, size.width, &mut nearest, &mut copies);
            }
            copies
        });
        Self { size, copies: blocks.into_iter().flatten().collect() }
    }

    /// The texture size that this is for.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Gives the texels beside the islands their padding.
    ///
    /// # Panics
    /// If the texture has another size.
    pub fn apply(&self, texture: &mut Texture) {
        assert_eq!(texture.size(), self.size, "padding is for one size");
        let channels = texture.channels().count();
        match texture.texels_mut() {
            Texels::U8(values) => self.copy(values, channels),
            Texels::U16(values) => self.copy(values, channels),
            Texels::F32(values) => self.copy(values, channels),
        }
    }

    /// As [`Padding::apply`], to plain values with `C` a texel.
    pub(crate) fn fill<const C: usize>(&self, values: &mut [f32]) {
        self.copy(values, C);
    }

    /// The transpose of [`Padding::fill`]: what texels beside the islands hold goes to the texels
    /// whose value they would take, and leaves nothing behind.
    pub(crate) fn give_back<const C: usize>(&self, values: &mut [f32]) {
        for [outside, inside] in self.copies.iter().map(|copy| copy.map(|texel| texel as usize)) {
            for channel in 0..C {
                let value = std::mem::take(&mut values[outside * C + channel]);
                values[inside * C + channel] += value;
            }
        }
    }

    fn copy<T: Copy>(&self, values: &mut [T], channels: usize) {
        for [outside, inside] in self.copies.iter().map(|copy| copy.map(|texel| texel as usize)) {
            values.copy_within(inside * channels..(inside + 1) * channels, outside * channels);
        }
    }
}

/// The nearest covered texel so far of an uncovered one.
#[derive(Clone, Copy)]
struct Nearest {
    squared: u32,
    x: u32,
    row: u32,
}

impl Nearest {
    const NONE: Self = Self { squared: u32::MAX, x: 0, row: 0 };
}

/// Finds the nearest covered texel for each uncovered one of `row`; of several that are equally
/// near, the one whose row is nearest, then the upper, then the left. `nearest` has an entry for
/// each texel of the row, and is left as it was found.
fn pad_row(
    row: usize,
    gaps: &[Range<u32>],
    intervals: &[Vec<Range<u32>>],
    radius: u32,
    width: u32,
    nearest: &mut [Nearest],
    copies: &mut Vec<[u32; 2]>,
) {
    for down in 0..=radius {
        // How far to the side a row at this distance can still be near enough.
        let aside = (radius * radius - down * down).isqrt();
        let above = row.checked_sub(down as usize);
        let below = Some(row + down as usize).filter(|&row| down > 0 && row < intervals.len());
        for other in [above, below].into_iter().flatten() {
            let mut first_gap = 0;
            for interval in &intervals[other] {
                let near = interval.start.saturating_sub(aside)..(interval.end + aside).min(width);
                while first_gap < gaps.len() && gaps[first_gap].end <= near.start {
                    first_gap += 1;
                }
                for gap in gaps[first_gap..].iter().take_while(|gap| gap.start < near.end) {
                    let within = gap.start.max(near.start)..gap.end.min(near.end);
                    offer(interval, other as u32, down * down, within, nearest);
                }
            }
        }
    }
    for x in gaps.iter().cloned().flatten() {
        let found = std::mem::replace(&mut nearest[x as usize], Nearest::NONE);
        if found.squared != u32::MAX {
            copies.push([row as u32 * width + x, found.row * width + found.x]);
        }
    }
}

/// Offers the texels of an interval of another row to the uncovered texels `within` of a row.
fn offer(
    interval: &Range<u32>,
    row: u32,
    squared_down: u32,
    within: Range<u32>,
    nearest: &mut [Nearest],
) {
    let mut offer = |x: u32, inside: u32| {
        let squared = squared_down + inside.abs_diff(x).pow(2);
        let best = &mut nearest[x as usize];
        if squared < best.squared {
            *best = Nearest { squared, x: inside, row };
            return None;
        }
        Some(best.x)
    };
    for x in within.start.max(interval.start)..within.end.min(interval.end) {
        offer(x, x);
    }
    // Squared distances to two texels differ by a linear function of x. Going away from the
    // interval, once a texel that is no farther back is nearer, it stays nearer.
    let (first, last) = (interval.start, interval.end - 1);
    for x in (within.start..within.end.min(interval.start)).rev() {
        if offer(x, first).is_some_and(|other| other <= first) {
            break;
        }
    }
    for x in within.start.max(interval.end)..within.end {
        if offer(x, last).is_some_and(|other| other >= last) {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Encoding;
    use crate::islands::Islands;
    use crate::map::Coverage;
    use crate::mesh::Mesh;
    use crate::texture::Channels;

    #[test]
    fn takes_the_nearest_texel_within_the_radius() {
        let uv = vec![[0.3, 0.2], [0.72, 0.33], [0.4, 0.81], [0.9, 0.9], [0.95, 0.95], [0.9, 0.98]];
        let faces = [[0, 1, 2], [3, 4, 5]];
        let mesh = Mesh::from_triangles(vec![[0.0; 3]; 6], uv, &faces, &faces).unwrap();
        let size = Size::new(40, 31);
        let coverage = Coverage::new(&mesh, &Islands::new(&mesh), size);
        let radius = 4;
        let mut covered = vec![false; size.texels()];
        for row in 0..size.height {
            for span in coverage.row(row) {
                covered[row as usize * 40..][span.texels()].fill(true);
            }
        }
        // Each texel holds its own number; uncovered ones are far off.
        let values: Vec<f32> = (0..size.texels())
            .map(|texel| if covered[texel] { texel as f32 } else { -1.0 })
            .collect();
        let mut texture =
            Texture::new(size, Channels::Grey, Encoding::Data, Texels::F32(values)).unwrap();
        Padding::new(&Region::covered(&coverage), radius).apply(&mut texture);

        let squared = |a: usize, b: usize| {
            (a % 40).abs_diff(b % 40).pow(2) + (a / 40).abs_diff(b / 40).pow(2)
        };
        for texel in 0..size.texels() {
            let found = texture.get((texel % 40) as u32, (texel / 40) as u32, 0);
            let wanted = (0..size.texels())
                .filter(|&other| covered[other])
                .map(|other| squared(texel, other))
                .min()
                .filter(|&squared| squared <= 16);
            let found = (found >= 0.0).then(|| squared(texel, found as usize));
            assert_eq!(found, wanted, "texel {texel}");
        }
    }
}
