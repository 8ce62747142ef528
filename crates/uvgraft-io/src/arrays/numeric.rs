//! Numeric arrays, independent of their stored type.

use std::borrow::Cow;

use super::error::Unread;
use crate::numpy::order::last_axis_fastest;
use crate::numpy::{Dtype, NumberKind};

/// A shape and its values, with the last axis contiguous. An array without axes is a scalar.
#[derive(Debug, Clone, PartialEq)]
pub struct NumericArray {
    shape: Vec<usize>,
    numbers: Numbers,
}

/// The value types that are distinguished: every other one fits into one of them without loss.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Numbers {
    F32(Vec<f32>),
    F64(Vec<f64>),
    I64(Vec<i64>),
}

impl NumericArray {
    /// An array of 32-bit floats; `None` if their number does not match the shape.
    pub fn new_f32(shape: Vec<usize>, values: Vec<f32>) -> Option<Self> {
        Self::new(shape, Numbers::F32(values))
    }

    /// An array of 64-bit floats; `None` if their number does not match the shape.
    pub fn new_f64(shape: Vec<usize>, values: Vec<f64>) -> Option<Self> {
        Self::new(shape, Numbers::F64(values))
    }

    /// An array of integers; `None` if their number does not match the shape.
    pub fn new_i64(shape: Vec<usize>, values: Vec<i64>) -> Option<Self> {
        Self::new(shape, Numbers::I64(values))
    }

    pub(super) fn new(shape: Vec<usize>, numbers: Numbers) -> Option<Self> {
        (count(&shape) == Some(numbers.len())).then_some(Self { shape, numbers })
    }

    /// As [`NumericArray::new`], for values with the first axis contiguous.
    pub(super) fn new_in_fortran_order(shape: Vec<usize>, numbers: Numbers) -> Option<Self> {
        if count(&shape) != Some(numbers.len()) {
            return None;
        }
        let numbers = match numbers {
            Numbers::F32(values) => Numbers::F32(last_axis_fastest(&values, &shape)),
            Numbers::F64(values) => Numbers::F64(last_axis_fastest(&values, &shape)),
            Numbers::I64(values) => Numbers::I64(last_axis_fastest(&values, &shape)),
        };
        Some(Self { shape, numbers })
    }

    /// As [`NumericArray::new`], from the bytes of the values in a file.
    pub(super) fn stored(
        shape: Vec<usize>,
        is_fortran: bool,
        dtype: Dtype,
        bytes: &[u8],
    ) -> Result<Self, Unread> {
        let numbers = Numbers::decode(dtype, bytes).ok_or_else(beyond_63_bits)?;
        let array = if is_fortran {
            Self::new_in_fortran_order(shape, numbers)
        } else {
            Self::new(shape, numbers)
        };
        array.ok_or_else(|| Unread::broken("shape and number of values do not match"))
    }

    /// As [`NumericArray::new`], from the bytes of the values; `None` also for integers beyond 63
    /// bits.
    pub(crate) fn decode(shape: Vec<usize>, dtype: Dtype, bytes: &[u8]) -> Option<Self> {
        Self::new(shape, Numbers::decode(dtype, bytes)?)
    }

    /// As [`NumericArray::new`], from the upper halves of 32-bit floats, such as torch's
    /// `bfloat16`.
    pub(crate) fn decode_brain(shape: Vec<usize>, bytes: &[u8], big_endian: bool) -> Option<Self> {
        Self::new(shape, Numbers::decode_brain(bytes, big_endian))
    }

    /// The lengths of its axes.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    pub(super) const fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// Shape and values, which must match.
    pub(super) const fn from_parts(shape: Vec<usize>, numbers: Numbers) -> Self {
        Self { shape, numbers }
    }

    pub(super) fn into_parts(self) -> (Vec<usize>, Numbers) {
        (self.shape, self.numbers)
    }

    /// Its values as 32-bit floats, rounded to nearest; larger doubles become infinite.
    pub fn f32s(&self) -> Cow<'_, [f32]> {
        match &self.numbers {
            Numbers::F32(values) => Cow::Borrowed(values),
            Numbers::F64(values) => values.iter().map(|&value| value as f32).collect(),
            Numbers::I64(values) => values.iter().map(|&value| value as f32).collect(),
        }
    }

    /// Its values as 64-bit floats; integers beyond 2⁵³ are rounded.
    pub fn f64s(&self) -> Cow<'_, [f64]> {
        match &self.numbers {
            Numbers::F32(values) => values.iter().map(|&value| f64::from(value)).collect(),
            Numbers::F64(values) => Cow::Borrowed(values),
            Numbers::I64(values) => values.iter().map(|&value| value as f64).collect(),
        }
    }

    /// Its values if all are integers: integers, bools as 0 and 1, and floats without a fraction up
    /// to 2⁵³. Values are returned as stored: a root's parent stored as an unsigned -1 is
    /// 4294967295.
    pub fn integers(&self) -> Option<Vec<i64>> {
        match &self.numbers {
            Numbers::F32(values) => values.iter().map(|&value| whole(value.into())).collect(),
            Numbers::F64(values) => values.iter().map(|&value| whole(value)).collect(),
            Numbers::I64(values) => Some(values.clone()),
        }
    }
}

