//! Free space in a UV layout: rectangles that keep their distance from every island.
//!
//! Occupancy is rasterised once, on a grid of fixed size, so that a chart gets the same UV
//! coordinates whatever the resolution of the texture it is painted on.

use uvgraft::raster::ScanTriangle;
use uvgraft::{Mesh, Size};

/// Cells along each side of the occupancy grid.
const SIDE: usize = 1024;

/// Margin in cells kept free around a rectangle: 16 texels of a 2048 x 2048 texture,
/// half of which are the rectangle's own gutter.
const MARGIN: usize = 8;

/// Factor by which the chart shrinks after each failed attempt.
const SHRINK: f32 = 0.93;

/// Occupancy of a UV layout, for placing additional charts.
#[derive(Debug, Clone)]
pub struct FreeSpace {
    taken: Vec<bool>,
}

/// A rectangle in a layout, in UV units with the origin at the top left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChartRect {
    /// Its left edge.
    pub left: f32,
    /// Its upper edge.
    pub top: f32,
    /// Its width as laid out, after any rotation.
    pub width: f32,
    /// Its height as laid out, after any rotation.
    pub height: f32,
    /// Whether the chart is rotated by a quarter turn.
    pub turned: bool,
}

impl ChartRect {
    /// How far a chart may be painted beyond its rectangle, in UV units, without reaching another
    /// chart's gutter.
    pub const GUTTER: f32 = (MARGIN / 2 - 1) as f32 / SIDE as f32;

    /// Maps a point of the chart to UV coordinates.
    ///
    /// - `at`: position along the chart's width and down its height, each in `0.0..=1.0`.
    pub fn uv(&self, [s, t]: [f32; 2]) -> [f32; 2] {
        let [x, y] = if self.turned { [1.0 - t, s] } else { [s, t] };
        [self.left + x * self.width, self.top + y * self.height]
    }

    /// Maps UV coordinates to a point of the chart: the inverse of [`ChartRect::uv`].
    pub fn at(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [x, y] = [(u - self.left) / self.width, (v - self.top) / self.height];
        if self.turned { [y, 1.0 - x] } else { [x, y] }
    }
}

impl FreeSpace {
    /// Rasterises the triangles of a layout.
    pub fn of(mesh: &Mesh) -> Self {
        let mut taken = vec![false; SIDE * SIDE];
        let size = Size::square(SIDE as u32);
        for face in 0..mesh.faces().len() {
            let corners = mesh.uv_triangle(face).map(|uv| uv.map(|v| f64::from(v) * SIDE as f64));
            // Slivers may cover no cell centre, so the cells of the corners are always marked.
            for [x, y] in corners {
                let cell = |value: f64| (value.max(0.0) as usize).min(SIDE - 1);
                taken[cell(y) * SIDE + cell(x)] = true;
            }
            let Some(scan) = ScanTriangle::new(corners, size) else { continue };
            for (row, span) in scan.spans(&(0..size.height)) {
                let first = row as usize * SIDE;
                taken[first + span.start as usize..first + span.end as usize].fill(true);
            }
        }
        Self { taken }
    }

    /// Finds room for a chart and reserves it: the largest rectangle up to `widest`, upright or
    /// rotated. `None` if nothing as wide as `narrowest` fits.
    ///
    /// - `aspect`: the chart's width divided by its height.
    /// - `widest`, `narrowest`: limits of the chart's own width, in UV units.
    pub fn place(&mut self, aspect: f32, widest: f32, narrowest: f32) -> Option<ChartRect> {
        let sums = self.sums();
        let mut width = widest;
        while width >= narrowest {
            let cells = |side: f32| ((side * SIDE as f32).ceil() as usize).max(1);
            let (w, h) = (cells(width), cells(width / aspect));
            for (w, h, turned) in [(w, h, false), (h, w, true)] {
                if let Some((x, y)) = first_free(&sums, w, h) {
                    for row in y..y + h {
                        self.taken[row * SIDE + x..row * SIDE + x + w].fill(true);
                    }
                    let unit = |cells: usize| cells as f32 / SIDE as f32;
                    let (left, top, width, height) = (unit(x), unit(y), unit(w), unit(h));
                    return Some(ChartRect { left, top, width, height, turned });
                }
            }
            width *= SHRINK;
        }
        None
    }

