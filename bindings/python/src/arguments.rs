//! Arguments that are more than a type: names, sizes, sides.

use pyo3::prelude::*;
use uvgraft::blend::Side;
use uvgraft::{
    Content, Direction, Encoding, Filter, NormalOptions, NormalY, Overlap, Prefer, Size, Tone,
};

use crate::error::{bad_type, bad_value};

/// The value that goes with a name.
///
/// # Errors
/// `ValueError` with all names.
pub(crate) fn chosen<T: Copy>(what: &str, name: &str, choices: &[(&str, T)]) -> PyResult<T> {
    choices.iter().find(|(known, _)| *known == name).map(|&(_, value)| value).ok_or_else(|| {
        let names: Vec<String> = choices.iter().map(|(name, _)| format!("{name:?}")).collect();
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

pub(crate) fn filter(name: &str) -> PyResult<Filter> {
    let choices = [
        ("nearest", Filter::Nearest),
        ("bilinear", Filter::Bilinear),
        ("catmull-rom", Filter::CatmullRom),
        ("lanczos3", Filter::Lanczos3),
    ];
    chosen("filter", name, &choices)
}

/// The name of a filter.
pub(crate) fn filter_name(filter: Filter) -> &'static str {
    match filter {
        Filter::Nearest => "nearest",
        Filter::Bilinear => "bilinear",
        Filter::CatmullRom => "catmull-rom",
        _ => "lanczos3",
    }
}

/// The encoding of colours in arrays.
pub(crate) fn color_encoding(name: &str) -> PyResult<Encoding> {
    chosen("encoding", name, &[("srgb", Encoding::Srgb), ("linear", Encoding::Linear)])
}

pub(crate) fn prefer(name: &str) -> PyResult<Prefer> {
    let choices = [("first", Prefer::First), ("left", Prefer::Left), ("right", Prefer::Right)];
    chosen("prefer", name, &choices)
}

pub(crate) fn overlap(name: &str) -> PyResult<Overlap> {
    chosen("overlap", name, &[("first", Overlap::First), ("average", Overlap::Average)])
}

pub(crate) fn tone(name: &str) -> PyResult<Option<Tone>> {
    let choices = [
        ("base", Some(Tone::Base)),
        ("source", Some(Tone::Source)),
        ("both", Some(Tone::Both)),
        ("none", None),
    ];
    chosen("tone", name, &choices)
}

pub(crate) fn side(name: &str) -> PyResult<Side> {
    chosen("side", name, &[("source", Side::Source), ("target", Side::Target)])
}

fn normal_y(what: &str, name: &str) -> PyResult<NormalY> {
    chosen(what, name, &[("opengl", NormalY::OpenGl), ("directx", NormalY::DirectX)])
}

/// What textures hold; the conventions are those of normal maps.
pub(crate) fn content(name: &str, from: &str, to: Option<&str>) -> PyResult<Content> {
    let source = normal_y("normal_y", from)?;
    let target = to.map_or(Ok(source), |name| normal_y("normal_y_out", name))?;
    let normals = Content::Normals(NormalOptions::new(source, target));
    let choices = [("color", Content::Color), ("data", Content::Data), ("normals", normals)];
    chosen("content", name, &choices)
}

pub(crate) const fn direction(reverse: bool) -> Direction {
    if reverse { Direction::Reverse } else { Direction::Forward }
}

/// A size: a side, or `(height, width)` as in an array's shape.
///
/// # Errors
/// `TypeError` for anything else, `ValueError` for sizes that no texture can have.
pub(crate) fn size(what: &str, given: &Bound<'_, PyAny>) -> PyResult<Size> {
    let wanted = || bad_type(format_args!("{what} must be a number of texels or (height, width)"));
    let [height, width] = if let Ok(side) = given.extract::<i64>() {
        [side; 2]
    } else {
        let (height, width) = given.extract::<(i64, i64)>().map_err(|_| wanted())?;
        [height, width]
    };
    let max = uvgraft::Texture::MAX_SIDE;
    let side = |texels: i64| match u32::try_from(texels) {
        Ok(texels) if (1..=max).contains(&texels) => Ok(texels),
        _ => Err(bad_value(format_args!("{what} must be 1 to {max} texels a side, got {texels}"))),
    };
    Ok(Size::new(side(width)?, side(height)?))
}
