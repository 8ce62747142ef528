//! The transfer as a matrix.

use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use uvgraft::{Operator as CoreOperator, Size};

use crate::arrays::{numbers, shape_text, shaped};
use crate::error::bad_value;
use crate::threads;

/// The linear part ``H`` of a transfer, with its transpose; from `Graft.operator`.
///
/// Values are float32. Channels are independent of each other, and alpha is one like any other, so
/// colours have to be premultiplied. Where UV islands overlap, the island that owns a texel is read.
#[pyclass(frozen, module = "uvgraft", name = "Operator")]
pub(crate) struct Operator {
    pub(crate) operator: Arc<CoreOperator>,
    pub(crate) threads: Option<usize>,
}

/// A product with the matrix or its transpose, on texels of some channels.
type Product = fn(&CoreOperator, usize, &[f32]) -> Vec<f32>;

/// Most planes that are processed as the channels of one texture.
const MAX_CHANNELS: usize = 4;

#[pymethods]
impl Operator {
    /// Height and width of source textures.
    #[getter]
    fn source_shape(&self) -> (u32, u32) {
        let Size { width, height } = self.operator.source_size();
        (height, width)
    }

    /// Height and width of target textures.
    #[getter]
    fn target_shape(&self) -> (u32, u32) {
        let Size { width, height } = self.operator.target_size();
        (height, width)
    }

    /// Apply ``H``.
    ///
    /// Parameters
    /// ----------
    /// texture : array_like of float32, shape (h, w) or (h, w, channels)
    ///     A source texture, 1 to 4 channels.
    /// threads : int, optional
    ///     In place of the graft's own.
    ///
    /// Returns
    /// -------
    /// ndarray of float32
    ///     The target texture, with as many axes. Texels that nothing reaches are 0.
    #[pyo3(signature = (texture, *, threads=None))]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        texture: &Bound<'py, PyAny>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let sizes = [self.operator.source_size(), self.operator.target_size()];
        self.product(py, texture, sizes, CoreOperator::apply, threads)
    }

    /// Apply the transpose of ``H``.
    ///
    /// Parameters
    /// ----------
    /// texture : array_like of float32, shape (h, w) or (h, w, channels)
    ///     A target texture, 1 to 4 channels.
    /// threads : int, optional
    ///     In place of the graft's own.
    ///
    /// Returns
    /// -------
    /// ndarray of float32
    ///     A source texture, with as many axes. Texels that nothing reads are 0.
    #[pyo3(signature = (texture, *, threads=None))]
    fn adjoint<'py>(
        &self,
        py: Python<'py>,
        texture: &Bound<'py, PyAny>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let sizes = [self.operator.target_size(), self.operator.source_size()];
        self.product(py, texture, sizes, CoreOperator::apply_transposed, threads)
    }

    /// `H` on planes of shape `(planes, height, width)`, any number of them.
    #[pyo3(signature = (planes, *, threads=None))]
    fn _forward_planes<'py>(
        &self,
        py: Python<'py>,
        planes: &Bound<'py, PyAny>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let sizes = [self.operator.source_size(), self.operator.target_size()];
        self.plane_product(py, planes, sizes, CoreOperator::apply, threads)
    }

    /// `Hᵀ` on planes.
    #[pyo3(signature = (planes, *, threads=None))]
    fn _adjoint_planes<'py>(
        &self,
        py: Python<'py>,
        planes: &Bound<'py, PyAny>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let sizes = [self.operator.target_size(), self.operator.source_size()];
        self.plane_product(py, planes, sizes, CoreOperator::apply_transposed, threads)
    }

    /// Return the matrix in SciPy's form.
    ///
    /// Parameters
    /// ----------
    /// threads : int, optional
    ///     In place of the graft's own.
    ///
    /// Returns
    /// -------
    /// (data, indices, indptr) : (ndarray of float32, ndarray of int32, ndarray of int64)
    ///     Rows are texels of the target and columns texels of the source, both row by row.
    /// shape : (int, int)
    ///     ``scipy.sparse.csr_array(*operator.csr())`` is the matrix.
    #[pyo3(signature = (*, threads=None))]
    fn csr<'py>(
        &self,
        py: Python<'py>,
        threads: Option<i64>,
    ) -> PyResult<(Bound<'py, PyAny>, (usize, usize))> {
        let operator = Arc::clone(&self.operator);
        let (source, target) = (operator.source_size(), operator.target_size());
        let threads = threads::checked(threads)?.or(self.threads);
        let rows = threads::run(py, threads, || operator.matrix().rows(0..target.height))?;
        let mut starts = Vec::with_capacity(rows.ends.len() + 1);
        starts.push(0_i64);
        starts.extend(rows.ends.iter().map(|&end| end as i64));
        // A texture has at most 2³⁰ texels, so columns fit.
        let columns: Vec<i32> = rows.columns.into_iter().map(u32::cast_signed).collect();
        let parts = (
            PyArray1::from_vec(py, rows.values),
            PyArray1::from_vec(py, columns),
            PyArray1::from_vec(py, starts),
        );
        Ok((parts.into_pyobject(py)?.into_any(), (target.texels(), source.texels())))
    }

    fn __repr__(&self) -> String {
        let (source, target) = (self.source_shape(), self.target_shape());
        format!("<uvgraft.Operator: {source:?} to {target:?}>")
    }
}

