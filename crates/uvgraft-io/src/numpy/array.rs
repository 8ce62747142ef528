//! NPY files of one array.

use super::header::{Header, HeaderError, axes, unquoted};
use super::{Dtype, MAGIC, MAX_AXES};

/// An NPY file taken apart. Its claims are compared with the bytes that follow before any value is read.
#[derive(Debug, Clone)]
pub(crate) struct NpyArray<'a> {
    /// The dtype as it is written, with its quotes.
    pub(crate) descr: &'a [u8],
    /// The shape as it is written.
    pub(crate) shape: &'a [u8],
    /// The lengths of its axes; nothing where the shape is not a tuple of at most [`MAX_AXES`] lengths.
    pub(crate) axes: Option<Vec<u64>>,
    /// Whether the first axis runs fastest.
    pub(crate) fortran_order: bool,
    /// What follows the header.
    pub(crate) values: &'a [u8],
}

impl<'a> NpyArray<'a> {
    /// Reads the header of a file; nothing if it is not NPY.
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

    /// The dtype without its quotes; nothing for arrays of structures.
    pub(crate) fn dtype_text(&self) -> Option<&'a [u8]> {
        unquoted(self.descr)
    }

    /// The dtype, if it is one of numbers.
    pub(crate) fn dtype(&self) -> Option<Dtype> {
        self.dtype_text().and_then(|text| std::str::from_utf8(text).ok()).and_then(Dtype::from_text)
    }

    /// Checks that the values are as many bytes as the shape asks for.
    ///
    /// - `width`: bytes of one value.
    ///
    /// # Errors
    /// The bytes that there must be; what 128 bits cannot count is the most that they can.
    pub(crate) fn check_length(&self, width: usize) -> Result<(), u128> {
        let axes = self.axes.iter().flatten();
        let wanted = axes.fold(width as u128, |product, &axis| product.saturating_mul(axis.into()));
        if wanted == self.values.len() as u128 { Ok(()) } else { Err(wanted) }
    }
}
