//! Screen-space ambient occlusion: the fraction of the sky that nearby surfaces leave visible.

use std::f32::consts::TAU;

use uvgraft::easing::smoothstep;
use uvgraft::{Size, threads};
use uvgraft_avatar::paint::noise::random;

use super::camera::Camera;
use super::depth::DepthMap;

const TAPS: usize = 14;

/// A place to compare depths with, relative to a pixel.
#[derive(Debug, Clone, Copy, Default)]
struct Tap {
    direction: [f32; 2],
    /// Distance, in mesh units.
    reach: f32,
}

/// Ambient occlusion for each pixel of a picture: 1 where nothing is in front, towards 0 in folds.
///
/// Each pixel compares its depth with 14 taps on a spiral around it (golden-angle steps of 2.4
/// radians), out to about 5 cm. The fraction it loses grows with the slope from pixel to tap.
/// Each pixel of a 4 × 4 tile rotates the spiral by another random angle, and a blur over the
/// tile then averages the pattern away.
///
/// - `map`: depths of the same view, a whole number of times as fine as the picture.
/// - `step`: distance between the samples of the map, in samples of the camera.
/// - `metre`: length of one metre in mesh units.
pub(crate) fn occlusion(
    map: &DepthMap,
    camera: &Camera,
    step: u32,
    metre: f32,
    size: Size,
) -> Vec<f32> {
    let scale = (map.size.width / size.width) as usize;
    let width = size.width as usize;
    let spirals: Vec<[Tap; TAPS]> = (0..16).map(|k| spiral(k % 4, k / 4, metre)).collect();
    let mut heights = vec![f32::NEG_INFINITY; size.texels()];
    let mut open = vec![1.0; size.texels()];
    let rows = heights.chunks_mut(width).zip(open.chunks_mut(width));
    threads::for_each(rows, |y, (heights, open)| {
        let depths = map.row((y * scale) as u32);
        for (x, (height, open)) in heights.iter_mut().zip(open).enumerate() {
            let depth = depths[x * scale];
            if depth == f32::NEG_INFINITY {
                continue;
            }
            let here = camera.height_of(depth);
            *height = here;
            let per_unit = 1.0 / (camera.unit_per_px(depth) * step as f32);
            let mut hidden = 0.0;
            for tap in &spirals[y % 4 * 4 + x % 4] {
                let steps = tap.reach * per_unit;
                let [dx, dy] = tap.direction.map(|along| (along * steps) as i32);
                let there = map.depth((x * scale) as i32 + dx, (y * scale) as i32 + dy);
                // Nothing is hidden by what is as far away or farther.
                if there <= depth {
                    continue;
                }
                let rise = (camera.height_of(there) - here) / tap.reach;
                // Surfaces far in front do not occlude.
                if rise > 0.15 && rise < 4.0 {
                    hidden += smoothstep(0.15, 1.3, rise) * smoothstep(4.0, 2.0, rise);
                }
            }
            *open = 1.0 - hidden / TAPS as f32;
        }
    });
    smoothed(&open, &heights, 0.008 * metre, size)
}

/// The taps of a pixel, by its place in its tile.
fn spiral(x: i32, y: i32, metre: f32) -> [Tap; TAPS] {
    let turn = random(x, y, 0, 101) * TAU;
    std::array::from_fn(|tap| {
        let (sin, cos) = (turn + tap as f32 * 2.4).sin_cos();
        // Radii from a few millimetres to a few centimetres.
        let reach = metre * (0.004 + 0.05 * ((tap as f32 + 0.5) / TAPS as f32).powi(2));
        Tap { direction: [cos, sin], reach }
    })
}

/// Averages over the 4 × 4 pixels in which the tap rotation repeats, skipping pixels at another
/// depth (by `near` or more) so that silhouettes do not bleed.
fn smoothed(open: &[f32], heights: &[f32], near: f32, size: Size) -> Vec<f32> {
    let (width, height) = (size.width as usize, size.height as usize);
    let mut result = vec![1.0; size.texels()];
    let sums = || (vec![0.0_f32; width], vec![0.0_f32; width]);
    threads::for_each_with(result.chunks_mut(width), sums, |(sum, count), y, result| {
        let here = &heights[y * width..][..width];
        if here.iter().all(|&height| height == f32::NEG_INFINITY) {
            return;
        }
        sum.fill(0.0);
        count.fill(0.0);
        for row in y.saturating_sub(2)..(y + 2).min(height) {
            // Whole rows, shifted by -2 to 1 columns, so that several pixels are done at once.
            for shift in 0..4_usize {
                let (to, from) = (2_usize.saturating_sub(shift), shift.saturating_sub(2));
                let length = width.saturating_sub(to.max(from));
                let (to, from) = (to.min(width), row * width + from.min(width));
                let there = heights[from..][..length].iter().zip(&open[from..][..length]);
                let own = here[to..][..length].iter();
                let sums = sum[to..][..length].iter_mut().zip(&mut count[to..][..length]);
                for (((sum, count), here), (there, open)) in sums.zip(own).zip(there) {
                    let is_near = (there - here).abs() < near;
                    *sum += if is_near { *open } else { 0.0 };
                    *count += if is_near { 1.0 } else { 0.0 };
                }
            }
        }
        for (((result, sum), count), here) in result.iter_mut().zip(&*sum).zip(&*count).zip(here) {
            if *here > f32::NEG_INFINITY {
                *result = sum / count.max(1.0);
            }
        }
    });
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition: each pixel for itself.
    fn reference(open: &[f32], heights: &[f32], near: f32, size: Size, x: i32, y: i32) -> f32 {
        let index = |x: i32, y: i32| (y * size.width as i32 + x) as usize;
        let here = heights[index(x, y)];
        if here == f32::NEG_INFINITY {
            return 1.0;
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for (dx, dy) in (-2..2).flat_map(|dy| (-2..2).map(move |dx| (dx, dy))) {
            let (column, row) = (x + dx, y + dy);
            let is_inside =
                (0..size.width as i32).contains(&column) && (0..size.height as i32).contains(&row);
            if is_inside && (heights[index(column, row)] - here).abs() < near {
                sum += open[index(column, row)];
                count += 1.0;
            }
        }
        sum / count
    }

    #[test]
    fn the_blur_is_the_mean_of_the_tile_at_the_same_depth() {
        let mut rng = fastrand::Rng::with_seed(5);
        let sizes = [(1, 1), (1, 9), (2, 2), (3, 5), (4, 1), (9, 7), (33, 20)];
        for (width, height) in sizes {
            let size = Size::new(width, height);
            for _ in 0..20 {
                let open: Vec<f32> = (0..size.texels()).map(|_| rng.f32()).collect();
                let levels = [0.0, 0.05, 0.3, f32::NEG_INFINITY];
                let heights: Vec<f32> = open.iter().map(|_| levels[rng.usize(..4)]).collect();
                let found = smoothed(&open, &heights, 0.1, size);
                for (y, row) in (0..).zip(found.chunks_exact(width as usize)) {
                    for (x, &found) in (0..).zip(row) {
                        let wanted = reference(&open, &heights, 0.1, size, x, y);
                        assert!((found - wanted).abs() < 1e-5, "{size} {x} {y}: {found} {wanted}");
                    }
                }
            }
        }
    }
}