impl Operator {
    fn product<'py>(
        &self,
        py: Python<'py>,
        given: &Bound<'py, PyAny>,
        [from, to]: [Size; 2],
        product: Product,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (shape, values) = numbers::<f32>(given, "texture", "float32")?;
        let (height, width) = (from.height as usize, from.width as usize);
        let channels = match shape[..] {
            [rows, columns] if (rows, columns) == (height, width) => 1,
            [rows, columns, channels @ 1..=MAX_CHANNELS] if (rows, columns) == (height, width) => {
                channels
            }
            _ => {
                return Err(bad_value(format_args!(
                    "texture must have shape ({height}, {width}) or ({height}, {width}, channels) \
                     with 1 to 4 channels, got {}",
                    shape_text(&shape)
                )));
            }
        };
        let threads = threads::checked(threads)?.or(self.threads);
        let done = threads::run(py, threads, || product(&self.operator, channels, &values))?;
        let mut of_result = vec![to.height as usize, to.width as usize];
        of_result.extend(shape.get(2));
        shaped(py, done, of_result)
    }

    fn plane_product<'py>(
        &self,
        py: Python<'py>,
        given: &Bound<'py, PyAny>,
        [from, to]: [Size; 2],
        product: Product,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (shape, values) = numbers::<f32>(given, "planes", "float32")?;
        let (height, width) = (from.height as usize, from.width as usize);
        let count = match shape[..] {
            [count, rows, columns] if (rows, columns) == (height, width) => count,
            _ => {
                return Err(bad_value(format_args!(
                    "planes must have shape (planes, {height}, {width}), got {}",
                    shape_text(&shape)
                )));
            }
        };
        let threads = threads::checked(threads)?.or(self.threads);
        let done = threads::run(py, threads, || {
            let mut done = vec![0.0; count * to.texels()];
            let groups = values.chunks(from.texels() * MAX_CHANNELS);
            for (group, done) in groups.zip(done.chunks_mut(to.texels() * MAX_CHANNELS)) {
                let channels = group.len() / from.texels();
                let result = product(&self.operator, channels, &interleaved(group, channels));
                separate(&result, channels, done);
            }
            done
        })?;
        shaped(py, done, vec![count, to.height as usize, to.width as usize])
    }
}

/// The texels of planes that follow each other.
fn interleaved(planes: &[f32], channels: usize) -> Vec<f32> {
    let texels = planes.len() / channels;
    let mut values = vec![0.0; planes.len()];
    for (channel, plane) in planes.chunks_exact(texels).enumerate() {
        for (texel, &value) in values.chunks_exact_mut(channels).zip(plane) {
            texel[channel] = value;
        }
    }
    values
}

/// The reverse of [`interleaved`].
fn separate(values: &[f32], channels: usize, planes: &mut [f32]) {
    let texels = values.len() / channels;
    for (channel, plane) in planes.chunks_exact_mut(texels).enumerate() {
        for (value, texel) in plane.iter_mut().zip(values.chunks_exact(channels)) {
            *value = texel[channel];
        }
    }
}
