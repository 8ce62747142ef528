//! Interpolation of tangent frames along a run of texels.

use super::frames::{Frames, PieceFrames};
use super::options::{NormalOptions, NormalY};
use crate::map::{Run, SamplingMap};

/// Frames vary linearly along a run: those at its first texel, and their change per texel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    pub first: Frames,
    pub step: Frames,
    /// The signs of the bitangents of source and target, negated where green points down.
    pub signs: [f32; 2],
}

impl Walk {
    #[inline(always)]
    pub fn new(
        piece: &PieceFrames,
        options: NormalOptions,
        map: &SamplingMap,
        row: u32,
        run: Run,
    ) -> Self {
        let size = map.size();
        let scale = [f64::from(size.width), f64::from(size.height)];
        let triangle = Triangle::new(piece.tgt_uv.map(|uv| [0, 1].map(|k| uv[k] * scale[k])));
        let is_gutter = map.is_gutter(run);
        let at = |x: u32| {
            let px = [f64::from(x) + 0.5, f64::from(row) + 0.5];
            let weights =
                if is_gutter { triangle.nearest(px) } else { clamped(triangle.weights(px)) };
            interpolated(&piece.corners, weights)
        };
        let first = at(run.x);
        let mut step = Frames::default();
        // Both ends lie in the triangle, so everything between does. In the gutter too: the
        // nearest points of a run next to an edge lie along that edge, of one around a corner at
        // the corner.
        if run.len > 1 {
            let last = at(run.x + (run.len - 1));
            let share = 1.0 / (run.len - 1) as f32;
            let ends = first.as_flattened().iter().zip(last.as_flattened());
            for (step, (first, last)) in step.as_flattened_mut().iter_mut().zip(ends) {
                *step = (last - first) * share;
            }
        }
        let y = |y: NormalY| match y {
            NormalY::OpenGl => 1.0,
            NormalY::DirectX => -1.0,
        };
        let signs = [piece.signs[0] * y(options.source), piece.signs[1] * y(options.target)];
        Self { first, step, signs }
    }
}

#[inline(always)]
fn interpolated(corners: &[Frames; 3], weights: [f64; 3]) -> Frames {
    let weights = weights.map(|weight| weight as f32);
    let [a, b, c] = corners;
    let mut interpolated = Frames::default();
    for vector in 0..4 {
        for axis in 0..3 {
            interpolated[vector][axis] = a[vector][axis] * weights[0]
                + b[vector][axis] * weights[1]
                + c[vector][axis] * weights[2];
        }
    }
    interpolated
}

/// Clamps barycentric coordinates to the triangle: centres of covered texels are outside only by
/// rounding.
#[inline(always)]
fn clamped([_, b, c]: [f64; 3]) -> [f64; 3] {
    let (b, c) = (b.clamp(0.0, 1.0), c.clamp(0.0, 1.0));
    let sum = b + c;
    if sum > 1.0 { [0.0, b / sum, c / sum] } else { [1.0 - sum, b, c] }
}

/// A triangle of the target layout, in texels.
struct Triangle {
    corners: [[f64; 2]; 3],
}

impl Triangle {
    #[inline(always)]
    fn new(corners: [[f64; 2]; 3]) -> Self {
        Self { corners }
    }

    /// Barycentric coordinates; not finite for a triangle without area.
    #[inline(always)]
    fn weights(&self, px: [f64; 2]) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let [p, q, r] = [b, c, px].map(|point| [point[0] - a[0], point[1] - a[1]]);
        let area = 1.0 / (p[0] * q[1] - p[1] * q[0]);
        let b = (r[0] * q[1] - r[1] * q[0]) * area;
        let c = (p[0] * r[1] - p[1] * r[0]) * area;
        [1.0 - b - c, b, c]
    }

    /// Barycentric coordinates of the point of the triangle that is nearest to `px`.
    fn nearest(&self, px: [f64; 2]) -> [f64; 3] {
        let weights = self.weights(px);
        if weights.iter().all(|&weight| weight >= 0.0) {
            return weights;
        }
        let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
        for k in 0..3 {
            let next = (k + 1) % 3;
            let (from, to) = (self.corners[k], self.corners[next]);
            let along = [to[0] - from[0], to[1] - from[1]];
            let offset = [px[0] - from[0], px[1] - from[1]];
            let squared_length = along[0] * along[0] + along[1] * along[1];
            let t = (offset[0] * along[0] + offset[1] * along[1]) / squared_length;
            // NaN, of an edge without length, becomes its first end.
            let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
            let away = [offset[0] - t * along[0], offset[1] - t * along[1]];
            let distance = away[0] * away[0] + away[1] * away[1];
            if distance < best.0 {
                let mut weights = [0.0; 3];
                weights[k] = 1.0 - t;
                weights[next] = t;
                best = (distance, weights);
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_lies_in_the_triangle() {
        let triangle = Triangle::new([[10.0, 10.0], [20.0, 10.0], [10.0, 30.0]]);
        let cases = [
            ([13.0, 5.0], [0.7, 0.3, 0.0]),
            ([4.0, 15.0], [0.75, 0.0, 0.25]),
            ([2.0, 3.0], [1.0, 0.0, 0.0]),
            ([30.0, 9.0], [0.0, 1.0, 0.0]),
            ([11.0, 12.0], [0.8, 0.1, 0.1]),
            // Next to the midpoint of the long edge, at right angles to it.
            ([19.0, 22.0], [0.0, 0.5, 0.5]),
        ];
        for (px, wanted) in cases {
            let found = triangle.nearest(px);
            let close = (0..3).all(|k| (found[k] - wanted[k]).abs() < 1e-12);
            assert!(close, "{px:?}: {found:?}, wanted {wanted:?}");
        }
        let point = Triangle::new([[3.0, 3.0]; 3]);
        assert_eq!(point.nearest([5.0, 5.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn rounding_stays_inside() {
        assert_eq!(clamped([-1e-9, 0.5, 0.5 + 1e-9])[0], 0.0);
        assert_eq!(clamped([1.0, -1e-9, 1e-9]), [1.0 - 1e-9, 0.0, 1e-9]);
        assert_eq!(clamped([0.25, 0.5, 0.25]), [0.25, 0.5, 0.25]);
    }

    #[test]
    fn frames_are_mixed_by_weight() {
        let corner = |first: f32| -> Frames {
            std::array::from_fn(|vector| {
                std::array::from_fn(|axis| first * (1 + 3 * vector + axis) as f32)
            })
        };
        let found = interpolated(&[corner(1.0), corner(2.0), corner(4.0)], [0.5, 0.25, 0.25]);
        assert_eq!(found, corner(2.0));
    }
}
