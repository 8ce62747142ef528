//! NPY files of a single array.

use super::header::{Header, HeaderError, axes, unquoted};
use super::{Dtype, MAGIC, MAX_AXES};

/// A parsed NPY file. The header's claims are compared with the data that follows before any value
/// is read.
#[derive(Debug, Clone)]
pub(crate) struct NpyArray<'a> {
    /// The dtype as written, with its quotes.
    pub(crate) descr: &'a [u8],
    /// The shape as written.
    pub(crate) shape: &'a [u8],
    /// The lengths of the axes; `None` if the shape is not a tuple of at most [`MAX_AXES`] lengths.
    pub(crate) axes: Option<Vec<u64>>,
    /// Whether the first axis is contiguous.
    pub(crate) fortran_order: bool,
    /// The data after the header.
    pub(crate) values: &'a [u8],
}

impl<'a> NpyArray<'a> {
    /// Parses the header of a file; `None` if it is not NPY.
    pub(crate) fn parse(bytes: &'a [u8]) -> Option<Result<Self, HeaderError>> {
        let header = Header::parse(bytes.strip_prefix(MAGIC)?);
        Some(header.map(|Header { descr, fortran_order, shape, values }| Self {
            descr,
            shape,
            axes: axes(shape, MAX_AXES),
            fortran_order,
            values,
        }))
    }

    /// The dtype without its quotes; `None` for structured arrays.
    pub(crate) fn dtype_text(&self) -> Option<&'a [u8]> {
        unquoted(self.descr)
    }

    /// The dtype, if it is numeric.
    pub(crate) fn dtype(&self) -> Option<Dtype> {
        self.dtype_text().and_then(|text| std::str::from_utf8(text).ok()).and_then(Dtype::from_text)
    }

    /// Checks that the number of bytes matches the shape.
    ///
    /// - `width`: bytes of one value.
    ///
    /// # Errors
    /// The required number of bytes, saturated at 128 bits.
    pub(crate) fn check_length(&self, width: usize) -> Result<(), u128> {
        let axes = self.axes.iter().flatten();
        let wanted = axes.fold(width as u128, |product, &axis| product.saturating_mul(axis.into()));
        if wanted == self.values.len() as u128 { Ok(()) } else { Err(wanted) }
    }
}
