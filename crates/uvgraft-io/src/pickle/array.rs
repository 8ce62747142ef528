//! Numeric NumPy arrays.

use super::texts::TextDtype;
use super::value::Id;
use crate::integers::Number;

/// NumPy's own limit in version 2; version 1 had 32.
pub(super) const MOST_AXES: usize = 64;

/// The kind of the values of an array.
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

/// The stored type of the values of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dtype {
    /// Their kind.
    pub kind: NumberKind,
    /// Bytes of each: 1 to 8, a power of two.
    pub width: usize,
    /// Whether the byte order is big-endian.
    pub big_endian: bool,
}

impl Dtype {
    /// Parses NumPy's notation, such as `f4` or `>i8`; `None` unless numeric.
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
}

/// The contents of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Items {
    Numbers(Dtype),
    Texts(TextDtype),
    /// Arbitrary objects of the pickle.
    Objects,
}

impl Items {
    /// Parses NumPy's notation; `None` for structures, dates and other rare types.
    pub(super) fn from_text(text: &str) -> Option<Self> {
        match text {
            "O" | "O8" | "O4" | "|O" | "|O8" => Some(Self::Objects),
            _ => Dtype::from_text(text)
                .map(Self::Numbers)
                .or_else(|| TextDtype::from_text(text.as_bytes()).map(Self::Texts)),
        }
    }
}

/// The shape and type of an array, and the value that holds its bytes.
#[derive(Debug)]
pub(super) struct ArrayLayout {
    pub(super) dtype: Dtype,
    pub(super) shape: Vec<usize>,
    pub(super) fortran_order: bool,
    pub(super) data: Id,
}

impl ArrayLayout {
    /// The size required by the shape, unless it overflows.
    pub(super) fn bytes(&self) -> Option<usize> {
        let sides = self.shape.iter();
        sides.copied().try_fold(self.dtype.width, usize::checked_mul)
    }
}

/// An array whose size matches its shape.
#[derive(Debug, Clone, Copy)]
pub struct Array<'p> {
    pub(super) layout: &'p ArrayLayout,
    pub(super) data: &'p [u8],
}

impl<'p> Array<'p> {
    /// The lengths of its axes.
    pub fn shape(&self) -> &'p [usize] {
        &self.layout.shape
    }

    /// Their stored type.
    pub const fn dtype(&self) -> Dtype {
        self.layout.dtype
    }

    /// Its raw values.
    pub const fn bytes(&self) -> &'p [u8] {
        self.data
    }

    /// Whether it is in Fortran order.
    pub const fn is_fortran_order(&self) -> bool {
        self.layout.fortran_order
    }

    /// Its values in C order, if they are 32-bit floats.
    pub fn f32s(&self) -> Option<Vec<f32>> {
        let Dtype { kind: NumberKind::Float, width: 4, big_endian } = self.layout.dtype else {
            return None;
        };
        let read = if big_endian { f32::from_be_bytes } else { f32::from_le_bytes };
        let written: Vec<f32> =
            self.data.as_chunks::<4>().0.iter().map(|&word| read(word)).collect();
        Some(self.ordered(written))
    }

    /// Number of values.
    pub const fn count(&self) -> usize {
        self.data.len() / self.layout.dtype.width
    }

    /// Its values in C order, if they are integers that fit a signed 64-bit one.
    pub fn integers(&self) -> Option<Vec<i64>> {
        let Dtype { kind, width, big_endian } = self.layout.dtype;
        let signed = match kind {
            NumberKind::Signed => true,
            NumberKind::Unsigned => false,
            NumberKind::Bool | NumberKind::Float => return None,
        };
        let number = Number { big_endian, signed, width };
        let written = self.data.chunks_exact(width).map(|bytes| number.read(bytes));
        Some(self.ordered(written.collect::<Result<Vec<i64>, u64>>().ok()?))
    }

    fn ordered<T: Copy>(&self, written: Vec<T>) -> Vec<T> {
        if self.layout.fortran_order { last_axis_fastest(&written, self.shape()) } else { written }
    }
}

/// Converts values from Fortran to C order.
pub(crate) fn last_axis_fastest<T: Copy>(values: &[T], shape: &[usize]) -> Vec<T> {
    let mut step = 1;
    let mut axes: Vec<(usize, usize, usize)> = Vec::with_capacity(shape.len());
    for &length in shape {
        axes.push((0, length, step));
        step *= length;
    }
    let mut at = 0;
    let mut next = || {
        let value = values[at];
        for (place, length, step) in axes.iter_mut().rev() {
            *place += 1;
            at += *step;
            if *place < *length {
                break;
            }
            *place = 0;
            at -= *step * *length;
        }
        value
    };
    (0..values.len()).map(|_| next()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_of_axes() {
        let written = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(last_axis_fastest(&written, &[2, 3]), [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
        assert_eq!(last_axis_fastest(&written, &[6]), written);
        assert_eq!(last_axis_fastest::<f32>(&[], &[0, 3]), [0.0; 0]);
    }

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
