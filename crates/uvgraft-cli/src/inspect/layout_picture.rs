//! A picture of one layout: a panel for each UV tile, islands in colours of their own.

use std::path::Path;

use uvgraft::islands::Islands;
use uvgraft::mesh::TileFaces;
use uvgraft::mesh_report::MeshReport;
use uvgraft::{MapOptions, Mesh, SamplingMap, Size, Texture};

use crate::report::grouped;
use uvgraft_assembly::drawing::{Rgb, Sheet};
use uvgraft_assembly::pair_picture::{BACKGROUND, CAPTION, MARGIN, PANEL, draw_lines};
use uvgraft_assembly::recognition;

/// Further tiles are not drawn; the report lists them.
const MAX_PANELS: usize = 4;

/// Draws the layout of a mesh and writes the picture.
pub(super) fn write(
    mesh: &Mesh,
    report: &MeshReport,
    name: &str,
    path: &Path,
) -> anyhow::Result<()> {
    let shown: Vec<&TileFaces> = report.tiles.iter().take(MAX_PANELS).collect();
    let count = shown.len() as u32;
    let size = Size::new(count * (PANEL + MARGIN) + MARGIN, PANEL + CAPTION + 2 * MARGIN);
    let mut picture = Sheet::new(size, BACKGROUND);
    let islands = Islands::new(mesh);
    for (index, tile) in (0u32..).zip(&shown) {
        let left = MARGIN + index * (PANEL + MARGIN);
        picture.paste(&panel(mesh, &islands, tile.tile)?, left, CAPTION + MARGIN);
        let title = match (index, count, tile.udim) {
            (_, 1, _) => name.to_owned(),
            (_, _, Some(udim)) => format!("{name}: tile {udim}"),
            (_, _, None) => format!("{name}: column {}, row {}", tile.tile[0], tile.tile[1]),
        };
        let title = Sheet::fitted(&title, PANEL, 2);
        picture.text(&title, left, MARGIN, 2, [236, 238, 242]);
        let faces = recognition::triangles(tile.faces);
        let counts = if index == 0 {
            let layout = recognition::names(&report.recognition)[1].clone();
            format!("{faces}; {} UV islands in all; {layout}", grouped(report.islands))
        } else {
            faces
        };
        let counts = Sheet::fitted(&counts, PANEL, 1);
        picture.text(&counts, left, MARGIN + 28, 1, [160, 166, 176]);
    }
    Ok(picture.write(path)?)
}

/// One tile of the layout.
fn panel(mesh: &Mesh, islands: &Islands, [column, row]: [i32; 2]) -> anyhow::Result<Texture> {
    let size = Size::square(PANEL);
    let mut panel = Sheet::new(size, BACKGROUND.map(|value| value / 2));
    // Rows of tiles are counted upwards, and `v` grows downwards.
    let uv = mesh.uv().iter().map(|&[u, v]| [u - column as f32, v + row as f32]).collect();
    let positions = mesh.positions().to_vec();
    let moved = Mesh::from_triangles(positions, uv, mesh.faces(), mesh.uv_faces())?;
    let map = SamplingMap::of_layout(&moved, size, &MapOptions::with_gutter(0));
    for y in 0..PANEL {
        for run in map.row(y) {
            let face = map.patches()[run.patch as usize].face;
            let color = island_color(islands.of_faces()[face as usize]);
            (run.x..run.x + run.len).for_each(|x| panel.set(x, y, color));
        }
    }
    draw_lines(&moved, &mut panel)?;
    Ok(panel.into_texture()?)
}

/// A colour for an island: hues a golden ratio apart, so that neighbours in number differ well.
fn island_color(island: u32) -> Rgb {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let hue = (f64::from(island) * GOLDEN).fract();
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|shift| {
        let wave = ((hue + shift) * std::f64::consts::TAU).cos();
        (132.0 + 74.0 * wave) as u8
    })
}
