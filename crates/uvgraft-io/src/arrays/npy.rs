//! NPY files of any array.
//!
//! Source: `numpy.lib.format`, versions 1.0 to 3.0.

use super::error::Unread;
use super::named::Held;
use super::numeric::{NumericArray, count};
use crate::numpy::text::TextDtype;
use crate::numpy::{Dtype, MAX_AXES, NpyArray, length};
use crate::obj::shown;

/// The content of an NPY file.
pub(crate) enum Content<'a> {
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
        self.dtype.bytes(&self.shape)
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
    let array = parse(header)?;
    let Some(dtype) = array.dtype() else { return Ok(None) };
    let (shape, fortran_order) = (lengths(&array)?, array.fortran_order);
    Ok(Some(Described { dtype, shape, fortran_order }))
}

fn parse(bytes: &[u8]) -> Result<NpyArray<'_>, Unread> {
    match NpyArray::parse(bytes) {
        Some(array) => array.map_err(|error| Unread::Broken(error.to_string())),
        None => Err(Unread::Broken(format!("must be an NPY array, got `{}`", shown(bytes)))),
    }
}

fn lengths(array: &NpyArray<'_>) -> Result<Vec<usize>, Unread> {
    let shape = array.axes.as_ref().map(|axes| axes.iter().copied().map(length).collect());
    shape.ok_or_else(|| {
        let found = shown(array.shape);
        Unread::Broken(format!("shape must have at most {MAX_AXES} dimensions, got {found}"))
    })
}

/// Reads an NPY file. `spend` receives the number of values before they are read.
pub(crate) fn read<'a>(
    bytes: &'a [u8],
    spend: impl FnOnce(usize) -> Result<(), Unread>,
) -> Result<Content<'a>, Unread> {
    let array = parse(bytes)?;
    let Some(descr) = array.dtype_text() else {
        return Err(Unread::Unusable("a structured array".to_owned()));
    };
    if matches!(descr, b"|O" | b"O" | b"|O8" | b"O8") {
        return Ok(Content::Pickle(array.values));
    }
    let shape = lengths(&array)?;
    let check = |width: Option<usize>| {
        let wanted = match width.map(|width| array.check_length(width)) {
            Some(Ok(())) => return Ok(()),
            Some(Err(wanted)) => wanted.to_string(),
            None => "more".to_owned(),
        };
        let found = array.values.len();
        Err(Unread::Broken(format!(
            "an array of shape {shape:?} must have {wanted} bytes, got {found}"
        )))
    };
    if let Some(dtype) = TextDtype::from_text(descr) {
        check(dtype.width())?;
        return match count(&shape) {
            Some(1) => match dtype.read(array.values) {
                Some(text) => Ok(Content::Held(Held::Text(text))),
                None => Err(Unread::Broken("invalid character in a string".to_owned())),
            },
            _ => Err(Unread::Unusable(format!("an array of strings of shape {shape:?}"))),
        };
    }
    let Some(dtype) = array.dtype() else {
        return Err(Unread::Unusable(format!("an array of dtype `{}`", shown(descr))));
    };
    check(Some(dtype.width))?;
    spend(array.values.len() / dtype.width)?;
    let array = NumericArray::stored(shape, array.fortran_order, dtype, array.values)?;
    Ok(Content::Held(Held::Array(array)))
}
