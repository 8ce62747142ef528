//! Undoes the filters of several rows at once.
//!
//! With Paeth and Average, a value depends on its neighbours to the left and above, so texels of a
//! row can only be decoded one after the other. But a row may follow the one above it at a distance
//! of one texel: every step decodes one texel of each row, which takes as long as a single one.
//! Other filters take part where they interrupt rows with these: libpng changes to Up and back
//! every few rows.

use std::array;

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
use fearless_simd::dispatch;
use fearless_simd::{Bytes, Level, Select, Simd, SimdBase, SimdInt, SimdInto, u8x16, u32x4};

use super::unfilter::{AVERAGE, PAETH, SUB, UP};

/// Texels of a row that are loaded together.
const TEXELS: usize = 4;

/// Decodes the first rows at once if that pays, and returns their number.
///
/// - `filtered`: rows after the byte with the type of their filter.
/// - `above`: the row above the first.
pub(super) fn unfilter(
    level: Level,
    texel_bytes: usize,
    filtered: &[u8],
    above: &[u8],
    out: &mut [u8],
) -> usize {
    match texel_bytes {
        1 => dispatched::<1>(level, filtered, above, out),
        2 => dispatched::<2>(level, filtered, above, out),
        3 => dispatched::<3>(level, filtered, above, out),
        4 => dispatched::<4>(level, filtered, above, out),
        _ => 0,
    }
}

/// Without instructions that rearrange bytes, as with SSE2 alone, nothing would be gained.
fn dispatched<const B: usize>(
    level: Level,
    filtered: &[u8],
    above: &[u8],
    out: &mut [u8],
) -> usize {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    return match (level.as_avx2(), level.as_sse4_2()) {
        (Some(simd), _) => vectorized::<_, B>(simd, filtered, above, out),
        (None, Some(simd)) => vectorized::<_, B>(simd, filtered, above, out),
        (None, None) => 0,
    };
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    if level.is_fallback() {
        0
    } else {
        dispatch!(level, simd => vectorized::<_, B>(simd, filtered, above, out))
    }
}

#[inline(always)]
fn vectorized<S: Simd, const B: usize>(
    simd: S,
    filtered: &[u8],
    above: &[u8],
    out: &mut [u8],
) -> usize {
    simd.vectorize(
        #[inline(always)]
        || rows::<S, B>(simd, filtered, above, out),
    )
}

#[inline(always)]
fn rows<S: Simd, const B: usize>(simd: S, filtered: &[u8], above: &[u8], out: &mut [u8]) -> usize {
    let mut filters = filtered.iter().step_by(above.len() + 1).copied();
    let filters: [Option<u8>; 8] = array::from_fn(|_| filters.next());
    let only_paeth = |rows: usize| filters[..rows].iter().all(|&filter| filter == Some(PAETH));
    if only_paeth(8) {
        wave::<S, B, 2, 8, false>(simd, filtered, above, out);
        8
    } else if only_paeth(4) {
        wave::<S, B, 1, 4, false>(simd, filtered, above, out);
        4
    } else if pays(&filters) {
        wave::<S, B, 2, 8, true>(simd, filtered, above, out);
        8
    } else if pays(&filters[..4]) {
        wave::<S, B, 1, 4, true>(simd, filtered, above, out);
        4
    } else {
        0
    }
}

/// Whether there are all these rows, and several of them would take long by themselves.
fn pays(filters: &[Option<u8>]) -> bool {
    let slow = filters.iter().filter(|filter| matches!(filter, Some(AVERAGE | PAETH))).count();
    slow >= 2 && filters.iter().all(|filter| filter.is_some_and(|filter| filter <= PAETH))
}

/// Decodes `ROWS` rows with `N` vectors of four rows.
///
/// - `MIXED`: whether some of them have another filter than Paeth.
#[inline(always)]
fn wave<S: Simd, const B: usize, const N: usize, const ROWS: usize, const MIXED: bool>(
    simd: S,
    filtered: &[u8],
    above: &[u8],
    out: &mut [u8],
) {
    let len = above.len();
    let from: [&[u8]; ROWS] = array::from_fn(|row| &filtered[row * (len + 1) + 1..][..len]);
    let kinds: [Kinds<S>; N] = array::from_fn(|four| {
        Kinds::new(simd, array::from_fn(|row| filtered[(4 * four + row) * (len + 1)]))
    });
    let mut rest = out;
    let to: [&mut [u8]; ROWS] = array::from_fn(|_| {
        let (row, after) = std::mem::take(&mut rest).split_at_mut(len);
        rest = after;
        row
    });
    let spread: u8x16<S> = spread::<B>().simd_into(simd);
    let gather: u8x16<S> = gather::<B>().simd_into(simd);
    let zero = u8x16::splat(simd, 0);
    let (mut left, mut corner) = ([zero; N], [zero; N]);
    for first in (0..len / B + ROWS - 1).step_by(TEXELS) {
        // Every row is a texel behind the one above it.
        let is_inside = first + 1 >= ROWS && first * B + 16 <= len;
        let load = |row: &[u8], behind: usize| -> u8x16<S> {
            let bytes = if is_inside {
                *row[(first - behind) * B..].first_chunk().expect("16 bytes are left")
            } else {
                load_edge::<B>(row, first, behind)
            };
            SimdInto::<u8x16<S>, S>::simd_into(bytes, simd).swizzle_dyn_within_blocks(spread)
        };
        let mut steps: [[u8x16<S>; TEXELS]; N] = array::from_fn(|four| {
            transpose(array::from_fn(|row| load(from[4 * four + row], 4 * four + row)))
        });
        let over = load(above, 0);
        // The texel of each step in the last place.
        let over = [over.slide::<4>(over), over.slide::<8>(over), over.slide::<12>(over), over];
        for step in 0..TEXELS {
            let up: [u8x16<S>; N] = array::from_fn(|four| {
                let before = if four == 0 { over[step] } else { left[four - 1] };
                before.slide::<12>(left[four])
            });
            for four in 0..N {
                let filtered = steps[four][step];
                let paeth = decode(filtered, left[four], up[four], corner[four]);
                left[four] = if MIXED {
                    kinds[four].choose(filtered, left[four], up[four], paeth)
                } else {
                    paeth
                };
                steps[four][step] = left[four];
            }
            corner = up;
        }
        for (four, steps) in steps.into_iter().enumerate() {
            for (row, texels) in transpose(steps).into_iter().enumerate() {
                let row = 4 * four + row;
                let texels = texels.swizzle_dyn_within_blocks(gather);
                if is_inside {
                    // What is not part of the texels is overwritten by the next ones.
                    texels.store_slice(&mut to[row][(first - row) * B..][..16]);
                } else {
                    store_edge::<B>(texels.into(), to[row], first, row);
                }
            }
        }
    }
}

