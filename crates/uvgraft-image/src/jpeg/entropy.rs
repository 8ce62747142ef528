//! Huffman codes for quantised blocks.
//!
//! # Source
//! ITU-T T.81, annexes C, F and K. The tables are annex K's, so that the parts of a scan can be
//! encoded without knowing one another.

/// Number of codes of each length, and their symbols.
pub(super) struct Table {
    pub(super) counts: [u8; 16],
    pub(super) symbols: &'static [u8],
}

pub(super) const LUMA_DC: Table = Table {
    counts: [0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0],
    symbols: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
};
pub(super) const CHROMA_DC: Table = Table {
    counts: [0, 3, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0],
    symbols: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
};
pub(super) const LUMA_AC: Table = Table {
    counts: [0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 0x7d],
    symbols: &[
        0x01, 0x02, 0x03, 0x00, 0x04, 0x11, 0x05, 0x12, 0x21, 0x31, 0x41, 0x06, 0x13, 0x51, 0x61,
        0x07, 0x22, 0x71, 0x14, 0x32, 0x81, 0x91, 0xa1, 0x08, 0x23, 0x42, 0xb1, 0xc1, 0x15, 0x52,
        0xd1, 0xf0, 0x24, 0x33, 0x62, 0x72, 0x82, 0x09, 0x0a, 0x16, 0x17, 0x18, 0x19, 0x1a, 0x25,
        0x26, 0x27, 0x28, 0x29, 0x2a, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44, 0x45,
        0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58, 0x59, 0x5a, 0x63, 0x64,
        0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74, 0x75, 0x76, 0x77, 0x78, 0x79, 0x7a, 0x83,
        0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99,
        0x9a, 0xa2, 0xa3, 0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4, 0xb5, 0xb6,
        0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9, 0xca, 0xd2, 0xd3,
        0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda, 0xe1, 0xe2, 0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8,
        0xe9, 0xea, 0xf1, 0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa,
    ],
};
pub(super) const CHROMA_AC: Table = Table {
    counts: [0, 2, 1, 2, 4, 4, 3, 4, 7, 5, 4, 4, 0, 1, 2, 0x77],
    symbols: &[
        0x00, 0x01, 0x02, 0x03, 0x11, 0x04, 0x05, 0x21, 0x31, 0x06, 0x12, 0x41, 0x51, 0x07, 0x61,
        0x71, 0x13, 0x22, 0x32, 0x81, 0x08, 0x14, 0x42, 0x91, 0xa1, 0xb1, 0xc1, 0x09, 0x23, 0x33,
        0x52, 0xf0, 0x15, 0x62, 0x72, 0xd1, 0x0a, 0x16, 0x24, 0x34, 0xe1, 0x25, 0xf1, 0x17, 0x18,
        0x19, 0x1a, 0x26, 0x27, 0x28, 0x29, 0x2a, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44,
        0x45, 0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58, 0x59, 0x5a, 0x63,
        0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74, 0x75, 0x76, 0x77, 0x78, 0x79, 0x7a,
        0x82, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97,
        0x98, 0x99, 0x9a, 0xa2, 0xa3, 0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4,
        0xb5, 0xb6, 0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9, 0xca,
        0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda, 0xe2, 0xe3, 0xe4, 0xe5, 0xe6, 0xe7,
        0xe8, 0xe9, 0xea, 0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa,
    ],
};

/// The codes of luma or of chroma.
pub(super) struct Codes {
    dc: [Code; 256],
    ac: [Code; 256],
}

#[derive(Clone, Copy, Default)]
struct Code {
    bits: u32,
    count: u32,
}

impl Codes {
    pub(super) fn new(dc: &Table, ac: &Table) -> Self {
        Self { dc: dc.codes(), ac: ac.codes() }
    }

    /// Writes a block in the order of storage.
    ///
    /// - `before`: the first coefficient of the previous block of this component.
    #[inline(always)]
    pub(super) fn write(&self, block: &[i16; 64], before: i16, bits: &mut Bits<'_>) {
        let (code, size) = value(block[0].wrapping_sub(before));
        bits.write(self.dc[size as usize].then(code));
        let mut left = set(block) & !1;
        let mut last = 0;
        while left != 0 {
            let place = left.trailing_zeros();
            left &= left - 1;
            let mut zeros = place - last - 1;
            last = place;
            while zeros >= 16 {
                bits.write(self.ac[0xf0]);
                zeros -= 16;
            }
            let (code, size) = value(block[place as usize]);
            bits.write(self.ac[(zeros << 4 | size) as usize & 0xff].then(code));
        }
        if last != 63 {
            bits.write(self.ac[0]);
        }
    }
}

