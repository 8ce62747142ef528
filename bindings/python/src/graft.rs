//! Prepared transfers.

use std::borrow::Cow;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use uvgraft::blend::FeatherFit;
use uvgraft::layout_match::LayoutProbe;
use uvgraft::{
    Averaging, Blend, BlendDomain, BlendOptions, Choice, Content, Direction, Encoding, Filter,
    FitOptions, FitProgress, FitSummary, Graft as CoreGraft, Labels, MapOptions, NormalY, Overlap,
    Overlay, Pair as CorePair, Prefer, Size, Sizes, TexelFormat, Texels, Texture, Tone,
};
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{BlendMode, CheckedPair, LayoutChecks, ToneSide, toned, toning};

use crate::arguments::{self, chosen, direction};
use crate::arrays::{GivenTexture, OutArray, array, copy, depth_of, shape, texture};
use crate::base::Base;
use crate::batch::{self, Batch, Shared};
use crate::error::{bad_value, failed, of_graft, warn_caller};
use crate::map::{self, SamplingMap};
use crate::operator::Operator;
use crate::pair::{self, Pair};
use crate::region::selection;
use crate::threads;

/// Grafts that are kept, one for each pair of sizes.
const MAX_KEPT: usize = 4;

/// Default width of the feather of blends, in the target mesh's unit: 1 cm if that is the metre.
const DEFAULT_FEATHER: f64 = 0.01;

/// A transfer that is prepared once and applied often.
///
/// It owns everything it needs and may be used by any number of threads at once. Preparing takes
/// milliseconds, with a blend up to a second; what depends on sizes is prepared with the first texture
/// of a size. It can be pickled: the pickle holds the pair and the options. Called like a function, it
/// does what `apply` does.
///
/// Parameters
/// ----------
/// pair : Pair or path
///     The meshes: a pair, or a pair file.
/// size : int or (int, int), optional
///     Size of results where the base is not an image: a side in texels, or ``(height, width)``.
/// reverse : bool
///     Transfer from the pair's target to its source.
/// filter : {"nearest", "bilinear", "catmull-rom", "lanczos3"}, optional
///     Interpolation filter; by default lanczos3 for colours and bilinear for data and normals.
/// gutter : int
///     Width of the gutter around UV islands in texels, 0 to 256.
/// prefer : {"first", "left", "right"}
///     UV island that owns texels that several cover.
/// overlap : {"first", "average"}
///     How overlapping UV islands are combined.
/// linear_light : bool
///     Average colours in linear light instead of as encoded.
/// encoding : {"srgb", "linear"}
///     Encoding of colours in arrays; files have their own.
/// content : {"color", "data", "normals"}
///     What textures hold. Values of data are never converted, and have no alpha. Normals are rotated
///     into the target's tangent frames.
/// normal_y, normal_y_out : {"opengl", "directx"}
///     Green channel of normal maps and of results; results have that of `normal_y` by default.
/// region : Region, optional
///     The part of the surface to transfer; by default everything linked.
/// blend : {"none", "feather", "membrane"}, optional
///     How to hide the boundary of the region: by fading into the base, or by matching skin tones as
///     well.
/// feather : float, optional
///     Width of the feather, inwards from the boundary, in the target mesh's unit, and at most as wide as
///     the region; by default 0.01 with a blend.
/// tone : {"base", "source", "both", "none"}
///     Side that sets the skin tone.
/// match_skin : bool
///     Also match the mean and the covariance of the colours of skin.
/// keep_all : bool
///     Do not leave out cloth and background at the neck.
/// skin : ndarray, PIL image or path, optional
///     Skin of the base, white on black, in the target's layout; by default estimated.
/// labels : ndarray, PIL image or path, optional
///     Labels of the texture as colours; by default estimated for each texture.
/// threads : int, optional
///     Number of threads, 0 for one per processor; see `set_threads`.
///
/// Raises
/// ------
/// TypeError, ValueError
///     For options that do not exist, and values that are not allowed, such as a feather that is wider
///     than the region.
/// uvgraft.Error
///     If no linked triangle is left in the region.
#[pyclass(frozen, module = "uvgraft", name = "Graft")]
pub(crate) struct Graft {
    settings: Settings,
    /// The size of results where the base has none.
    size: Option<Size>,
    threads: Option<usize>,
    /// The most recently used last. Locked with the interpreter's lock held, and only for a moment.
    kept: Mutex<Vec<Arc<CoreGraft>>>,
    layout_checks: LayoutChecks,
    pair: Py<Pair>,
    /// As they were given, to be pickled.
    options: Py<PyDict>,
}

