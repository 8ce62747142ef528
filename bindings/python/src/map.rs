//! Sampling maps as arrays.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use uvgraft::threads::for_each_chunk;
use uvgraft::{MapOptions, Prefer, SamplingMap as CoreMap, Size};

use crate::arguments::{chosen, direction, size};
use crate::arrays::{array, shaped};
use crate::error::bad_value;
use crate::pair;
use crate::threads;

/// For each texel of a target texture, where in the source its value comes from.
///
/// Parameters
/// ----------
/// pair : Pair or path
///     The meshes: a pair, or a pair file.
/// size : int or (int, int)
///     Size of the target: a side in texels, or ``(height, width)``.
/// reverse : bool
///     From the pair's target to its source.
/// gutter : int
///     Width of the gutter around UV islands in texels, 0 to 256.
/// prefer : {"first", "left", "right"}
///     UV island that owns texels that several cover.
/// threads : int, optional
///     Number of threads, 0 for one per processor; see `set_threads`.
#[pyclass(frozen, module = "uvgraft", name = "SamplingMap")]
pub(crate) struct SamplingMap {
    pub(crate) map: Arc<CoreMap>,
    pub(crate) threads: Option<usize>,
}

#[pymethods]
impl SamplingMap {
    #[new]
    #[pyo3(signature = (
        pair, *, size, reverse=false, gutter=16, prefer="first", threads=None
    ))]
    fn new(
        py: Python<'_>,
        pair: &Bound<'_, PyAny>,
        size: &Bound<'_, PyAny>,
        reverse: bool,
        gutter: u32,
        prefer: &str,
        threads: Option<i64>,
    ) -> PyResult<Self> {
        let size = crate::arguments::size("size", size)?;
        let options = options(gutter, chosen("prefer", prefer)?)?;
        let threads = threads::checked(threads)?;
        let pair = Arc::clone(&pair::pair(pair, "a Pair or a path")?.get().file.pair);
        let map =
            threads::run(py, threads, || CoreMap::new(&pair, direction(reverse), size, &options))?;
        Ok(Self { map: Arc::new(map), threads })
    }

    /// Height and width in texels.
    #[getter]
    fn shape(&self) -> (u32, u32) {
        let Size { width, height } = self.map.size();
        (height, width)
    }

    /// Return source positions as UV coordinates.
    ///
    /// Parameters
    /// ----------
    /// gutter : bool
    ///     Whether the gutter has positions too.
    ///
    /// Returns
    /// -------
    /// ndarray of float32, shape (height, width, 2)
    ///     Origin at the top left, 0 to 1 across the source; NaN where nothing is read.
    #[pyo3(signature = (*, gutter=true))]
    fn uv<'py>(&self, py: Python<'py>, gutter: bool) -> PyResult<Bound<'py, PyAny>> {
        self.positions(py, gutter, f32::NAN, |uv| uv.map(|value| value as f32))
    }

    /// Return positions for ``torch.nn.functional.grid_sample`` with ``align_corners=False``.
    #[pyo3(signature = (*, gutter=true))]
    fn _grid<'py>(&self, py: Python<'py>, gutter: bool) -> PyResult<Bound<'py, PyAny>> {
        // Outside of -1 to 1 by more than any filter reads, so padding with zeros gives 0.
        self.positions(py, gutter, -3.0, |uv| uv.map(|value| (2.0 * value - 1.0) as f32))
    }

    /// Return source positions for ``cv2.remap``.
    ///
    /// Parameters
    /// ----------
    /// source_size : int or (int, int)
    ///     Size of source textures.
    /// gutter : bool
    ///     Whether the gutter has positions too.
    ///
    /// Returns
    /// -------
    /// x, y : ndarray of float32, shape (height, width)
    ///     Texel indices in the source, 0 at the centre of the first; -10000 where nothing is read.
    #[pyo3(signature = (source_size, *, gutter=true))]
    fn remap<'py>(
        &self,
        py: Python<'py>,
        source_size: &Bound<'py, PyAny>,
        gutter: bool,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let source = size("source_size", source_size)?;
        let sides = [f64::from(source.width), f64::from(source.height)];
        let both: [Bound<'py, PyAny>; 2] = {
            let on = |axis: usize| {
                self.values(py, gutter, -1e4_f32, move |uv| (uv[axis] * sides[axis] - 0.5) as f32)
            };
            [on(0)?, on(1)?]
        };
        Ok(both.into())
    }

    /// Return the triangle of the target that owns each texel.
    ///
    /// Parameters
    /// ----------
    /// gutter : bool
    ///     Whether texels of the gutter belong to the triangle beside them.
    ///
    /// Returns
    /// -------
    /// ndarray of int32, shape (height, width)
    ///     Indices of faces, -1 where there is none.
    #[pyo3(signature = (*, gutter=false))]
    fn faces<'py>(&self, py: Python<'py>, gutter: bool) -> PyResult<Bound<'py, PyAny>> {
        let map = Arc::clone(&self.map);
        let Size { width, height } = map.size();
        let faces = threads::run(py, self.threads, || {
            let mut faces = vec![-1_i32; map.size().texels()];
            for_each_chunk(&mut faces, width as usize, |row, faces| {
                for &run in map.row(row as u32).iter().filter(|run| gutter || !map.is_gutter(**run))
                {
                    let face = map.patches()[run.patch as usize].face.cast_signed();
                    faces[run.x as usize..(run.x + run.len) as usize].fill(face);
                }
            });
            faces
        })?;
        shaped(py, faces, vec![height as usize, width as usize])
    }

    /// Return where linked triangles own texels: uint8 of shape (height, width), 255 inside.
    fn mask<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mask = py.detach(|| self.map.mask());
        array(py, mask, true)
    }

    /// Numbers of texels that are ``linked``, in the ``gutter``, ``covered`` and ``overlapping``.
    #[getter]
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = self.map.stats();
        let stats = PyDict::new(py);
        stats.set_item("linked", found.linked)?;
        stats.set_item("gutter", found.gutter)?;
        stats.set_item("covered", found.covered)?;
        stats.set_item("overlapping", found.overlapping)?;
        Ok(stats)
    }

    fn __repr__(&self) -> String {
        let (shape, stats) = (self.shape(), self.map.stats());
        format!("<uvgraft.SamplingMap {shape:?}: {} texels linked>", stats.linked)
    }
}

