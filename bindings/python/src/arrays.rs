//! Textures from and to NumPy arrays.

use std::path::PathBuf;

use numpy::{
    Element, PyArray1, PyArrayDescr, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods,
    PyReadonlyArrayDyn, PyReadwriteArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyMemoryError;
use pyo3::intern;
use pyo3::prelude::*;
use uvgraft::{Channels, Depth, Encoding, Size, TexelFormat, Texels, TexelsMut, Texture};
use uvgraft_image as image;

use crate::error::{bad_type, bad_value, failed, of_reading, of_texture};

/// Modes of PIL images that are arrays of 1 to 4 channels as they are.
const PIL_MODES: [&str; 6] = ["L", "LA", "RGB", "RGBA", "I;16", "F"];

/// A texture given by a user.
#[derive(Clone)]
pub(crate) struct GivenTexture {
    pub(crate) texture: Texture,
    /// What messages call it: its file, or the argument.
    pub(crate) name: PathBuf,
    /// Whether the array has no axis of channels, so that results should have none either.
    pub(crate) is_flat: bool,
}

/// A texture from an array, a PIL image, or the path of an image file. Its values are copied, with
/// the interpreter's lock released. Floats of other widths become 32-bit ones, booleans black and white.
///
/// - `what`: the name of the argument.
/// - `encoding`: of an array; a file has its own.
///
/// # Errors
/// `TypeError` for another type or dtype, `ValueError` for another shape, `OSError` and
/// `uvgraft.Error` for files that cannot be read.
pub(crate) fn texture(
    given: &Bound<'_, PyAny>,
    what: &str,
    encoding: Encoding,
) -> PyResult<GivenTexture> {
    let py = given.py();
    if let Ok(path) = given.extract::<PathBuf>() {
        let read = py.detach(|| image::read_with(&path, encoding.into())).map_err(of_reading)?;
        return Ok(GivenTexture { texture: read.texture, name: path, is_flat: false });
    }
    let name = file_of_pil(given).unwrap_or_else(|| PathBuf::from(what));
    let array = untyped(given, what)?;
    let (size, channels) = shape(&array, what)?;
    let is_flat = array.ndim() == 2;
    let array = contiguous(with_known_floats(array)?)?;
    let texels = if let Some(values) = copied::<u8>(&array)? {
        Texels::U8(values)
    } else if let Some(values) = copied::<u16>(&array)? {
        Texels::U16(values)
    } else if let Some(values) = copied::<f32>(&array)? {
        Texels::F32(values)
    } else if let Some(values) = converted(&array, |value: f64| value as f32)? {
        Texels::F32(values)
    } else if let Some(values) = converted(&array, |value| if value { 255 } else { 0 })? {
        Texels::U8(values)
    } else {
        let found = array.dtype().str()?.to_string();
        // NumPy makes these of whole numbers that nobody gave a type.
        let hint = match array.dtype().kind() {
            b'i' | b'u' => "; values from 0 to 255 fit into uint8: texture.astype(\"uint8\")",
            _ => "",
        };
        return Err(bad_type(format_args!(
            "{what} must have dtype uint8, uint16, float16, float32, float64 or bool (native byte \
             order), got {found}{hint}"
        )));
    };
    let texture = Texture::new(size, channels, encoding, texels).map_err(of_texture)?;
    Ok(GivenTexture { texture, name, is_flat })
}

/// The file that a PIL image was opened from.
fn file_of_pil(given: &Bound<'_, PyAny>) -> Option<PathBuf> {
    let py = given.py();
    given.getattr_opt(intern!(py, "getbands")).ok()??;
    let name = given.getattr_opt(intern!(py, "filename")).ok()??;
    name.extract().ok().filter(|name: &PathBuf| !name.as_os_str().is_empty())
}

/// An array of any dtype.
fn untyped<'py>(given: &Bound<'py, PyAny>, what: &str) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = given.py();
    if let Ok(array) = given.cast::<PyUntypedArray>() {
        // Of a masked array only the values would be left.
        if given.hasattr(intern!(py, "mask"))? {
            return Err(bad_type(format_args!(
                "{what} must not be a masked array; use filled(), and a region or alpha"
            )));
        }
        return Ok(array.clone());
    }
    if given.hasattr(intern!(py, "getbands"))? {
        let mode: String = given.getattr(intern!(py, "mode"))?.extract()?;
        if !PIL_MODES.contains(&mode.as_str()) {
            return Err(bad_value(format_args!(
                "{what}: PIL images must have mode {}, got {mode}; convert it first, such as by \
                 image.convert(\"RGB\")",
                PIL_MODES.join(", ")
            )));
        }
    } else if !given.hasattr(intern!(py, "__array__"))? {
        let found = given.get_type().name()?.to_string();
        return Err(bad_type(format_args!(
            "{what} must be a NumPy array, a PIL image or a path, got {found}"
        )));
    }
    let array = py.import(intern!(py, "numpy"))?.call_method1(intern!(py, "asarray"), (given,))?;
    Ok(array.cast_into::<PyUntypedArray>()?)
}