/// Which bytes of four rows have which filter: all bits or none.
struct Kinds<S: Simd> {
    sub: u8x16<S>,
    up: u8x16<S>,
    average: u8x16<S>,
    paeth: u8x16<S>,
}

impl<S: Simd> Kinds<S> {
    #[inline(always)]
    fn new(simd: S, filters: [u8; 4]) -> Self {
        let of = |filter| -> u8x16<S> {
            let bytes: [u8; 16] =
                array::from_fn(|at| if filters[at / 4] == filter { 255 } else { 0 });
            bytes.simd_into(simd)
        };
        Self { sub: of(SUB), up: of(UP), average: of(AVERAGE), paeth: of(PAETH) }
    }

    /// Decodes each row with its filter.
    #[inline(always)]
    fn choose(
        &self,
        filtered: u8x16<S>,
        left: u8x16<S>,
        up: u8x16<S>,
        paeth: u8x16<S>,
    ) -> u8x16<S> {
        // Half the sum, without its carry.
        let average = (left & up) + (((left ^ up) >> 1) & 0x7f);
        let predicted = (left & self.sub) | (up & self.up) | (average & self.average);
        (paeth & self.paeth) | ((filtered + predicted) & !self.paeth)
    }
}

/// `filtered` plus Paeth's prediction. The sum of `left` and `up` less `corner` is as far from the
/// lower of the two as the higher is from the corner, and the other way round. Unless the corner is
/// between the two, one of these distances is cut to 0, which is then the nearest.
#[inline(always)]
fn decode<S: Simd>(filtered: u8x16<S>, left: u8x16<S>, up: u8x16<S>, corner: u8x16<S>) -> u8x16<S> {
    let (low, high) = (left.min(up), left.max(up));
    let (to_low, to_high) = (high.saturating_sub(corner), corner.saturating_sub(low));
    // The distance to the corner is their difference: twice one is at most the other.
    let is_low = to_high.saturating_sub(to_low).simd_ge(to_low);
    let is_high = to_low.saturating_sub(to_high).simd_ge(to_high);
    let other = is_high.select(filtered + high, filtered + corner);
    is_low.select(filtered + low, other)
}

/// From four rows of four texels to four columns, and back.
#[inline(always)]
fn transpose<S: Simd>(rows: [u8x16<S>; 4]) -> [u8x16<S>; 4] {
    let [a, b, c, d] = rows.map(Bytes::bitcast::<u32x4<S>>);
    let (ac, bd) = (a.zip_low(c), b.zip_low(d));
    let (ac_after, bd_after) = (a.zip_high(c), b.zip_high(d));
    [ac.zip_low(bd), ac.zip_high(bd), ac_after.zip_low(bd_after), ac_after.zip_high(bd_after)]
        .map(Bytes::bitcast)
}

/// Places of the bytes of four texels, each in four bytes.
fn spread<const B: usize>() -> [u8; 16] {
    array::from_fn(|at| (at / 4 * B + (at % 4).min(B - 1)) as u8)
}

/// The reverse of [`spread`]; the bytes after the texels don't matter.
fn gather<const B: usize>() -> [u8; 16] {
    array::from_fn(|at| if at < 4 * B { (at / B * 4 + at % B) as u8 } else { 0 })
}

/// Texels from `first - behind`; zeros outside of the row, which decode to zeros.
fn load_edge<const B: usize>(row: &[u8], first: usize, behind: usize) -> [u8; 16] {
    let mut bytes = [0; 16];
    let texels = row.as_chunks::<B>().0;
    for (at, to) in bytes.chunks_exact_mut(B).take(TEXELS).enumerate() {
        if let Some(texel) = (first + at).checked_sub(behind).and_then(|x| texels.get(x)) {
            to.copy_from_slice(texel);
        }
    }
    bytes
}

fn store_edge<const B: usize>(bytes: [u8; 16], row: &mut [u8], first: usize, behind: usize) {
    let texels = row.as_chunks_mut::<B>().0;
    for (at, from) in bytes.as_chunks::<B>().0.iter().take(TEXELS).enumerate() {
        if let Some(texel) = (first + at).checked_sub(behind).and_then(|x| texels.get_mut(x)) {
            *texel = *from;
        }
    }
}
