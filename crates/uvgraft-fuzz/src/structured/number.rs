//! Numbers in the place of those of a valid file.

use arbitrary::{Arbitrary, Result, Unstructured};

/// A number in the place of another.
#[derive(Debug, Clone, Copy, Arbitrary)]
pub(super) enum Number {
    /// A power of two, or one less or more.
    Power { exponent: u8, off: u8 },
    /// A little more or less than it was.
    Near(i8),
    /// So many times as much, by a power of two.
    Times { exponent: u8 },
    /// A count that readers may accept.
    Plain(Many),
}

impl Number {
    pub fn instead_of(self, was: u64) -> u64 {
        match self {
            Self::Power { exponent, off } => {
                (1_u64 << (exponent % 64)).wrapping_add((off % 3).into()).wrapping_sub(1)
            }
            Self::Near(more) => was.wrapping_add_signed(more.into()),
            Self::Times { exponent } => was.saturating_mul(1 << (exponent % 28)),
            Self::Plain(many) => many.0 as u64,
        }
    }

    /// Replaces a number within bytes.
    ///
    /// - `width`: of the number, in bytes; at most 8.
    pub fn patch(self, bytes: &mut [u8], at: usize, width: usize, is_big: bool) {
        let Some(place) = bytes.get_mut(at..at + width) else { return };
        let mut number = [0; 8];
        if is_big {
            number[8 - width..].copy_from_slice(place);
            let number = self.instead_of(u64::from_be_bytes(number)).to_be_bytes();
            place.copy_from_slice(&number[8 - width..]);
        } else {
            number[..width].copy_from_slice(place);
            let number = self.instead_of(u64::from_le_bytes(number)).to_le_bytes();
            place.copy_from_slice(&number[..width]);
        }
    }
}

/// How often something is there: rarely more than a thousand times, so that thousands of files can be
/// read in seconds, and at most a hundred thousand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Many(pub usize);

impl Many {
    /// As often as fits the bound on the size of files.
    ///
    /// - `each`: bytes of one.
    pub fn of(self, each: usize) -> usize {
        self.0.min(super::MAX_BYTES / each.max(1))
    }
}

impl<'a> Arbitrary<'a> for Many {
    fn arbitrary(from: &mut Unstructured<'a>) -> Result<Self> {
        let [size, exponent] = from.arbitrary::<[u8; 2]>()?;
        let exponent = if size % 32 == 31 { 10 + exponent % 7 } else { exponent % 10 };
        Ok(Self((1 << exponent) + from.arbitrary::<u16>()? as usize % (1 << exponent)))
    }
}

/// Numbers at any place of a file.
#[derive(Debug, Clone, Copy, Arbitrary)]
pub(super) struct Patch {
    at: u16,
    width: u8,
    to: Number,
}

impl Patch {
    pub fn apply(self, bytes: &mut [u8], is_big: bool) {
        let at = usize::from(self.at) % bytes.len().max(1);
        self.to.patch(bytes, at, [1, 2, 4, 8][usize::from(self.width) % 4], is_big);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_patched_in_both_orders() {
        let mut bytes = *b"\x01\0\0\0\x01";
        Number::Near(2).patch(&mut bytes, 0, 4, false);
        Number::Times { exponent: 3 }.patch(&mut bytes, 3, 2, true);
        assert_eq!(bytes, *b"\x03\0\0\0\x08");
        Number::Near(2).patch(&mut bytes, 4, 4, true);
        assert_eq!(bytes, *b"\x03\0\0\0\x08", "nothing beyond the end");
    }
}
