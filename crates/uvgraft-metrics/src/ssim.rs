//! Structural similarity.
//!
//! Wang, Bovik, Sheikh, Simoncelli: "Image Quality Assessment: From Error Visibility to Structural
//! Similarity", 2004, in the two variants of scikit-image's `structural_similarity` that are most
//! common, each channel separately.
//!
//! With means `m`, variances `v` and the covariance `c` under a window, the similarity is
//! `(2 ma mb + C1) (2 c + C2) / ((ma² + mb² + C1) (va + vb + C2))`. Means, squares and products are
//! filtered along rows, then down columns, in tiles of the picture that fit a processor's cache.
//! Only texels whose window lies inside the picture count, so nothing is read outside it.

use uvgraft::threads::map_indices;

use super::{Colors, Mask, MetricError, same_size};

const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Size of a tile: enough rows to amortise the rows above it that are filtered again, and few
/// enough columns that one filtered row is small. Affects the last digits of the result, so it is
/// not a tuning option.
const TILE_ROWS: usize = 128;
const TILE_COLUMNS: usize = 256;

/// Local statistics for SSIM: both means, the sum of both mean squares, the mean product.
const STATISTICS: usize = 4;

/// SSIM with a Gaussian window of 11 texels, sigma 1.5, as proposed by Wang et al.
///
/// 1.0 for identical pictures, lower is worse, down to -1.0. The mean runs over channels and over
/// texels whose window lies inside the picture, which leaves out the outermost five. With a mask it
/// runs over those that the mask selects; their windows still extend beyond the mask.
///
/// # Errors
/// [`MetricError::Size`] if the pictures or the mask differ in size, [`MetricError::TooSmall`]
/// below 11 texels a side, [`MetricError::EmptyMask`] if the mask selects only texels near the
/// picture's edge.
///
/// # Source
/// scikit-image's `structural_similarity` with
/// `gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=-1`;
/// with a mask, the mean of its full map.
pub fn ssim(a: &Colors, b: &Colors, mask: Option<&Mask>) -> Result<f64, MetricError> {
    mean_ssim(a, b, mask, &Window::gaussian())
}

/// SSIM with a uniform window of 7×7 texels and sample covariance: scikit-image's default.
///
/// Like [`ssim`], but the outermost three texels are left out, and 7 texels a side are enough.
///
/// # Errors
/// As [`ssim`], with 7 texels instead of 11.
///
/// # Source
/// scikit-image's `structural_similarity` with `data_range=1, channel_axis=-1`; with a mask, the
/// mean of its full map.
pub fn ssim_uniform(a: &Colors, b: &Colors, mask: Option<&Mask>) -> Result<f64, MetricError> {
    mean_ssim(a, b, mask, &Window::uniform())
}

/// A separable window, and the factor for variances under it.
struct Window {
    metric: &'static str,
    /// From the centre outwards; the other half is symmetric.
    weights: Vec<f64>,
    covariance_norm: f64,
}

impl Window {
    fn gaussian() -> Self {
        const SIGMA: f64 = 1.5;
        let falloff = |k: u32| (-0.5 * f64::from(k * k) / (SIGMA * SIGMA)).exp();
        let sum: f64 = falloff(0) + 2.0 * (1..=5).map(falloff).sum::<f64>();
        let weights = (0..=5).map(|k| falloff(k) / sum).collect();
        Self { metric: "SSIM", weights, covariance_norm: 1.0 }
    }

    fn uniform() -> Self {
        // Sample covariance: one of the 49 degrees of freedom goes to the mean.
        let covariance_norm = 49.0 / 48.0;
        Self { metric: "SSIM with a uniform window", weights: vec![1.0 / 7.0; 4], covariance_norm }
    }

    fn radius(&self) -> usize {
        self.weights.len() - 1
    }

    /// The similarity from the statistics of one window.
    fn similarity(&self, [mean_a, mean_b, squares, product]: [f64; STATISTICS]) -> f64 {
        let (means, mean_squares) = (mean_a * mean_b, mean_a * mean_a + mean_b * mean_b);
        let covariance = self.covariance_norm * (product - means);
        let variances = self.covariance_norm * (squares - mean_squares);
        (2.0 * means + C1) * (2.0 * covariance + C2) / ((mean_squares + C1) * (variances + C2))
    }
}

fn mean_ssim(
    a: &Colors,
    b: &Colors,
    mask: Option<&Mask>,
    window: &Window,
) -> Result<f64, MetricError> {
    same_size(a, b, mask)?;
    let size = a.size();
    let (width, height) = (size.width as usize, size.height as usize);
    let border = 2 * window.radius();
    if width.min(height) <= border {
        let (metric, least) = (window.metric, border as u32 + 1);
        return Err(MetricError::TooSmall { metric, least, found: size });
    }
    // Positions are relative to the first texel whose window lies inside.
    let (columns, rows) = (width - border, height - border);
    let across = columns.div_ceil(TILE_COLUMNS);
    let tiles = across * rows.div_ceil(TILE_ROWS);
    let sums = map_indices(tiles, |tile| {
        let (left, top) = (tile % across * TILE_COLUMNS, tile / across * TILE_ROWS);
        let tile = Tile {
            left,
            top,
            columns: TILE_COLUMNS.min(columns - left),
            rows: TILE_ROWS.min(rows - top),
        };
        tile.sum(a, b, mask, window)
    });
    let (sum, texels) = sums
        .into_iter()
        .fold((0.0, 0), |(sum, count), (piece, texels)| (sum + piece, count + texels));
    if texels == 0 {
        return Err(MetricError::EmptyMask(" whose window lies inside the image"));
    }
    Ok(sum / (texels as f64 * 3.0))
}

