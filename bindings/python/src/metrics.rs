//! Metrics of two textures, with the numbers of `uvgraft compare`.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use uvgraft::{Choice, Encoding, Size};
use uvgraft_metrics::lpips::Lpips;
use uvgraft_metrics::{self as metrics, Colors, Mask, Measure, Metric};

use crate::arguments::{chosen, chosen_from, color_encoding};
use crate::arrays::texture;
use crate::error::{bad_type, bad_value, failed};
use crate::lpips_weights;
use crate::threads;

const NO_FLIP: &str = "this build of uvgraft lacks the feature `flip`";

const NO_WEIGHTS: &str = "LPIPS needs weights: import them by `uvgraft weights import` (see \
                          `uvgraft weights --help`), or give the path of a weights file as weights";

/// Two textures, and what of them is compared.
struct Compared {
    reference: Colors,
    test: Colors,
    mask: Option<Mask>,
    threads: Option<usize>,
}

impl Compared {
    fn new(
        reference: &Bound<'_, PyAny>,
        test: &Bound<'_, PyAny>,
        mask: Option<&Bound<'_, PyAny>>,
        encoding: &str,
        threads: Option<i64>,
    ) -> PyResult<Self> {
        let encoding = color_encoding(encoding)?;
        let threads = threads::checked(threads)?;
        let reference = colors(reference, "reference", encoding)?;
        let test = colors(test, "test", encoding)?;
        same_size("test", test.size(), reference.size())?;
        let mask = mask.map(|mask| selected(mask, reference.size())).transpose()?;
        Ok(Self { reference, test, mask, threads })
    }

    fn by_formula(&self, py: Python<'_>, measure: Measure) -> PyResult<f64> {
        let Self { reference, test, mask, threads } = self;
        threads::run(py, *threads, || measure(reference, test, mask.as_ref()))?.map_err(bad_value)
    }

    fn by_network(&self, py: Python<'_>, network: &Lpips) -> PyResult<f64> {
        let Self { reference, test, mask, threads } = self;
        let work = || {
            let maps = network.compare(reference, test)?;
            mask.as_ref().map_or_else(|| Ok(maps.mean()), |mask| maps.masked_mean(mask))
        };
        threads::run(py, *threads, work)?.map_err(bad_value)
    }
}

fn colors(given: &Bound<'_, PyAny>, what: &str, encoding: Encoding) -> PyResult<Colors> {
    let texture = texture(given, what, encoding)?.texture;
    let colors = given.py().detach(|| Colors::new(texture));
    colors.map_err(|error| bad_value(format_args!("{what}: {error}")))
}

fn selected(given: &Bound<'_, PyAny>, wanted: Size) -> PyResult<Mask> {
    if let Ok(array) = given.cast::<PyUntypedArray>()
        && !matches!((array.dtype().kind(), array.dtype().itemsize()), (b'b' | b'u', 1))
    {
        let found = array.dtype().str()?.to_string();
        return Err(bad_type(format_args!("mask must have dtype bool or uint8, got {found}")));
    }
    // A mask is data, so one half is one half whatever encoding a file states.
    let texture = texture(given, "mask", Encoding::Data)?.texture.with_encoding(Encoding::Data);
    same_size("mask", texture.size(), wanted)?;
    Mask::from_texture(&texture).map_err(|_| {
        bad_value("mask selects no texel: some must be True, or at least half white (128 of 255)")
    })
}

fn same_size(what: &str, found: Size, wanted: Size) -> PyResult<()> {
    if found == wanted {
        return Ok(());
    }
    Err(bad_value(format_args!(
        "{what} must have the height and width of reference, ({}, {}), got ({}, {})",
        wanted.height, wanted.width, found.height, found.width
    )))
}

