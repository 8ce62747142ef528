//! Profiles of shapes as curves through control points.

/// A cubic Hermite spline through `(x, value)` knots in ascending `x`, with central-difference
/// slopes; constant beyond both ends.
pub(crate) fn curve(knots: &[(f32, f32)], x: f32) -> f32 {
    let after = knots.partition_point(|knot| knot.0 <= x);
    if after == 0 {
        return knots[0].1;
    }
    if after == knots.len() {
        return knots[after - 1].1;
    }
    let (a, b) = (knots[after - 1], knots[after]);
    let slope = |i: usize| {
        let (low, high) = (knots[i.saturating_sub(1)], knots[(i + 1).min(knots.len() - 1)]);
        (high.1 - low.1) / (high.0 - low.0)
    };
    let width = b.0 - a.0;
    let t = (x - a.0) / width;
    let (t2, t3) = (t * t, t * t * t);
    a.1 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + b.1 * (3.0 * t2 - 2.0 * t3)
        + slope(after - 1) * width * (t3 - 2.0 * t2 + t)
        + slope(after) * width * (t3 - t2)
}
