//! Images of at most four columns with chroma of half their width.
//!
//! Decoders interpolate chroma between its columns, except that libjpeg, and whatever is built on it,
//! repeats each column of such images, because there are two at most. `zune-jpeg` interpolates, which is
//! dozens of levels of 255 apart where colours change. Here its interpolation, with weights of 3/4 and
//! 1/4, is undone.

use uvgraft::texture::Size;

use super::ycbcr::to_rgb;

/// The widest image with at most two columns of chroma.
pub(super) const MAX_WIDTH: u32 = 4;

/// From Y, Cb and Cr with interpolated chroma to RGB with repeated chroma.
///
/// - `values`: `[height * width * 3]`, converted in place.
/// - `halves_rows`: whether chroma has half as many rows, too.
pub(super) fn repeat_chroma(values: &mut [u8], size: Size, halves_rows: bool) {
    let (width, height) = (size.width as usize, size.height as usize);
    let at = |x: usize, y: usize, channel: usize| (y * width + x) * 3 + channel;
    for channel in [1, 2] {
        let column = |x: usize| -> Vec<f32> {
            let column = (0..height).map(|y| f32::from(values[at(x, y, channel)]));
            let column: Vec<f32> = column.collect();
            if halves_rows { repeated(&column) } else { column }
        };
        let (first, third) = (column(0), (width > 2).then(|| column(2)));
        for y in 0..height {
            for x in 0..width {
                let chroma = match &third {
                    Some(third) if x >= 2 => nearer(third[y], first[y]),
                    _ => first[y],
                };
                values[at(x, y, channel)] = (chroma + 0.5) as u8;
            }
        }
    }
    to_rgb(values);
}

/// Undoes the interpolation of rows, and repeats them: every second value depends on the row before.
fn repeated(column: &[f32]) -> Vec<f32> {
    let mut rows = Vec::with_capacity(column.len());
    let mut before = None;
    for pair in column.chunks(2) {
        let row = before.map_or(pair[0], |before| nearer(pair[0], before));
        rows.extend(pair.iter().map(|_| row));
        before = Some(row);
    }
    rows
}

/// The nearer of two values that were mixed 3 : 1.
fn nearer(mixed: f32, farther: f32) -> f32 {
    ((4.0 * mixed - farther) / 3.0).clamp(0.0, 255.0)
}

#[cfg(test)]
mod tests {
    use super::super::ycbcr::rgb;
    use super::*;

    /// As decoders interpolate: 3 : 1 between neighbours, none beyond the ends.
    fn interpolated(values: &[f32]) -> Vec<f32> {
        let at = |index: usize| values[index.min(values.len() - 1)];
        let each = |index: usize| {
            let (before, after) = (at(index.saturating_sub(1)), at(index + 1));
            [before, after].map(|other| (3.0 * at(index) + other) / 4.0)
        };
        (0..values.len()).flat_map(each).collect()
    }

    #[test]
    fn interpolation_of_rows_is_undone() {
        let rows = [10.0, 200.0, 0.0, 255.0, 90.0];
        let found = repeated(&interpolated(&rows));
        for (index, found) in found.iter().enumerate() {
            assert!((found - rows[index / 2]).abs() < 1e-3);
        }
    }

    #[test]
    fn columns_are_repeated() {
        // Chroma 100 and 180: 100, 120, 160, 180.
        let mut values: Vec<u8> = [100, 120, 160, 180].iter().flat_map(|&c| [90, c, 128]).collect();
        repeat_chroma(&mut values, Size::new(4, 1), false);
        let [left, right] = [100, 180].map(|cb| rgb([90, cb, 128]));
        assert_eq!(values, [left, left, right, right].concat());
    }
}
