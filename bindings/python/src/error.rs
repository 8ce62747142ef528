//! Errors of the crates as the exceptions that Python users expect.

use std::fs::File;
use std::io;
use std::path::Path;

use pyo3::create_exception;
use pyo3::exceptions::{PyKeyboardInterrupt, PyMemoryError, PyOSError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use uvgraft::{GraftError, TextureError};
use uvgraft_files::input::ReadError;
use uvgraft_pipeline::{Failure, Fault, Input, spelled};

create_exception!(
    uvgraft,
    Error,
    pyo3::exceptions::PyException,
    "Something that uvgraft was given cannot be used, or its work failed."
);

/// A failure that has no better exception in Python.
pub(crate) fn failed(message: impl std::fmt::Display) -> PyErr {
    Error::new_err(message.to_string())
}

/// An argument with a value that is not allowed.
pub(crate) fn bad_value(message: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(message.to_string())
}

/// An argument of the wrong type.
pub(crate) fn bad_type(message: impl std::fmt::Display) -> PyErr {
    PyTypeError::new_err(message.to_string())
}

/// An error of the system about a file, as the subclass of `OSError` for it.
pub(crate) fn of_file(reason: &io::Error, path: &Path) -> PyErr {
    match code_of(reason) {
        Some(code) => {
            let text = io::Error::from_raw_os_error(code).to_string();
            let text = text.split(" (os error").next().unwrap_or_default().to_owned();
            PyOSError::new_err((code, text, path.as_os_str().to_owned()))
        }
        None => failed(format_args!("{}: {reason}", path.display())),
    }
}

/// The system's number of an error; of one that a library has wrapped, that of its kind.
fn code_of(reason: &io::Error) -> Option<i32> {
    let by_kind = || match reason.kind() {
        io::ErrorKind::NotFound => Some(libc::ENOENT),
        io::ErrorKind::PermissionDenied => Some(libc::EACCES),
        io::ErrorKind::NotADirectory => Some(libc::ENOTDIR),
        io::ErrorKind::IsADirectory => Some(libc::EISDIR),
        io::ErrorKind::StorageFull => Some(libc::ENOSPC),
        io::ErrorKind::ReadOnlyFilesystem => Some(libc::EROFS),
        _ => None,
    };
    reason.raw_os_error().or_else(by_kind)
}

/// An error of reading a file: of the system, or of its content.
pub(crate) fn of_reading<E: std::error::Error + 'static>(error: ReadError<E>) -> PyErr {
    match error {
        ReadError::Io { path, reason } => of_file(&reason, &path),
        content => failed(content),
    }
}

/// A failure to read a file by a function that reads several formats.
pub(crate) fn of_any_file(failure: &Failure, path: &Path) -> PyErr {
    // The system is asked again, since a failure does not keep its error.
    match std::fs::File::open(path) {
        Err(reason) if !path.to_string_lossy().contains('#') => of_file(&reason, path),
        _ => failed(failure),
    }
}

/// An error of preparing or applying a transfer.
pub(crate) fn of_graft(error: GraftError) -> PyErr {
    match error {
        GraftError::Texture(error) => of_texture(error),
        GraftError::Size { .. } | GraftError::Channels { .. } | GraftError::NotFinite { .. } => {
            bad_value(error)
        }
        error => failed(error),
    }
}

/// An error of making a texture.
pub(crate) fn of_texture(error: TextureError) -> PyErr {
    match error {
        TextureError::Memory(_) => PyMemoryError::new_err(error.to_string()),
        error => bad_value(error),
    }
}

/// What Python calls a parameter, in backticks; `None` if libraries call it the same.
fn in_python(name: &str) -> Option<String> {
    (name == "map").then(|| "`maps`".to_owned())
}

/// A message of a library with the names that parameters have in Python, in backticks.
pub(crate) fn with_names(message: &str) -> String {
    spelled(message, in_python)
}

/// A failure of a request.
pub(crate) fn of_pipeline(failure: Failure) -> PyErr {
    let message = failure.spelled(in_python);
    match failure.fault() {
        Fault::Cancelled => PyKeyboardInterrupt::new_err(message),
        Fault::Input | Fault::Work => failed(message),
    }
}

/// An option of a request with a value that it cannot have.
///
/// - `wanted`: follows the name, as in `must be 1 to 100, got 0`.
pub(crate) fn of_option(name: &str, wanted: impl std::fmt::Display) -> PyErr {
    failed(format_args!("`{name}` {wanted}"))
}

/// Checks that all inputs that are files can be opened, for the exceptions that Python has for those
/// that cannot. Pipes are left alone: they can be opened once.
///
/// # Errors
/// The subclass of `OSError` for the first that cannot.
pub(crate) fn check_files<'a>(
    py: Python<'_>,
    inputs: impl IntoIterator<Item = &'a Input>,
) -> PyResult<()> {
    let paths: Vec<&Path> = inputs.into_iter().filter_map(Input::path).collect();
    py.detach(|| paths.into_iter().try_for_each(check_file))
}

/// Checks that a file or a folder can be opened.
///
/// # Errors
/// As [`check_files`].
pub(crate) fn check_file(path: &Path) -> PyResult<()> {
    let opened = path.metadata().and_then(|found| {
        if found.is_dir() {
            path.read_dir().map(drop)
        } else if found.is_file() {
            File::open(path).map(drop)
        } else {
            Ok(())
        }
    });
    opened.map_err(|reason| of_file(&reason, path))
}

/// Warns, of the line that called the package.
///
/// # Errors
/// The first warning, where warnings are to be raised.
pub(crate) fn warn_caller(py: Python<'_>, texts: Vec<String>) -> PyResult<()> {
    if !texts.is_empty() {
        py.import("uvgraft._warnings")?.call_method1("warn", (texts,))?;
    }
    Ok(())
}
