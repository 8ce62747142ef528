//! Numeric NumPy arrays.

use super::node::ArrayLayout;
use crate::numpy::order::last_axis_fastest;
use crate::numpy::{Dtype, NumberKind};

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
