//! Previews of a pair: both layouts side by side, to check the pairing at a glance.
//!
//! The linked region has the same colours on both sides: hue and checks follow the position in the
//! source layout, so an eye that is orange on the left must be orange on the right.

use std::path::Path;
use std::sync::Arc;

use tiny_skia::{Color, Paint, PathBuilder, Stroke, Transform};
use uvgraft::islands::Islands;
use uvgraft::{Blend, Direction, Graft, MapOptions, Mesh, SamplingMap, Size, Sizes, Texture};
use uvgraft_io::pair_file::PairFile;

use crate::picture::Picture;
use crate::report::grouped;

/// Side of a layout's panel, in pixels.
pub(crate) const PANEL: u32 = 1024;
pub(crate) const MARGIN: u32 = 24;
pub(crate) const CAPTION: u32 = 56;

pub(crate) const BACKGROUND: [u8; 3] = [24, 26, 30];
const UNLINKED: [u8; 3] = [74, 78, 86];

/// Draws the weight of a blend at each texel, on both layouts, and writes the picture.
pub(crate) fn write_region(file: &PairFile, blend: &Arc<Blend>, path: &Path) -> anyhow::Result<()> {
    let direction = blend.domain().direction();
    // Weights do not depend on the size of textures.
    let sizes = Sizes { from: Size::square(1), to: Size::square(PANEL) };
    let graft = Graft::builder(Arc::clone(&file.pair), sizes)
        .direction(direction)
        .gutter_px(0)
        .shared_blend(Arc::clone(blend))
        .build()?;
    let weights = graft.mask();
    let to_color = |uv: [f64; 2]| {
        let [x, y] = uv.map(|at| (at * f64::from(PANEL)).clamp(0.0, f64::from(PANEL - 1)) as u32);
        weight_color(weights.get(x, y, 0))
    };
    draw(file, path, |shown, here_uv, there_uv| {
        to_color(if shown == direction { here_uv } else { there_uv })
    })
}

/// From grey (excluded) through dark blue (little) to yellow (full weight).
fn weight_color(weight: f32) -> [u8; 3] {
    if weight == 0.0 {
        return UNLINKED.map(|value| value + 34);
    }
    let mix = |from: f32, to: f32| from + (to - from) * weight;
    [mix(36.0, 250.0) as u8, mix(52.0, 196.0) as u8, mix(140.0, 60.0) as u8]
}

/// Draws a pair and writes the picture.
pub(crate) fn write(file: &PairFile, path: &Path) -> anyhow::Result<()> {
    draw(file, path, |shown, here_uv, there_uv| {
        place_color(if shown == Direction::Forward { there_uv } else { here_uv })
    })
}

/// Draws both layouts.
///
/// - `color`: the colour of a linked texel, by the direction that leads to the layout, and its UV
///   coordinates there and in the other layout.
fn draw(
    file: &PairFile,
    path: &Path,
    color: impl Fn(Direction, [f64; 2], [f64; 2]) -> [u8; 3],
) -> anyhow::Result<()> {
    let size = Size::new(2 * PANEL + 3 * MARGIN, PANEL + CAPTION + 2 * MARGIN);
    let mut picture = Picture::new(size, BACKGROUND);
    for (index, (title, direction)) in (0u32..).zip([
        (format!("source: {}", file.source_name), Direction::Reverse),
        (format!("target: {}", file.target_name), Direction::Forward),
    ]) {
        let left = MARGIN + index * (PANEL + MARGIN);
        let panel = panel(file, direction, |here, there| color(direction, here, there))?;
        picture.paste(&panel, left, CAPTION + MARGIN);
        picture.text(&title, left, MARGIN, 2, [236, 238, 242]);
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
        picture.text(&counts, left, MARGIN + 28, 1, [160, 166, 176]);
    }
    picture.write(path)
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
    color: impl Fn([f64; 2], [f64; 2]) -> [u8; 3],
) -> anyhow::Result<Texture> {
    let mesh = file.pair.to(direction);
    let size = Size::square(PANEL);
    let mut panel = Picture::new(size, BACKGROUND.map(|value| value / 2));
    let options = MapOptions::with_gutter(0);
    let all = SamplingMap::of_layout(mesh, size, &options);
    let linked = SamplingMap::new(&file.pair, direction, size, &options);
    for y in 0..PANEL {
        for run in all.row(y) {
            (run.x..run.x + run.len).for_each(|x| panel.set(x, y, UNLINKED));
        }
        for run in linked.row(y) {
            let patch = &linked.patches()[run.patch as usize];
            for x in run.x..run.x + run.len {
                let here = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let there_uv = patch.src_uv_from_tgt_px.at(here);
                panel.set(x, y, color(here.map(|at| at / f64::from(PANEL)), there_uv));
            }
        }
    }
    draw_lines(mesh, &mut panel)?;
    panel.into_texture()
}

/// A colour that encodes a position in the unit square: four corner colours blended, with checks.
fn place_color([u, v]: [f64; 2]) -> [u8; 3] {
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
pub(crate) fn draw_lines(mesh: &Mesh, panel: &mut Picture) -> anyhow::Result<()> {
    let at = |index: u32| mesh.uv()[index as usize].map(|coordinate| coordinate * PANEL as f32);
    let mut wires = PathBuilder::new();
    for corners in mesh.uv_faces() {
        let [a, b, c] = corners.map(at);
        wires.move_to(a[0], a[1]);
        wires.line_to(b[0], b[1]);
        wires.line_to(c[0], c[1]);
        wires.close();
    }
    let mut borders = PathBuilder::new();
    for edge in Islands::new(mesh).boundary_edges() {
        let corners = mesh.uv_faces()[edge.face as usize];
        let [a, b] = [0, 1].map(|k| at(corners[(usize::from(edge.corner) + k) % 3]));
        borders.move_to(a[0], a[1]);
        borders.line_to(b[0], b[1]);
    }
    let strokes = [
        (wires, Color::from_rgba8(0, 0, 0, 70), 0.6),
        (borders, Color::from_rgba8(255, 255, 255, 220), 1.4),
    ];
    panel.draw(|pixmap| {
        for (path, color, width) in strokes {
            let mut paint = Paint::default();
            paint.set_color(color);
            paint.anti_alias = true;
            let stroke = Stroke { width, ..Stroke::default() };
            if let Some(path) = path.finish() {
                pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
            }
        }
    })
}
