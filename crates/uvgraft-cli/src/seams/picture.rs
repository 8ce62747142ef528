//! Pictures of seams: the layout with its edges coloured by their steps, and close-ups of the worst
//! ones.

use uvgraft::{Mesh, Size, Texture};
use uvgraft_metrics::seams::{EdgeGroup, SeamEdge, SeamReport, Step, Unfolded};

use super::colors::{BEHIND, TOP, blend, edge_color, shown, step_color};
use super::crops::{CROP, EdgeCrop};
use super::face::Face;
use super::report::{Subject, kind, worst};
use super::style::{TEXT, TITLE};
use crate::report::grouped;
use uvgraft_assembly::drawing::Pen;
use uvgraft_assembly::drawing::{Rgb, Sheet};

/// Longer side of the layout in pixels.
const PANEL: u32 = 1140;
const MARGIN: u32 = 24;
const HEAD: u32 = 124;
/// Gap between crops.
const GAP: u32 = 8;
/// Height of the captions of crops.
const CAPTION: u32 = 44;
const LABEL: u32 = 14;
const CELL: Size = Size::new(3 * CROP + 2 * GAP, CAPTION + CROP + LABEL + 14);
/// More close-ups than this make the picture useless.
const MAX_PLACES: usize = 60;

const BACKGROUND: Rgb = [24, 26, 30];

/// Draws the seams of a texture.
pub(super) fn draw(
    subject: &Subject,
    mesh: &Mesh,
    texture: &Texture,
    seams: &SeamReport,
    face: Option<&Face<'_>>,
) -> anyhow::Result<Sheet> {
    let places: Vec<(&SeamEdge, Step)> = worst(seams).take(MAX_PLACES).collect();
    let layout = layout(texture, seams, &places)?;
    // As many in a column as fit next to the layout, unless that takes too many columns.
    let columns = (places.len() as u32).div_ceil(PANEL / CELL.height).min(3);
    let rows = (places.len() as u32).div_ceil(columns.max(1));
    let width = MARGIN + PANEL + columns * (MARGIN + CELL.width) + MARGIN;
    let bottom = HEAD + PANEL.max(rows * CELL.height) + MARGIN;
    let below = face.map_or(0, |face| face.height(width - 2 * MARGIN) + MARGIN);
    let size = Size::new(width, bottom + below);
    let mut picture = Sheet::new(size, BACKGROUND);
    head(&mut picture, subject, seams, size.width - 2 * MARGIN);
    let Size { width, height } = layout.size();
    picture.paste(&layout, MARGIN + (PANEL - width) / 2, HEAD + (PANEL - height) / 2);
    let surface = Unfolded::new(mesh);
    for (index, (edge, step)) in (0u32..).zip(places) {
        let left = MARGIN + PANEL + MARGIN + index / rows * (CELL.width + MARGIN);
        let top = HEAD + index % rows * CELL.height;
        let place = EdgeCrop::new(texture, edge, step);
        cell(&mut picture, [left, top], index + 1, (edge, step), &place, &surface)?;
    }
    if let Some(face) = face {
        face.draw(&mut picture, [MARGIN, bottom], size.width - 2 * MARGIN);
    }
    Ok(picture)
}

fn head(picture: &mut Sheet, subject: &Subject, seams: &SeamReport, width: u32) {
    let title = format!("seams of {}", subject.texture);
    picture.text(&Sheet::fitted(&title, width, 2), MARGIN, MARGIN, 2, TITLE);
    let text = format!(
        "on {}, {} texels; colours sampled {} from the edge on either side; the region \
         is {}",
        subject.mesh,
        subject.size,
        subject.offset(),
        subject.region
    );
    picture.text(&Sheet::fitted(&text, width, 1), MARGIN, MARGIN + 26, 1, TEXT);
    let columns = [("UV seams", &seams.uv_seams, false), ("boundary", &seams.rim, true)];
    for (index, (name, group, is_rim)) in (0u32..).zip(columns) {
        scale(picture, [MARGIN + index * (PANEL / 2 + 6), MARGIN + 46], name, group, is_rim);
    }
}

/// The statistics of a kind of edges, and its colour scale.
fn scale(picture: &mut Sheet, [left, top]: [u32; 2], name: &str, group: &EdgeGroup, is_rim: bool) {
    const WIDTH: u32 = PANEL / 2 - 30;
    const HEIGHT: u32 = 10;
    let steps = group.delta_e.map_or("not measured".to_owned(), |steps| {
        format!(
            "delta E median {:.1}, 95 % {:.1}, largest {:.1}",
            steps.median, steps.p95, steps.max
        )
    });
    let text = format!("{name}: {} edges, {steps}", grouped(group.edges));
    picture.text(&Sheet::fitted(&text, WIDTH, 1), left, top, 1, TITLE);
    for x in 0..WIDTH {
        let color = step_color(f64::from(x) / f64::from(WIDTH - 1) * TOP, is_rim);
        (0..HEIGHT).for_each(|y| picture.set(left + x, top + 14 + y, color));
    }
    for (delta_e, text) in [(0.0, "0"), (2.0, "2"), (5.0, "5"), (TOP, "10 and more")] {
        let at = (delta_e / TOP * f64::from(WIDTH - 1)) as u32;
        let room = Sheet::text_width(text, 1);
        let start = (at.saturating_sub(room / 2)).min(WIDTH - room);
        (0..3).for_each(|y| picture.set(left + at, top + 14 + HEIGHT + y, TEXT));
        picture.text(text, left + start, top + 14 + HEIGHT + 5, 1, TEXT);
    }
}