/// The base of a texture, which may be that of others too.
enum GivenBase<'a, 'py> {
    /// As it was given, and what it is called.
    Given(Option<&'a Bound<'py, PyAny>>, &'a str),
    /// Decoded, for several textures.
    Decoded(Base),
}

/// Colours of surfaces are at most white, 1.0; light that is added to them is brighter in a few places. Of
/// photographs that were not divided by 255, all but their blackest values are above this.
const BEYOND_WHITE: f32 = 2.0;

/// What all grafts of a transfer share, whatever their sizes.
struct Settings {
    pair: Arc<CorePair>,
    direction: Direction,
    filter: Filter,
    map: MapOptions,
    overlap: Overlap,
    averaging: Averaging,
    content: Content,
    encoding: Encoding,
    blend: Option<Arc<Blend>>,
}

impl Settings {
    fn build(&self, sizes: Sizes) -> Result<CoreGraft, uvgraft::GraftError> {
        let mut builder = CoreGraft::builder(Arc::clone(&self.pair), sizes)
            .direction(self.direction)
            .filter(self.filter)
            .map_options(self.map)
            .overlap(self.overlap)
            .averaging(self.averaging)
            .content(self.content);
        if let Some(blend) = &self.blend {
            builder = builder.shared_blend(Arc::clone(blend));
        }
        builder.build()
    }
}

#[pymethods]
impl Graft {
    #[new]
    #[pyo3(
        signature = (pair, **options),
        text_signature = "(pair, *, size=None, reverse=False, filter=None, gutter=16, \
            prefer='first', overlap='first', linear_light=False, encoding='srgb', content='color', \
            normal_y='opengl', normal_y_out=None, region=None, blend=None, feather=None, \
            tone='base', match_skin=False, keep_all=False, skin=None, labels=None, threads=None)"
    )]
    fn new(pair: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let py = pair.py();
        let options = match options {
            Some(options) => options.copy()?,
            None => PyDict::new(py),
        };
        let given = Options::new(&options)?;
        given.make(&pair::pair(pair, "a Pair or a path")?, options.unbind())
    }

    /// Lay a texture over a base, or each of several.
    ///
    /// Parameters
    /// ----------
    /// texture : ndarray, PIL image or path, or several
    ///     In the source's layout, of any size. Several are a list of these, or an array of shape
    ///     (n, height, width, channels).
    /// base : ndarray, PIL image, path or colour, or several, optional
    ///     In the target's layout, or a colour such as ``"#808080"``. Without one, colours are laid over
    ///     transparency, data over 0 and normals over flat ones. Several textures have one base, or one
    ///     each.
    /// out : ndarray, or several, optional
    ///     C-contiguous array for the result; may be `base` itself, which then saves a copy. Several
    ///     textures need one each, or an array of shape (n, height, width, channels).
    /// threads : int, optional
    ///     In place of the graft's own.
    ///
    /// Returns
    /// -------
    /// ndarray or list of ndarray
    ///     `out`, or a new array with the channels of both and the wider dtype of the two, of shape
    ///     (height, width, channels), or (height, width) if both are such. The results of a list are a
    ///     list, those of an array of several are one.
    ///
    /// Warns
    /// -----
    /// UserWarning
    ///     If no tone can be matched, or a tone is implausible; for NaN and infinite values, which are
    ///     left out; for floats that seem to be from 0 to 255; if `texture` or `base` was plainly made for
    ///     another layout. Each names the texture: its file, or ``texture``, or ``texture[3]`` of several.
    ///
    /// Raises
    /// ------
    /// TypeError, ValueError
    ///     For arrays of other dtypes and shapes, and for sizes that differ from the graft's.
    /// OSError
    ///     For files that cannot be read.
    #[pyo3(signature = (texture, base=None, *, out=None, threads=None))]
    fn apply<'py>(
        &self,
        py: Python<'py>,
        texture: &Bound<'py, PyAny>,
        base: Option<&Bound<'py, PyAny>>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let threads = threads::checked(threads)?.or(self.threads);
        let Some(textures) = Batch::of(texture)? else {
            batch::check_single(base, "base")?;
            let base = GivenBase::Given(base, "base");
            return self.apply_one(py, (texture, "texture"), &base, out, threads);
        };
        let bases = Batch::one_or_each(base, "base", textures.len())?;
        let outs = match Batch::one_or_each(out, "out", textures.len())? {
            Shared::One(None) => None,
            Shared::Each(outs) => Some(outs),
            Shared::One(Some(_)) => {
                return Err(bad_value(
                    "out must be a list of arrays, or have shape (n, height, width, channels)",
                ));
            }
        };
        let shared = match &bases {
            Shared::One(base) => self.decoded_once(base.as_ref())?,
            Shared::Each(_) => GivenBase::Given(None, "base"),
        };
        textures.map(py, out, |index, texture| {
            let (name, name_of_base) = (format!("texture[{index}]"), format!("base[{index}]"));
            let own = match &bases {
                Shared::One(_) => None,
                Shared::Each(bases) => Some(GivenBase::Given(Some(&bases[index]), &name_of_base)),
            };
            let base = own.as_ref().unwrap_or(&shared);
            let out = outs.as_ref().map(|outs| &outs[index]);
            self.apply_one(py, (texture, &name), base, out, threads)
        })
    }

    #[pyo3(signature = (texture, base=None, *, out=None, threads=None))]
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        texture: &Bound<'py, PyAny>,
        base: Option<&Bound<'py, PyAny>>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.apply(py, texture, base, out, threads)
    }

    #[pyo3(signature = (
        texture, base=None, *, steps=None, min_gain=None, regularization=None, smoothness=None,
        progress=None, out=None, threads=None
    ))]
    /// Solve for the texture that reads back best, instead of sampling it.
    ///
    /// Parameters
    /// ----------
    /// texture, base, out, threads
    ///     As in `apply`.
    /// steps : int, optional
    ///     Maximum number of steps.
    /// min_gain : float, optional
    ///     Stop after a step that lowers the error by less than this fraction.
    /// regularization, smoothness : float, optional
    ///     Weights that hold the solution to the sampled texture, and its differences to those of the
    ///     sampled texture.
    /// progress : bool, callable, or progress bar, optional
    ///     True shows a bar. A callable is called as ``progress(step, max_steps, rms)`` before the
    ///     first step and after each; a bar of tqdm, or a class of bars, is advanced.
    ///
    /// Returns
    /// -------
    /// Fit
    ///     The texture, and how well it fits.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For NaN and infinite values.
    /// uvgraft.Error
    ///     For normals, averaged overlaps and the filter nearest, which cannot be fitted.
    fn fit<'py>(
        &self,
        py: Python<'py>,
        texture: &Bound<'py, PyAny>,
        base: Option<&Bound<'py, PyAny>>,
        steps: Option<u32>,
        min_gain: Option<f64>,
        regularization: Option<f32>,
        smoothness: Option<f32>,
        progress: Option<Py<PyAny>>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let threads = threads::checked(threads)?.or(self.threads);
        let mut options = FitOptions::default();
        options.max_steps = steps.unwrap_or(options.max_steps);
        options.min_gain = min_gain.unwrap_or(options.min_gain);
        options.regularization = regularization.unwrap_or(options.regularization);
        options.smoothness = smoothness.or(options.smoothness);
        let source = crate::arrays::texture(texture, "texture", self.settings.encoding)?;
        let base = Base::new(base, "base", self.settings.content, self.settings.encoding)?;
        let (mut summary, mut raised) = (None, None);
        // Bars and `True` become callables; None stays None.
        let given = (progress, intern!(py, "fit"));
        let reporter =
            py.import(intern!(py, "uvgraft._progress"))?.call_method1("reporter", given)?;
        let progress = (!reporter.is_none()).then(|| reporter.unbind());
        let fitted = self.lay(py, source, base, out, threads, |graft, texture, format| {
            let mut report = |now: FitProgress| {
                let Some(callback) = progress.as_ref().filter(|_| raised.is_none()) else { return };
                raised = Python::attach(|py| {
                    callback.call1(py, (now.step, now.max_steps, now.rms)).err()
                });
            };
            let fitted = graft.fit(texture, format, &options, &mut report).map_err(of_graft)?;
            summary = Some(fitted.summary);
            Ok(fitted.overlay)
        });
        if let Some(reporter) = &progress {
            reporter.call_method0(py, "close")?;
        }
        if let Some(error) = raised {
            return Err(error);
        }
        let fitted = fitted?;
        let FitSummary { steps, sampled_rms, fitted_rms, share_met, .. } =
            summary.ok_or_else(|| failed("internal error: nothing was fitted"))?;
        let kind = py.import(intern!(py, "uvgraft._results"))?.getattr(intern!(py, "Fit"))?;
        kind.call1((fitted, steps, sampled_rms, fitted_rms, share_met))
    }

    /// Return how the blend changes the colours of a texture and a base; None without a blend that does.
    ///
    /// Parameters
    /// ----------
    /// texture, base, threads
    ///     As in `apply`.
    ///
    /// Raises
    /// ------
    /// uvgraft.Error
    ///     If no tone can be estimated.
    #[pyo3(signature = (texture, base=None, *, threads=None))]
    fn tone<'py>(
        &self,
        py: Python<'py>,
        texture: &Bound<'py, PyAny>,
        base: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let threads = threads::checked(threads)?.or(self.threads);
        let source = crate::arrays::texture(texture, "texture", self.settings.encoding)?.texture;
        let base = Base::new(base, "base", self.settings.content, self.settings.encoding)?;
        let graft = self.graft(py, self.sizes(source.size(), base.size())?, threads)?;
        let format = base.format(source.format());
        let colors = base.colors()?;
        let toning = threads::run(py, threads, || graft.toning(&source, &colors, format))?;
        let Some(toning) = toning.map_err(failed)? else { return Ok(None) };
        let report = toning.report();
        let kind = py.import(intern!(py, "uvgraft._results"))?.getattr(intern!(py, "Tone"))?;
        let [face, body] = report.lightness;
        let [face_clipped, body_clipped] = report.clipped;
        let figures = (
            (face, body),
            (face_clipped, body_clipped),
            report.boundary_delta_e,
            report.left_out,
            report.warnings(),
        );
        kind.call1(figures).map(Some)
    }

    /// Return the texels that are transferred.
    ///
    /// Parameters
    /// ----------
    /// size, source_size : int or (int, int), optional
    ///     Size of the target, by default the graft's, and of textures.
    ///
    /// Returns
    /// -------
    /// ndarray of uint8, shape (height, width)
    ///     255 where the texture covers the base, less where the base shows through a feather.
    #[pyo3(signature = (*, size=None, source_size=None))]
    fn mask<'py>(
        &self,
        py: Python<'py>,
        size: Option<&Bound<'py, PyAny>>,
        source_size: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let graft = self.of_sizes(py, size, source_size)?;
        let mask = threads::run(py, self.threads, || graft.mask())?;
        array(py, mask, true)
    }

    /// Return the sampling map.
    ///
    /// Parameters
    /// ----------
    /// size, source_size : int or (int, int), optional
    ///     Size of the target, by default the graft's, and of textures.
    #[pyo3(signature = (*, size=None, source_size=None))]
    fn map(
        &self,
        py: Python<'_>,
        size: Option<&Bound<'_, PyAny>>,
        source_size: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<SamplingMap> {
        let graft = self.of_sizes(py, size, source_size)?;
        let map = Arc::clone(graft.map());
        Ok(SamplingMap { map, threads: self.threads })
    }

    /// Return the transfer as a matrix.
    ///
    /// Parameters
    /// ----------
    /// size : int or (int, int), optional
    ///     Size of the target, by default the graft's.
    /// source_size : int or (int, int)
    ///     Size of textures.
    #[pyo3(signature = (*, size=None, source_size))]
    fn operator(
        &self,
        py: Python<'_>,
        size: Option<&Bound<'_, PyAny>>,
        source_size: &Bound<'_, PyAny>,
    ) -> PyResult<Operator> {
        let graft = self.of_sizes(py, size, Some(source_size))?;
        let operator = threads::run(py, self.threads, || graft.operator())?;
        Ok(Operator { operator: Arc::new(operator), threads: self.threads })
    }

    /// Return where each texel comes from, as ``grid_sample`` takes it.
    ///
    /// Parameters
    /// ----------
    /// size : int or (int, int), optional
    ///     Size of the target, by default the graft's.
    /// device : str, torch.device, jax.Device or jax.sharding.Sharding, optional
    ///     Where the grid shall be. A name or a device of PyTorch gives a tensor, one of JAX an array
    ///     of JAX; by default it is a NumPy array.
    ///
    /// Returns
    /// -------
    /// ndarray, torch.Tensor or jax.Array of float32, shape (height, width, 2)
    ///     x and y in the texture, where -1 and 1 are its left and right, top and bottom *edges*
    ///     (``align_corners=False``), gutter included; -3 where nothing is transferred.
    #[pyo3(signature = (size=None, *, device=None))]
    fn grid<'py>(
        &self,
        py: Python<'py>,
        size: Option<&Bound<'_, PyAny>>,
        device: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = self.map(py, size, None)?;
        py.import(intern!(py, "uvgraft._grids"))?.getattr(intern!(py, "grid"))?.call1((map, device))
    }

    /// The pair.
    #[getter]
    fn pair(&self, py: Python<'_>) -> Py<Pair> {
        self.pair.clone_ref(py)
    }

    /// Whether textures go from the pair's target to its source.
    #[getter]
    fn reverse(&self) -> bool {
        self.settings.direction == Direction::Reverse
    }

    /// The part of the surface that is transferred; None for everything linked.
    #[getter]
    pub(crate) fn region<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        Options { given: self.options.bind(py).clone() }.get("region")
    }

    /// The interpolation filter.
    #[getter]
    fn filter(&self) -> &'static str {
        self.settings.filter.name()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let options = self.options.bind(py).repr()?;
        Ok(format!("<uvgraft.Graft of {}, {options}>", self.pair.get().file.source_name))
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        Ok((PyTuple::new(py, [self.pair.clone_ref(py)])?, self.options.bind(py).copy()?))
    }
}