/// Return the mean absolute error: the mean of ``|reference - test|`` over texels and channels.
///
/// As all metrics, it compares colours as displayed: in sRGB from 0 to 1, over black where they are
/// transparent, with grey as three equal channels. Values outside 0 to 1 are not clamped.
///
/// Parameters
/// ----------
/// reference, test : ndarray, PIL image or path
///     Two textures of the same height and width; dtypes and channels may differ.
/// mask : ndarray of bool or uint8, shape (height, width), PIL image or path, optional
///     The texels that count: True, or at least half white (128 of 255).
/// encoding : {"srgb", "linear"}
///     Encoding of colours in arrays; files have their own.
/// threads : int, optional
///     Number of threads, 0 for one per processor; see `set_threads`. It does not affect the result.
///
/// Returns
/// -------
/// float
///     0.0 for identical textures, 1.0 for black against white; lower is better.
///
/// Raises
/// ------
/// TypeError
///     For other dtypes.
/// ValueError
///     If sizes differ, the mask selects no texel, or a value is NaN or infinite.
/// OSError
///     For files that cannot be read.
#[pyfunction]
#[pyo3(signature = (reference, test, *, mask=None, encoding="srgb", threads=None))]
pub(crate) fn l1(
    py: Python<'_>,
    reference: &Bound<'_, PyAny>,
    test: &Bound<'_, PyAny>,
    mask: Option<&Bound<'_, PyAny>>,
    encoding: &str,
    threads: Option<i64>,
) -> PyResult<f64> {
    Compared::new(reference, test, mask, encoding, threads)?.by_formula(py, metrics::l1)
}

/// Return the peak signal-to-noise ratio, ``10 log10(1 / mean((reference - test)²))``.
///
/// It equals scikit-image's ``peak_signal_noise_ratio`` with ``data_range=1``.
///
/// Parameters
/// ----------
/// reference, test, mask, encoding, threads
///     As in `l1`.
///
/// Returns
/// -------
/// float
///     Decibels; higher is better, ``inf`` for identical textures.
///
/// Raises
/// ------
/// TypeError, ValueError, OSError
///     As `l1`.
#[pyfunction]
#[pyo3(signature = (reference, test, *, mask=None, encoding="srgb", threads=None))]
pub(crate) fn psnr(
    py: Python<'_>,
    reference: &Bound<'_, PyAny>,
    test: &Bound<'_, PyAny>,
    mask: Option<&Bound<'_, PyAny>>,
    encoding: &str,
    threads: Option<i64>,
) -> PyResult<f64> {
    Compared::new(reference, test, mask, encoding, threads)?.by_formula(py, metrics::psnr)
}

/// Return the structural similarity (SSIM), each channel separately.
///
/// It equals scikit-image's ``structural_similarity`` with ``data_range=1`` and ``channel_axis=-1``,
/// and for the Gaussian window ``gaussian_weights=True, sigma=1.5, use_sample_covariance=False``. The
/// mean runs over texels whose window lies inside the texture, and with a mask over those that it
/// selects; their windows extend beyond the mask.
///
/// Parameters
/// ----------
/// reference, test, mask, encoding, threads
///     As in `l1`.
/// window : {"gaussian", "uniform"}
///     A Gaussian of 11 texels with sigma 1.5, as proposed by Wang et al., or 7 × 7 texels with the
///     sample covariance, scikit-image's default (``ssim-uniform`` of the command).
///
/// Returns
/// -------
/// float
///     1.0 for identical textures, down to -1.0; higher is better.
///
/// Raises
/// ------
/// TypeError, OSError
///     As `l1`.
/// ValueError
///     As `l1`, for textures smaller than the window, and for masks that select only texels near the
///     texture's edge.
#[pyfunction]
#[pyo3(signature = (
    reference, test, *, window="gaussian", mask=None, encoding="srgb", threads=None
))]
pub(crate) fn ssim(
    py: Python<'_>,
    reference: &Bound<'_, PyAny>,
    test: &Bound<'_, PyAny>,
    window: &str,
    mask: Option<&Bound<'_, PyAny>>,
    encoding: &str,
    threads: Option<i64>,
) -> PyResult<f64> {
    let windows: [(&str, Measure); 2] =
        [("gaussian", metrics::ssim), ("uniform", metrics::ssim_uniform)];
    let measure = chosen_from("window", window, &windows)?;
    Compared::new(reference, test, mask, encoding, threads)?.by_formula(py, measure)
}

