//! NumPy's notation: NPY files, dtypes and orders of axes.
//!
//! Source: `numpy.lib.format`, versions 1.0 to 3.0.

mod array;
mod dtype;
pub(crate) mod header;
pub(crate) mod order;
pub(crate) mod text;

use std::io::{self, Write};

pub(crate) use self::array::NpyArray;
pub use self::dtype::{Dtype, NumberKind};
pub use self::header::HeaderError;

/// The magic of NPY files.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// Maximum number of axes: the limit of NumPy 2. Version 1 had 32.
pub(crate) const MAX_AXES: usize = 64;

/// Header and values together start at a multiple of this.
const ALIGNMENT: usize = 64;

/// A length that a file tells. Where lengths have 32 bits, nothing is as long as the longest of them, which
/// therefore stands for all that are longer.
pub(crate) fn length(declared: u64) -> usize {
    usize::try_from(declared).unwrap_or(usize::MAX)
}

/// Writes everything before the values of an array in C order; `descr` is the dtype in NumPy's
/// notation, such as `<f4`.
///
/// # Errors
/// Those of `out`.
pub(crate) fn write_header(descr: &str, shape: &[usize], out: &mut impl Write) -> io::Result<()> {
    write_ordered_header(descr, shape, false, out)
}

/// As [`write_header`], for values in C order or in Fortran order, in which the first axis is
/// contiguous.
pub(crate) fn write_ordered_header(
    descr: &str,
    shape: &[usize],
    fortran_order: bool,
    out: &mut impl Write,
) -> io::Result<()> {
    // A tuple with one element has a trailing comma.
    let shape = match shape {
        [length] => format!("{length},"),
        shape => shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
    };
    let order = if fortran_order { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({shape}), }}");
    let fixed = MAGIC.len() + 4;
    let end = (fixed + header.len() + 1).next_multiple_of(ALIGNMENT);
    let padded = end - fixed - 1;
    let header = format!("{header:padded$}\n");
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    // A few axes take a few hundred bytes at most, far from the limit of 65,535.
    out.write_all(&(header.len() as u16).to_le_bytes())?;
    out.write_all(header.as_bytes())
}
