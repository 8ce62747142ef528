//! What requests read: files by their paths, and values of Python as the content of files.
//!
//! Values are encoded without loss. Messages call each by the name of its argument.

use std::io::Cursor;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyMapping};
use uvgraft::{Depth, Encoding};
use uvgraft_assembly::mesh_file::LoadedMesh;
use uvgraft_image::{self as image, Format, Image, WriteOptions};
use uvgraft_io::{obj, pair_file};
use uvgraft_pipeline::{BaseSource, Input};

use crate::arrays::texture;
use crate::error::{bad_value, failed, of_pipeline};
use crate::keywords::{extracted, of_type};
use crate::mesh::{Mesh, mesh};
use crate::pair::Pair;

/// An image: a path, an array or a PIL image.
///
/// - `name`: of the argument.
/// - `encoding`: of the values of an array.
///
/// # Errors
/// As [`texture`].
pub(crate) fn image(given: &Bound<'_, PyAny>, name: &str, encoding: Encoding) -> PyResult<Input> {
    if let Ok(path) = given.extract::<PathBuf>() {
        return Ok(Input::from(path));
    }
    let texture = texture(given, name, encoding)?.texture;
    // TIFF is the only format that keeps 32-bit floats and straight alpha.
    let format = if texture.depth() == Depth::F32 { Format::TIFF } else { Format::PNG };
    let encoded = given.py().detach(|| {
        let mut out = Cursor::new(Vec::new());
        image::encode(&Image::from(texture), format, &WriteOptions::default(), &mut out)
            .map(|_| out.into_inner())
    });
    encoded.map(|bytes| Input::bytes(name, bytes)).map_err(failed)
}

/// What something is laid over: a colour such as `#c08a70`, or an image.
///
/// # Errors
/// As [`image`], and `uvgraft.Error` for what begins like a colour but is none.
pub(crate) fn base(
    given: &Bound<'_, PyAny>,
    name: &str,
    encoding: Encoding,
) -> PyResult<BaseSource> {
    match given.extract::<PathBuf>() {
        Ok(path) => match path.to_str() {
            Some(text) => BaseSource::parse(text)
                .map_err(|failure| of_pipeline(failure.context(format_args!("`{name}`")))),
            None => Ok(BaseSource::image(path)),
        },
        Err(_) => image(given, name, encoding).map(BaseSource::Image),
    }
}

/// Images by role.
///
/// - `make`: what becomes of an image, with its name and the encoding of its values.
///
/// # Errors
/// As `make`, and `TypeError` for what is not a mapping.
pub(crate) fn by_role<T>(
    given: &Bound<'_, PyAny>,
    name: &str,
    make: impl Fn(&Bound<'_, PyAny>, &str, Encoding) -> PyResult<T>,
) -> PyResult<Vec<(String, T)>> {
    let wanted = "a mapping of roles to images";
    let images = given.cast::<PyMapping>().map_err(|_| of_type(given, name, wanted))?.items()?;
    let image = |item: Bound<'_, PyAny>| {
        let (role, image): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let role: String = extracted(&role, name, wanted)?;
        // Only emitted light is colour; the other maps keep their values.
        let is_color = role.eq_ignore_ascii_case("emissive");
        let encoding = if is_color { Encoding::Srgb } else { Encoding::Data };
        let image = make(&image, &format!("{name}[{role:?}]"), encoding)?;
        Ok((role, image))
    };
    images.iter().map(image).collect()
}

/// One image, a sequence of these, or an array of several.
///
/// # Errors
/// As [`image`].
pub(crate) fn images(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Input>> {
    let axes = given.getattr("ndim").and_then(|axes| axes.extract::<usize>());
    let is_one = given.extract::<PathBuf>().is_ok()
        || given.hasattr("getbands")?
        || axes.is_ok_and(|axes| axes < 4);
    if is_one {
        return Ok(vec![image(given, name, Encoding::Srgb)?]);
    }
    let wanted = "an image or a sequence of these";
    let images = given.try_iter().map_err(|_| of_type(given, name, wanted))?;
    images
        .enumerate()
        .map(|(index, given)| image(&given?, &format!("{name}[{index}]"), Encoding::Srgb))
        .collect()
}

/// A pair: a file, or an object as the content of one.
///
/// # Errors
/// `TypeError` for anything else.
pub(crate) fn pair(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Input> {
    if let Ok(pair) = given.cast::<Pair>() {
        let file = &pair.get().file;
        let bytes = given.py().detach(|| pair_file::encode(file)).map_err(failed)?;
        return Ok(Input::bytes(name, bytes));
    }
    extracted::<PathBuf>(given, name, "a Pair or a path").map(Input::from)
}

/// An avatar: a file, or an object with the content of one.
///
/// # Errors
/// `TypeError` for anything else.
pub(crate) fn avatar(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Input> {
    if let Ok(path) = given.extract::<PathBuf>() {
        return Ok(Input::from(path));
    }
    let other = || of_type(given, name, "an Avatar or a path");
    let file_name: String =
        given.getattr("name").and_then(|it| it.extract()).map_err(|_| other())?;
    let data = given.getattr("data").map_err(|_| other())?;
    let data = data.cast::<PyBytes>().map_err(|_| other())?;
    Ok(Input::bytes(file_name, data.as_bytes()))
}

/// What pictures show: an avatar, or a mesh in a file or of Python, as the content of an OBJ file.
///
/// # Errors
/// `TypeError` for anything else.
pub(crate) fn shown(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Input> {
    if given.extract::<PathBuf>().is_ok() || given.hasattr("data")? {
        return avatar(given, name);
    }
    if !(given.is_instance_of::<Mesh>()
        || given.hasattr("vertices")?
        || given.hasattr("geometry")?)
    {
        return Err(of_type(given, name, "an Avatar, a Mesh or a path"));
    }
    let LoadedMesh { mesh, name, .. } = mesh(given, name)?;
    let mut text = Vec::new();
    given.py().detach(|| obj::write(&mesh, &mut text)).map_err(failed)?;
    Ok(Input::bytes(name, text))
}

/// Finite numbers by name.
///
/// # Errors
/// `TypeError` for what is not a mapping, and `ValueError` for NaN and infinite values.
pub(crate) fn named_numbers(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<(String, f32)>> {
    let wanted = "a mapping of str to numbers";
    let numbers = given.cast::<PyMapping>().map_err(|_| of_type(given, name, wanted))?.items()?;
    let number = |item: Bound<'_, PyAny>| {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let key: String = extracted(&key, name, wanted)?;
        let value: f64 = extracted(&value, name, wanted)?;
        match value as f32 {
            number if number.is_finite() => Ok((key, number)),
            _ => Err(bad_value(format_args!("{name}[{key:?}] must be finite, got {value}"))),
        }
    };
    numbers.iter().map(number).collect()
}
