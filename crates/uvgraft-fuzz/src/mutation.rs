//! Mutations of seeds, for machines without a fuzzer.

use fastrand::Rng;

/// Numbers that break arithmetic.
const NUMBERS: [u64; 12] = [
    0,
    1,
    2,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0xffff_ffff_ffff_ffff,
];

/// Words that break parsers of text.
const WORDS: [&str; 14] = [
    "-1",
    "0",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "4294967296",
    "99999999999999999999",
    "1.5",
    "\"",
    "[",
    "}",
    "\0",
    " ",
];

/// Makes inputs from seeds, the same for the same seed of its generator.
#[derive(Debug)]
pub struct Mutator {
    seeds: Vec<Vec<u8>>,
    random: Rng,
}

impl Mutator {
    /// Inputs grow to at most this many bytes.
    const MAX_BYTES: usize = 1 << 16;

    /// - `seeds`: at least one.
    pub fn new(seeds: Vec<Vec<u8>>, seed: u64) -> Self {
        assert!(!seeds.is_empty(), "there must be seeds");
        Self { seeds, random: Rng::with_seed(seed) }
    }

    /// The next input.
    pub fn next_input(&mut self) -> Vec<u8> {
        let mut bytes = self.seed().to_vec();
        for _ in 0..1 << self.random.u32(0..5) {
            self.mutate(&mut bytes);
        }
        bytes.truncate(Self::MAX_BYTES);
        bytes
    }

    fn seed(&mut self) -> &[u8] {
        let index = self.random.usize(..self.seeds.len());
        &self.seeds[index]
    }

    fn mutate(&mut self, bytes: &mut Vec<u8>) {
        let at = self.random.usize(..=bytes.len());
        let span = at..bytes.len().min(at + (1 << self.random.u32(0..8)));
        match self.random.u32(0..11) {
            0 if at < bytes.len() => bytes[at] ^= 1 << self.random.u32(0..8),
            1 if at < bytes.len() => bytes[at] = self.random.u8(..),
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(span)),
            4 => {
                let copied = bytes[span].to_vec();
                let to = self.random.usize(..=bytes.len());
                bytes.splice(to..to, copied);
            }
            5 => {
                let count = self.random.usize(..16);
                let filling: Vec<u8> = (0..count).map(|_| self.random.u8(..)).collect();
                bytes.splice(at..at, filling);
            }
            6 => {
                let other = self.seed().to_vec();
                let from = self.random.usize(..=other.len());
                bytes.truncate(at);
                bytes.extend(&other[from..]);
            }
            7 | 8 => {
                let number = NUMBERS[self.random.usize(..NUMBERS.len())];
                let number = number.wrapping_add(self.random.u64(0..3)).wrapping_sub(1);
                let width = [1, 2, 4, 8][self.random.usize(..4)];
                let big = number.to_be_bytes();
                let number = if self.random.bool() {
                    &number.to_le_bytes()[..width]
                } else {
                    &big[8 - width..]
                };
                let end = bytes.len().min(at + width);
                bytes[at..end].copy_from_slice(&number[..end - at]);
            }
            9 => {
                // In place of a word.
                let is_word =
                    |byte: &u8| !byte.is_ascii_whitespace() && !b",:/[]{}()\"".contains(byte);
                let start =
                    bytes[..at].iter().rposition(|byte| !is_word(byte)).map_or(0, |at| at + 1);
                let length = bytes[at..].iter().position(|byte| !is_word(byte));
                let end =
                    length.map_or(bytes.len(), |length| at + length).min(start + 64).max(start);
                let word = WORDS[self.random.usize(..WORDS.len())];
                bytes.splice(start..end, word.bytes());
            }
            _ => bytes[span].fill(0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_the_same_for_the_same_seed_and_differ_otherwise() {
        let inputs = |seed| {
            let mut mutator = Mutator::new(vec![b"a first seed 12 34".to_vec(), vec![7; 40]], seed);
            (0..500).map(|_| mutator.next_input()).collect::<Vec<_>>()
        };
        assert!(inputs(1) == inputs(1) && inputs(1) != inputs(2));
        let mut distinct = inputs(1);
        distinct.sort();
        distinct.dedup();
        assert!(distinct.len() > 400);
    }
}
