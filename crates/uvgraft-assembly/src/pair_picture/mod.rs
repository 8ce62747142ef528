//! Previews of a pair: both layouts side by side, to check the pairing at a glance.
//!
//! The linked region has the same colours on both sides: hue and checks follow the position in the
//! source layout, so an eye that is orange on the left must be orange on the right.

mod surfaces;

use std::sync::Arc;

use uvgraft::correspond::surface::SurfaceReport;
use uvgraft::islands::Islands;
use uvgraft::{Blend, Direction, Graft, MapOptions, Mesh, SamplingMap, Size, Sizes, Texture};
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{Blame, Result};

use crate::drawing::{Pen, Rgb, Sheet};
use crate::report::grouped;

/// Side of a layout's panel, in pixels.
pub const PANEL: u32 = 1024;
/// Around panels, in pixels.
pub const MARGIN: u32 = 24;
/// Height of the text above a panel, in pixels.
pub const CAPTION: u32 = 56;

/// Around panels and behind layouts.
pub const BACKGROUND: [u8; 3] = [24, 26, 30];
const UNLINKED: Rgb = [74, 78, 86];
const TEXT: Rgb = [236, 238, 242];
const FAINT_TEXT: Rgb = [160, 166, 176];

/// Draws the weight of a blend at each texel, on both layouts.
///
/// # Errors
/// If the blend is not one of the pair.
pub fn of_region(file: &PairFile, blend: &Arc<Blend>) -> Result<Sheet> {
    let direction = blend.domain().direction();
    // Weights do not depend on the size of textures.
    let sizes = Sizes { from: Size::square(1), to: Size::square(PANEL) };
    let graft = Graft::builder(Arc::clone(&file.pair), sizes)
        .direction(direction)
        .gutter_px(0)
        .shared_blend(Arc::clone(blend))
        .build()
        .or_work()?;
    let weights = graft.mask();
    let to_color = |uv: [f64; 2]| {
        let [x, y] = uv.map(|at| (at * f64::from(PANEL)).clamp(0.0, f64::from(PANEL - 1)) as u32);
        weight_color(weights.get(x, y, 0))
    };
    layouts(file, 0, |shown, here_uv, there_uv| {
        to_color(if shown == direction { here_uv } else { there_uv })
    })
}

/// From grey (excluded) through dark blue (little) to yellow (full weight).
fn weight_color(weight: f32) -> Rgb {
    if weight == 0.0 {
        return UNLINKED.map(|value| value + 34);
    }
    let mix = |from: f32, to: f32| from + (to - from) * weight;
    [mix(36.0, 250.0) as u8, mix(52.0, 196.0) as u8, mix(140.0, 60.0) as u8]
}

/// Draws a pair.
///
/// - `registered`: what registration found, if the meshes were linked by it; both surfaces are drawn
///   too.
///
/// # Errors
/// If the meshes cannot be drawn.
pub fn of_pair(file: &PairFile, registered: Option<&SurfaceReport>) -> Result<Sheet> {
    let below = if registered.is_some() { surfaces::HEIGHT } else { 0 };
    let mut picture = layouts(file, below, by_place)?;
    if let Some(report) = registered {
        surfaces::draw(file, report, &mut picture)?;
    }
    Ok(picture)
}

/// The colour of a linked texel by its position in the source layout.
fn by_place(shown: Direction, here_uv: [f64; 2], there_uv: [f64; 2]) -> Rgb {
    place_color(if shown == Direction::Forward { there_uv } else { here_uv })
}

/// Draws both layouts.
///
/// - `below`: height of the empty space below them, in pixels.
/// - `color`: the colour of a linked texel, by the direction that leads to the layout, and its UV
///   coordinates there and in the other layout.
fn layouts(
    file: &PairFile,
    below: u32,
    color: impl Fn(Direction, [f64; 2], [f64; 2]) -> Rgb,
) -> Result<Sheet> {
    let size = Size::new(2 * PANEL + 3 * MARGIN, PANEL + CAPTION + 2 * MARGIN + below);
    let mut picture = Sheet::new(size, BACKGROUND);
    for (index, (title, direction)) in (0u32..).zip([
        (format!("source: {}", file.source_name), Direction::Reverse),
        (format!("target: {}", file.target_name), Direction::Forward),
    ]) {
        let left = MARGIN + index * (PANEL + MARGIN);
        let panel = panel(file, direction, |here, there| color(direction, here, there))?;
        picture.paste(&panel, left, CAPTION + MARGIN);
        picture.text(&title, left, MARGIN, 2, TEXT);
        let mesh = file.pair.to(direction);
        let linked = match direction {
            Direction::Forward => file.pair.pieces().map(|piece| piece.target).collect(),
            Direction::Reverse => file.pair.pieces().map(|piece| piece.source).collect(),
        };
        let counts = format!(
            "{} of {} triangles linked, {} UV islands",
            grouped(distinct(linked)),
            grouped(mesh.faces().len()),
            grouped(Islands::new(mesh).count()),
        );
        picture.text(&counts, left, MARGIN + 28, 1, FAINT_TEXT);
    }
    Ok(picture)
}

