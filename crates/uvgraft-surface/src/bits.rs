//! Bit sets of small integers, which put the columns of a row in order without sorting, and a hash of
//! integers.

use std::ops::Range;

/// Number of words that hold `count` bits.
#[inline]
pub fn words(count: u32) -> usize {
    count.div_ceil(64) as usize
}

/// The bits of `range` in the word at index `word`, which the range must overlap.
#[inline]
fn mask(range: &Range<u32>, word: usize) -> u64 {
    let first = word as u32 * 64;
    let from = range.start.saturating_sub(first);
    let beyond = (first + 64).saturating_sub(range.end);
    (u64::MAX << from) & (u64::MAX >> beyond)
}

/// The indices of the words that a non-empty range overlaps.
#[inline]
fn touched(range: &Range<u32>) -> Range<usize> {
    range.start as usize / 64..(range.end as usize - 1) / 64 + 1
}

/// Spreads every bit over all others: the finaliser of SplitMix64 (Steele, Lea and Flood, 2014),
/// after an increment without which 0 would stay 0.
pub(crate) fn mixed(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ value >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ value >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ value >> 31
}

/// Adds a number.
#[inline]
pub fn insert(set: &mut [u64], number: u32) {
    set[number as usize / 64] |= 1 << (number % 64);
}

/// Whether a number is in the set.
#[inline]
pub fn contains(set: &[u64], number: u32) -> bool {
    set[number as usize / 64] >> (number % 64) & 1 == 1
}

/// Adds a range.
#[inline]
pub fn insert_range(set: &mut [u64], range: &Range<u32>) {
    if !range.is_empty() {
        claim(set, range);
    }
}

/// Adds a non-empty range; returns whether any member of it was present before.
#[inline]
pub fn claim(set: &mut [u64], range: &Range<u32>) -> bool {
    // Most ranges lie within a word.
    let words = touched(range);
    let mask = mask(range, words.start);
    let taken = set[words.start] & mask != 0;
    set[words.start] |= mask;
    if words.len() == 1 { taken } else { claim_rest(set, range) || taken }
}

/// As [`claim`], for all words that the range overlaps except the first.
#[inline(never)]
fn claim_rest(set: &mut [u64], range: &Range<u32>) -> bool {
    let words = touched(range);
    let mut taken = 0;
    for word in words.start + 1..words.end {
        let mask = mask(range, word);
        taken |= set[word] & mask;
        set[word] |= mask;
    }
    taken != 0
}

/// Whether the set contains any number of a range.
#[inline]
pub fn meets(set: &[u64], range: &Range<u32>) -> bool {
    !range.is_empty() && touched(range).any(|word| set[word] & mask(range, word) != 0)
}

/// Adds all members of another set.
#[inline]
pub fn unite(set: &mut [u64], other: &[u64]) {
    for (word, other) in set.iter_mut().zip(other) {
        *word |= other;
    }
}

/// The members in ascending order.
#[inline]
pub fn members(set: &[u64]) -> impl Iterator<Item = u32> {
    set.iter().zip(0..).flat_map(|(&word, index)| {
        let mut rest = word;
        std::iter::from_fn(move || {
            let bit = rest.trailing_zeros();
            rest &= rest.wrapping_sub(1);
            (bit < 64).then_some(index * 64 + bit)
        })
    })
}

/// The set as disjoint, non-adjacent ranges in ascending order.
#[inline]
pub fn ranges(set: &[u64]) -> impl Iterator<Item = Range<u32>> {
    stretches(set, true, set.len() as u32 * 64)
}

/// The ranges of `0..count` that are not in the set, in ascending order.
#[inline]
pub fn gaps(set: &[u64], count: u32) -> impl Iterator<Item = Range<u32>> {
    stretches(set, false, count)
}

/// The maximal ranges below `count` whose numbers are all in the set (`inside`), or all not in it.
#[inline]
fn stretches(set: &[u64], inside: bool, count: u32) -> impl Iterator<Item = Range<u32>> {
    // The first number from `start` on that is in the set (`wanted`), or that is not.
    let next = move |start: u32, wanted: bool| {
        let mut word = start as usize / 64;
        let mut from = u64::MAX << (start % 64);
        while word < set.len() {
            let found = if wanted { set[word] } else { !set[word] } & from;
            if found != 0 {
                return (word as u32 * 64 + found.trailing_zeros()).min(count);
            }
            from = u64::MAX;
            word += 1;
        }
        count
    };
    let mut end = 0;
    std::iter::from_fn(move || {
        let start = next(end, inside);
        end = next(start, !inside);
        (start < end).then_some(start..end)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_ranges_come_back_in_order() {
        let mut set = vec![0; words(200)];
        assert_eq!(set.len(), 4);
        for range in [190..200, 3..5, 60..130, 5..6, 7..7] {
            insert_range(&mut set, &range);
        }
        insert(&mut set, 255);
        assert_eq!(ranges(&set).collect::<Vec<_>>(), [3..6, 60..130, 190..200, 255..256]);
        assert_eq!(members(&set).count(), 3 + 70 + 10 + 1);
        assert!(members(&set).is_sorted() && members(&set).all(|number| contains(&set, number)));
        assert!(meets(&set, &(0..4)) && meets(&set, &(129..190)) && meets(&set, &(6..61)));
        assert!(!meets(&set, &(130..190)) && !meets(&set, &(60..60)) && !contains(&set, 6));
        let gaps = |set: &[u64]| gaps(set, 250).collect::<Vec<_>>();
        assert_eq!(gaps(&set), [0..3, 6..60, 130..190, 200..250]);
        assert!(claim(&mut set, &(100..180)) && !claim(&mut set, &(180..190)));
        assert_eq!(gaps(&set), [0..3, 6..60, 200..250]);
        insert_range(&mut set, &(0..256));
        assert!(ranges(&set).eq(std::iter::once(0..256)));
    }

    #[test]
    fn a_set_is_united_with_another() {
        let mut set = [1, 0];
        unite(&mut set, &[2, 1]);
        assert_eq!(members(&set).collect::<Vec<_>>(), [0, 1, 64]);
    }
}
