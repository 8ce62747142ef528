//! NumPy arrays of numbers.

use super::value::Id;
use crate::numpy::order::last_axis_fastest;
use crate::numpy::text::TextDtype;
use crate::numpy::{Dtype, NumberKind};

/// What an array holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Items {
    Numbers(Dtype),
    Texts(TextDtype),
    /// Whatever the pickle holds, one by one.
    Objects,
}

impl Items {
    /// From NumPy's notation; nothing for structures, dates and other rare things.
    pub(super) fn from_text(text: &str) -> Option<Self> {
        match text {
            "O" | "O8" | "O4" | "|O" | "|O8" => Some(Self::Objects),
            _ => Dtype::from_text(text)
                .map(Self::Numbers)
                .or_else(|| TextDtype::from_text(text.as_bytes()).map(Self::Texts)),
        }
    }
}

/// What an array is, and which value of the pickle holds its bytes.
#[derive(Debug)]
pub(super) struct ArrayLayout {
    pub(super) dtype: Dtype,
    pub(super) shape: Vec<usize>,
    pub(super) fortran_order: bool,
    pub(super) data: Id,
}

impl ArrayLayout {
    /// The bytes that the shape asks for, if they can be counted.
    pub(super) fn bytes(&self) -> Option<usize> {
        self.dtype.bytes(&self.shape)
    }
}

/// An array whose bytes are as many as its shape says.
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

    /// How its numbers are written.
    pub const fn dtype(&self) -> Dtype {
        self.layout.dtype
    }

    /// Its numbers as they are written.
    pub const fn bytes(&self) -> &'p [u8] {
        self.data
    }

    /// Whether the first axis runs fastest.
    pub const fn is_fortran_order(&self) -> bool {
        self.layout.fortran_order
    }

    /// Its numbers, the last axis running fastest, if they are 32-bit floats.
    pub fn f32s(&self) -> Option<Vec<f32>> {
        let Dtype { kind: NumberKind::Float, width: 4, big_endian } = self.layout.dtype else {
            return None;
        };
        let read = if big_endian { f32::from_be_bytes } else { f32::from_le_bytes };
        let written: Vec<f32> =
            self.data.as_chunks::<4>().0.iter().map(|&word| read(word)).collect();
        Some(self.ordered(written))
    }

    /// How many numbers there are.
    pub const fn count(&self) -> usize {
        self.data.len() / self.layout.dtype.width
    }

    /// Its numbers, the last axis running fastest, if they are integers that fit 64 bits with a sign.
    pub fn integers(&self) -> Option<Vec<i64>> {
        let dtype = self.layout.dtype;
        if !dtype.is_integer() {
            return None;
        }
        let written = self.data.chunks_exact(dtype.width).map(|bytes| dtype.integer(bytes));
        Some(self.ordered(written.collect::<Result<Vec<i64>, u64>>().ok()?))
    }

    fn ordered<T: Copy>(&self, written: Vec<T>) -> Vec<T> {
        if self.layout.fortran_order { last_axis_fastest(&written, self.shape()) } else { written }
    }
}
