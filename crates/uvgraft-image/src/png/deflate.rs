//! Deflate for filtered rows: Huffman codes for each piece, and runs of zeros.
//!
//! Filtered rows of photographs hardly repeat themselves, but contain many small numbers and runs
//! of zeros, and nothing else is searched for. Pieces are independent, so that they can be
//! compressed in parallel, and end at whole bytes, so that they can be concatenated.
//!
//! # Source
//! RFC 1951. Limiting the length of codes: as in zlib's `gen_bitlen`, by Kraft sums.

/// The end of a stream: an empty, stored last block.
pub(super) const END: [u8; 5] = [1, 0, 0, 0xff, 0xff];

/// Literals, the end of the block, and run lengths.
const SYMBOLS: usize = 286;
const END_OF_BLOCK: usize = 256;
const LONGEST_RUN: usize = 258;

/// Four codes and the rest of a byte fit into 64 bits, and decoders look up codes of this length in
/// one step.
const LONGEST_CODE: usize = 12;

/// One part in this many is sampled for the codes: sampling everything gives files 0.1 % smaller.
const SAMPLED: usize = 8;
const SAMPLE: usize = 2048;

/// Writes `data` to a stream as non-final blocks, from `start` on, and returns the end.
///
/// - `out`: grows where it is too short, and may then be longer than the stream.
pub(super) fn compress(data: &[u8], start: usize, out: &mut Vec<u8>) -> usize {
    let codes = codes(&lengths(&count(data)));
    let most = most(data.len());
    // Its values don't matter.
    if out.len() < start + most {
        out.resize(start + most, 0);
    }
    let mut bits = Bits { out: &mut out[start..], at: 0, buffer: 0, count: 0 };
    write_codes(&codes, &mut bits);
    let literals = Literals::new(&codes);
    walk(
        data,
        &mut bits,
        |bits, bytes| match bytes.as_chunks::<4>() {
            ([first, second], []) => {
                bits.write(literals.four(*first));
                bits.write(literals.four(*second));
            }
            (fours, rest) => {
                fours.iter().for_each(|four| bits.write(literals.four(*four)));
                bits.write(literals.fewer(rest));
            }
        },
        |bits, length| {
            let (symbol, extra) = run(length);
            bits.write(codes[symbol].then(extra).then(DISTANCE));
        },
    );
    bits.write(codes[END_OF_BLOCK]);
    // An empty stored block, which aligns the stream to a byte.
    bits.write(Code { bits: 0, count: 3 });
    bits.align();
    bits.write(Code { bits: 0xffff_0000, count: 32 });
    start + bits.at
}

/// No fewer bytes than [`compress`] writes for `len` bytes: the longest code of each, the lengths of
/// all codes, and the bits written at once.
pub(super) fn most(len: usize) -> usize {
    len / 2 * 3 + SYMBOLS + 64
}

/// Bits in the order of writing, the first in the lowest position.
#[derive(Clone, Copy, Default)]
struct Code {
    bits: u64,
    count: u32,
}

/// The only distance, 1: a run repeats the previous byte.
const DISTANCE: Code = Code { bits: 0, count: 1 };

impl Code {
    fn then(self, next: Self) -> Self {
        Self { bits: self.bits | next.bits << self.count, count: self.count + next.count }
    }
}

/// The codes of bytes: in the highest bits, with the length in the lowest.
struct Literals([u64; 256]);

impl Literals {
    fn new(codes: &[Code; SYMBOLS]) -> Self {
        Self(std::array::from_fn(|byte| {
            let Code { bits, count } = codes[byte];
            bits << (64 - count) | u64::from(count)
        }))
    }

    #[inline(always)]
    fn four(&self, bytes: [u8; 4]) -> Code {
        Self::join(bytes.map(|byte| self.0[usize::from(byte)]))
    }

    /// The codes of less than four bytes.
    #[inline(always)]
    fn fewer(&self, bytes: &[u8]) -> Code {
        Self::join([0, 1, 2, 3].map(|k| bytes.get(k).map_or(0, |&byte| self.0[usize::from(byte)])))
    }

    /// Shifts by the lowest bits of a code, and leaves no more than these below the codes that
    /// were joined, so that a symbol takes a shift, an OR and an addition.
    #[inline(always)]
    fn join([a, b, c, d]: [u64; 4]) -> Code {
        let then = |before: u64, next: u64| before >> (next & 63) | next;
        let count = a.wrapping_add(b).wrapping_add(c).wrapping_add(d) & 63;
        Code { bits: then(then(then(a, b), c), d) >> ((64 - count) & 63), count: count as u32 }
    }
}

struct Bits<'a> {
    out: &'a mut [u8],
    at: usize,
    buffer: u64,
    /// Less than 8 between writes.
    count: u32,
}

impl Bits<'_> {
    /// Writes at most 56 bits.
    fn write(&mut self, code: Code) {
        self.buffer |= code.bits << self.count;
        self.count += code.count;
        self.out[self.at..self.at + 8].copy_from_slice(&self.buffer.to_le_bytes());
        self.at += (self.count / 8) as usize;
        self.buffer >>= self.count & !7;
        self.count &= 7;
    }

    fn align(&mut self) {
        self.write(Code { bits: 0, count: (8 - self.count) % 8 });
    }
}

