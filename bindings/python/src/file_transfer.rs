//! Transfers of encoded images, for callers with more textures than fit in memory.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use uvgraft::Size;
use uvgraft_io::image::Format;
use uvgraft_pipeline::{Carried, PreparedTransfer};

use crate::error::{bad_value, failed, of_file, of_pipeline};
use crate::threads;

/// The compiled part of `uvgraft.FileTransfer`.
#[pyclass(frozen, module = "uvgraft._uvgraft", name = "PreparedTransfer")]
pub(crate) struct Prepared {
    prepared: PreparedTransfer,
    threads: Option<usize>,
}

/// What `uvgraft.Transferred` is made of: the difference at the boundary, bytes, height, width,
/// warnings and notes.
type Figures = (Option<f64>, u64, u32, u32, Vec<String>, Vec<String>);

#[pymethods]
impl Prepared {
    /// - `arguments`: those of `uvgraft transfer`.
    #[new]
    #[pyo3(signature = (arguments, *, threads=None))]
    fn new(py: Python<'_>, arguments: Vec<OsString>, threads: Option<i64>) -> PyResult<Self> {
        let threads = threads::checked(threads)?;
        let transfer = uvgraft_cli::parse_transfer(arguments)
            .map_err(|error| failed(format_args!("{error:#}")))?;
        check_file(transfer.correspondence.input().name())?;
        let prepared = threads::run(py, threads, || transfer.prepare(&()))?.map_err(of_pipeline)?;
        Ok(Self { prepared, threads })
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
        let carried = threads::run(py, threads, || self.prepared.carry_file(&source, &output))?;
        carried.map(figures).map_err(of_pipeline)
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
        let carried = threads::run(py, threads, || self.prepared.carry_bytes(data, name, kind))?;
        let (bytes, carried) = carried.map_err(of_pipeline)?;
        Ok((PyBytes::new(py, &bytes), figures(carried)))
    }

    /// Of all options and all files that textures share.
    #[getter]
    fn fingerprint(&self) -> &str {
        self.prepared.fingerprint()
    }

    #[getter]
    fn shape(&self) -> (u32, u32) {
        let Size { width, height } = self.prepared.size();
        (height, width)
    }

    fn made_from_bytes(&self, py: Python<'_>, data: &[u8]) -> String {
        py.detach(|| self.prepared.made_from_bytes(data))
    }

    fn made_from_file(&self, py: Python<'_>, source: PathBuf) -> PyResult<String> {
        check_file(&source)?;
        py.detach(|| self.prepared.made_from_file(&source)).map_err(of_pipeline)
    }
}

/// Checks that a file can be looked at, for the exception that Python has for it.
fn check_file(path: &Path) -> PyResult<()> {
    path.metadata().map(drop).map_err(|reason| of_file(&reason, path))
}

fn figures(carried: Carried) -> Figures {
    let Carried { boundary_delta_e, bytes, size, warnings, notes, .. } = carried;
    (boundary_delta_e, bytes, size.height, size.width, warnings, notes)
}
