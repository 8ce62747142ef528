//! Values at the points of a surface, interpolated at the texels of a map.

use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::raster::corners_px;
use uvgraft_surface::surface::Surface;
use uvgraft_surface::threads::map_indices;

use crate::map::{Patch, SamplingMap};

/// A value that is linear over the texels of a triangle. Outside the triangle, in its gutter, it is
/// clamped to the range of the corner values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinearValue {
    origin_px: [f64; 2],
    at_origin: f64,
    by_px: [f64; 2],
    least: f32,
    most: f32,
}

/// A [`LinearValue`] along the texels of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    start: f32,
    step: f32,
    least: f32,
    most: f32,
}

impl LinearValue {
    /// The same value everywhere.
    pub fn constant(value: f32) -> Self {
        let at_origin = f64::from(value);
        Self { origin_px: [0.0; 2], at_origin, by_px: [0.0; 2], least: value, most: value }
    }

    /// From the values at the corners of a triangle; their mean if it has no area.
    pub(super) fn new(corners_px: [[f64; 2]; 3], values: [f32; 3]) -> Self {
        let [a, b, c] = values.map(f64::from);
        let [p, q] = [1, 2].map(|k| [0, 1].map(|axis| corners_px[k][axis] - corners_px[0][axis]));
        let determinant = p[0] * q[1] - p[1] * q[0];
        let by_px = [
            ((b - a) * q[1] - (c - a) * p[1]) / determinant,
            ((c - a) * p[0] - (b - a) * q[0]) / determinant,
        ];
        if !by_px.iter().all(|value| value.is_finite()) {
            return Self::constant(((a + b + c) / 3.0) as f32);
        }
        Self {
            origin_px: corners_px[0],
            at_origin: a,
            by_px,
            least: values.into_iter().fold(f32::INFINITY, f32::min),
            most: values.into_iter().fold(f32::NEG_INFINITY, f32::max),
        }
    }

    /// The values along a row, from texel `x` on.
    #[inline(always)]
    pub fn line(&self, x: u32, row: u32) -> Line {
        if self.least == self.most {
            return Line::level(self.least);
        }
        let offset = [x, row].map(|px| f64::from(px) + 0.5);
        let start = self.at_origin
            + self.by_px[0] * (offset[0] - self.origin_px[0])
            + self.by_px[1] * (offset[1] - self.origin_px[1]);
        Line { start: start as f32, step: self.by_px[0] as f32, least: self.least, most: self.most }
    }

    /// Whether it is `value` everywhere.
    pub fn is_constant(&self, value: f32) -> bool {
        self.least == value && self.most == value
    }
}

impl Line {
    /// 1 at every texel.
    pub const ONE: Self = Self::level(1.0);

    /// The same value at every texel.
    const fn level(value: f32) -> Self {
        Self { start: value, step: 0.0, least: value, most: value }
    }

    /// Whether it is the same at every texel.
    pub fn is_level(&self) -> bool {
        self.step == 0.0 || self.least == self.most
    }

    /// The value at the run's texel `k`.
    #[inline(always)]
    pub fn at(&self, k: u32) -> f32 {
        // Vectors of unsigned integers are slow to convert.
        let value = self.start + self.step * k as i32 as f32;
        // Steep slopes overshoot the bounds within a texel.
        value.max(self.least).min(self.most)
    }
}

/// One value for each patch of a map.
///
/// - `value`: the value at a point of a triangle, from the indices of the triangle and the point.
pub(crate) fn linear_values<const N: usize>(
    map: &SamplingMap,
    mesh: &Mesh,
    surface: &Surface,
    value: impl Fn(u32, u32) -> [f32; N] + Sync,
) -> Vec<[LinearValue; N]> {
    let patches = map.patches();
    /// Patches in one unit of parallel work.
    const CHUNK: usize = 1024;
    let chunks = map_indices(patches.len().div_ceil(CHUNK), |chunk| {
        let patches = &patches[chunk * CHUNK..((chunk + 1) * CHUNK).min(patches.len())];
        let values = patches.iter().map(|Patch { face, .. }| {
            let corners_px = corners_px(mesh, *face as usize, map.size());
            let values = surface.triangles()[*face as usize].map(|point| value(*face, point));
            std::array::from_fn(|n| LinearValue::new(corners_px, values.map(|values| values[n])))
        });
        values.collect::<Vec<_>>()
    });
    chunks.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_by_hand() {
        let corners = [[10.0, 10.0], [20.0, 10.0], [10.0, 30.0]];
        let value = LinearValue::new(corners, [1.0, 3.0, 5.0]);
        // 0.2 per texel to the right, 0.2 per texel down.
        let line = value.line(12, 14);
        assert!((line.at(0) - (1.0 + 0.2 * 2.5 + 0.2 * 4.5)).abs() < 1e-6);
        assert!((line.at(3) - line.at(0) - 0.6).abs() < 1e-6);
        // Outside the triangle.
        assert_eq!(value.line(0, 0).at(0), 1.0);
        assert_eq!(value.line(90, 90).at(0), 5.0);
        assert!(LinearValue::new([[1.0; 2], [2.0; 2], [3.0; 2]], [0.0, 1.0, 5.0]).is_constant(2.0));
    }
}