/// An array of 16-bit floats as one of 32-bit floats, which can be read; any other as it is.
fn with_known_floats(array: Bound<'_, PyUntypedArray>) -> PyResult<Bound<'_, PyUntypedArray>> {
    let py = array.py();
    let dtype = array.dtype();
    if (dtype.kind(), dtype.itemsize(), dtype.is_native_byteorder()) != (b'f', 2, Some(true)) {
        return Ok(array);
    }
    let numpy = py.import(intern!(py, "numpy"))?;
    let wide = numpy.call_method1(intern!(py, "asarray"), (array, intern!(py, "float32")))?;
    Ok(wide.cast_into::<PyUntypedArray>()?)
}

/// The storage type of an array's values, if textures have it.
pub(crate) fn depth_of(array: &Bound<'_, PyUntypedArray>) -> Option<Depth> {
    let py = array.py();
    let dtype = array.dtype();
    let is = |other: Bound<'_, PyArrayDescr>| dtype.is_equiv_to(&other);
    if is(numpy::dtype::<u8>(py)) {
        Some(Depth::U8)
    } else if is(numpy::dtype::<u16>(py)) {
        Some(Depth::U16)
    } else {
        is(numpy::dtype::<f32>(py)).then_some(Depth::F32)
    }
}

/// The size and the channels of an array of texels.
pub(crate) fn shape(array: &Bound<'_, PyUntypedArray>, what: &str) -> PyResult<(Size, Channels)> {
    let wrong = || {
        let hint = match *array.shape() {
            [.., 1..=4, height, width] if height > 4 && width > 4 => {
                "; the channels come last: numpy.moveaxis(texture, -3, -1)"
            }
            _ => "",
        };
        bad_value(format_args!(
            "{what} must have shape (height, width) or (height, width, channels) with 1 to 4 \
             channels, got {}{hint}",
            shape_text(array.shape())
        ))
    };
    let (height, width, channels) = match *array.shape() {
        [height, width] => (height, width, 1),
        [height, width, channels] => (height, width, channels),
        _ => return Err(wrong()),
    };
    let channels = channels_of(channels).ok_or_else(wrong)?;
    let max = Texture::MAX_SIDE;
    let side = |texels: usize| match u32::try_from(texels) {
        Ok(texels) if (1..=max).contains(&texels) => Ok(texels),
        _ => Err(bad_value(format_args!(
            "{what} must have 1 to {max} texels a side, got {}",
            shape_text(array.shape())
        ))),
    };
    Ok((Size::new(side(width)?, side(height)?), channels))
}

/// A shape as Python writes it.
pub(crate) fn shape_text(shape: &[usize]) -> String {
    let sides: Vec<String> = shape.iter().map(ToString::to_string).collect();
    match &sides[..] {
        [only] => format!("({only},)"),
        _ => format!("({})", sides.join(", ")),
    }
}

/// The channels of texels with a number of values.
pub(crate) fn channels_of(count: usize) -> Option<Channels> {
    match count {
        1 => Some(Channels::Grey),
        2 => Some(Channels::GreyAlpha),
        3 => Some(Channels::Rgb),
        4 => Some(Channels::Rgba),
        _ => None,
    }
}

/// The array itself if it is C-contiguous and aligned, or a copy that is.
fn contiguous(array: Bound<'_, PyUntypedArray>) -> PyResult<Bound<'_, PyUntypedArray>> {
    let py = array.py();
    let numpy = py.import(intern!(py, "numpy"))?;
    let wanted = [intern!(py, "C_CONTIGUOUS"), intern!(py, "ALIGNED")];
    let required = numpy.call_method1(intern!(py, "require"), (array, py.None(), wanted))?;
    Ok(required.cast_into::<PyUntypedArray>()?)
}

/// The values of a contiguous array; `None` if it has another dtype.
fn copied<T: Element + Copy + Send + Sync>(
    array: &Bound<'_, PyUntypedArray>,
) -> PyResult<Option<Vec<T>>> {
    converted(array, |value: T| value)
}

/// What becomes of each value of a contiguous array; `None` if it has another dtype.
fn converted<T: Element + Copy + Send + Sync, U: Send>(
    array: &Bound<'_, PyUntypedArray>,
    convert: impl Fn(T) -> U + Sync,
) -> PyResult<Option<Vec<U>>> {
    let Ok(array) = array.cast::<PyArrayDyn<T>>() else { return Ok(None) };
    let borrowed: PyReadonlyArrayDyn<'_, T> = array.try_readonly().map_err(bad_value)?;
    let values = borrowed.as_slice().map_err(bad_value)?;
    let copy = array.py().detach(|| {
        let mut copy = Vec::new();
        copy.try_reserve_exact(values.len()).map(|()| {
            copy.extend(values.iter().map(|&value| convert(value)));
            copy
        })
    });
    copy.map(Some).map_err(|_| PyMemoryError::new_err("not enough memory for a copy of an array"))
}

/// A contiguous vector of numbers in a dtype, from anything that NumPy can convert without loss.
///
/// - `what`: the name of the argument.
/// - `dtype`: that of `T`, as NumPy names it.
pub(crate) fn numbers<T: Element + Copy + Send + Sync>(
    given: &Bound<'_, PyAny>,
    what: &str,
    dtype: &str,
) -> PyResult<(Vec<usize>, Vec<T>)> {
    let py = given.py();
    let numpy = py.import(intern!(py, "numpy"))?;
    let array = numpy.call_method1(intern!(py, "asarray"), (given,))?;
    let array = array.cast_into::<PyUntypedArray>()?;
    let found = array.dtype().kind();
    let is_right = match dtype {
        "float32" | "float64" => matches!(found, b'f' | b'i' | b'u'),
        _ => matches!(found, b'i' | b'u'),
    };
    // An empty list is an array of floats to NumPy.
    let is_empty_list = array.is_empty() && found == b'f';
    if !is_right && !is_empty_list {
        let found = array.dtype().str()?.to_string();
        return Err(bad_type(format_args!(
            "{what} must hold numbers of dtype {dtype}, got {found}"
        )));
    }
    let array = numpy.call_method1(intern!(py, "asarray"), (array, dtype))?;
    let array = contiguous(array.cast_into::<PyUntypedArray>()?)?;
    let values = copied::<T>(&array)?
        .ok_or_else(|| bad_type(format_args!("{what} must hold numbers of dtype {dtype}")))?;
    Ok((array.shape().to_vec(), values))
}

/// A list of finite numbers.
///
/// # Errors
/// As [`numbers`], and `ValueError` for another shape, NaN and infinite values.
pub(crate) fn floats(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<f32>> {
    let (shape, values) = numbers::<f32>(given, what, "float32")?;
    if shape.len() != 1 || !values.iter().all(|value| value.is_finite()) {
        let given = given.repr()?;
        return Err(bad_value(format_args!("{what} must be finite, of shape (n,), got {given}")));
    }
    Ok(values)
}

/// Numbers in rows of `N`.
///
/// # Errors
/// As [`numbers`], and `ValueError` for another shape.
pub(crate) fn rows<T: Element + Copy + Send + Sync, const N: usize>(
    given: &Bound<'_, PyAny>,
    what: &str,
    dtype: &str,
) -> PyResult<Vec<[T; N]>> {
    let (shape, values) = numbers::<T>(given, what, dtype)?;
    if !matches!(shape[..], [_, columns] if columns == N) {
        return Err(bad_value(format_args!(
            "{what} must have shape (n, {N}), got {}",
            shape_text(&shape)
        )));
    }
    Ok(values.as_chunks::<N>().0.to_vec())
}

/// A texture as an array of shape `(height, width, channels)`, or `(height, width)` if it has one
/// channel and `is_flat`. The array owns the texture's memory; nothing is copied.
pub(crate) fn array<'py>(
    py: Python<'py>,
    texture: Texture,
    is_flat: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let Size { width, height } = texture.size();
    let channels = texture.channels().count();
    let shape = match (channels, is_flat) {
        (1, true) => vec![height as usize, width as usize],
        _ => vec![height as usize, width as usize, channels],
    };
    match texture.into_texels() {
        Texels::U8(values) => shaped(py, values, shape),
        Texels::U16(values) => shaped(py, values, shape),
        Texels::F32(values) => shaped(py, values, shape),
    }
}

/// An array that owns the memory of a vector.
pub(crate) fn shaped<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    shape: Vec<usize>,
) -> PyResult<Bound<'_, PyAny>> {
    Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any())
}