fn distinct(mut faces: Vec<u32>) -> usize {
    faces.sort_unstable();
    faces.dedup();
    faces.len()
}

/// The layout that `direction` leads to: linked texels in colours by the UV coordinates there and
/// in the other layout, the rest grey, with the wireframe on top.
fn panel(
    file: &PairFile,
    direction: Direction,
    color: impl Fn([f64; 2], [f64; 2]) -> Rgb,
) -> Result<Texture> {
    let mesh = file.pair.to(direction);
    let mut panel = Sheet::new(Size::square(PANEL), BACKGROUND.map(|value| value / 2));
    let all = SamplingMap::of_layout(mesh, panel.size(), &MapOptions::with_gutter(0));
    for y in 0..PANEL {
        for run in all.row(y) {
            (run.x..run.x + run.len).for_each(|x| panel.set(x, y, UNLINKED));
        }
    }
    color_linked(file, direction, 0, &mut panel, color);
    draw_lines(mesh, &mut panel)?;
    panel.into_texture()
}

/// Colours the linked texels of the layout that `direction` leads to, and those in a gutter around
/// them.
fn color_linked(
    file: &PairFile,
    direction: Direction,
    gutter_px: u32,
    picture: &mut Sheet,
    color: impl Fn([f64; 2], [f64; 2]) -> Rgb,
) {
    let size = picture.size();
    let options = MapOptions::with_gutter(gutter_px);
    let linked = SamplingMap::new(&file.pair, direction, size, &options);
    for y in 0..size.height {
        for run in linked.row(y) {
            let patch = &linked.patches()[run.patch as usize];
            for x in run.x..run.x + run.len {
                let here = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let there_uv = patch.src_uv_from_tgt_px.at(here);
                let here_uv = [here[0] / f64::from(size.width), here[1] / f64::from(size.height)];
                picture.set(x, y, color(here_uv, there_uv));
            }
        }
    }
}

/// A colour that encodes a position in the unit square: four corner colours blended, with checks.
fn place_color([u, v]: [f64; 2]) -> Rgb {
    const CORNERS: [[f64; 3]; 4] =
        [[240.0, 110.0, 90.0], [245.0, 200.0, 80.0], [90.0, 120.0, 230.0], [70.0, 200.0, 160.0]];
    let (s, t) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    let square = ((u * 16.0).floor() + (v * 16.0).floor()).rem_euclid(2.0);
    let shade = if square == 0.0 { 1.0 } else { 0.82 };
    std::array::from_fn(|channel| {
        let [a, b, c, d] = CORNERS.map(|corner| corner[channel]);
        let top = a + (b - a) * s;
        let bottom = c + (d - c) * s;
        ((top + (bottom - top) * t) * shade) as u8
    })
}

/// Draws the wireframe of a layout faintly and the borders of its islands clearly.
///
/// # Errors
/// As [`Sheet::draw`].
pub fn draw_lines(mesh: &Mesh, panel: &mut Sheet) -> Result<()> {
    let at = |index: u32| mesh.uv()[index as usize].map(|value| f64::from(value * PANEL as f32));
    panel.draw(|canvas| {
        let [mut wires, mut borders] = [canvas.lines(), canvas.lines()];
        mesh.uv_faces().iter().for_each(|corners| wires.add_triangle(corners.map(at)));
        for edge in Islands::new(mesh).boundary_edges() {
            let corners = mesh.uv_faces()[edge.face as usize];
            borders.add([0, 1].map(|k| at(corners[(usize::from(edge.corner) + k) % 3])));
        }
        canvas.draw(wires, Pen::flat([0; 3], 70, 0.6));
        canvas.draw(borders, Pen::flat([255; 3], 220, 1.4));
    })
}