pub(super) fn beyond_63_bits() -> Unread {
    Unread::Unusable("an array of integers beyond 63 bits".to_owned())
}

fn whole(value: f64) -> Option<i64> {
    const EXACT: f64 = (1_u64 << 53) as f64;
    (value.fract() == 0.0 && value.abs() <= EXACT).then_some(value as i64)
}

/// The number of values of a shape, unless it overflows.
pub(super) fn count(shape: &[usize]) -> Option<usize> {
    shape.iter().copied().try_fold(1, usize::checked_mul)
}

impl Numbers {
    pub(super) const fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
            Self::I64(values) => values.len(),
        }
    }

    /// An empty list with capacity; floats of 64 bits will be rounded to 32.
    pub(super) fn with_capacity(dtype: Dtype, count: usize) -> Self {
        match dtype.kind {
            NumberKind::Float => Self::F32(Vec::with_capacity(count)),
            _ => Self::I64(Vec::with_capacity(count)),
        }
    }

    /// Decodes values from bytes and appends them to a list made by [`Numbers::with_capacity`];
    /// false for integers beyond 63 bits.
    pub(super) fn extend_decoded(&mut self, dtype: Dtype, bytes: &[u8]) -> bool {
        if let (Self::F32(values), NumberKind::Float, 4, false) =
            (&mut *self, dtype.kind, dtype.width, dtype.big_endian)
        {
            values.extend(bytes.as_chunks::<4>().0.iter().map(|&word| f32::from_le_bytes(word)));
            return true;
        }
        match (self, Self::decode(dtype, bytes)) {
            (Self::F32(values), Some(Self::F32(more))) => values.extend(more),
            (Self::F32(values), Some(Self::F64(more))) => {
                values.extend(more.into_iter().map(|value| value as f32));
            }
            (Self::I64(values), Some(Self::I64(more))) => values.extend(more),
            _ => return false,
        }
        true
    }

    /// Decodes values from bytes; `None` for integers beyond 63 bits.
    pub(super) fn decode(dtype: Dtype, bytes: &[u8]) -> Option<Self> {
        let Dtype { kind, width, big_endian } = dtype;
        Some(match (kind, width) {
            (NumberKind::Float, 2) => {
                Self::F32(words(bytes, big_endian, |word| from_half(u16::from_le_bytes(word))))
            }
            (NumberKind::Float, 4) => Self::F32(words(bytes, big_endian, f32::from_le_bytes)),
            (NumberKind::Float, _) => Self::F64(words(bytes, big_endian, f64::from_le_bytes)),
            (NumberKind::Bool, _) => {
                Self::I64(bytes.iter().map(|&byte| i64::from(byte != 0)).collect())
            }
            (NumberKind::Signed, 1) => {
                Self::I64(bytes.iter().map(|&byte| i64::from(byte.cast_signed())).collect())
            }
            (NumberKind::Signed, 2) => {
                Self::I64(words(bytes, big_endian, |word| i16::from_le_bytes(word).into()))
            }
            (NumberKind::Signed, 4) => {
                Self::I64(words(bytes, big_endian, |word| i32::from_le_bytes(word).into()))
            }
            (NumberKind::Signed, _) => Self::I64(words(bytes, big_endian, i64::from_le_bytes)),
            (NumberKind::Unsigned, 1) => Self::I64(bytes.iter().map(|&byte| byte.into()).collect()),
            (NumberKind::Unsigned, 2) => {
                Self::I64(words(bytes, big_endian, |word| u16::from_le_bytes(word).into()))
            }
            (NumberKind::Unsigned, 4) => {
                Self::I64(words(bytes, big_endian, |word| u32::from_le_bytes(word).into()))
            }
            (NumberKind::Unsigned, _) => {
                let values = words(bytes, big_endian, i64::from_le_bytes);
                if values.iter().any(|&value| value < 0) {
                    return None;
                }
                Self::I64(values)
            }
        })
    }

    /// Decodes values from the upper halves of 32-bit floats, such as torch's `bfloat16`.
    fn decode_brain(bytes: &[u8], big_endian: bool) -> Self {
        Self::F32(words(bytes, big_endian, |[low, high]| f32::from_le_bytes([0, 0, low, high])))
    }
}

fn words<const WIDTH: usize, T>(
    bytes: &[u8],
    big_endian: bool,
    read: impl Fn([u8; WIDTH]) -> T,
) -> Vec<T> {
    let words = bytes.as_chunks::<WIDTH>().0.iter();
    if big_endian {
        words
            .map(|&(mut word)| {
                word.reverse();
                read(word)
            })
            .collect()
    } else {
        words.map(|&word| read(word)).collect()
    }
}