/// The texture, darkened, as a background for its seams.
fn layout(
    texture: &Texture,
    seams: &SeamReport,
    places: &[(&SeamEdge, Step)],
) -> anyhow::Result<Texture> {
    let Size { width, height } = texture.size();
    let side = |texels: u32| {
        let share = f64::from(texels) / f64::from(width.max(height));
        ((share * f64::from(PANEL)) as u32).max(1)
    };
    let size = Size::new(side(width), side(height));
    let mut panel = Sheet::new(size, BEHIND);
    for y in 0..size.height {
        for x in 0..size.width {
            let color = reduced(texture, size, x, y);
            let grey = [color.iter().map(|&value| u32::from(value)).sum::<u32>() / 3; 3];
            let pale = blend(color, grey.map(|value| value as u8), 0.4);
            panel.set(x, y, blend(pale, BEHIND, 0.45));
        }
    }
    let pixel = |uv: [f64; 2]| [uv[0] * f64::from(size.width), uv[1] * f64::from(size.height)];
    // The border of the region over UV seams, and in each the largest steps on top.
    let mut edges: Vec<&SeamEdge> = seams.edges.iter().collect();
    edges.sort_by(|a, b| {
        let mean = |edge: &SeamEdge| edge.mean.unwrap_or(-1.0);
        a.is_rim.cmp(&b.is_rim).then(mean(a).total_cmp(&mean(b)))
    });
    panel.draw(|canvas| {
        for edge in edges {
            for side in &edge.sides {
                let ends = side.uv.map(|uv| pixel(uv.map(f64::from)));
                let width = if edge.is_rim { 3.0 } else { 2.2 };
                canvas.line(ends, Pen::round(edge_color(edge), 255, width));
            }
        }
        for (_, step) in places {
            for uv in step.uv {
                canvas.ring(pixel(uv), 8.0, Pen::round([0; 3], 150, 4.0));
                canvas.ring(pixel(uv), 8.0, Pen::round([255; 3], 255, 1.8));
            }
        }
    })?;
    for (number, (_, step)) in (1u32..).zip(places) {
        for uv in step.uv {
            let [x, y] = pixel(uv).map(|value| value.clamp(0.0, f64::from(PANEL)) as u32);
            let text = number.to_string();
            // Beside the ring, on the side with space.
            let room = Sheet::text_width(&text, 1);
            let left =
                if x + 14 + room < size.width { x + 12 } else { x.saturating_sub(12 + room) };
            let top = y.saturating_sub(4);
            for (dx, dy) in [(0, 1), (2, 1), (1, 0), (1, 2)] {
                panel.text(&text, left + dx, top + dy, 1, [0; 3]);
            }
            panel.text(&text, left + 1, top + 1, 1, [255; 3]);
        }
    }
    Ok(panel.into_texture()?)
}

/// The colour of a pixel of a panel, from a few of its texels.
fn reduced(texture: &Texture, panel: Size, x: u32, y: u32) -> Rgb {
    const SAMPLES: u32 = 3;
    let Size { width, height } = texture.size();
    let texel = |pixel: u32, sample: u32, pixels: u32, texels: u32| {
        let at = (f64::from(pixel) + (f64::from(sample) + 0.5) / f64::from(SAMPLES))
            * f64::from(texels)
            / f64::from(pixels);
        (at as u32).min(texels - 1)
    };
    let mut sum = [0u32; 3];
    for row in 0..SAMPLES {
        for column in 0..SAMPLES {
            let (x, y) =
                (texel(x, column, panel.width, width), texel(y, row, panel.height, height));
            let color = shown(texture, x, y);
            (0..3).for_each(|k| sum[k] += u32::from(color[k]));
        }
    }
    sum.map(|value| (value / (SAMPLES * SAMPLES)) as u8)
}

/// One close-up: its caption, its two colours side by side, and three crops.
fn cell(
    picture: &mut Sheet,
    [left, top]: [u32; 2],
    number: u32,
    (edge, step): (&SeamEdge, Step),
    place: &EdgeCrop<'_>,
    surface: &Unfolded<'_>,
) -> anyhow::Result<()> {
    const SWATCH: u32 = 34;
    let mean = edge.mean.unwrap_or(step.delta_e);
    let title = format!("{number} {}, delta E {mean:.1}", kind(edge));
    picture.text(&title, left, top, 2, TITLE);
    let [a, b] = edge.sides.map(|side| side.face);
    let text = format!("triangles {a}, {b}; largest difference {:.1}", step.delta_e);
    picture.text(&Sheet::fitted(&text, CELL.width - 80, 1), left, top + 23, 1, TEXT);
    let colors = step.colors.map(|color| color.map(|value| (value * 255.0 + 0.5) as u8));
    for (color, start) in colors.into_iter().zip([CELL.width - 2 * SWATCH, CELL.width - SWATCH]) {
        for pixel in 0..SWATCH * SWATCH {
            picture.set(left + start + pixel % SWATCH, top + pixel / SWATCH, color);
        }
    }
    let crops = [
        (place.side(0)?, format!("triangle {a}")),
        (place.side(1)?, format!("triangle {b}")),
        (place.unfolded(surface)?, "on the surface".to_owned()),
    ];
    for ((crop, label), start) in crops.into_iter().zip((0..).step_by((CROP + GAP) as usize)) {
        let left = left + start;
        picture.paste(&crop.into_texture()?, left, top + CAPTION);
        picture.text(&label, left, top + CAPTION + CROP + 4, 1, TEXT);
    }
    Ok(())
}