/// Splits data into literals and runs of zeros that follow a zero.
#[inline(always)]
fn walk<S>(
    data: &[u8],
    state: &mut S,
    mut literals: impl FnMut(&mut S, &[u8]),
    mut zeros: impl FnMut(&mut S, usize),
) {
    let mut rest = data;
    while let Some(eight) = rest.first_chunk::<8>() {
        let value = u64::from_le_bytes(*eight);
        if value != 0 {
            // Zeros at the end may start a run; short ones are cheaper as literals.
            let zeros = value.leading_zeros() as usize / 8;
            let (taken, left) = rest.split_at(if zeros < 4 { 8 } else { 8 - zeros });
            literals(state, taken);
            rest = left;
            continue;
        }
        let mut len = 8;
        while let Some(next) = rest[len..].first_chunk::<8>() {
            let same = u64::from_le_bytes(*next).trailing_zeros() as usize / 8;
            len += same;
            if same < 8 {
                break;
            }
        }
        literals(state, &[0]);
        let mut left = len - 1;
        while left > 2 {
            // Never leaves 1 or 2, which cannot be runs.
            let taken = if left > LONGEST_RUN { LONGEST_RUN.min(left - 3) } else { left };
            zeros(state, taken);
            left -= taken;
        }
        rest = &rest[len..];
    }
    literals(state, rest);
}

/// The symbol of a run of 3 to 258, and its extra bits.
fn run(length: usize) -> (usize, Code) {
    if length == LONGEST_RUN {
        return (285, Code::default());
    }
    let length = length as u32 - 3;
    if length < 8 {
        return (257 + length as usize, Code::default());
    }
    // Four symbols for each number of extra bits, which grows with every power of two.
    let count = length.ilog2() - 2;
    let symbol = 257 + 4 * count + (length >> count);
    (symbol as usize, Code { bits: u64::from(length & ((1 << count) - 1)), count })
}

/// Histogram of symbols in a sample. No count is zero, because the rest may contain any symbol.
fn count(data: &[u8]) -> [u32; SYMBOLS] {
    let mut counts = [1; SYMBOLS];
    for sample in data.chunks(SAMPLE * SAMPLED) {
        let sample = &sample[..sample.len().min(SAMPLE)];
        walk(
            sample,
            &mut counts,
            |counts, literals| literals.iter().for_each(|&byte| counts[usize::from(byte)] += 1),
            |counts, length| counts[run(length).0] += 1,
        );
    }
    counts
}

/// Lengths of optimal prefix codes, none longer than [`LONGEST_CODE`].
fn lengths(counts: &[u32; SYMBOLS]) -> [u8; SYMBOLS] {
    let mut order: Vec<usize> = (0..SYMBOLS).collect();
    order.sort_unstable_by_key(|&symbol| (counts[symbol], symbol));
    // Huffman's tree: leaves, then inner nodes, both in ascending order.
    let mut weights: Vec<u64> = order.iter().map(|&symbol| counts[symbol].into()).collect();
    let mut parents = vec![0; 2 * SYMBOLS - 1];
    let (mut leaf, mut node) = (0, SYMBOLS);
    while weights.len() < parents.len() {
        let parent = weights.len();
        let mut weight = 0;
        for _ in 0..2 {
            let takes_leaf = leaf < SYMBOLS && (node == parent || weights[leaf] <= weights[node]);
            let taken = if takes_leaf { &mut leaf } else { &mut node };
            weight += weights[*taken];
            parents[*taken] = parent;
            *taken += 1;
        }
        weights.push(weight);
    }
    let mut depths = vec![0; parents.len()];
    let mut of_depth = [0; LONGEST_CODE + 1];
    for index in (0..parents.len() - 1).rev() {
        depths[index] = depths[parents[index]] + 1;
        if index < SYMBOLS {
            of_depth[depths[index].min(LONGEST_CODE)] += 1;
        }
    }
    // Truncated codes violate the Kraft sum. Each step attaches a leaf of the lowest level and one
    // of a higher level as siblings, one level below the latter.
    let room = |of_depth: &[u32]| -> u32 {
        of_depth.iter().enumerate().skip(1).map(|(d, &n)| n << (LONGEST_CODE - d)).sum()
    };
    let mut excess = room(&of_depth) - (1 << LONGEST_CODE);
    while excess > 0 {
        let above = (1..LONGEST_CODE).rev().find(|&depth| of_depth[depth] > 0).unwrap_or(1);
        of_depth[LONGEST_CODE] -= 1;
        of_depth[above] -= 1;
        of_depth[above + 1] += 2;
        excess -= 1;
    }
    // The rarest symbols get the longest codes.
    let mut lengths = [0; SYMBOLS];
    let mut symbols = order.into_iter();
    for depth in (1..=LONGEST_CODE).rev() {
        for symbol in symbols.by_ref().take(of_depth[depth] as usize) {
            lengths[symbol] = depth as u8;
        }
    }
    lengths
}

