//! The outline of a painted mask on a surface: where it crosses the edges of triangles.

use glam::DVec3;
use uvgraft_surface::piece::Weights;
use uvgraft_surface::surface::Surface;

use crate::sampler::Sampler;
use crate::texture::Texture;

/// Steps in which an edge is sampled.
const STEPS: usize = 16;

/// Where a triangle lies in a mask's layout.
#[derive(Debug, Clone, Copy)]
pub(super) enum MaskUv {
    /// Not in the layout at all.
    Unmapped,
    /// At these corners.
    Triangle([[f32; 2]; 3]),
    /// Piece by piece, as `uv` of [`level`] gives it.
    Pieces,
}

/// The centroid of a triangle, as barycentric weights.
const CENTROID: Weights = [1.0 / 3.0; 3];

/// A level at each point whose zero, linear along edges, is where a mask's brightness falls below a
/// half; positive where it is bright. Near the outline it is the distance along the nearest edge.
///
/// Each point is bright or dark by a majority vote of its triangles, which sample different texels.
/// Along an edge between bright and dark the crossing is half a step before the first dark sample.
///
/// - `mask_uv`: where each triangle lies.
/// - `uv`: where a point of a triangle lies that lies piece by piece, by its weights.
pub(super) fn level(
    surface: &Surface,
    mask_uv: &[MaskUv],
    uv: impl Fn(usize, Weights) -> Option<[f64; 2]>,
    mask: &Texture,
) -> Vec<f64> {
    let sampler = Sampler::new(mask);
    let is_bright_at = |uv: [f64; 2]| sampler.brightness(uv) >= 0.5;
    // Whether a triangle is bright between two of its corners. Outside its islands a mask may hold
    // anything, so corners are sampled from slightly inside.
    let is_bright = |face: usize, from: usize, to: usize, t: f64| match mask_uv[face] {
        MaskUv::Unmapped => false,
        MaskUv::Triangle(corners) => {
            let corners = corners.map(|corner| corner.map(f64::from));
            let center = [0, 1].map(|k| corners.iter().map(|at| at[k]).sum::<f64>() / 3.0);
            let [from, to] = [from, to].map(|corner| mix(corners[corner], center, 0.02));
            is_bright_at(mix(from, to, t))
        }
        MaskUv::Pieces => {
            let [from, to] = [from, to].map(|corner| {
                let corner: Weights = std::array::from_fn(|k| f64::from(u8::from(k == corner)));
                mix(corner, CENTROID, 0.02)
            });
            uv(face, mix(from, to, t)).is_some_and(is_bright_at)
        }
    };
    let mut votes = vec![0_i32; surface.positions().len()];
    for (face, corners) in surface.triangles().iter().enumerate() {
        for (corner, &point) in corners.iter().enumerate() {
            votes[point as usize] += if is_bright(face, corner, corner, 0.0) { 1 } else { -1 };
        }
    }
    let is_in: Vec<bool> = votes.into_iter().map(|votes| votes > 0).collect();
    let mut level: Vec<f64> =
        is_in.iter().map(|&is_in| if is_in { f64::INFINITY } else { f64::NEG_INFINITY }).collect();
    for (face, corners) in surface.triangles().iter().enumerate() {
        for k in 0..3 {
            let (from, to) = (k, (k + 1) % 3);
            let (a, b) = (corners[from], corners[to]);
            if is_in[a as usize] == is_in[b as usize] {
                continue;
            }
            let (from, to) = if is_in[a as usize] { (from, to) } else { (to, from) };
            // In a triangle that the mask's layout lacks, the region ends at the bright point.
            let crossing = if matches!(mask_uv[face], MaskUv::Unmapped) {
                0.0
            } else {
                let steps = (0..=STEPS).map(|step| step as f64 / STEPS as f64);
                let mut dark = steps.filter(|&t| !is_bright(face, from, to, t));
                dark.next().map_or(1.0, |t| (t - 0.5 / STEPS as f64).max(0.0))
            };
            let length = surface.length(a, b);
            for (corner, distance) in [(from, crossing), (to, crossing - 1.0)] {
                let level = &mut level[corners[corner] as usize];
                if (distance * length).abs() < level.abs() {
                    *level = distance * length;
                }
            }
        }
    }
    level
}

fn mix<const N: usize>(a: [f64; N], b: [f64; N], t: f64) -> [f64; N] {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

/// The distances of a triangle's corners from the zero line of a value that is given at the corners
/// and linear in between; `None` for triangles without one.
pub(super) fn distances_to_contour(corners: [DVec3; 3], levels: [f64; 3]) -> [Option<f64>; 3] {
    let mut ends = [DVec3::ZERO; 3];
    let mut count = 0;
    let mut push = |end: DVec3| {
        if count < ends.len() {
            ends[count] = end;
            count += 1;
        }
    };
    for k in 0..3 {
        let (a, b) = (levels[k], levels[(k + 1) % 3]);
        if a == 0.0 {
            push(corners[k]);
        } else if a * b < 0.0 {
            let t = if a.is_finite() && b.is_finite() { a / (a - b) } else { 0.5 };
            push(corners[k].lerp_monotonic(corners[(k + 1) % 3], t));
        }
    }
    match count {
        0 => [None; 3],
        1 => levels.map(|level| (level == 0.0).then_some(0.0)),
        2 => corners.map(|corner| Some(to_segment(corner, ends[0], ends[1]))),
        // The whole triangle is on the contour.
        _ => [Some(0.0); 3],
    }
}

fn to_segment(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (along, from) = (b - a, point - a);
    let squared = along.length_squared();
    let t = if squared > 0.0 { (from.dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (from - along * t).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_by_hand() {
        let corners = [DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y];
        // Halfway between the first corner and the others.
        let found = distances_to_contour(corners, [1.0, -1.0, -1.0]).map(Option::unwrap);
        assert!((found[0] - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(found[1], 2.0);
        // Along an edge, and through a corner.
        let found = distances_to_contour(corners, [0.0, 0.0, f64::INFINITY]);
        assert_eq!(found, [Some(0.0), Some(0.0), Some(4.0)]);
        let found = distances_to_contour(corners, [0.0, 1.0, 1.0]);
        assert_eq!(found, [Some(0.0), None, None]);
        assert_eq!(distances_to_contour(corners, [1.0; 3]), [None; 3]);
    }
}