/// An array that results are written to.
pub(crate) enum OutArray<'py> {
    U8(PyReadwriteArrayDyn<'py, u8>),
    U16(PyReadwriteArrayDyn<'py, u16>),
    F32(PyReadwriteArrayDyn<'py, f32>),
}

impl<'py> OutArray<'py> {
    /// Checks that a result of a size and a format can be written to an array.
    ///
    /// # Errors
    /// `TypeError` and `ValueError`, with what the array must be.
    pub(crate) fn new(
        given: &Bound<'py, PyAny>,
        size: Size,
        format: TexelFormat,
    ) -> PyResult<Self> {
        let (height, width) = (size.height as usize, size.width as usize);
        let channels = format.channels.count();
        let dtype = match format.depth {
            Depth::U8 => "uint8",
            Depth::U16 => "uint16",
            Depth::F32 => "float32",
        };
        let Ok(array) = given.cast::<PyUntypedArray>() else {
            let found = given.get_type().name()?.to_string();
            return Err(bad_type(format_args!("out must be a NumPy array, got {found}")));
        };
        let is_shaped = match *array.shape() {
            [rows, columns] => channels == 1 && (rows, columns) == (height, width),
            [rows, columns, depth] => (rows, columns, depth) == (height, width, channels),
            _ => false,
        };
        if !is_shaped {
            return Err(bad_value(format_args!(
                "out must have shape ({height}, {width}, {channels}), got {}",
                shape_text(array.shape())
            )));
        }
        let found = array.dtype().str()?.to_string();
        let wrong_type = || bad_type(format_args!("out must have dtype {dtype}, got {found}"));
        Ok(match format.depth {
            Depth::U8 => Self::U8(writable(array.cast().map_err(|_| wrong_type())?)?),
            Depth::U16 => Self::U16(writable(array.cast().map_err(|_| wrong_type())?)?),
            Depth::F32 => Self::F32(writable(array.cast().map_err(|_| wrong_type())?)?),
        })
    }

    /// The array's values.
    pub(crate) fn texels_mut(&mut self) -> PyResult<TexelsMut<'_>> {
        Ok(match self {
            Self::U8(array) => TexelsMut::U8(array.as_slice_mut().map_err(bad_value)?),
            Self::U16(array) => TexelsMut::U16(array.as_slice_mut().map_err(bad_value)?),
            Self::F32(array) => TexelsMut::F32(array.as_slice_mut().map_err(bad_value)?),
        })
    }
}

/// Exclusive access to the values of an array.
fn writable<'py, T: Element>(
    array: &Bound<'py, PyArrayDyn<T>>,
) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    let is_aligned = (array.data() as usize).is_multiple_of(align_of::<T>());
    if !array.is_c_contiguous() || !is_aligned {
        return Err(bad_value("out must be C-contiguous and aligned"));
    }
    array
        .try_readwrite()
        .map_err(|_| bad_value("out must be writeable, and must not be in use by another call"))
}

/// Copies texels.
///
/// # Errors
/// `uvgraft.Error` if the formats differ, which callers rule out.
pub(crate) fn copy(from: &Texels, to: &mut TexelsMut<'_>) -> PyResult<()> {
    match (from, to) {
        (Texels::U8(from), TexelsMut::U8(to)) => to.copy_from_slice(from),
        (Texels::U16(from), TexelsMut::U16(to)) => to.copy_from_slice(from),
        (Texels::F32(from), TexelsMut::F32(to)) => to.copy_from_slice(from),
        _ => return Err(failed("internal error: formats differ")),
    }
    Ok(())
}