impl Graft {
    /// The sizes of a texture and a base.
    fn sizes(&self, from: Size, base: Option<Size>) -> PyResult<Sizes> {
        match (base, self.size) {
            (Some(found), Some(wanted)) if found != wanted => Err(bad_value(format_args!(
                "base must have the graft's size, ({}, {}), got ({}, {})",
                wanted.height, wanted.width, found.height, found.width
            ))),
            (Some(to), _) | (None, Some(to)) => Ok(Sizes { from, to }),
            (None, None) => Err(bad_value(
                "without a base image the result must have a size, such as size=2048, in Graft() or \
                 transfer()",
            )),
        }
    }

    /// The graft for given sizes; the texture's matters for operators only.
    fn of_sizes(
        &self,
        py: Python<'_>,
        size: Option<&Bound<'_, PyAny>>,
        source_size: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Arc<CoreGraft>> {
        let to = size.map(|size| arguments::size("size", size)).transpose()?.or(self.size);
        let to =
            to.ok_or_else(|| bad_value("size is required, here or in Graft(pair, size=...)"))?;
        let from = source_size.map(|size| arguments::size("source_size", size)).transpose()?;
        self.graft(py, Sizes { from: from.unwrap_or(Size::square(1)), to }, self.threads)
    }

    /// The graft for some sizes, made on first use.
    fn graft(
        &self,
        py: Python<'_>,
        sizes: Sizes,
        threads: Option<usize>,
    ) -> PyResult<Arc<CoreGraft>> {
        let (found, near) = {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            match kept.iter().position(|graft| graft.sizes() == sizes) {
                Some(at) => {
                    let graft = kept.remove(at);
                    kept.push(Arc::clone(&graft));
                    (Some(graft), None)
                }
                None => (None, kept.iter().find(|graft| graft.sizes().to == sizes.to).cloned()),
            }
        };
        if let Some(found) = found {
            return Ok(found);
        }
        let settings = &self.settings;
        let graft = threads::run(py, threads, || match near {
            Some(near) => near.with_texture_size(sizes.from),
            None => settings.build(sizes),
        })?;
        let graft = Arc::new(graft.map_err(of_graft)?);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() == MAX_KEPT {
            kept.remove(0);
        }
        kept.push(Arc::clone(&graft));
        Ok(graft)
    }

    /// The base of several textures. An array is copied for each in any case.
    fn decoded_once<'a, 'py>(
        &self,
        given: Option<&'a Bound<'py, PyAny>>,
    ) -> PyResult<GivenBase<'a, 'py>> {
        if given.is_some_and(|given| given.cast::<PyUntypedArray>().is_ok()) {
            return Ok(GivenBase::Given(given, "base"));
        }
        let base = Base::new(given, "base", self.settings.content, self.settings.encoding)?;
        Ok(GivenBase::Decoded(base))
    }

    /// Lays one texture over its base.
    ///
    /// - `texture`: with the name of the argument.
    fn apply_one<'py>(
        &self,
        py: Python<'py>,
        (texture, name): (&Bound<'py, PyAny>, &str),
        base: &GivenBase<'_, 'py>,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Settings { content, encoding, .. } = self.settings;
        let source = crate::arrays::texture(texture, name, encoding)?;
        if let (GivenBase::Given(Some(base), _), Some(out)) = (base, out)
            && self.works_in_place(source.texture.format(), base, out)?
        {
            return self.apply_in_place(py, source, base, out, threads);
        }
        let base = match base {
            GivenBase::Given(base, name) => Base::new(*base, name, content, encoding)?,
            GivenBase::Decoded(base) => base.clone(),
        };
        self.lay(py, source, base, out, threads, |graft, texture, format| {
            graft.overlay(texture, format).map_err(of_graft)
        })
    }

    /// Lays a texture over a base.
    ///
    /// - `make`: makes the overlay; called on the pool, without the interpreter's lock.
    fn lay<'py>(
        &self,
        py: Python<'py>,
        source: GivenTexture,
        base: Base,
        out: Option<&Bound<'py, PyAny>>,
        threads: Option<usize>,
        make: impl FnOnce(&CoreGraft, Texture, TexelFormat) -> PyResult<Overlay> + Send,
    ) -> PyResult<Bound<'py, PyAny>> {
        let GivenTexture { texture, name, is_flat } = source;
        let is_flat = is_flat
            && match &base {
                Base::Texture(given) => given.is_flat,
                Base::Color(_) => true,
            };
        let sizes = self.sizes(texture.size(), base.size())?;
        let graft = self.graft(py, sizes, threads)?;
        let format = base.format(texture.format());
        let (result, warnings) = threads::run(py, threads, || -> PyResult<_> {
            let (texture, mut warnings) = self.finite(texture, &name);
            warnings.extend(self.misfit_of_source(&texture, &name));
            if let Base::Texture(given) = &base {
                warnings.extend(self.misfit_of_range(&given.texture, &given.name));
                warnings.extend(self.misfit_of_base(&given.texture, &given.name));
            }
            let is_toned = self.settings.content == Content::Color;
            let colors = || base.colors().map(Cow::Owned);
            let (toning, of_tone) = toning(&graft, &texture, is_toned, format, colors)?;
            // Named, so that Python's filter tells each text once for each texture.
            let of_tone = of_tone.into_iter();
            warnings.extend(of_tone.map(|warning| format!("{}: {warning}", name.display())));
            let overlay = make(&graft, texture, format)?;
            let overlay = toned(overlay, toning.as_ref(), is_toned).map_err(failed)?;
            let base = base.into_texture(sizes.to, format)?;
            Ok((overlay.lay(0, self.reinterpreted(base)).map_err(bad_value)?, warnings))
        })??;
        warn_caller(py, warnings)?;
        let Some(out) = out else { return array(py, result, is_flat) };
        let mut target = OutArray::new(out, result.size(), result.format())?;
        copy(result.texels(), &mut target.texels_mut()?)?;
        Ok(out.clone())
    }

    /// Whether a texture can be laid over `out` without a copy of the base in another place: a plain
    /// transfer, which need not see the base, where all three have one format.
    fn works_in_place(
        &self,
        format: TexelFormat,
        base: &Bound<'_, PyAny>,
        out: &Bound<'_, PyAny>,
    ) -> PyResult<bool> {
        let settings = &self.settings;
        let is_plain = settings.averaging == Averaging::Encoded
            && matches!(settings.content, Content::Color | Content::Data)
            && !settings.blend.as_ref().is_some_and(|blend| blend.options().needs_labels());
        let (Ok(base), Ok(out)) = (base.cast::<PyUntypedArray>(), out.cast::<PyUntypedArray>())
        else {
            return Ok(false);
        };
        let channels = |array: &Bound<'_, PyUntypedArray>| match *array.shape() {
            [_, _] => 1,
            [_, _, channels] => channels,
            _ => 0,
        };
        let has_format = |array: &Bound<'_, PyUntypedArray>| {
            channels(array) == format.channels.count()
                && depth_of(array) == Some(format.depth)
                && !array.shape().contains(&0)
        };
        Ok(is_plain && has_format(base) && has_format(out) && base.shape()[..2] == out.shape()[..2])
    }

    /// Lays a texture over `out`, which first gets the base unless it is that array already.
    fn apply_in_place<'py>(
        &self,
        py: Python<'py>,
        source: GivenTexture,
        base: &Bound<'py, PyAny>,
        out: &Bound<'py, PyAny>,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let array = base.cast::<PyUntypedArray>()?;
        let (to, _) = shape(array, "base")?;
        let (texture, mut warnings) = self.finite(source.texture, &source.name);
        let format = texture.format();
        let graft = self.graft(py, self.sizes(texture.size(), Some(to))?, threads)?;
        if !base.is(out) {
            // Checks `out` before it changes.
            OutArray::new(out, to, format)?;
            py.import(intern!(py, "numpy"))?.call_method1(intern!(py, "copyto"), (out, base))?;
        }
        let mut target = OutArray::new(out, to, format)?;
        let texels = target.texels_mut()?;
        threads::run(py, threads, || -> PyResult<()> {
            warnings.extend(self.misfit_of_source(&texture, &source.name));
            let overlay = graft.overlay(texture, format).map_err(of_graft)?;
            overlay.lay_in_place(0, format, texels).map_err(bad_value)
        })??;
        warn_caller(py, warnings)?;
        Ok(out.clone())
    }

    /// A texture without NaN and infinite values, and a warning if it had any.
    fn finite(&self, texture: Texture, name: &Path) -> (Texture, Vec<String>) {
        let texture = self.reinterpreted(texture);
        let (texture, warning) = uvgraft_pipeline::without_non_finite(texture, name);
        let warnings = warning.into_iter().chain(self.misfit_of_range(&texture, name)).collect();
        (texture, warnings)
    }

    /// A warning of colours whose values seem to have another range.
    fn misfit_of_range(&self, texture: &Texture, name: &Path) -> Option<String> {
        (self.settings.content == Content::Color && is_beyond_white(texture)).then(|| {
            format!(
                "{}: most values are above {BEYOND_WHITE}, where 1.0 is white; those from 0 to 255 must be \
                 divided by 255",
                name.display()
            )
        })
    }

    /// A warning of a texture that was not made for the layout that is read.
    fn misfit_of_source(&self, texture: &Texture, name: &Path) -> Option<String> {
        let (rows, name) = (texture.size().height, name.display().to_string());
        self.layout_checks.source(self.checked_pair()?, texture, rows, &name)
    }

    /// A warning of a base that was not made for the layout that is filled.
    fn misfit_of_base(&self, base: &Texture, name: &Path) -> Option<String> {
        let checked = self.checked_pair()?;
        let [from, to] = self.layout_checks.points(checked);
        let mut probe = LayoutProbe::new([to, from], base.size());
        probe.look(0, base);
        LayoutChecks::base(checked, &probe, &name.display().to_string())
    }

    /// `None` for what is not a colour.
    fn checked_pair(&self) -> Option<CheckedPair<'_>> {
        let PairFile { pair, source_name, target_name, .. } = &self.pair.get().file;
        let names = [&**source_name, &**target_name];
        let direction = self.settings.direction;
        (self.settings.content == Content::Color).then_some(CheckedPair { pair, names, direction })
    }

    /// A texture with the encoding that the content says.
    fn reinterpreted(&self, texture: Texture) -> Texture {
        match self.settings.content {
            Content::Color => texture,
            _ => texture.with_encoding(Encoding::Data),
        }
    }
}

