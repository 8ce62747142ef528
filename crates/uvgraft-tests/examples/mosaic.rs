//! Writes the mosaic of photographs that round trips are measured on:
//! `cargo run --release -p uvgraft-tests --example mosaic -- mosaic.png`

use std::path::Path;
use std::process::ExitCode;

use uvgraft::Size;
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_tests::photographs::mosaic;

#[expect(clippy::print_stderr, reason = "the only output there is")]
fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: mosaic OUT.png");
        return ExitCode::from(2);
    };
    let Some(texture) = mosaic(Size::square(4096)) else { return ExitCode::FAILURE };
    match image::write(&Image::from(texture), Path::new(&path), &WriteOptions::default()) {
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
