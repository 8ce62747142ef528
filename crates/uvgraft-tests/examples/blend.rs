//! Carries a face to a body with a different skin tone, without a visible seam:
//! `cargo run --release -p uvgraft-tests --example blend -- body.png`

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use uvgraft::blend::Growth;
use uvgraft::{BlendDomain, BlendOptions, Direction, Graft, Pair, Size, Sizes};
use uvgraft_figure::{Figure, paint_body_in_tone, paint_head};
use uvgraft_image::{self as image, Image, WriteOptions};

/// - `path`: the image to write.
pub fn run(path: &Path) -> Result<(), Box<dyn Error>> {
    let figure = Figure::new();
    let face = paint_head(&figure, Size::square(1024));
    let body = paint_body_in_tone(&figure, Size::square(2048), [0.55, 0.47, 0.42]);
    let vertex_map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
    let pair = Arc::new(Pair::by_vertex_map(figure.head, figure.body, &vertex_map)?);

    // Everything linked except the lower end of the neck. Regions are made from vertices, painted
    // masks and other regions. Lengths are in the mesh's unit, here metres.
    let domain = BlendDomain::new(Arc::clone(&pair), Direction::Forward);
    let region = domain.linked().grown(Growth::Length(-0.01));

    // Match the face to the tone of the body's skin along the region's boundary, and fade it out
    // over one centimetre.
    let options = BlendOptions::default().membrane().feather(0.01);
    let graft = Graft::builder(pair, Sizes { from: face.size(), to: body.size() })
        .region(region)
        .blend(options)
        .build()?;
    let result = graft.apply(face, body)?;
    let _ = image::write(&Image::from(result), path, &WriteOptions::default())?;
    Ok(())
}

#[expect(clippy::print_stdout, reason = "what there is to tell")]
fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map(PathBuf::from);
    let path = path.unwrap_or_else(|| std::env::temp_dir().join("uvgraft-blend.png"));
    run(&path)?;
    println!("wrote {}", path.display());
    Ok(())
}
