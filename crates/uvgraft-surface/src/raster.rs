//! Scanline rasterisation with the top-left rule: which texels a triangle owns.
//!
//! A triangle owns the texels whose centres lie inside it. Two triangles that share an edge compute
//! its crossing with a row from the same two points in the same order, so both get the same number,
//! bit for bit, and half-open spans assign every centre to exactly one of them. With rounding
//! differences instead, seams would show holes or texels that are written twice.

use std::ops::Range;

use crate::mesh::Mesh;
use crate::size::Size;

/// The corners of a face in a texture of `size`, in texels.
#[inline]
pub fn corners_px(mesh: &Mesh, face: usize, size: Size) -> [[f64; 2]; 3] {
    in_texels(mesh.uv_triangle(face), size)
}

/// UV coordinates in a texture of `size`, in texels.
#[inline]
pub fn in_texels(corners_uv: [[f32; 2]; 3], size: Size) -> [[f64; 2]; 3] {
    let scale = [f64::from(size.width), f64::from(size.height)];
    corners_uv.map(|[u, v]| [f64::from(u) * scale[0], f64::from(v) * scale[1]])
}

/// A triangle in texel coordinates, prepared for scan conversion.
#[derive(Debug, Clone)]
pub struct ScanTriangle {
    /// From the top corner to the bottom corner.
    long: Edge,
    /// From the top corner to the middle corner.
    upper: Edge,
    /// From the middle corner to the bottom corner.
    lower: Edge,
    /// Rows above this cross `upper`; rows from here on cross `lower`.
    middle_y: f64,
    rows: Range<u32>,
    width: u32,
}

/// An edge from its upper to its lower end, where upper means smaller y, then smaller x.
#[derive(Debug, Clone, Copy)]
struct Edge {
    top: [f64; 2],
    slope: f64,
}

impl Edge {
    #[inline]
    fn new(top: [f64; 2], bottom: [f64; 2]) -> Self {
        Self { top, slope: (bottom[0] - top[0]) / (bottom[1] - top[1]) }
    }

    #[inline]
    fn x_at(&self, y: f64) -> f64 {
        self.top[0] + (y - self.top[1]) * self.slope
    }
}

impl ScanTriangle {
    /// Prepares a triangle for a texture of `size`, clipped to it. `None` if the triangle has no
    /// area or lies outside all row centres, and so owns no texel.
    ///
    /// - `corners_px`: finite, in texels, with the origin at the top left corner of texel `(0, 0)`.
    #[inline]
    pub fn new(mut corners_px: [[f64; 2]; 3], size: Size) -> Option<Self> {
        let [a, b, c] = corners_px;
        let doubled_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if doubled_area == 0.0 {
            return None;
        }
        // Sort from top to bottom, then from left to right.
        for (a, b) in [(0, 1), (1, 2), (0, 1)] {
            let (first, second) = (corners_px[a], corners_px[b]);
            if second[1] < first[1] || (second[1] == first[1] && second[0] < first[0]) {
                corners_px.swap(a, b);
            }
        }
        let [top, middle, bottom] = corners_px;
        let rows = centres_between(top[1], bottom[1], size.height);
        (!rows.is_empty()).then(|| Self {
            long: Edge::new(top, bottom),
            upper: Edge::new(top, middle),
            lower: Edge::new(middle, bottom),
            middle_y: middle[1],
            rows,
            width: size.width,
        })
    }

    /// The rows in which a triangle with these corner `y` coordinates may own texels.
    #[inline]
    pub fn rows_between(corners_y_px: [f64; 3], height: u32) -> Range<u32> {
        let [a, b, c] = corners_y_px;
        centres_between(a.min(b).min(c), a.max(b).max(c), height)
    }

    /// The rows in which the triangle may own texels.
    #[inline]
    pub fn rows(&self) -> Range<u32> {
        self.rows.clone()
    }

    /// The texels of `row` that the triangle owns; empty outside [`ScanTriangle::rows`].
    #[inline]
    pub fn span(&self, row: u32) -> Range<u32> {
        if self.rows.contains(&row) { self.span_within(row) } else { 0..0 }
    }

    /// The spans of texels that the triangle owns in `rows`, for the rows where it may own any.
    #[inline]
    pub fn spans(&self, rows: &Range<u32>) -> impl Iterator<Item = (u32, Range<u32>)> {
        let rows = self.rows.start.max(rows.start)..self.rows.end.min(rows.end);
        rows.map(|row| (row, self.span_within(row)))
    }

