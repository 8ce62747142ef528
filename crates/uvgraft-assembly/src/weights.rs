//! The networks that are not part of uvgraft, in the user's data folder: where they are kept, and those
//! that find faces.

use std::path::PathBuf;

use uvgraft_files::input::ReadError;
use uvgraft_pipeline::{Failure, Result};
use uvgraft_selfie::face_networks::{self, FaceModels};

/// Overrides the path of the LPIPS weights in the user's data folder.
const LPIPS_VARIABLE: &str = "UVGRAFT_WEIGHTS";

/// Overrides the path of the face networks in the user's data folder.
const FACE_VARIABLE: &str = "UVGRAFT_FACE_WEIGHTS";

/// Where the weights of LPIPS are kept, whether or not they were imported.
///
/// # Errors
/// If the environment names no folder for user data.
pub fn lpips_path() -> Result<PathBuf> {
    path(LPIPS_VARIABLE, "lpips.safetensors")
}

/// Where the networks that find faces are kept, whether or not they were imported.
///
/// # Errors
/// As [`lpips_path`].
pub fn face_networks_path() -> Result<PathBuf> {
    path(FACE_VARIABLE, "face_networks.safetensors")
}

/// The networks that find faces; `None` if none were imported.
///
/// # Errors
/// As bad input for a file that cannot be read, and as [`lpips_path`].
pub fn face_models() -> Result<Option<FaceModels>> {
    match face_networks::read(face_networks_path()?) {
        Ok(models) => Ok(Some(models)),
        Err(error) => missing_or(error),
    }
}

/// `None` if a file of networks does not exist.
///
/// # Errors
/// As bad input for any other error.
pub fn missing_or<T, E: std::error::Error>(error: ReadError<E>) -> Result<Option<T>> {
    match error {
        ReadError::Io { reason, .. } if reason.kind() == std::io::ErrorKind::NotFound => Ok(None),
        error => Err(Failure::input(format!(
            "{error}; import the weights again: see `uvgraft weights --help`"
        ))),
    }
}

/// Path of an imported file, by an environment variable or by its name in the user's data folder.
fn path(variable: &str, name: &str) -> Result<PathBuf> {
    if let Some(path) = std::env::var_os(variable).filter(|path| !path.is_empty()) {
        return Ok(PathBuf::from(path));
    }
    let folder = data_folder().ok_or_else(|| {
        Failure::input(format!("no home folder to keep weights in; set {variable} to a file path"))
    })?;
    Ok(folder.join("uvgraft").join(name))
}

#[cfg(not(target_family = "wasm"))]
fn data_folder() -> Option<PathBuf> {
    use etcetera::BaseStrategy;
    etcetera::choose_base_strategy().ok().map(|folders| folders.data_dir())
}

/// WebAssembly has no home.
#[cfg(target_family = "wasm")]
fn data_folder() -> Option<PathBuf> {
    None
}
