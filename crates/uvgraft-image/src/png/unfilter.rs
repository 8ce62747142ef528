//! Undoes the filters of rows.
//!
//! # Source
//! PNG (Third Edition), section 9, <https://www.w3.org/TR/png-3/#9Filters>.

use fearless_simd::Level;

use super::wave;

/// Undoes the filters of a non-interlaced image, from top to bottom.
pub(super) struct Unfilter {
    level: Level,
    texel_bytes: usize,
    /// The row above the next one; zeros above the first.
    above: Vec<u8>,
}

/// A filter type that does not exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct UnknownFilter(pub(super) u8);

const NONE: u8 = 0;
pub(super) const SUB: u8 = 1;
pub(super) const UP: u8 = 2;
pub(super) const AVERAGE: u8 = 3;
pub(super) const PAETH: u8 = 4;

impl Unfilter {
    /// - `row_bytes`: a multiple of `texel_bytes`, which is 1, 2, 3, 4, 6 or 8.
    pub(super) fn new(row_bytes: usize, texel_bytes: usize) -> Self {
        Self { level: Level::new(), texel_bytes, above: vec![0; row_bytes] }
    }

    /// Undoes the filters of the next rows.
    ///
    /// - `filtered`: rows after the byte with the type of their filter.
    /// - `rows`: as many rows.
    pub(super) fn apply(&mut self, filtered: &[u8], rows: &mut [u8]) -> Result<(), UnknownFilter> {
        let len = self.above.len();
        let mut done = 0;
        let mut rest = filtered;
        while let Some(&filter) = rest.first() {
            let (finished, out) = rows.split_at_mut(done);
            let above = if done == 0 { &self.above } else { &finished[done - len..] };
            let taken = wave::unfilter(self.level, self.texel_bytes, rest, above, out);
            let taken = if taken > 0 {
                taken
            } else {
                self.row(filter, &rest[1..=len], above, &mut out[..len])?;
                1
            };
            rest = &rest[taken * (len + 1)..];
            done += taken * len;
        }
        if done > 0 {
            self.above.copy_from_slice(&rows[done - len..done]);
        }
        Ok(())
    }

    fn row(
        &self,
        filter: u8,
        from: &[u8],
        above: &[u8],
        to: &mut [u8],
    ) -> Result<(), UnknownFilter> {
        match self.texel_bytes {
            1 => row::<1>(filter, from, above, to),
            2 => row::<2>(filter, from, above, to),
            3 => row::<3>(filter, from, above, to),
            4 => row::<4>(filter, from, above, to),
            6 => row::<6>(filter, from, above, to),
            _ => row::<8>(filter, from, above, to),
        }
    }
}

fn row<const B: usize>(
    filter: u8,
    from: &[u8],
    above: &[u8],
    to: &mut [u8],
) -> Result<(), UnknownFilter> {
    match filter {
        NONE => to.copy_from_slice(from),
        SUB => texels::<B>(from, above, to, |left, _, _| left),
        UP => {
            for ((to, from), above) in to.iter_mut().zip(from).zip(above) {
                *to = from.wrapping_add(*above);
            }
        }
        AVERAGE => texels::<B>(from, above, to, |left, above, _| {
            u16::midpoint(left.into(), above.into()) as u8
        }),
        PAETH => texels::<B>(from, above, to, predict),
        unknown => return Err(UnknownFilter(unknown)),
    }
    Ok(())
}

/// Adds predictions from the values to the left, above, and above to the left.
#[inline(always)]
fn texels<const B: usize>(
    from: &[u8],
    above: &[u8],
    to: &mut [u8],
    predict: impl Fn(u8, u8, u8) -> u8,
) {
    let (mut left, mut corner) = ([0; B], [0; B]);
    let (from, above) = (from.as_chunks::<B>().0, above.as_chunks::<B>().0);
    for ((to, from), above) in to.as_chunks_mut::<B>().0.iter_mut().zip(from).zip(above) {
        for channel in 0..B {
            let predicted = predict(left[channel], above[channel], corner[channel]);
            left[channel] = from[channel].wrapping_add(predicted);
        }
        *to = left;
        corner = *above;
    }
}