/// A rectangle of windows, positioned by the top left texel of the first.
struct Tile {
    left: usize,
    top: usize,
    columns: usize,
    rows: usize,
}

impl Tile {
    /// The sum of similarities over channels and selected texels, and the number of these texels.
    ///
    /// A ring buffer holds the rows under the window, already filtered horizontally, so that each
    /// row of the picture is filtered only once for each tile.
    fn sum(&self, a: &Colors, b: &Colors, mask: Option<&Mask>, window: &Window) -> (f64, usize) {
        let (width, radius) = (a.size().width as usize, window.radius());
        let taps = 2 * radius + 1;
        let selected = |row: usize| {
            let start = (self.top + row + radius) * width + self.left + radius;
            mask.map(|mask| &mask.selected()[start..start + self.columns])
        };
        let is_needed = |row: &usize| selected(*row).is_none_or(|row| row.contains(&true));
        if !(0..self.rows).any(|row| is_needed(&row)) {
            return (0.0, 0);
        }
        let values = self.columns * 3;
        let stride = values * STATISTICS;
        // A ring buffer of the rows that a window covers, each filtered along the row.
        let mut ring = vec![0.0; taps * stride];
        let mut products = vec![0.0; (values + 6 * radius) * STATISTICS];
        let mut filtered = vec![0.0; stride];
        let (mut sum, mut texels) = (0.0, 0);
        for y in 0..self.rows + 2 * radius {
            let start = (self.top + y) * width + self.left;
            let row = start..start + self.columns + 2 * radius;
            multiply(&a.values(row.clone()), &b.values(row), &mut products);
            let slot = y % taps;
            along_row(&products, window, &mut ring[slot * stride..(slot + 1) * stride]);
            let Some(row) = y.checked_sub(2 * radius).filter(is_needed) else { continue };
            down_columns(&ring, row, window, &mut filtered);
            let plane = |statistic: usize| &filtered[statistic * values..(statistic + 1) * values];
            let [mean_a, mean_b, squares, product] = [0, 1, 2, 3].map(plane);
            let at = |k: usize| window.similarity([mean_a[k], mean_b[k], squares[k], product[k]]);
            match selected(row) {
                None => {
                    sum += (0..values).map(at).sum::<f64>();
                    texels += self.columns;
                }
                Some(selected) => {
                    for (x, _) in selected.iter().enumerate().filter(|(_, selected)| **selected) {
                        sum += at(3 * x) + at(3 * x + 1) + at(3 * x + 2);
                        texels += 1;
                    }
                }
            }
        }
        (sum, texels)
    }
}

/// The values from which the statistics are filtered, one plane after the other.
fn multiply(a: &[f32], b: &[f32], out: &mut [f64]) {
    let length = a.len();
    let (means, squares_and_products) = out.split_at_mut(2 * length);
    let (mean_a, mean_b) = means.split_at_mut(length);
    let (squares, product) = squares_and_products.split_at_mut(length);
    for k in 0..length {
        let (a, b) = (f64::from(a[k]), f64::from(b[k]));
        mean_a[k] = a;
        mean_b[k] = b;
        squares[k] = a * a + b * b;
        product[k] = a * b;
    }
}

/// Filters each statistic along a row of texels; the result is shorter by twice the
/// window's radius.
fn along_row(products: &[f64], window: &Window, out: &mut [f64]) {
    let radius = window.radius();
    let (length, values) = (products.len() / STATISTICS, out.len() / STATISTICS);
    for (input, out) in products.chunks_exact(length).zip(out.chunks_exact_mut(values)) {
        let middle = &input[3 * radius..][..values];
        for (out, value) in out.iter_mut().zip(middle) {
            *out = window.weights[0] * value;
        }
        for k in 1..=radius {
            let before = &input[3 * (radius - k)..][..values];
            let after = &input[3 * (radius + k)..][..values];
            add_weighted(out, window.weights[k], before, after);
        }
    }
}

/// Filters down the rows of the ring; row `first` of the tile is the top row of the window.
fn down_columns(ring: &[f64], first: usize, window: &Window, out: &mut [f64]) {
    let radius = window.radius();
    let taps = 2 * radius + 1;
    let length = out.len();
    let row = |k: usize| &ring[(first + k) % taps * length..][..length];
    for (out, value) in out.iter_mut().zip(row(radius)) {
        *out = window.weights[0] * value;
    }
    for k in 1..=radius {
        add_weighted(out, window.weights[k], row(radius - k), row(radius + k));
    }
}

