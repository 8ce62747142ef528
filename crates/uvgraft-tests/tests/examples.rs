//! Runs the examples and checks their results.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::error::Error;
use std::path::Path;

use uvgraft::{Size, Texture};

#[path = "../examples/bands.rs"]
#[allow(dead_code, reason = "what the command line does is not called")]
mod bands;
#[path = "../examples/blend.rs"]
#[allow(dead_code, reason = "what the command line does is not called")]
mod blend;
#[path = "../examples/fit.rs"]
#[allow(dead_code, reason = "what the command line does is not called")]
mod fit;
#[path = "../examples/transfer.rs"]
#[allow(dead_code, reason = "what the command line does is not called")]
mod transfer;

/// Runs an example and reads the image it wrote.
fn written<R>(run: impl Fn(&Path) -> Result<R, Box<dyn Error>>) -> (Texture, R) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("result.png");
    let result = run(&path).unwrap();
    (uvgraft_image::read(&path).unwrap().texture, result)
}

#[test]
fn transfer_and_blend_write_bodies() {
    let [plain, blended] = [written(transfer::run).0, written(blend::run).0];
    assert_eq!([plain.size(), blended.size()], [Size::square(2048); 2]);
    assert_ne!(plain, blended);
}

#[test]
fn bands_write_a_face_on_one_colour() {
    let (texture, ()) = written(bands::run);
    assert_eq!(texture.size(), Size::square(4096));
    let gray = |&at: &u32| texture.get(at % 4096, at / 4096, 0) == 77.0 / 255.0;
    let count = (0..4096 * 4096).step_by(997).filter(gray).count();
    // Some of it, but not all.
    assert!((1_000..16_000).contains(&count), "{count}");
}

#[test]
fn fit_reads_back_better() {
    let (texture, summary) = written(fit::run);
    assert_eq!(texture.size(), Size::square(512));
    assert!(summary.fitted_rms < 0.95 * summary.sampled_rms, "{summary:?}");
}
