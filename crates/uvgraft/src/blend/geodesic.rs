//! Distances along a surface, by fast marching.
//!
//! Based on R. Kimmel and J. A. Sethian, "Computing geodesic paths on manifolds" (1998):
//! points are settled in order of distance, and a triangle with two settled corners gives
//! the third the distance of a straight front through both. Where such a front would come
//! from outside the triangle, as it may at obtuse angles, the path along an edge is used,
//! which is slightly too long.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use uvgraft_surface::surface::Surface;

/// The distance of each point from the nearest seed; infinite where no path leads, or where it
/// would be longer than `limit`.
///
/// - `seeds`: points and their initial distances; a point may occur several times.
pub(super) fn distances(
    surface: &Surface,
    seeds: impl IntoIterator<Item = (u32, f64)>,
    limit: f64,
) -> Vec<f64> {
    let mut found = vec![f64::INFINITY; surface.positions().len()];
    let mut settled = vec![false; found.len()];
    let mut queue = BinaryHeap::new();
    let relax = |point: u32, distance: f64, found: &mut [f64], queue: &mut BinaryHeap<_>| {
        if distance < found[point as usize] && distance <= limit {
            found[point as usize] = distance;
            // Distances are not negative, so their bit patterns sort like the values.
            queue.push(Reverse((distance.to_bits(), point)));
        }
    };
    for (point, distance) in seeds {
        relax(point, distance.max(0.0), &mut found, &mut queue);
    }
    while let Some(Reverse((_, point))) = queue.pop() {
        if std::mem::replace(&mut settled[point as usize], true) {
            continue;
        }
        for &triangle in surface.around(point) {
            let corners = surface.triangles()[triangle as usize];
            for third in 0..3 {
                let to = corners[third];
                if settled[to as usize] {
                    continue;
                }
                let others = [corners[(third + 1) % 3], corners[(third + 2) % 3]];
                let reached = others.map(|other| settled[other as usize]);
                let distance = if reached == [true, true] {
                    front(surface, to, others, others.map(|other| found[other as usize]))
                } else {
                    found[point as usize] + surface.length(point, to)
                };
                relax(to, distance, &mut found, &mut queue);
            }
        }
    }
    found
}

/// The distance at `to` of a straight front that passes two `others` at the given `distances`;
/// along the shorter edge path if the front does not come through the triangle.
///
/// With `V` the edges from `to` to the others, `Q = (VᵀV)⁻¹` and `t` the distances, it is the
/// larger root `d` of `(t - d·1)ᵀ Q (t - d·1) = 1`.
fn front(surface: &Surface, to: u32, others: [u32; 2], distances: [f64; 2]) -> f64 {
    let positions = surface.positions();
    let [a, b] = others.map(|other| positions[other as usize] - positions[to as usize]);
    let along_edges = (distances[0] + a.length()).min(distances[1] + b.length());
    let (aa, ab, bb) = (a.length_squared(), a.dot(b), b.length_squared());
    let determinant = aa * bb - ab * ab;
    // A triangle without area has no front.
    if determinant <= 1e-12 * aa * bb {
        return along_edges;
    }
    let [p, q] = distances;
    let inverse = [bb, -ab, aa].map(|value| value / determinant);
    let [one_one, one_d, d_d] = [
        inverse[0] + 2.0 * inverse[1] + inverse[2],
        inverse[0] * p + inverse[1] * (p + q) + inverse[2] * q,
        inverse[0] * p * p + 2.0 * inverse[1] * p * q + inverse[2] * q * q,
    ];
    let under_root = one_d * one_d - one_one * (d_d - 1.0);
    if under_root < 0.0 {
        return along_edges;
    }
    let distance = (one_d + under_root.sqrt()) / one_one;
    // The front comes through the triangle where its origin lies between both edges.
    let back = [p - distance, q - distance];
    let weights =
        [inverse[0] * back[0] + inverse[1] * back[1], inverse[1] * back[0] + inverse[2] * back[1]];
    if weights[0] <= 0.0 && weights[1] <= 0.0 { distance.min(along_edges) } else { along_edges }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;

    use super::*;

    /// A sheet of `side × side` squares with diagonals in alternating directions and jittered
    /// corners, mapped into space by `place`.
    fn sheet(side: u32, jitter: f64, place: impl Fn([f64; 2]) -> [f64; 3]) -> Surface {
        let mut rng = fastrand::Rng::with_seed(7);
        let mut positions = Vec::new();
        for y in 0..=side {
            for x in 0..=side {
                let at = [x, y].map(|k| {
                    let inner = if k == 0 || k == side { 0.0 } else { jitter };
                    (f64::from(k) + (rng.f64() - 0.5) * inner) / f64::from(side)
                });
                positions.push(place(at).map(|value| value as f32));
            }
        }
        let mut faces = Vec::new();
        for y in 0..side {
            for x in 0..side {
                let [a, b, c, d] =
                    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (y + dy) * (side + 1) + x + dx);
                if (x + y) % 2 == 0 {
                    faces.extend([[a, b, d], [a, d, c]]);
                } else {
                    faces.extend([[a, b, c], [b, d, c]]);
                }
            }
        }
        let uv = vec![[0.0; 2]; positions.len()];
        Surface::new(&Mesh::from_triangles(positions, uv, &faces, &faces).unwrap())
    }

    #[test]
    fn straight_fronts_are_exact_and_round_ones_close() {
        // Rolled up, which leaves distances along the surface unchanged.
        let rolled = |[x, y]: [f64; 2]| [x.sin(), y, x.cos()];
        for (jitter, straight, round) in [(0.0, 0.001, 0.03), (0.8, 0.015, 0.04)] {
            let surface = sheet(60, jitter, rolled);
            let at = |point: usize| {
                let at = surface.positions()[point];
                [at.x.atan2(at.z), at.y]
            };
            let edge = (0..surface.positions().len() as u32)
                .filter(|&point| at(point as usize)[0] < 1e-9)
                .map(|point| (point, 0.0));
            let found = distances(&surface, edge, f64::INFINITY);
            let worst = (0..found.len()).map(|point| (found[point] - at(point)[0]).abs());
            assert!(worst.fold(0.0, f64::max) < straight);

            let found = distances(&surface, [(0, 0.0)], f64::INFINITY);
            let wanted = |point: usize| at(point)[0].hypot(at(point)[1]);
            let worst = (0..found.len()).map(|point| (found[point] - wanted(point)).abs());
            assert!(worst.fold(0.0, f64::max) < round);
        }
    }

    #[test]
    fn stops_at_the_limit_and_without_seeds() {
        let surface = sheet(4, 0.0, |[x, y]| [x, y, 0.0]);
        let found = distances(&surface, [(0, 0.1)], 0.5);
        assert_eq!(found[0], 0.1);
        assert!((found[1] - 0.35).abs() < 1e-12);
        assert_eq!(found[4], f64::INFINITY);
        assert!(distances(&surface, [], 1.0).iter().all(|distance| distance.is_infinite()));
    }
}