/// Converts a 16-bit IEEE 754 float to a 32-bit one, which is exact.
fn from_half(bits: u16) -> f32 {
    let sign = u32::from(bits & 0x8000) << 16;
    let exponent = u32::from(bits >> 10 & 0x1f);
    let fraction = u32::from(bits & 0x3ff);
    let magnitude = match exponent {
        // Subnormal, in units of 2⁻²⁴.
        0 => (fraction as f32 / 16_777_216.0).to_bits(),
        // Infinity and NaN.
        31 => 0xff << 23 | fraction << 13,
        // The exponent bias is 15 here, 127 there.
        _ => (exponent + 112) << 23 | fraction << 13,
    };
    f32::from_bits(sign | magnitude)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(text: &str, bytes: &[u8]) -> NumericArray {
        let dtype = Dtype::from_text(text).unwrap();
        let numbers = Numbers::decode(dtype, bytes).unwrap();
        NumericArray::new(vec![bytes.len() / dtype.width], numbers).unwrap()
    }

    #[test]
    fn every_kind_of_number() {
        let integers = |text, bytes: &[u8]| decode(text, bytes).integers().unwrap();
        assert_eq!(integers("|b1", &[0, 7]), [0, 1]);
        assert_eq!(integers("|i1", &[0xff]), [-1]);
        assert_eq!(integers("|u1", &[0xff]), [255]);
        assert_eq!(integers("<i2", &[0xfe, 0xff]), [-2]);
        assert_eq!(integers(">u2", &[1, 5]), [261]);
        assert_eq!(integers(">i4", &[0xff, 0xff, 0xff, 0xfe]), [-2]);
        assert_eq!(integers("<u4", &[0xff; 4]), [4_294_967_295]);
        assert_eq!(integers("<i8", &[0xff; 8]), [-1]);
        assert_eq!(integers("<u8", &[1, 0, 0, 0, 0, 0, 0, 0]), [1]);
        assert_eq!(Numbers::decode(Dtype::from_text("<u8").unwrap(), &[0xff; 8]), None);
        assert_eq!(decode("<f4", &1.5_f32.to_le_bytes()).f64s()[..], [1.5]);
        assert_eq!(decode(">f8", &0.1_f64.to_be_bytes()).f64s()[..], [0.1]);
        assert_eq!(decode(">f8", &0.1_f64.to_be_bytes()).f32s()[..], [0.1]);
        assert_eq!(decode("<i2", &[3, 0]).f32s()[..], [3.0]);
    }

    #[test]
    fn halves() {
        let cases = [
            (0x0000, 0.0),
            (0x3c00, 1.0),
            (0xc100, -2.5),
            (0x7bff, 65_504.0),
            // The smallest one, and the largest subnormal one.
            (0x0001, 2.0_f32.powi(-24)),
            (0x03ff, 1023.0 * 2.0_f32.powi(-24)),
            (0x0400, 2.0_f32.powi(-14)),
            (0xfc00, f32::NEG_INFINITY),
        ];
        for (bits, value) in cases {
            assert_eq!(from_half(bits), value, "{bits:04x}");
        }
        assert_eq!(from_half(0x8000).to_bits(), 0x8000_0000);
        assert!(from_half(0x7e00).is_nan());
        assert_eq!(Numbers::decode_brain(&[0x20, 0xc0], false), Numbers::F32(vec![-2.5]));
        assert_eq!(Numbers::decode_brain(&[0xc0, 0x20], true), Numbers::F32(vec![-2.5]));
    }

    #[test]
    fn whole_numbers_only_are_integers() {
        let integers = |values| NumericArray::new_f64(vec![2], values).unwrap().integers();
        assert_eq!(integers(vec![4_294_967_295.0, -2.0]), Some(vec![4_294_967_295, -2]));
        for none in [0.5, f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(integers(vec![0.0, none]), None);
        }
        let floats = NumericArray::new_f32(vec![], vec![7.0]).unwrap();
        assert_eq!(floats.integers(), Some(vec![7]));
    }

    #[test]
    fn shapes_and_numbers_agree() {
        assert!(NumericArray::new_f32(vec![2, 3], vec![0.0; 6]).is_some());
        assert!(NumericArray::new_f32(vec![2, 3], vec![0.0; 5]).is_none());
        assert!(NumericArray::new_i64(vec![], vec![]).is_none());
        assert!(NumericArray::new_f64(vec![usize::MAX, 2], vec![]).is_none());
        assert!(NumericArray::new_f64(vec![5, 0], vec![]).is_some());
        let written = Numbers::I64(vec![0, 1, 2, 3, 4, 5]);
        let turned = NumericArray::new_in_fortran_order(vec![2, 3], written.clone()).unwrap();
        assert_eq!(turned.integers().unwrap(), [0, 2, 4, 1, 3, 5]);
        assert!(NumericArray::new_in_fortran_order(vec![7], written).is_none());
    }
}