/// Whether most values of a texture of floats are so far beyond white that they are likely to be those of
/// another range, such as 0 to 255.
fn is_beyond_white(texture: &Texture) -> bool {
    let Texels::F32(values) = texture.texels() else { return false };
    2 * values.iter().filter(|&&value| value > BEYOND_WHITE).count() > values.len()
}

/// The options of a graft as they were given.
struct Options<'py> {
    given: Bound<'py, PyDict>,
}

/// The names of all options.
const NAMES: [&str; 20] = [
    "size",
    "reverse",
    "filter",
    "gutter",
    "prefer",
    "overlap",
    "linear_light",
    "encoding",
    "content",
    "normal_y",
    "normal_y_out",
    "region",
    "blend",
    "feather",
    "tone",
    "match_skin",
    "keep_all",
    "skin",
    "labels",
    "threads",
];

impl<'py> Options<'py> {
    fn new(given: &Bound<'py, PyDict>) -> PyResult<Self> {
        for name in given.keys() {
            let name: String = name.extract()?;
            if !NAMES.contains(&name.as_str()) {
                return Err(crate::error::bad_type(format_args!(
                    "Graft() got an unexpected keyword argument '{name}'"
                )));
            }
        }
        Ok(Self { given: given.clone() })
    }

    /// An option that is given and not `None`.
    fn get(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(self.given.get_item(name)?.filter(|value| !value.is_none()))
    }