    /// Column-wise prefix sums of the occupied cells, with one row more than the grid: a run of
    /// cells in a column is free if the sums at its two ends are equal.
    fn sums(&self) -> Vec<u16> {
        let mut sums = vec![0; (SIDE + 1) * SIDE];
        for (at, &is_taken) in self.taken.iter().enumerate() {
            sums[at + SIDE] = sums[at] + u16::from(is_taken);
        }
        sums
    }
}

/// Finds the first free rectangle of `w` by `h` cells with its margin, in row-major order. Half the
/// margin is enough at the edge of the layout, since no other chart has a gutter there.
///
/// Columns are tested from right to left: the rectangle has to move past the rightmost occupied
/// column anyway, so most columns are never tested.
fn first_free(sums: &[u16], w: usize, h: usize) -> Option<(usize, usize)> {
    let edge = MARGIN / 2;
    if w + MARGIN > SIDE || h + MARGIN > SIDE {
        return None;
    }
    for y in edge..=SIDE - edge - h {
        let (top, bottom) = (y.saturating_sub(MARGIN), (y + h + MARGIN).min(SIDE));
        let is_taken = |column: &usize| sums[top * SIDE + column] != sums[bottom * SIDE + column];
        let mut x = edge;
        while x <= SIDE - edge - w {
            let (left, right) = (x.saturating_sub(MARGIN), (x + w + MARGIN).min(SIDE));
            match (left..right).rev().find(is_taken) {
                Some(column) => x = column + 1 + MARGIN,
                None => return Some((x, y)),
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rectangular islands given as `[left, top, right, bottom]`.
    fn layout(rectangles: &[[f32; 4]]) -> Mesh {
        let (mut uv, mut faces) = (Vec::new(), Vec::new());
        for &[left, top, right, bottom] in rectangles {
            let first = uv.len() as u32;
            uv.extend([[left, top], [right, top], [right, bottom], [left, bottom]]);
            faces.extend([[0, 1, 2], [0, 2, 3]].map(|face| face.map(|k: u32| k + first)));
        }
        Mesh::from_triangles(vec![[0.0; 3]; uv.len()], uv, &faces, &faces).unwrap()
    }

    #[test]
    fn places_keep_away_from_islands_and_each_other() {
        let islands = [[0.0, 0.0, 0.66, 1.0], [0.66, 0.5, 1.0, 1.0]];
        let mut free = FreeSpace::of(&layout(&islands));
        let mut found: Vec<[f32; 4]> = islands.to_vec();
        for _ in 0..4 {
            let place = free.place(2.0, 0.2, 0.1).unwrap();
            let ChartRect { left, top, width, height, turned } = place;
            let (own_width, own_height) = if turned { (height, width) } else { (width, height) };
            assert!(
                (0.1..0.203).contains(&own_width) && (own_width / own_height - 2.0).abs() < 0.05
            );
            assert!(left > 0.0 && top > 0.0 && left + width < 1.0 && top + height < 1.0);
            let gap = MARGIN as f32 / SIDE as f32 - 1e-6;
            for [l, t, r, b] in &found {
                let apart = (left - r).max(l - left - width).max(top - b).max(t - top - height);
                assert!(apart >= gap, "{place:?} is {apart} from an island");
            }
            found.push([left, top, left + width, top + height]);
            for at in [[0.0, 0.0], [0.3, 0.8]] {
                let [s, t] = place.at(place.uv(at));
                assert!((s - at[0]).abs() < 1e-4 && (t - at[1]).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn charts_that_do_not_fit_upright_are_rotated_or_refused() {
        let mut free = FreeSpace::of(&layout(&[[0.0, 0.0, 0.8, 1.0]]));
        let place = free.place(4.0, 0.5, 0.5).unwrap();
        assert!(place.turned && place.height > place.width);
        assert_eq!(FreeSpace::of(&layout(&[[0.0, 0.0, 1.0, 1.0]])).place(1.0, 0.1, 0.02), None);
    }
}
