//! The frame rate of a file.

use uvgraft_io::arrays::NamedArrays;

use super::super::MotionError;
use super::has_key;

/// Upper limit of the frame rate, in frames a second.
const MAX_RATE: f64 = 10_000.0;
/// AMASS's names first, then those of other tools.
const NAMES: [&str; 6] =
    ["mocap_framerate", "mocap_frame_rate", "fps", "mocap_fps", "framerate", "frame_rate"];

/// The frame rate that a file states, as a number or as text.
pub(super) fn stated(arrays: &NamedArrays) -> Result<Option<f64>, MotionError> {
    let Some(key) = NAMES.into_iter().find(|key| has_key(arrays, key)) else { return Ok(None) };
    if let Some(rate) = arrays.text(key).and_then(|text| text.trim().parse().ok()) {
        return Ok(Some(rate));
    }
    let rate = arrays.require(key)?;
    match rate.f64s().as_ref() {
        &[rate] => Ok(Some(rate)),
        _ => {
            let (found, wanted) = (rate.shape().to_vec(), "[1]".to_owned());
            Err(MotionError::Shape { key, found, wanted })
        }
    }
}

pub(super) fn missing(arrays: &NamedArrays) -> MotionError {
    let wanted = NAMES.map(|name| format!("`{name}`")).join(", ");
    MotionError::NoRate { wanted, found: arrays.listed() }
}

pub(super) fn checked(found: f64) -> Result<f64, MotionError> {
    if found.is_finite() && found > 0.0 && found <= MAX_RATE {
        Ok(found)
    } else {
        Err(MotionError::Rate { found, most: MAX_RATE })
    }
}
