//! NPY files of any array.
//!
//! Source: `numpy.lib.format`, versions 1.0 to 3.0.

use super::collect::Unread;
use super::numeric::{Numbers, count};
use super::{NumericArray, named::Held};
use crate::npy::MAGIC;
use crate::npy::header::{Header, axes, unquoted};
use crate::obj::shown;
use crate::pickle::Dtype;
use crate::pickle::texts::TextDtype;

/// NumPy's maximum number of axes, in any version.
const MOST_AXES: usize = 64;

/// The content of an NPY file.
pub(super) enum Content<'a> {
    Held(Held),
    /// A pickle of an array of objects.
    Pickle(&'a [u8]),
}

/// A numeric array as its header describes it.
pub(super) struct Described {
    pub(super) dtype: Dtype,
    pub(super) shape: Vec<usize>,
    pub(super) fortran_order: bool,
}

impl Described {
    /// The size of its values in bytes, unless it overflows.
    pub(super) fn bytes(&self) -> Option<usize> {
        count(&self.shape)?.checked_mul(self.dtype.width)
    }

    /// The error for an array of the wrong size.
    pub(super) fn other_size(&self, found: u64) -> Unread {
        let wanted = self.bytes().map_or("more".to_owned(), |wanted| wanted.to_string());
        Unread::Broken(format!(
            "an array of shape {:?} must have {wanted} bytes, got {found}",
            self.shape
        ))
    }
}

/// The numeric array described by the header of an NPY file; `None` for strings, objects and
/// unsupported types.
///
/// - `header`: everything before the values.
pub(super) fn describe(header: &[u8]) -> Result<Option<Described>, Unread> {
    let Some(rest) = header.strip_prefix(MAGIC) else {
        let found = shown(header);
        return Err(Unread::Broken(format!("must be an NPY array, got `{found}`")));
    };
    let header = Header::parse(rest).map_err(|error| Unread::Broken(error.to_string()))?;
    let descr = unquoted(header.descr).and_then(|descr| std::str::from_utf8(descr).ok());
    let Some(dtype) = descr.and_then(Dtype::from_text) else { return Ok(None) };
    let (shape, fortran_order) = (lengths(&header)?, header.fortran_order);
    Ok(Some(Described { dtype, shape, fortran_order }))
}

fn lengths(header: &Header<'_>) -> Result<Vec<usize>, Unread> {
    let shape = axes(header.shape, MOST_AXES).and_then(|axes| {
        axes.into_iter().map(|length| usize::try_from(length).ok()).collect::<Option<Vec<_>>>()
    });
    shape.ok_or_else(|| {
        let found = shown(header.shape);
        Unread::Broken(format!("shape must have at most {MOST_AXES} dimensions, got {found}"))
    })
}

/// Reads an NPY file. `spend` receives the number of values before they are read.
pub(super) fn read<'a>(
    bytes: &'a [u8],
    spend: impl FnOnce(usize) -> Result<(), Unread>,
) -> Result<Content<'a>, Unread> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        let found = shown(bytes);
        return Err(Unread::Broken(format!("must be an NPY array, got `{found}`")));
    };
    let header = Header::parse(rest).map_err(|error| Unread::Broken(error.to_string()))?;
    let Some(descr) = unquoted(header.descr) else {
        return Err(Unread::LeftOut("a structured array".to_owned()));
    };
    if matches!(descr, b"|O" | b"O" | b"|O8" | b"O8") {
        return Ok(Content::Pickle(header.values));
    }
    let shape = lengths(&header)?;
    let check = |width: Option<usize>| {
        let wanted = count(&shape).zip(width).and_then(|(count, width)| count.checked_mul(width));
        let found = header.values.len();
        if wanted == Some(found) {
            return Ok(());
        }
        let wanted = wanted.map_or("more".to_owned(), |wanted| wanted.to_string());
        Err(Unread::Broken(format!(
            "an array of shape {shape:?} must have {wanted} bytes, got {found}"
        )))
    };
    if let Some(dtype) = TextDtype::from_text(descr) {
        check(dtype.width())?;
        return match count(&shape) {
            Some(1) => match dtype.read(header.values) {
                Some(text) => Ok(Content::Held(Held::Text(text))),
                None => Err(Unread::Broken("invalid character in a string".to_owned())),
            },
            _ => Err(Unread::LeftOut(format!("an array of strings of shape {shape:?}"))),
        };
    }
    let dtype = std::str::from_utf8(descr).ok().and_then(Dtype::from_text);
    let Some(dtype) = dtype else {
        return Err(Unread::LeftOut(format!("an array of dtype `{}`", shown(descr))));
    };
    check(Some(dtype.width))?;
    spend(header.values.len() / dtype.width)?;
    let numbers = Numbers::decode(dtype, header.values)
        .ok_or_else(|| Unread::LeftOut("an array of integers beyond 63 bits".to_owned()))?;
    let array = if header.fortran_order {
        NumericArray::new_in_fortran_order(shape, numbers)
    } else {
        NumericArray::new(shape, numbers)
    };
    match array {
        Some(array) => Ok(Content::Held(Held::Array(array))),
        None => Err(Unread::Broken("shape and number of values do not match".to_owned())),
    }
}
