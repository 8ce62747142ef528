//! Arguments that are more than a type: names, sizes, sides.

use pyo3::prelude::*;
use uvgraft::{Choice, Content, Direction, Encoding, NormalOptions, NormalY, Size};

use crate::error::{bad_type, bad_value};

/// The choice of a name.
///
/// # Errors
/// `ValueError` with all names.
pub(crate) fn chosen<T: Choice>(what: &str, name: &str) -> PyResult<T> {
    chosen_of(what, name, T::ALL)
}

/// As [`chosen`], of some values alone.
pub(crate) fn chosen_of<T: Choice>(what: &str, name: &str, values: &[T]) -> PyResult<T> {
    let named: Vec<(&str, T)> = values.iter().map(|&value| (value.name(), value)).collect();
    chosen_from(what, name, &named)
}

/// As [`chosen`], for values that are no choice elsewhere.
pub(crate) fn chosen_from<T: Copy>(what: &str, name: &str, named: &[(&str, T)]) -> PyResult<T> {
    named.iter().find(|(known, _)| *known == name).map(|&(_, value)| value).ok_or_else(|| {
        let names: Vec<String> = named.iter().map(|(name, _)| format!("{name:?}")).collect();
        bad_value(format_args!("{what} must be {}, got {name:?}", listed(&names)))
    })
}

/// `a, b or c`.
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// The encodings that colours in arrays may have.
pub(crate) const COLOR_ENCODINGS: &[Encoding] = &[Encoding::Srgb, Encoding::Linear];

/// The encoding of colours in arrays.
pub(crate) fn color_encoding(name: &str) -> PyResult<Encoding> {
    chosen_of("encoding", name, COLOR_ENCODINGS)
}

/// What textures hold; the conventions are those of normal maps.
pub(crate) fn content(name: &str, from: &str, to: Option<&str>) -> PyResult<Content> {
    let source: NormalY = chosen("normal_y", from)?;
    let target = to.map_or(Ok(source), |name| chosen("normal_y_out", name))?;
    let normals = Content::Normals(NormalOptions::new(source, target));
    let choices = [("color", Content::Color), ("data", Content::Data), ("normals", normals)];
    chosen_from("content", name, &choices)
}

pub(crate) const fn direction(reverse: bool) -> Direction {
    if reverse { Direction::Reverse } else { Direction::Forward }
}

/// A size: a side, or `(height, width)` as in an array's shape.
///
/// # Errors
/// `TypeError` for anything else, `ValueError` for sizes that no texture can have.
pub(crate) fn size(what: &str, given: &Bound<'_, PyAny>) -> PyResult<Size> {
    size_or(what, given, |wanted| bad_value(format_args!("{what} {wanted}")))
}

/// As [`size`], with another error for sizes that no texture can have.
///
/// - `refused`: makes it of what they must be.
pub(crate) fn size_or(
    what: &str,
    given: &Bound<'_, PyAny>,
    refused: impl Fn(String) -> PyErr,
) -> PyResult<Size> {
    let [height, width] = if let Ok(side) = given.extract::<i64>() {
        [side; 2]
    } else {
        given.extract::<[i64; 2]>().map_err(|_| {
            bad_type(format_args!("{what} must be a number of texels or (height, width)"))
        })?
    };
    let max = uvgraft::Texture::MAX_SIDE;
    let side = |texels: i64| match u32::try_from(texels) {
        Ok(texels) if (1..=max).contains(&texels) => Ok(texels),
        _ => Err(refused(format!("must be 1 to {max} texels a side, got {texels}"))),
    };
    Ok(Size::new(side(width)?, side(height)?))
}
