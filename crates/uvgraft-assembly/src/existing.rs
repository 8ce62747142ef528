//! Inputs that exist, which is looked up before any large file is read.

use uvgraft_files::input::Input;
use uvgraft_pipeline::{Failure, Result};

/// Checks that all inputs that are files exist.
///
/// # Errors
/// As bad input for the first that does not, with the system's reason.
pub(crate) fn check<'a>(inputs: impl IntoIterator<Item = &'a Input>) -> Result<()> {
    for path in inputs.into_iter().filter_map(Input::path) {
        if let Err(error) = path.metadata() {
            return Err(Failure::input(format!("{}: {error}", path.display())));
        }
    }
    Ok(())
}
