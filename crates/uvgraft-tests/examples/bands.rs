//! Lays a texture over a base, band by band, without ever holding the whole base in memory:
//! `cargo run --release -p uvgraft-tests --example bands -- body.png`

use std::error::Error;
use std::path::{Path, PathBuf};

use uvgraft::{Channels, Depth, Encoding, Graft, Pair, Size, Sizes, TexelFormat, Texture};
use uvgraft_figure::{Figure, paint_head};
use uvgraft_image::{BandWriter, TextureSpec, WriteOptions};

/// Rows per band.
const ROWS: u32 = 256;

/// - `path`: the image to write.
pub fn run(path: &Path) -> Result<(), Box<dyn Error>> {
    let figure = Figure::new();
    let face = paint_head(&figure, Size::square(1024));
    let vertex_map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
    let pair = Pair::by_vertex_map(figure.head, figure.body, &vertex_map)?;
    let size = Size::square(4096);
    let graft = Graft::builder(pair, Sizes { from: face.size(), to: size }).build()?;

    // An overlay is a texture prepared for bases of one format. The format of its results differs
    // if the texture has more channels or a greater depth.
    let base = TexelFormat { channels: Channels::Rgb, depth: Depth::U8, encoding: Encoding::Srgb };
    let overlay = graft.overlay(face, base)?;
    let spec = TextureSpec::new(size, overlay.format());
    let mut writer = BandWriter::create(path, spec, None, &WriteOptions::default())?;
    for first_row in (0..size.height).step_by(ROWS as usize) {
        // A single colour here; `uvgraft_image::BandReader` reads the bands of an image.
        let band = Size::new(size.width, ROWS.min(size.height - first_row));
        let band = Texture::filled(band, base.channels, base.encoding, base.depth, &[0.3; 3])?;
        writer.push(&overlay.lay(first_row, band)?)?;
    }
    let _ = writer.finish()?;
    Ok(())
}

#[expect(clippy::print_stdout, reason = "what there is to tell")]
fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map(PathBuf::from);
    let path = path.unwrap_or_else(|| std::env::temp_dir().join("uvgraft-bands.png"));
    run(&path)?;
    println!("wrote {}", path.display());
    Ok(())
}
