//! A close-up of the face, and the skin colours of face and body side by side.

use uvgraft::islands::Islands;
use uvgraft::{Anatomy, Area, Mesh, Size, Texture};
use uvgraft_metrics::seams::{SkinColors, ToneMatch};

use super::colors::{UNKNOWN, shown};
use super::style::{TEXT, TITLE};
use super::tone;
use uvgraft_assembly::drawing::{Rgb, Sheet};

/// Maximum height of a panel in pixels.
const TALLEST: u32 = 680;
/// Gap between panels.
const GAP: u32 = 24;
/// Height of the caption over each panel.
const CAPTION: u32 = 16;
const SWATCH: u32 = 64;
/// Height of the caption below the swatches.
const LABEL: u32 = 20;
/// Height of the title and of each line of text.
const HEADING: u32 = 28;
const LINE: u32 = 14;
/// Margin around the face, as a share of its longer side.
const AROUND: f64 = 0.18;
/// Islands smaller than this share of the largest one are ignored: the inside of the lips.
const MIN_ISLAND: f64 = 0.1;

/// The part of a layout with the face, for one texture or two.
pub(super) struct Face<'a> {
    panels: Vec<Panel<'a>>,
    /// Left, top and right, bottom in the unit square.
    uv: [[f64; 2]; 2],
    lines: Vec<String>,
    verdict: Option<String>,
}

struct Panel<'a> {
    name: &'static str,
    texture: &'a Texture,
    skin: Option<SkinColors>,
}

impl<'a> Face<'a> {
    /// Finds the face in the layout; `None` if there is none.
    pub fn new(
        mesh: &Mesh,
        anatomy: &Anatomy,
        texture: &'a Texture,
        base: Option<&'a Texture>,
        tone: &ToneMatch,
    ) -> Option<Self> {
        let mut panels = vec![Panel { name: "the texture", texture, skin: tone.skin }];
        panels.extend(base.map(|texture| Panel { name: "the base", texture, skin: tone.own }));
        let uv = bounds(mesh, anatomy)?;
        // The font of pictures has no Greek.
        let drawn = |text: String| text.replace("ΔE", "delta E");
        let lines = tone::lines(tone).into_iter().map(drawn).collect();
        Some(Self { panels, uv, lines, verdict: tone::verdict(tone).map(drawn) })
    }

    /// The height it takes in a picture.
    ///
    /// - `width`: the width available.
    pub fn height(&self, width: u32) -> u32 {
        self.text_height() + CAPTION + self.panel(width).height + SWATCH + LABEL
    }

    /// Draws it with its top left corner at a position.
    pub fn draw(&self, picture: &mut Sheet, [left, top]: [u32; 2], width: u32) {
        picture.text("face", left, top, 2, TITLE);
        let text = self.lines.iter().map(|line| (line, TEXT));
        let text = text.chain(self.verdict.iter().map(|verdict| (verdict, TITLE)));
        for ((text, color), top) in text.zip((top + HEADING..).step_by(LINE as usize)) {
            picture.text(&Sheet::fitted(text, width, 1), left, top, 1, color);
        }
        let size = self.panel(width);
        let top = top + self.text_height();
        for (panel, left) in self.panels.iter().zip((left..).step_by((size.width + GAP) as usize)) {
            picture.text(&Sheet::fitted(panel.name, size.width, 1), left, top, 1, TEXT);
            let top = top + CAPTION;
            self.crop(picture, panel.texture, [left, top], size);
            swatches(picture, panel.skin, [left, top + size.height], size.width);
        }
    }

    fn text_height(&self) -> u32 {
        HEADING + LINE * (self.lines.len() as u32 + u32::from(self.verdict.is_some())) + GAP / 2
    }

    /// Size of each panel.
    fn panel(&self, width: u32) -> Size {
        let count = self.panels.len() as u32;
        let widest = f64::from((width - (count - 1) * GAP) / count);
        let [right, down] = self.extent(self.panels[0].texture.size());
        let width = widest.min(f64::from(TALLEST) * right / down);
        Size::new(width.max(1.0) as u32, (width * down / right).clamp(1.0, TALLEST.into()) as u32)
    }

    /// Its width and height in texels for a texture of the given size.
    fn extent(&self, size: Size) -> [f64; 2] {
        let [low, high] = self.uv;
        let texels = [size.width, size.height].map(f64::from);
        [0, 1].map(|k| ((high[k] - low[k]) * texels[k]).max(1.0))
    }

    fn crop(&self, picture: &mut Sheet, texture: &Texture, [left, top]: [u32; 2], panel: Size) {
        let size = texture.size();
        let first = [self.uv[0][0] * f64::from(size.width), self.uv[0][1] * f64::from(size.height)];
        let [right, down] = self.extent(size);
        let step = [right / f64::from(panel.width), down / f64::from(panel.height)];
        for y in 0..panel.height {
            for x in 0..panel.width {
                let at = [first[0] + f64::from(x) * step[0], first[1] + f64::from(y) * step[1]];
                picture.set(left + x, top + y, averaged(texture, at, step));
            }
        }
    }
}

