//! Transfers of encoded images, for callers with more textures than fit in memory.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use uvgraft::{Averaging, Encoding, FitOptions, MapOptions, Size};
use uvgraft_image::{Format, WriteOptions};
use uvgraft_pipeline::{
    Correspondence, Inputs, PreparedTransfer, Transfer, TransferredTexture, Values,
};

use crate::arguments::direction;
use crate::error::{bad_value, check_file, check_files, of_option, of_pipeline};
use crate::inputs;
use crate::keywords::Keywords;
use crate::threads;
use crate::work::{self, Finished};

/// The compiled part of `uvgraft.FileTransfer`.
#[pyclass(frozen, module = "uvgraft._uvgraft", name = "PreparedTransfer")]
pub(crate) struct Prepared {
    prepared: PreparedTransfer,
    /// What preparing assumed.
    notes: Vec<String>,
    threads: Option<usize>,
}

/// What `uvgraft.Transferred` is made of: the difference at the boundary, bytes, height, width,
/// warnings and notes.
type Figures = (Option<f64>, u64, u32, u32, Vec<String>, Vec<String>);

#[pymethods]
impl Prepared {
    /// - `arguments`: those of `uvgraft.FileTransfer`.
    #[new]
    fn new(py: Python<'_>, arguments: &Bound<'_, PyDict>) -> PyResult<Self> {
        let keywords = Keywords::new(arguments)?;
        let threads = keywords.threads()?;
        let transfer = keywords.transfer()?;
        keywords.finish()?;
        check_files(py, transfer.prepared_inputs())?;
        let Finished { result: prepared, notes } =
            work::run(py, threads, move |observer| transfer.prepare(observer))?;
        Ok(Self { prepared, notes, threads })
    }

    #[pyo3(signature = (source, output, *, threads=None))]
    fn to_file(
        &self,
        py: Python<'_>,
        source: PathBuf,
        output: PathBuf,
        threads: Option<i64>,
    ) -> PyResult<Figures> {
        check_file(&source)?;
        let threads = threads::checked(threads)?.or(self.threads);
        let transferred =
            threads::run(py, threads, || self.prepared.transfer_file(&source, &output))?;
        transferred.map(figures).map_err(of_pipeline)
    }

    #[pyo3(signature = (data, *, name="texture", format="png", threads=None))]
    fn to_bytes<'py>(
        &self,
        py: Python<'py>,
        data: &[u8],
        name: &str,
        format: &str,
        threads: Option<i64>,
    ) -> PyResult<(Bound<'py, PyBytes>, Figures)> {
        let threads = threads::checked(threads)?.or(self.threads);
        let kind = Format::from_extension(format.trim_start_matches('.')).ok_or_else(|| {
            let wanted = Format::extension_list();
            bad_value(format_args!("format must be one of {wanted}, got {format:?}"))
        })?;
        let transferred =
            threads::run(py, threads, || self.prepared.transfer_bytes(data, name, kind))?;
        let (bytes, transferred) = transferred.map_err(of_pipeline)?;
        Ok((PyBytes::new(py, &bytes), figures(transferred)))
    }

    /// Of all options and all files that textures share.
    #[getter]
    fn fingerprint(&self) -> &str {
        self.prepared.fingerprint()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    #[getter]
    fn shape(&self) -> (u32, u32) {
        let Size { width, height } = self.prepared.size();
        (height, width)
    }

    fn made_from_bytes(&self, py: Python<'_>, data: &[u8]) -> String {
        py.detach(|| self.prepared.fingerprint_of_bytes(data))
    }

    fn made_from_file(&self, py: Python<'_>, source: PathBuf) -> PyResult<String> {
        check_file(&source)?;
        py.detach(|| self.prepared.fingerprint_of_file(&source)).map_err(of_pipeline)
    }
}

fn figures(transferred: TransferredTexture) -> Figures {
    let TransferredTexture { boundary_delta_e, bytes, size, warnings, notes, .. } = transferred;
    (boundary_delta_e, bytes, size.height, size.width, warnings, notes)
}

impl Keywords<'_> {
    /// The transfer that the arguments describe.
    fn transfer(&self) -> PyResult<Transfer> {
        let pair = Correspondence::Pair(inputs::pair(&self.required("pair")?, "pair")?);
        let onto = self.take("onto")?;
        let onto = onto.map(|it| inputs::base(&it, "onto", Encoding::Srgb)).transpose()?;
        let values = if self.flag("data")? { Values::Data } else { Values::Albedo };
        // Textures and outputs come with each call.
        let textures = Inputs::Textures { sources: Vec::new(), onto, values };
        let mut transfer = Transfer::by(pair, textures, "");
        transfer.direction = direction(self.flag("reverse")?);
        transfer.size = self.size("size")?;
        transfer.filter = self.choice("filter")?;
        let gutter_px = self.whole("gutter", 0..=256)?.unwrap_or(MapOptions::default().gutter_px);
        let prefer = self.choice("prefer")?.unwrap_or_default();
        transfer.map = MapOptions::with_gutter(gutter_px).prefer(prefer);
        transfer.overlap = self.choice("overlap")?.unwrap_or_default();
        transfer.averaging = match self.flag("linear_light")? {
            true if values == Values::Data => {
                return Err(of_option("data", "cannot be used with `linear_light`"));
            }
            true => Averaging::Light,
            false => Averaging::Encoded,
        };
        transfer.fit = self.fit()?;
        transfer.region = self.region()?;
        let mut settings = self.blending()?;
        settings.labels = self.image("labels")?;
        settings.check().map_err(of_pipeline)?;
        transfer.blending = settings.blending_if_any(&transfer.region, gutter_px);
        transfer.source_mask = self.image("source_mask")?;
        transfer.fill = self.image("fill")?;
        transfer.write = WriteOptions::default().compress(self.flag("compress")?);
        transfer.write.jpeg_quality = self.whole("quality", 1..=100)?;
        Ok(transfer)
    }

    fn fit(&self) -> PyResult<Option<FitOptions>> {
        let is_fitted = self.flag("fit")?;
        let steps = self.whole("fit_steps", 1..=1000)?;
        if steps.is_some() && !is_fitted {
            return Err(of_option("fit_steps", "needs `fit`"));
        }
        let default = FitOptions::default();
        let steps = steps.unwrap_or(default.max_steps);
        Ok(is_fitted.then(|| default.max_steps(steps)))
    }
}
