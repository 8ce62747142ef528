//! Reference values of metrics, made by `fixtures/metrics.py` with other implementations.

use std::collections::BTreeMap;

use serde::Deserialize;

/// Two pictures, what of them counts, and what other implementations say of them.
#[derive(Debug, Deserialize)]
pub struct Case {
    /// What [`crate::pictures::picture`] paints or reads.
    pub picture: String,
    /// What [`crate::pictures::distorted`] does to it.
    pub distortion: String,
    /// What [`crate::pictures::mask`] leaves of it; nothing for all.
    pub mask: Option<String>,
    /// Values by the metrics' names; not every implementation takes masks.
    pub values: BTreeMap<String, f64>,
}

/// All cases.
///
/// # Panics
/// If the file is not what the script writes.
pub fn metrics() -> Vec<Case> {
    #[derive(Deserialize)]
    struct Fixtures {
        cases: Vec<Case>,
    }
    let json = include_str!("../fixtures/metrics.json");
    serde_json::from_str::<Fixtures>(json).expect("fixtures as the script writes them").cases
}