/// Return the SSIMULACRA 2 score of a texture as a copy of a reference.
///
/// It is not symmetric. Values are clamped to 0 to 1. With a mask, texels outside it count as identical
/// and both textures are cropped to the mask's bounding box, so scores with different masks are not
/// comparable.
///
/// Parameters
/// ----------
/// reference, test, mask, encoding, threads
///     As in `l1`.
///
/// Returns
/// -------
/// float
///     100.0 for identical textures, 90 where hardly anybody sees a difference side by side, 50 for
///     medium quality, below 0 beyond the range that it is made for; higher is better.
///
/// Raises
/// ------
/// TypeError, OSError
///     As `l1`.
/// ValueError
///     As `l1`, and for less than 8 texels a side, within the mask's bounding box if there is one.
#[pyfunction]
#[pyo3(signature = (reference, test, *, mask=None, encoding="srgb", threads=None))]
pub(crate) fn ssimulacra2(
    py: Python<'_>,
    reference: &Bound<'_, PyAny>,
    test: &Bound<'_, PyAny>,
    mask: Option<&Bound<'_, PyAny>>,
    encoding: &str,
    threads: Option<i64>,
) -> PyResult<f64> {
    Compared::new(reference, test, mask, encoding, threads)?.by_formula(py, metrics::ssimulacra2)
}

/// Return LDR-FLIP, the difference seen when alternating between two textures.
///
/// The mean of its error map at 67 texels per degree of visual angle, on textures rounded to 8 bits.
/// It equals the authors' ``flip-evaluator`` with its default settings within 1e-4. An optional feature
/// of the build.
///
/// Parameters
/// ----------
/// reference, test, mask, encoding, threads
///     As in `l1`.
///
/// Returns
/// -------
/// float
///     0.0 for identical textures, up to 1.0; lower is better.
///
/// Raises
/// ------
/// uvgraft.Error
///     In builds without the feature ``flip``.
/// TypeError, ValueError, OSError
///     As `l1`.
#[pyfunction]
#[pyo3(signature = (reference, test, *, mask=None, encoding="srgb", threads=None))]
pub(crate) fn flip(
    py: Python<'_>,
    reference: &Bound<'_, PyAny>,
    test: &Bound<'_, PyAny>,
    mask: Option<&Bound<'_, PyAny>>,
    encoding: &str,
    threads: Option<i64>,
) -> PyResult<f64> {
    let Some(measure) = Metric::Flip.measure() else { return Err(failed(NO_FLIP)) };
    Compared::new(reference, test, mask, encoding, threads)?.by_formula(py, measure)
}

/// Return LPIPS 0.1, learned perceptual image patch similarity.
///
/// It matches the Python package ``lpips`` 0.1.4: with a mask, its spatial map averaged over the mask,
/// where a texel's value also depends on its surroundings. The weights are not part of uvgraft. Those
/// of a file are kept in memory.
///
/// Parameters
/// ----------
/// reference, test, mask, encoding, threads
///     As in `l1`.
/// network : {"alex", "vgg"}
///     AlexNet, which the authors recommend for measuring, or VGG16, at some twenty times the cost.
/// weights : path, optional
///     A weights file, as ``uvgraft weights import`` writes it; by default the imported one, or the one
///     that the environment variable ``UVGRAFT_WEIGHTS`` names.
///
/// Returns
/// -------
/// float
///     0.0 for identical textures, seldom above 1.0; lower is better.
///
/// Raises
/// ------
/// uvgraft.Error
///     If no weights were imported, or the file is damaged.
/// TypeError, OSError
///     As `l1`.
/// ValueError
///     As `l1`, and for textures too small for the network.
#[pyfunction]
#[pyo3(signature = (
    reference, test, *, network="alex", weights=None, mask=None, encoding="srgb", threads=None
))]
pub(crate) fn lpips(
    py: Python<'_>,
    reference: &Bound<'_, PyAny>,
    test: &Bound<'_, PyAny>,
    network: &str,
    weights: Option<PathBuf>,
    mask: Option<&Bound<'_, PyAny>>,
    encoding: &str,
    threads: Option<i64>,
) -> PyResult<f64> {
    let network = chosen("network", network)?;
    let compared = Compared::new(reference, test, mask, encoding, threads)?;
    let network = lpips_weights::read(py, network, weights.as_deref())?;
    compared.by_network(py, &*network.ok_or_else(|| failed(NO_WEIGHTS))?)
}