/// Canonical codes for lengths, in the order of section 3.2.2.
fn codes(lengths: &[u8; SYMBOLS]) -> [Code; SYMBOLS] {
    let mut codes = [Code::default(); SYMBOLS];
    let mut next = 0u16;
    for length in 1..=LONGEST_CODE as u8 {
        for (code, _) in codes.iter_mut().zip(lengths).filter(|(_, found)| **found == length) {
            // Codes are written starting with the highest bit.
            let bits = next.reverse_bits() >> (16 - length);
            *code = Code { bits: bits.into(), count: length.into() };
            next += 1;
        }
        next <<= 1;
    }
    codes
}

/// The header of a block with its own codes, section 3.2.7. Their lengths are written with 4 bits
/// each: 143 bytes.
fn write_codes(codes: &[Code], bits: &mut Bits<'_>) {
    const BLOCK: Code = Code { bits: 0b10 << 1, count: 3 };
    const LITERALS: Code = Code { bits: SYMBOLS as u64 - 257, count: 5 };
    const DISTANCES: Code = Code { bits: 0, count: 5 };
    const LENGTHS: Code = Code { bits: 19 - 4, count: 4 };
    bits.write(BLOCK.then(LITERALS).then(DISTANCES).then(LENGTHS));
    // The code lengths of the length alphabet: of repetitions, which are not used, and of 0 to 15.
    bits.write(Code { bits: 0, count: 9 });
    (0..16).for_each(|_| bits.write(Code { bits: 4, count: 3 }));
    let of_distance = DISTANCE.count;
    for length in codes.iter().map(|code| code.count).chain([of_distance]) {
        bits.write(Code { bits: u64::from((length as u8).reverse_bits() >> 4), count: 4 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decodes with another implementation: the stream with its header, pieces, end and checksum.
    fn round_trip(pieces: &[&[u8]]) -> usize {
        let mut stream = vec![0x78, 1];
        for piece in pieces {
            let end = compress(piece, stream.len(), &mut stream);
            stream.truncate(end);
        }
        stream.extend(END);
        let data = pieces.concat();
        let (mut a, mut b) = (1u32, 0u32);
        for &byte in &data {
            a = (a + u32::from(byte)) % 65_521;
            b = (b + a) % 65_521;
        }
        stream.extend((b << 16 | a).to_be_bytes());
        let len = stream.len();
        let mut decoded = Vec::new();
        let mut decoder = flate2::read::ZlibDecoder::new(&*stream);
        std::io::Read::read_to_end(&mut decoder, &mut decoded).unwrap();
        assert!(decoded == data);
        assert_eq!(decoder.total_in() as usize, len);
        len
    }

    #[test]
    fn any_bytes_come_back() {
        let mut random = fastrand::Rng::with_seed(3);
        round_trip(&[]);
        for len in (0..70).chain([2048, 16_384, 20_000, 100_001]) {
            let noise: Vec<u8> = (0..len).map(|_| random.u8(..)).collect();
            let zeros = vec![0; len];
            let few: Vec<u8> =
                (0..len).map(|i| if i % 300 > 40 { 0 } else { random.u8(..3) }).collect();
            for data in [&noise, &zeros, &few] {
                assert!(round_trip(&[data]) <= data.len() / 2 * 3 + 400);
                round_trip(&[data, &noise, data]);
            }
        }
    }

    #[test]
    fn runs_of_every_length_come_back() {
        let mut data = Vec::new();
        for len in 0..1100 {
            data.push(1);
            data.resize(data.len() + len, 0);
        }
        let taken = round_trip(&[&data]);
        assert!(taken < data.len() / 50, "{taken} of {}", data.len());
    }

    #[test]
    fn codes_fill_the_room_there_is_whatever_the_counts() {
        let mut random = fastrand::Rng::with_seed(4);
        for steepness in 0..32 {
            let mut counts = [1u32; SYMBOLS];
            for (index, count) in counts.iter_mut().enumerate() {
                // Up to powers of two, for which Huffman codes are as long as there are symbols.
                *count = (1 << (index as u32).min(steepness)) + random.u32(..2);
            }
            let room: u32 = lengths(&counts).iter().map(|&len| 4096 >> len).sum();
            assert_eq!(room, 4096);
        }
    }

    /// Values from the table in section 3.2.5.
    #[test]
    fn runs_are_told_as_the_rfc_says() {
        for (length, symbol, bits, count) in [
            (3, 257, 0, 0),
            (10, 264, 0, 0),
            (11, 265, 0, 1),
            (18, 268, 1, 1),
            (19, 269, 0, 2),
            (130, 280, 15, 4),
            (131, 281, 0, 5),
            (257, 284, 30, 5),
            (258, 285, 0, 0),
        ] {
            let (found, extra) = run(length);
            assert_eq!((found, extra.bits, extra.count), (symbol, bits, count), "{length}");
        }
    }
}
