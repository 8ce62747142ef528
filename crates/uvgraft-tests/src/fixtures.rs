//! Reference values of metrics, computed by `fixtures/metrics.py` with other implementations.

use std::collections::BTreeMap;

use serde::Deserialize;

/// Two pictures, an optional mask, and the values that other implementations give for them.
#[derive(Debug, Deserialize)]
pub struct Case {
    /// Name of the first picture, for [`crate::pictures::picture`].
    pub picture: String,
    /// Name of the distortion that makes the second, for [`crate::pictures::distorted`].
    pub distortion: String,
    /// Name of the mask, for [`crate::pictures::mask`]; `None` for the whole picture.
    pub mask: Option<String>,
    /// Values by metric name; not every implementation supports masks.
    pub values: BTreeMap<String, f64>,
}

/// All cases.
///
/// # Panics
/// If the file is not in the script's format.
pub fn metrics() -> Vec<Case> {
    #[derive(Deserialize)]
    struct Fixtures {
        cases: Vec<Case>,
    }
    let json = include_str!("../fixtures/metrics.json");
    serde_json::from_str::<Fixtures>(json).expect("fixtures as the script writes them").cases
}
