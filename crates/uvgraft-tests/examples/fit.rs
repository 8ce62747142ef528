//! Solves for the head texture that best reproduces the body's own texture when applied to the
//! body: `cargo run --release -p uvgraft-tests --example fit -- head.png`

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use uvgraft::{
    Channels, Depth, Direction, Encoding, FitOptions, FitSummary, Graft, Pair, Size, Sizes, Texture,
};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_image::{self as image, Image, WriteOptions};

/// Returns the outcome of the fit.
///
/// - `path`: the image to write.
pub fn run(path: &Path) -> Result<FitSummary, Box<dyn Error>> {
    // Make a body with a face.
    let figure = Figure::new();
    let size = Size::square(1024);
    let (face, body) = (paint_head(&figure, size), paint_body(&figure, size));
    let vertex_map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
    let pair = Arc::new(Pair::by_vertex_map(figure.head, figure.body, &vertex_map)?);
    let there = Graft::builder(Arc::clone(&pair), Sizes { from: face.size(), to: body.size() });
    let body = there.build()?.apply(face, body)?;

    // Go back from the body's layout to the head's, at a quarter of the texels. Sampling blurs once
    // here and once more where the result is used; a fit compensates for both.
    let head = Size::square(512);
    let back = Graft::builder(pair, Sizes { from: body.size(), to: head })
        .direction(Direction::Reverse)
        .build()?;
    let base = Texture::filled(head, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3])?;
    let fitted = back.fit(body, base.format(), &FitOptions::default(), &mut |_| {})?;
    let result = fitted.overlay.lay(0, base)?;
    let _ = image::write(&Image::from(result), path, &WriteOptions::default())?;
    Ok(fitted.summary)
}

#[expect(clippy::print_stdout, reason = "what there is to tell")]
fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map(PathBuf::from);
    let path = path.unwrap_or_else(|| std::env::temp_dir().join("uvgraft-fit.png"));
    let FitSummary { sampled_rms, fitted_rms, steps, .. } = run(&path)?;
    let [sampled, fitted] = [sampled_rms, fitted_rms].map(|rms| rms * 255.0);
    println!("read back, sampled: off by {sampled:.3} levels of 255 (root mean square)");
    println!("read back, fitted in {steps} steps: off by {fitted:.3} levels");
    println!("wrote {}", path.display());
    Ok(())
}