    fn text(&self, name: &str, default: &str) -> PyResult<String> {
        match self.get(name)? {
            Some(value) => value.extract(),
            None => Ok(default.to_owned()),
        }
    }

    fn choice<T: Choice>(&self, name: &str, default: T) -> PyResult<T> {
        match self.get(name)? {
            Some(value) => chosen(name, &value.extract::<String>()?),
            None => Ok(default),
        }
    }

    fn flag(&self, name: &str) -> PyResult<bool> {
        self.get(name)?.map_or(Ok(false), |value| value.extract())
    }

    fn make(&self, pair: &Bound<'py, Pair>, options: Py<PyDict>) -> PyResult<Graft> {
        let py = pair.py();
        let normal_y_out = self.get("normal_y_out")?.map(|name| name.extract()).transpose()?;
        let normal_y_out: Option<String> = normal_y_out;
        let content = arguments::content(
            &self.text("content", "color")?,
            &self.text("normal_y", NormalY::OpenGl.name())?,
            normal_y_out.as_deref(),
        )?;
        let default_filter = match content {
            Content::Color => Filter::default(),
            _ => Filter::Bilinear,
        };
        let gutter = self.get("gutter")?.map_or(Ok(16), |value| value.extract())?;
        let threads = self.get("threads")?.map(|value| value.extract()).transpose()?;
        let threads = threads::checked(threads)?;
        let mut settings = Settings {
            pair: Arc::clone(&pair.get().file.pair),
            direction: direction(self.flag("reverse")?),
            filter: self.choice("filter", default_filter)?,
            map: map::options(gutter, self.choice("prefer", Prefer::First)?)?,
            overlap: self.choice("overlap", Overlap::First)?,
            averaging: match self.flag("linear_light")? {
                true => Averaging::Light,
                false => Averaging::Encoded,
            },
            content,
            encoding: arguments::color_encoding(&self.text("encoding", Encoding::Srgb.name())?)?,
            blend: None,
        };
        settings.blend = self.blend(py, &settings, gutter, threads)?;
        let size = self.get("size")?.map(|size| arguments::size("size", &size)).transpose()?;
        let pair = pair.clone().unbind();
        Ok(Graft {
            settings,
            size,
            threads,
            kept: Mutex::default(),
            layout_checks: LayoutChecks::default(),
            pair,
            options,
        })
    }

