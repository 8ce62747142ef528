//! Decodes the values of an NPY file in chunks, and selects columns.

use std::io::Read;
use std::ops::Range;

use super::error::Unread;
use super::npy::Described;
use super::numeric::{Numbers, NumericArray, beyond_63_bits};

/// Chunk size in bytes.
const PIECE: usize = 1 << 18;
pub(super) fn unreadable(error: &std::io::Error) -> Unread {
    Unread::Broken(error.to_string())
}

/// Decodes values in chunks, and keeps the selected columns.
pub(super) fn decode(
    entry: &mut dyn Read,
    described: &Described,
    columns: Option<&[Range<usize>]>,
    spend: impl FnOnce(usize) -> Result<(), Unread>,
) -> Result<NumericArray, Unread> {
    let (dtype, shape) = (described.dtype, &described.shape);
    let count: usize = shape.iter().product();
    let last = shape.last().copied().unwrap_or(1);
    // In Fortran order the values of a column are contiguous: everything is read.
    let columns = columns.map(|columns| clipped(columns, last));
    let straight = columns.as_ref().filter(|_| !described.fortran_order && last > 0);
    let kept: usize = straight.map_or(last, |columns| columns.iter().map(Range::len).sum());
    let total = count.checked_div(last).map_or(0, |rows| rows * kept);
    spend(total)?;
    let mut numbers = Numbers::with_capacity(dtype, total);
    // Whole rows if columns are selected, so that each chunk starts with one.
    let row = if straight.is_some() { last * dtype.width } else { dtype.width };
    let mut piece = vec![0; (PIECE / row).max(1) * row];
    let mut left = count * dtype.width;
    while left > 0 {
        let size = left.min(piece.len());
        let piece = &mut piece[..size];
        entry.read_exact(piece).map_err(|error| unreadable(&error))?;
        left -= size;
        let rows: &[Range<usize>] = straight.map_or(&[], |columns| columns);
        let fits = if straight.is_none() {
            numbers.extend_decoded(dtype, piece)
        } else {
            piece.chunks_exact(row).all(|row| {
                rows.iter().all(|columns| {
                    let bytes = columns.start * dtype.width..columns.end * dtype.width;
                    numbers.extend_decoded(dtype, &row[bytes])
                })
            })
        };
        if !fits {
            return Err(beyond_63_bits());
        }
    }
    let mut shape = shape.clone();
    if let (Some(_), Some(last)) = (straight, shape.last_mut()) {
        *last = kept;
    }
    let disagree = || Unread::broken("shape and number of values do not match");
    if described.fortran_order {
        let array = NumericArray::new_in_fortran_order(shape, numbers).ok_or_else(disagree)?;
        return match columns {
            Some(columns) => array.with_columns(&columns).ok_or_else(disagree),
            None => Ok(array),
        };
    }
    NumericArray::new(shape, numbers).ok_or_else(disagree)
}

/// The columns that exist.
fn clipped(columns: &[Range<usize>], length: usize) -> Vec<Range<usize>> {
    let clip = |range: &Range<usize>| range.start.min(length)..range.end.min(length);
    columns.iter().map(clip).filter(|range| !range.is_empty()).collect()
}

impl NumericArray {
    /// Restricted to a part of the last axis.
    pub(super) fn with_columns(self, columns: &[Range<usize>]) -> Option<Self> {
        fn choose<T: Copy>(values: &[T], last: usize, columns: &[Range<usize>]) -> Vec<T> {
            let rows = values.chunks_exact(last.max(1));
            rows.flat_map(|row| columns.iter().flat_map(|range| &row[range.clone()]))
                .copied()
                .collect()
        }
        let (mut shape, numbers) = self.into_parts();
        let last = *shape.last()?;
        let columns = clipped(columns, last);
        *shape.last_mut()? = columns.iter().map(Range::len).sum();
        let numbers = match numbers {
            Numbers::F32(values) => Numbers::F32(choose(&values, last, &columns)),
            Numbers::F64(values) => Numbers::F64(choose(&values, last, &columns)),
            Numbers::I64(values) => Numbers::I64(choose(&values, last, &columns)),
        };
        Self::new(shape, numbers)
    }

    /// With 64-bit floats rounded to 32 bits.
    pub(super) fn narrowed(self) -> Self {
        let (shape, numbers) = self.into_parts();
        let numbers = match numbers {
            Numbers::F64(values) => {
                Numbers::F32(values.into_iter().map(|value| value as f32).collect())
            }
            numbers => numbers,
        };
        Self::from_parts(shape, numbers)
    }
}