/// `out += weight * (a + b)`; a separate function so that it is compiled to vector instructions.
fn add_weighted(out: &mut [f64], weight: f64, a: &[f64], b: &[f64]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out += weight * (a + b);
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{colors, mask, noise};
    use super::*;

    /// The definition, texel by texel: the specification for the separable filter.
    fn reference(
        a: &Colors,
        b: &Colors,
        weight: impl Fn(i32, i32) -> f64,
        radius: i32,
        norm: f64,
        selected: impl Fn(i32, i32) -> bool,
    ) -> f64 {
        let (width, height) = (a.size().width as i32, a.size().height as i32);
        let (mut sum, mut count) = (0.0, 0.0);
        for y in radius..height - radius {
            for x in (radius..width - radius).filter(|&x| selected(x, y)) {
                for channel in 0..3 {
                    let (mut ma, mut mb, mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0, 0.0, 0.0);
                    for j in -radius..=radius {
                        for i in -radius..=radius {
                            let at = ((y + j) * width + x + i) as usize;
                            let [p, q] = [a, b].map(|c| f64::from(c.values(at..at + 1)[channel]));
                            let w = weight(i, j);
                            ma += w * p;
                            mb += w * q;
                            aa += w * p * p;
                            bb += w * q * q;
                            ab += w * p * q;
                        }
                    }
                    let (va, vb) = (norm * (aa - ma * ma), norm * (bb - mb * mb));
                    let vab = norm * (ab - ma * mb);
                    sum += (2.0 * ma * mb + 1e-4) * (2.0 * vab + 9e-4)
                        / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
                    count += 1.0;
                }
            }
        }
        sum / count
    }

    fn gaussian_weight(i: i32, j: i32) -> f64 {
        let falloff = |k: i32| (-f64::from(k * k) / 4.5).exp();
        let sum: f64 = (-5..=5).map(falloff).sum();
        falloff(i) * falloff(j) / (sum * sum)
    }

    /// Sizes with one window, with seams between tiles, and with tiles of one row or column.
    #[test]
    fn equal_to_the_definition() {
        for (width, height) in [(11, 11), (13, 30), (267, 14), (14, 139), (530, 19)] {
            let (a, b) = (noise((width, height), 1), noise((width, height), 2));
            let whole = |_, _| true;
            let found = ssim(&a, &b, None).unwrap();
            let wanted = reference(&a, &b, gaussian_weight, 5, 1.0, whole);
            assert!((found - wanted).abs() < 1e-12, "{width}×{height}: {found}, {wanted}");
            let found = ssim_uniform(&a, &b, None).unwrap();
            let wanted = reference(&a, &b, |_, _| 1.0 / 49.0, 3, 49.0 / 48.0, whole);
            assert!((found - wanted).abs() < 1e-12, "{width}×{height}: {found}, {wanted}");
        }
    }

    #[test]
    fn masks_choose_windows() {
        let size = (300, 40);
        let (a, b) = (noise(size, 3), noise(size, 4));
        let selected = |x: i32, y: i32| (x * 7 + y * 3) % 5 == 0 && x > 20;
        let chosen = mask(size, |x, y| selected(x as i32, y as i32));
        let found = ssim(&a, &b, Some(&chosen)).unwrap();
        let wanted = reference(&a, &b, gaussian_weight, 5, 1.0, selected);
        assert!((found - wanted).abs() < 1e-12, "{found}, {wanted}");
        let all = mask(size, |_, _| true);
        let (found, wanted) = (ssim(&a, &b, Some(&all)).unwrap(), ssim(&a, &b, None).unwrap());
        assert!((found - wanted).abs() < 1e-12, "{found}, {wanted}");
    }

    /// Two flat pictures have no structure, so only the luminance term remains.
    #[test]
    fn by_hand() {
        let (a, b) = (colors((12, 12), &[51; 432]), colors((12, 12), &[102; 432]));
        let wanted = (2.0 * 0.2 * 0.4 + 1e-4) / (0.04 + 0.16 + 1e-4);
        for found in [ssim(&a, &b, None), ssim_uniform(&a, &b, None)] {
            assert!((found.unwrap() - wanted).abs() < 1e-6);
        }
        let noise = noise((40, 20), 5);
        assert!((ssim(&noise, &noise, None).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn windows_must_fit() {
        let small = noise((30, 10), 1);
        assert!(matches!(
            ssim(&small, &small, None),
            Err(MetricError::TooSmall { metric: "SSIM", least: 11, .. })
        ));
        assert!(ssim_uniform(&small, &small, None).is_ok());
        let a = noise((20, 20), 1);
        let border = mask((20, 20), |x, _| x < 5);
        assert!(matches!(ssim(&a, &a, Some(&border)), Err(MetricError::EmptyMask(_))));
        assert!(ssim_uniform(&a, &a, Some(&border)).is_ok());
    }
}
