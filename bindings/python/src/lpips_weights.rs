//! The networks of LPIPS: where their weights are, and those that were read already.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use pyo3::prelude::*;
use uvgraft_metrics::lpips::{Lpips, LpipsNetwork};
use uvgraft_metrics::lpips_weights;

use crate::error::{of_file, of_reading};

/// A network that was read, and what shows that its file is still the same.
struct Known {
    path: PathBuf,
    network: LpipsNetwork,
    written: Option<SystemTime>,
    bytes: u64,
    lpips: Arc<Lpips>,
}

/// Networks that were read, each of two kinds from two files at most: textures are often compared
/// in a loop, and reading a network takes as long as comparing a small texture. Only touched while
/// the interpreter's lock is held.
static KNOWN: Mutex<Vec<Known>> = Mutex::new(Vec::new());
const MAX_KNOWN: usize = 4;

/// LPIPS with a network; `None` if no path is given and no weights were imported.
///
/// - `path`: of a weights file, if not the imported one.
///
/// # Errors
/// `OSError` if the file at `path` cannot be read, `uvgraft.Error` for a damaged file.
pub(crate) fn read(
    py: Python<'_>,
    network: LpipsNetwork,
    path: Option<&Path>,
) -> PyResult<Option<Arc<Lpips>>> {
    let path = match (path, uvgraft_assembly::weights::lpips_path().ok()) {
        (Some(path), _) => path.to_path_buf(),
        (None, Some(path)) if path.exists() => path,
        (None, _) => return Ok(None),
    };
    let status = path.metadata().map_err(|reason| of_file(&reason, &path))?;
    let (written, bytes) = (status.modified().ok(), status.len());
    let known = |known: &&Known| {
        (&known.path, known.network, known.written, known.bytes) == (&path, network, written, bytes)
    };
    let found = {
        let all = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().find(known).map(|known| Arc::clone(&known.lpips))
    };
    if found.is_some() {
        return Ok(found);
    }
    let weights = py.detach(|| lpips_weights::read(&path, network)).map_err(of_reading)?;
    let lpips = Arc::new(Lpips::new(weights));
    let mut all = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    // An earlier version of the file, or what another thread read meanwhile.
    all.retain(|known| (&known.path, known.network) != (&path, network));
    if all.len() == MAX_KNOWN {
        all.remove(0);
    }
    all.push(Known { path, network, written, bytes, lpips: Arc::clone(&lpips) });
    Ok(Some(lpips))
}
