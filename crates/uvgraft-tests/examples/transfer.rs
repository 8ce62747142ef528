//! Carries a face texture from the layout of a head to that of a whole body:
//! `cargo run --release -p uvgraft-tests --example transfer -- body.png`

use std::error::Error;
use std::path::{Path, PathBuf};

use uvgraft::{Graft, Pair, Size, Sizes};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_image::{self as image, Image, WriteOptions};

/// - `path`: the image to write.
pub fn run(path: &Path) -> Result<(), Box<dyn Error>> {
    // A head, and a body that contains it with other vertex indices and other UV coordinates.
    // `uvgraft_io::obj::read`, `uvgraft_io::vertex_map::read` and `uvgraft_image::read` read
    // them from files.
    let figure = Figure::new();
    let face = paint_head(&figure, Size::square(1024));
    let body = paint_body(&figure, Size::square(2048));

    // For each vertex of the head the corresponding vertex of the body, or -1 for none.
    let vertex_map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
    let pair = Pair::by_vertex_map(figure.head, figure.body, &vertex_map)?;

    // Everything that depends only on layouts and sizes is prepared once, for any number of
    // textures.
    let graft = Graft::builder(pair, Sizes { from: face.size(), to: body.size() }).build()?;
    let result = graft.apply(face, body)?;
    let _ = image::write(&Image::from(result), path, &WriteOptions::default())?;
    Ok(())
}

#[expect(clippy::print_stdout, reason = "what there is to tell")]
fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map(PathBuf::from);
    let path = path.unwrap_or_else(|| std::env::temp_dir().join("uvgraft-transfer.png"));
    run(&path)?;
    println!("wrote {}", path.display());
    Ok(())
}