impl SamplingMap {
    /// A value for each texel, made from its source UV.
    fn values<'py, T: numpy::Element + Copy + Send + Sync>(
        &self,
        py: Python<'py>,
        gutter: bool,
        nowhere: T,
        value: impl Fn([f64; 2]) -> T + Send + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Size { width, height } = self.map.size();
        let values = self.texel_values(py, gutter, nowhere, value)?;
        shaped(py, values, vec![height as usize, width as usize])
    }

    /// Two values for each texel.
    fn positions<'py>(
        &self,
        py: Python<'py>,
        gutter: bool,
        nowhere: f32,
        value: impl Fn([f64; 2]) -> [f32; 2] + Send + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Size { width, height } = self.map.size();
        let values = self.texel_values(py, gutter, [nowhere; 2], value)?;
        // Two floats lie in memory as an array of two does.
        let values = values.into_flattened();
        shaped(py, values, vec![height as usize, width as usize, 2])
    }

    fn texel_values<T: Copy + Send + Sync>(
        &self,
        py: Python<'_>,
        gutter: bool,
        nowhere: T,
        value: impl Fn([f64; 2]) -> T + Send + Sync,
    ) -> PyResult<Vec<T>> {
        let map = Arc::clone(&self.map);
        let width = map.size().width as usize;
        threads::run(py, self.threads, || {
            let mut values = vec![nowhere; map.size().texels()];
            for_each_chunk(&mut values, width, |row, values| {
                let y = row as f64 + 0.5;
                for &run in map.row(row as u32).iter().filter(|run| gutter || !map.is_gutter(**run))
                {
                    let at = &map.patches()[run.patch as usize].src_uv_from_tgt_px;
                    for x in run.x..run.x + run.len {
                        values[x as usize] = value(at.at([f64::from(x) + 0.5, y]));
                    }
                }
            });
            values
        })
    }
}

/// Options of a map.
pub(crate) fn options(gutter: u32, prefer: Prefer) -> PyResult<MapOptions> {
    if gutter > 256 {
        return Err(bad_value(format_args!("gutter must be from 0 to 256 texels, got {gutter}")));
    }
    Ok(MapOptions::with_gutter(gutter).prefer(prefer))
}
