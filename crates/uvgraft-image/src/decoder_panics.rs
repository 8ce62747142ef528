//! Decoders of other crates, whose panics are refusals of a file.
//!
//! A file is input like any other: whatever is wrong with it, or with the decoder of its format, costs that file alone and
//! not the process. The standard hook still prints the panic to standard error, since a library must not replace the
//! process's hook.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::{Format, ImageError};

/// Runs a decoder of another crate.
///
/// # Errors
/// Those of `decode`, and [`ImageError::GaveUp`] if it panics. What it was decoding into is undefined then, as after any
/// other error.
pub(super) fn refused<T>(
    format: Format,
    decode: impl FnOnce() -> Result<T, ImageError>,
) -> Result<T, ImageError> {
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|panic| {
        let reason = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("no reason given");
        Err(ImageError::GaveUp { format, reason: reason.to_owned() })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_of_its_file() {
        let wanted = "unsupported or damaged JPEG: its decoder gave up (of 3 tiles)";
        let tiles = 3;
        let error = refused::<()>(Format::JPEG, || panic!("of {tiles} tiles")).unwrap_err();
        assert_eq!(error.to_string(), wanted);
        let error = refused::<()>(Format::JPEG, || panic!("of 3 tiles")).unwrap_err();
        assert_eq!(error.to_string(), wanted);
        assert_eq!(refused(Format::JPEG, || Ok(7)).unwrap(), 7);
    }
}