/// Paeth's prediction. With `low` and `high` of the two neighbours, their distances to the estimate
/// (left + above − corner) are those of the other neighbour to the corner; outside of the two, the
/// corner is never the nearest.
#[inline(always)]
fn predict(left: u8, above: u8, corner: u8) -> u8 {
    let (left, above, corner) = (i16::from(left), i16::from(above), i16::from(corner));
    let (low, high) = (left.min(above), left.max(above));
    let threshold = 3 * corner - (left + above);
    let predicted = if high <= threshold { low } else { corner };
    (if threshold <= low { high } else { predicted }) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The filters as the specification states them.
    fn reference(texel_bytes: usize, len: usize, filtered: &[u8]) -> Vec<u8> {
        let mut rows = Vec::<u8>::new();
        for (y, row) in filtered.chunks_exact(len + 1).enumerate() {
            for (x, &value) in row[1..].iter().enumerate() {
                let at = rows.len();
                let left = if x < texel_bytes { 0 } else { rows[at - texel_bytes] };
                let above = if y == 0 { 0 } else { rows[at - len] };
                let is_first = y == 0 || x < texel_bytes;
                let corner = if is_first { 0 } else { rows[at - len - texel_bytes] };
                let [a, b, c] = [left, above, corner].map(i32::from);
                let predicted = match row[0] {
                    0 => 0,
                    1 => a,
                    2 => b,
                    3 => (a + b) / 2,
                    _ => {
                        let estimate = a + b - c;
                        let nearest = [a, b, c].into_iter().min_by_key(|x| (estimate - x).abs());
                        nearest.unwrap_or(0)
                    }
                };
                rows.push(value.wrapping_add(predicted as u8));
            }
        }
        rows
    }

    fn levels() -> Vec<Level> {
        let levels = vec![Level::new(), Level::baseline()];
        #[cfg(target_arch = "x86_64")]
        let levels = {
            let less = Level::new().as_sse4_2().map(fearless_simd::Simd::level);
            levels.into_iter().chain(less).collect()
        };
        levels
    }

    #[test]
    fn equals_the_specification_for_any_filters() {
        let mut random = fastrand::Rng::with_seed(1);
        for texel_bytes in [1, 2, 3, 4, 6, 8] {
            for width in 1..70 {
                let (len, height) = (width * texel_bytes, random.usize(1..40));
                let is_mixed = random.bool();
                let mut filtered: Vec<u8> =
                    (0..height * (len + 1)).map(|_| random.u8(..)).collect();
                // Small differences are near the ties of the prediction.
                let most = [255, 3][random.usize(..2)];
                filtered.iter_mut().for_each(|value| *value %= most);
                for row in filtered.chunks_exact_mut(len + 1) {
                    let is_paeth = random.u8(..20) > 0;
                    row[0] = if is_paeth && !is_mixed { PAETH } else { random.u8(..5) };
                }
                let wanted = reference(texel_bytes, len, &filtered);
                for level in levels() {
                    let mut unfilter = Unfilter { level, ..Unfilter::new(len, texel_bytes) };
                    let mut found = Vec::new();
                    let mut rest = &filtered[..];
                    while !rest.is_empty() {
                        let rows = random.usize(..30).min(rest.len() / (len + 1));
                        let (part, after) = rest.split_at(rows * (len + 1));
                        // What was there before doesn't matter.
                        let mut out = vec![77; rows * len];
                        assert_eq!(unfilter.apply(part, &mut out), Ok(()));
                        found.extend(out);
                        rest = after;
                    }
                    assert!(found == wanted, "{texel_bytes} × {width} × {height}, {level:?}");
                }
            }
        }
    }

    #[test]
    fn predicts_like_the_specification_for_all_neighbours() {
        // Every corner and value above; the filtered values decode to any neighbour to the left.
        for corner in 0..=255_u8 {
            let mut filtered = vec![0];
            filtered.extend((0..=255).flat_map(|above| [corner, above]));
            for left in (0..=255).step_by(7) {
                filtered.push(PAETH);
                filtered.extend([left; 512]);
            }
            let wanted = reference(1, 512, &filtered);
            for level in levels() {
                let mut found = vec![0; wanted.len()];
                let mut unfilter = Unfilter { level, ..Unfilter::new(512, 1) };
                assert_eq!(unfilter.apply(&filtered, &mut found), Ok(()));
                assert!(found == wanted, "{corner} {level:?}");
            }
        }
    }

    #[test]
    fn unknown_filters_are_errors() {
        let mut unfilter = Unfilter::new(3, 3);
        let filtered = [1, 7, 7, 7, 5, 1, 1, 1];
        assert_eq!(unfilter.apply(&filtered, &mut [0; 6]), Err(UnknownFilter(5)));
    }
}