    /// Refuses options of a blend where nothing asks for one.
    fn check_without_blend(&self, is_feathered: bool) -> PyResult<()> {
        let tone = self.text("tone", ToneSide::Base.name())? != ToneSide::Base.name();
        let given = |name| self.get(name).map(|value| value.is_some());
        for (is_asked, name) in [
            (tone, "tone"),
            (self.flag("keep_all")?, "keep_all"),
            (given("skin")?, "skin"),
            (given("labels")?, "labels"),
            (is_feathered, "feather"),
        ] {
            if is_asked {
                return Err(bad_value(format_args!("{name} needs blend=\"membrane\"")));
            }
        }
        Ok(())
    }

    /// The options of a blend with those that match colours.
    fn with_tone(
        &self,
        mut options: BlendOptions,
        mode: BlendMode,
        is_matched: bool,
    ) -> PyResult<BlendOptions> {
        let tone: Option<Tone> = self.choice("tone", ToneSide::Base)?.into();
        if let Some(tone) = tone {
            options = options.tone(tone);
            options = if mode == BlendMode::Membrane { options.membrane() } else { options };
            options = if is_matched { options.match_skin() } else { options };
        }
        Ok(if self.flag("keep_all")? { options.keep_all() } else { options })
    }

    /// The blend, if a region or an option asks for one.
    fn blend(
        &self,
        py: Python<'py>,
        settings: &Settings,
        gutter: u32,
        threads: Option<usize>,
    ) -> PyResult<Option<Arc<Blend>>> {
        let region = self.get("region")?;
        let feather: Option<f64> = self.get("feather")?.map(|value| value.extract()).transpose()?;
        let is_feathered = feather.is_some();
        let default = if is_feathered { BlendMode::Feather } else { BlendMode::None };
        let mode = self.choice("blend", default)?;
        let is_matched = self.flag("match_skin")?;
        if region.is_none() && mode == BlendMode::None && !is_matched {
            return self.check_without_blend(is_feathered).map(|()| None);
        }
        let default = if mode == BlendMode::None { 0.0 } else { DEFAULT_FEATHER };
        let feather = feather.unwrap_or(default);
        if !(0.0..=1e9).contains(&feather) {
            return Err(bad_value(format_args!("feather must not be negative, got {feather}")));
        }
        let options = BlendOptions::default().feather(feather).gutter_px(gutter);
        let options = self.with_tone(options, mode, is_matched)?;
        let skin = self.get("skin")?.map(|skin| texture(&skin, "skin", Encoding::Data));
        let skin = skin.transpose()?;
        let labels = self.get("labels")?.map(|labels| texture(&labels, "labels", Encoding::Srgb));
        let labels = labels.transpose()?;
        let (pair, direction) = (Arc::clone(&settings.pair), settings.direction);
        let domain = threads::run(py, threads, move || BlendDomain::new(pair, direction))?;
        let selected = match &region {
            Some(region) => selection(&domain, region)?,
            None => domain.linked(),
        };
        let blend = threads::run(py, threads, move || -> PyResult<_> {
            let mut blend = Blend::new(&selected, options).map_err(failed)?;
            if let FeatherFit::TooWide { depth } = blend.feather_fit() {
                return Err(bad_value(format_args!(
                    "feather must be at most {depth:.4}, the distance of the region's innermost point from \
                     its boundary in the mesh's unit, got {feather}"
                )));
            }
            if let Some(skin) = skin {
                blend = blend.with_skin(skin.texture);
            }
            if let Some(labels) = labels {
                blend = blend.with_labels(Labels::from_picture(&labels.texture).map_err(failed)?);
            }
            Ok(Arc::new(blend))
        })??;
        // With a membrane each texture gets a warning that there is no boundary.
        if blend.feather_fit() == FeatherFit::NoBoundary && !options.needs_colors() {
            let warning = "feather has no effect: the region has no boundary".to_owned();
            warn_caller(py, vec![warning])?;
        }
        Ok(Some(blend))
    }
}