/// The places of a block that are not 0, as bits.
fn set(block: &[i16; 64]) -> u64 {
    let (eights, _) = block.as_chunks::<8>();
    eights.iter().rev().fold(0, |set, eight| {
        let bytes = eight.map(|value| u8::from(value != 0));
        // Moves the lowest bit of byte k to bit 56 + k.
        set << 8 | u64::from_le_bytes(bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56
    })
}

/// A value without its leading bits, and their number.
#[inline(always)]
fn value(value: i16) -> (Code, u32) {
    let value = i32::from(value);
    let count = 32 - value.unsigned_abs().leading_zeros();
    // Of negative values one less, so that the highest bit is the sign.
    let bits = (value + (value >> 31)) as u32 & ((1 << count) - 1);
    (Code { bits, count }, count)
}

impl Table {
    fn codes(&self) -> [Code; 256] {
        let mut codes = [Code::default(); 256];
        let (mut symbols, mut next) = (self.symbols.iter(), 0);
        for (count, &of_length) in (1..).zip(&self.counts) {
            for &symbol in symbols.by_ref().take(of_length.into()) {
                codes[usize::from(symbol)] = Code { bits: next, count };
                next += 1;
            }
            next <<= 1;
        }
        codes
    }
}

impl Code {
    #[inline(always)]
    fn then(self, next: Self) -> Self {
        Self { bits: self.bits << next.count | next.bits, count: self.count + next.count }
    }
}

/// Bits from the highest to the lowest of each byte, where a byte of 0xff is followed by one of 0.
pub(super) struct Bits<'a> {
    out: &'a mut Vec<u8>,
    buffer: u64,
    /// Less than 32 between writes.
    count: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(out: &'a mut Vec<u8>) -> Self {
        Self { out, buffer: 0, count: 0 }
    }

    /// Writes at most 32 bits.
    #[inline(always)]
    fn write(&mut self, code: Code) {
        self.buffer = self.buffer << code.count | u64::from(code.bits);
        self.count += code.count;
        if self.count >= 32 {
            self.count -= 32;
            let word = (self.buffer >> self.count) as u32;
            // Whether a byte of the complement is 0.
            if word & (!word).wrapping_sub(0x0101_0101) & 0x8080_8080 == 0 {
                self.out.extend_from_slice(&word.to_be_bytes());
            } else {
                word.to_be_bytes().into_iter().for_each(|byte| self.push(byte));
            }
        }
    }

    fn push(&mut self, byte: u8) {
        self.out.push(byte);
        if byte == 0xff {
            self.out.push(0);
        }
    }

    /// Fills the last byte with ones.
    pub(super) fn finish(mut self) {
        while self.count > 0 {
            let byte = (self.buffer << 8 | 0xff) >> self.count;
            self.push(byte as u8);
            self.count = self.count.saturating_sub(8);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_by_hand() {
        let bits = |of: i16| value(of).0;
        for (of, wanted, count) in [
            (0, 0, 0),
            (1, 1, 1),
            (-1, 0, 1),
            (2, 2, 2),
            (3, 3, 2),
            (-3, 0, 2),
            (-2, 1, 2),
            (-1024, 1023, 11),
        ] {
            assert_eq!((bits(of).bits, bits(of).count), (wanted, count), "{of}");
        }
    }

    #[test]
    fn places_are_found() {
        let mut block = [0; 64];
        for place in [0, 1, 7, 8, 20, 62, 63] {
            block[place] = -3;
        }
        assert_eq!(set(&block), 1 | 2 | 1 << 7 | 1 << 8 | 1 << 20 | 3 << 62);
    }

    #[test]
    fn bytes_are_stuffed_and_filled() {
        let written = |codes: &[(u32, u32)]| {
            let mut out = Vec::new();
            let mut bits = Bits::new(&mut out);
            codes.iter().for_each(|&(bits_of, count)| bits.write(Code { bits: bits_of, count }));
            bits.finish();
            out
        };
        assert_eq!(written(&[]), Vec::<u8>::new());
        assert_eq!(written(&[(0b101, 3)]), [0b1011_1111]);
        assert_eq!(written(&[(0xff, 8), (0, 3)]), [0xff, 0, 0x1f]);
        assert_eq!(written(&[(0x12ff, 16), (0xff34, 16)]), [0x12, 0xff, 0, 0xff, 0, 0x34]);
        assert_eq!(
            written(&[(0x123, 12), (0x45_6789, 24), (0x7f, 7)]),
            [0x12, 0x34, 0x56, 0x78, 0x9f, 0xff, 0]
        );
    }

    /// Annex K's examples of codes.
    #[test]
    fn codes_are_those_of_the_standard() {
        let codes = LUMA_AC.codes();
        for (symbol, bits, count) in
            [(0x00, 0b1010, 4), (0x01, 0, 2), (0xf0, 0b111_1111_1001, 11), (0xfa, 0xfffe, 16)]
        {
            assert_eq!((codes[symbol].bits, codes[symbol].count), (bits, count), "{symbol:x}");
        }
        let codes = CHROMA_AC.codes();
        assert_eq!((codes[0xf0].bits, codes[0xf0].count), (0b11_1111_1010, 10));
        for table in [LUMA_AC, CHROMA_AC, LUMA_DC, CHROMA_DC] {
            let count: usize = table.counts.iter().map(|&count| usize::from(count)).sum();
            assert_eq!(count, table.symbols.len());
        }
    }
}