/// Cheeks and chest side by side, to show their difference, with labels below.
fn swatches(picture: &mut Sheet, skin: Option<SkinColors>, [left, top]: [u32; 2], width: u32) {
    let (colors, delta_e, below) = match skin {
        Some(skin) => {
            let rgb = |color: [f32; 3]| color.map(|value| (value * 255.0 + 0.5) as u8);
            let delta_e = format!("delta E {:.1}", skin.delta_e());
            ([rgb(skin.cheeks), rgb(skin.chest)], delta_e, tone::chest(skin))
        }
        None => ([UNKNOWN; 2], "unknown".to_owned(), "chest"),
    };
    for x in 0..width {
        let color = colors[usize::from(x >= width / 2)];
        (0..SWATCH).for_each(|y| picture.set(left + x, top + y, color));
    }
    let top = top + SWATCH + 6;
    let room = |text: &str| Sheet::text_width(text, 1);
    picture.text("cheeks", left, top, 1, TEXT);
    picture.text(&delta_e, left + (width - room(&delta_e).min(width)) / 2, top, 1, TITLE);
    picture.text(below, left + width - room(below).min(width), top, 1, TEXT);
}

/// The mean of a texture over the texels that a pixel spans, or interpolated where texels are
/// larger.
fn averaged(texture: &Texture, first: [f64; 2], step: [f64; 2]) -> Rgb {
    const MAX: f64 = 4.0;
    let counts = step.map(|step| step.ceil().clamp(1.0, MAX) as u32);
    let mut sum = [0.0; 3];
    for row in 0..counts[1] {
        for column in 0..counts[0] {
            let at = [0, 1].map(|k| {
                let sample = f64::from([column, row][k]) + 0.5;
                first[k] + step[k] * sample / f64::from(counts[k])
            });
            let color = between(texture, at);
            (0..3).for_each(|k| sum[k] += color[k]);
        }
    }
    sum.map(|sum| (sum / f64::from(counts[0] * counts[1]) + 0.5) as u8)
}

/// The colour of a texture, interpolated between texel centres.
fn between(texture: &Texture, at: [f64; 2]) -> [f64; 3] {
    let size = texture.size();
    let axis = |at: f64, count: u32| {
        let at = (at - 0.5).clamp(0.0, f64::from(count - 1));
        let low = at as u32;
        ([low, (low + 1).min(count - 1)], at - f64::from(low))
    };
    let ([left, right], across) = axis(at[0], size.width);
    let ([top, bottom], down) = axis(at[1], size.height);
    let mix =
        |a: [f64; 3], b: [f64; 3], share: f64| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * share);
    let texel = |x: u32, y: u32| shown(texture, x, y).map(f64::from);
    let row = |y: u32| mix(texel(left, y), texel(right, y), across);
    mix(row(top), row(bottom), down)
}

/// The bounds of cheeks, nose, lips and eyes in the layout, with a margin.
fn bounds(mesh: &Mesh, anatomy: &Anatomy) -> Option<[[f64; 2]; 2]> {
    let areas = [Area::Cheeks, Area::Nose, Area::Lips, Area::EyeSockets].map(|it| anatomy.area(it));
    let is_face = |&face: &usize| {
        let weight = |vertex: u32| areas.iter().map(|area| area[vertex as usize]).sum::<f32>();
        !mesh.is_outside(face) && mesh.faces()[face].iter().all(|&vertex| weight(vertex) >= 0.5)
    };
    let faces: Vec<usize> = (0..mesh.faces().len()).filter(is_face).collect();
    let islands = Islands::new(mesh);
    let mut extents = vec![0.0; islands.count()];
    for &face in &faces {
        extents[islands.of_faces()[face] as usize] += extent_uv(mesh, face);
    }
    let largest = extents.iter().copied().fold(0.0, f64::max);
    let is_shown = |&&face: &&usize| {
        extents[islands.of_faces()[face] as usize] >= (MIN_ISLAND * largest).max(f64::MIN_POSITIVE)
    };
    let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for uv in faces.iter().filter(is_shown).flat_map(|&face| mesh.uv_triangle(face)) {
        for k in 0..2 {
            bounds[0][k] = bounds[0][k].min(f64::from(uv[k]));
            bounds[1][k] = bounds[1][k].max(f64::from(uv[k]));
        }
    }
    let [low, high] = bounds;
    let around = AROUND * (high[0] - low[0]).max(high[1] - low[1]);
    let is_any = around.is_finite() && around > 0.0;
    is_any.then(|| {
        [low.map(|at| (at - around).clamp(0.0, 1.0)), high.map(|at| (at + around).clamp(0.0, 1.0))]
    })
}

/// A triangle's area in the layout.
fn extent_uv(mesh: &Mesh, face: usize) -> f64 {
    let [a, b, c] = mesh.uv_triangle(face).map(|uv| uv.map(f64::from));
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}