/// Compare two textures by several metrics, as the command ``uvgraft compare``.
///
/// Parameters
/// ----------
/// reference, test, mask, encoding, threads
///     As in `l1`.
/// metrics : str or iterable of str, optional
///     Of "l1", "psnr", "ssim", "ssim-uniform", "ssimulacra2", "flip", "lpips-alex" and "lpips-vgg"; or
///     "all". By default all but the slow one, "lpips-vgg".
/// weights : path, optional
///     As in `lpips`.
///
/// Returns
/// -------
/// dict of str to float
///     The values by metric, in the order above; see the functions of the metrics. Metrics that were
///     not named and cannot be computed are left out: of textures that are too small, for want of
///     weights, or of the feature ``flip``.
///
/// Raises
/// ------
/// uvgraft.Error
///     If a metric is named whose weights were not imported, or that the build lacks; if weights are
///     damaged.
/// TypeError, ValueError, OSError
///     As `l1`; and for metrics that do not exist, or are named and need larger textures.
#[pyfunction]
#[pyo3(signature = (
    reference, test, *, mask=None, metrics=None, weights=None, encoding="srgb", threads=None
))]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    reference: &Bound<'py, PyAny>,
    test: &Bound<'py, PyAny>,
    mask: Option<&Bound<'py, PyAny>>,
    metrics: Option<&Bound<'py, PyAny>>,
    weights: Option<PathBuf>,
    encoding: &str,
    threads: Option<i64>,
) -> PyResult<Bound<'py, PyDict>> {
    let selection = Selection::new(metrics)?;
    let networks = selection.ready(py, weights.as_deref())?;
    let compared = Compared::new(reference, test, mask, encoding, threads)?;
    let values = PyDict::new(py);
    for (metric, ready) in networks {
        let value = match &ready {
            Ready::Formula(measure) => compared.by_formula(py, *measure),
            Ready::Lpips(network) => compared.by_network(py, network),
        };
        match value {
            Ok(value) => values.set_item(metric.name(), value)?,
            Err(error) if selection.is_named || !is_of_value(py, &error) => return Err(error),
            Err(_) => {}
        }
    }
    Ok(values)
}

fn is_of_value(py: Python<'_>, error: &PyErr) -> bool {
    error.is_instance_of::<pyo3::exceptions::PyValueError>(py)
}

/// Metrics to compute, in the order of [`Metric::ALL`].
struct Selection {
    metrics: Vec<Metric>,
    /// Whether they were named, so that one that cannot be computed is an error.
    is_named: bool,
}

/// A metric with all that it needs.
enum Ready {
    Formula(Measure),
    Lpips(Arc<Lpips>),
}

impl Selection {
    fn new(given: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let of = |is_chosen: &dyn Fn(Metric) -> bool, is_named| {
            let metrics = Metric::ALL.iter().copied().filter(|metric| is_chosen(*metric));
            Ok(Self { metrics: metrics.collect(), is_named })
        };
        let Some(given) = given else { return of(&|metric| !metric.is_slow(), false) };
        let names: Vec<String> = match given.extract::<String>() {
            Ok(name) => vec![name],
            Err(_) => given
                .try_iter()
                .and_then(|names| names.map(|name| name?.extract()).collect())
                .map_err(|_| bad_type("metrics must be names of metrics"))?,
        };
        if names.iter().any(|name| name == "all") {
            return of(&|_| true, false);
        }
        let named: Vec<Metric> =
            names.iter().map(|name| chosen("metrics", name)).collect::<PyResult<_>>()?;
        of(&|metric| named.contains(&metric), true)
    }

    /// Loads what the metrics need.
    fn ready(
        &self,
        py: Python<'_>,
        weights: Option<&std::path::Path>,
    ) -> PyResult<Vec<(Metric, Ready)>> {
        let mut all = Vec::new();
        for &metric in &self.metrics {
            let ready = match (metric.measure(), metric.network()) {
                (Some(measure), _) => Ok(Ready::Formula(measure)),
                (None, Some(network)) => {
                    lpips_weights::read(py, network, weights)?.map(Ready::Lpips).ok_or(NO_WEIGHTS)
                }
                (None, None) => Err(NO_FLIP),
            };
            match ready {
                Ok(ready) => all.push((metric, ready)),
                Err(reason) if self.is_named => {
                    return Err(failed(format_args!("{}: {reason}", metric.name())));
                }
                Err(_) => {}
            }
        }
        Ok(all)
    }
}
