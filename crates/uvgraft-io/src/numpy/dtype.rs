//! Numeric types of NumPy.

/// The kind of number in an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberKind {
    /// `b`
    Bool,
    /// `i`
    Signed,
    /// `u`
    Unsigned,
    /// `f`
    Float,
}

/// The stored type of an array's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dtype {
    /// Their kind.
    pub kind: NumberKind,
    /// Bytes of a number: 1 to 8, a power of two.
    pub width: usize,
    /// Whether they are big-endian.
    pub big_endian: bool,
}

impl Dtype {
    /// Parses NumPy's notation, such as `f4` or `>i8`; `None` unless it is numeric.
    pub(crate) fn from_text(text: &str) -> Option<Self> {
        let (order, text) = match text.as_bytes() {
            [order @ (b'<' | b'>' | b'|' | b'='), rest @ ..] => (*order, rest),
            rest => (b'=', rest),
        };
        let (kind, width) = match text {
            b"b1" => (NumberKind::Bool, 1),
            [b'f', width @ (b'2' | b'4' | b'8')] => (NumberKind::Float, width - b'0'),
            [b'i', width @ (b'1' | b'2' | b'4' | b'8')] => (NumberKind::Signed, width - b'0'),
            [b'u', width @ (b'1' | b'2' | b'4' | b'8')] => (NumberKind::Unsigned, width - b'0'),
            _ => return None,
        };
        Some(Self { kind, width: usize::from(width), big_endian: order == b'>' })
    }

    /// The bytes of an array of some shape, unless it overflows.
    pub(crate) fn bytes(self, shape: &[usize]) -> Option<usize> {
        shape.iter().copied().try_fold(self.width, usize::checked_mul)
    }

    /// Whether they are integers.
    pub(crate) const fn is_integer(self) -> bool {
        matches!(self.kind, NumberKind::Signed | NumberKind::Unsigned)
    }

    /// The bytes of a number, the least significant first.
    fn word(self, bytes: &[u8]) -> [u8; 8] {
        let mut word = [0; 8];
        word[..self.width].copy_from_slice(bytes);
        if self.big_endian {
            word[..self.width].reverse();
        }
        word
    }

    /// Decodes one integer or a float of at least 32 bits.
    pub(crate) fn number(self, bytes: &[u8]) -> f64 {
        match (self.kind, self.word(bytes)) {
            (NumberKind::Float, [a, b, c, d, ..]) if self.width == 4 => {
                f32::from_le_bytes([a, b, c, d]).into()
            }
            (NumberKind::Float, word) => f64::from_le_bytes(word),
            _ => self.integer(bytes).map_or_else(|beyond| beyond as f64, |value| value as f64),
        }
    }

    /// Decodes one integer; as the error, the unsigned one beyond 63 bits.
    pub(crate) fn integer(self, bytes: &[u8]) -> Result<i64, u64> {
        let value = u64::from_le_bytes(self.word(bytes));
        let unused_bits = 64 - 8 * self.width as u32;
        if self.kind == NumberKind::Signed {
            // Extends the sign.
            Ok((value << unused_bits).cast_signed() >> unused_bits)
        } else {
            i64::try_from(value).map_err(|_| value)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_nothing_else() {
        let big = Dtype { kind: NumberKind::Signed, width: 8, big_endian: true };
        assert_eq!(Dtype::from_text(">i8"), Some(big));
        for text in ["f4", "<f4", "|b1", "=u2", "f2"] {
            assert!(Dtype::from_text(text).is_some(), "{text}");
        }
        for text in ["", "<", "O", "O8", "|O", "U5", "S3", "V8", "c8", "f3", "f16", "b2", "f4f4"] {
            assert_eq!(Dtype::from_text(text), None, "{text}");
        }
    }
}