    #[inline]
    fn span_within(&self, row: u32) -> Range<u32> {
        let y = f64::from(row) + 0.5;
        let short = if y < self.middle_y { &self.upper } else { &self.lower };
        let (a, b) = (self.long.x_at(y), short.x_at(y));
        // Branch-free, and without the NaN handling of `f64::min` and `f64::max`.
        let left = if a < b { a } else { b };
        let right = if a > b { a } else { b };
        centres_between(left, right, self.width)
    }
}

/// The texels in `0..count` whose centre `c` satisfies `from <= c < to`; `count` is at most 2³¹.
#[inline]
fn centres_between(from: f64, to: f64, count: u32) -> Range<u32> {
    // Computes `ceil(edge - 0.5)`, clamped to `0..=count`. Adding 2⁵² leaves no bits for a
    // fraction, so the low bits of the sum hold the nearest integer; if that was rounded down, 1 is
    // added. `ceil` compiles to a call where the baseline target has no instruction for it, and
    // float-to-int casts check for values that cannot occur here.
    const WHOLE: f64 = 4_503_599_627_370_496.0;
    let last = f64::from(count);
    let index = |edge: f64| {
        let shifted = edge - 0.5;
        let shifted = if shifted > 0.0 { shifted } else { 0.0 };
        let shifted = if shifted < last { shifted } else { last };
        let sum = shifted + WHOLE;
        sum.to_bits() as u32 + u32::from(sum - WHOLE < shifted)
    };
    index(from)..index(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(corners_px: [[f64; 2]; 3], size: Size) -> Vec<(u32, u32)> {
        ScanTriangle::new(corners_px, size)
            .into_iter()
            .flat_map(|scan| {
                scan.rows()
                    .flat_map(move |row| scan.span(row).map(move |x| (x, row)).collect::<Vec<_>>())
            })
            .collect()
    }

    #[test]
    fn centres_on_top_and_left_edges_are_in_and_on_the_others_out() {
        // A right triangle with its corners on the centres (0.5, 0.5), (2.5, 0.5) and (0.5, 2.5).
        let corners = [[0.5, 0.5], [2.5, 0.5], [0.5, 2.5]];
        assert_eq!(owned(corners, Size::square(4)), [(0, 0), (1, 0), (0, 1)]);
    }

    #[test]
    fn a_fan_owns_every_texel_once() {
        let mut rng = fastrand::Rng::with_seed(1);
        let size = Size::new(61, 47);
        let (w, h) = (f64::from(size.width), f64::from(size.height));
        for _ in 0..50 {
            let middle = [rng.f64() * w, rng.f64() * h];
            let ring = [[0.0, 0.0], [rng.f64() * w, 0.0], [w, 0.0], [w, h], [0.0, h]];
            let mut count = vec![0; size.texels()];
            for k in 0..ring.len() {
                for (x, y) in owned([middle, ring[(k + 1) % ring.len()], ring[k]], size) {
                    count[(y * size.width + x) as usize] += 1;
                }
            }
            assert!(count.iter().all(|&count| count == 1));
        }
    }

    #[test]
    fn centres_are_counted_exactly() {
        let wanted = |edge: f64| (edge - 0.5).ceil().clamp(0.0, 100.0) as u32;
        let near = [0.0, 0.5, 1.5, 2.0, 2.5, 3.5, 50.0, 99.5, 100.0, 100.5];
        let around = |at: f64| [at.next_down(), at, at.next_up(), at - 0.25, at + 0.25];
        let far = [-1e300, -1.0, -1e-300, 1e-300, 101.0, 1e9, 1e19, 1e300, f64::INFINITY];
        for edge in near.into_iter().flat_map(around).chain(far) {
            assert_eq!(centres_between(f64::MIN, edge, 100), 0..wanted(edge), "{edge:e}");
        }
    }

    #[test]
    fn clips_to_the_texture_and_skips_degenerate_triangles() {
        let all = owned([[-1e9, -1e9], [3e9, -1e9], [-1e9, 3e9]], Size::new(3, 2));
        assert_eq!(all.len(), 6);
        assert!(owned([[0.0, 0.0], [3.0, 3.0], [1.0, 1.0]], Size::square(4)).is_empty());
        assert!(owned([[-9.0, 0.0], [-1.0, 3.0], [-9.0, 9.0]], Size::square(4)).is_empty());
    }
}
