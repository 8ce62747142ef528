//! The compiled part of the Python package `uvgraft`.
//!
//! It converts arguments and results, and leaves the work to the crates. Doc comments of what
//! Python sees are its docstrings; types are in the package's stub, `uvgraft/_uvgraft.pyi`.

#![expect(clippy::needless_pass_by_value, reason = "the interpreter hands over owned arguments")]
#![expect(
    clippy::too_many_arguments,
    reason = "Python's keyword arguments have names and defaults"
)]

mod arguments;
mod arrays;
mod avatar;
mod base;
mod batch;
mod blending;
mod body;
mod choices;
mod command;
mod error;
mod file_transfer;
mod files;
mod foreign_mesh;
mod graft;
mod images;
mod inputs;
mod keywords;
mod lpips_weights;
mod map;
mod memory;
mod mesh;
mod metrics;
mod operator;
mod pair;
mod pictures;
mod region;
mod seams;
mod selfie;
mod threads;
mod work;

use pyo3::prelude::*;

/// Set the number of threads of calls that name none.
///
/// Parameters
/// ----------
/// threads : int
///     0 for one per processor, which is the default. Results never depend on it.
#[pyfunction]
fn set_threads(py: Python<'_>, threads: i64) -> PyResult<()> {
    threads::set_default(py, threads::checked(Some(threads))?.unwrap_or(0));
    Ok(())
}

/// Return the number of threads of calls that name none; 0 is one per processor.
#[pyfunction]
fn get_threads(py: Python<'_>) -> usize {
    threads::default(py)
}

#[pymodule]
fn _uvgraft(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("Error", py.get_type::<error::Error>())?;
    module.add_class::<mesh::Mesh>()?;
    module.add_class::<pair::Pair>()?;
    module.add_class::<graft::Graft>()?;
    module.add_class::<map::SamplingMap>()?;
    module.add_class::<operator::Operator>()?;
    module.add_class::<body::BodyModel>()?;
    module.add_class::<file_transfer::Prepared>()?;
    module.add_function(wrap_pyfunction!(files::load, module)?)?;
    module.add_function(wrap_pyfunction!(files::is_pair_file, module)?)?;
    module.add_function(wrap_pyfunction!(images::read_image, module)?)?;
    module.add_function(wrap_pyfunction!(images::write_image, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::compare, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::l1, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::psnr, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::ssim, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::ssimulacra2, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::flip, module)?)?;
    module.add_function(wrap_pyfunction!(metrics::lpips, module)?)?;
    module.add_function(wrap_pyfunction!(seams::seams, module)?)?;
    module.add_function(wrap_pyfunction!(set_threads, module)?)?;
    module.add_function(wrap_pyfunction!(get_threads, module)?)?;
    module.add_function(wrap_pyfunction!(avatar::make_avatar, module)?)?;
    module.add_function(wrap_pyfunction!(selfie::make_selfie, module)?)?;
    module.add_function(wrap_pyfunction!(pictures::make_picture, module)?)?;
    module.add_function(wrap_pyfunction!(pictures::make_page, module)?)?;
    module.add_function(wrap_pyfunction!(command::run_command, module)?)?;
    module.add_function(wrap_pyfunction!(choices::choices, module)?)?;
    Ok(())
}
