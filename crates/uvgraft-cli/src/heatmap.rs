//! Heatmaps of the differences between two textures.
//!
//! The error of a texel is the largest difference among its three channels, so that no channel is
//! hidden by two that agree. Large textures are reduced by the maximum of each block, so that a
//! single wrong texel stays visible.

use std::path::Path;

use uvgraft::Size;
use uvgraft::statistics::quantile;
use uvgraft_metrics::{Colors, Mask};

use crate::scores::ScoredRegion;
use uvgraft_assembly::drawing::{Rgb, Sheet};

/// Longest side of the panel in pixels; larger textures are reduced.
const LONGEST: u32 = 2048;
/// Smaller panels are enlarged by an integer factor, up to this size.
const ENLARGED: u32 = 1024;
const MARGIN: u32 = 24;
/// Minimum width, to fit the captions.
const MIN_WIDTH: u32 = 760;

const BACKGROUND: Rgb = [38, 40, 45];
const OUTSIDE: Rgb = [70, 73, 80];
const TITLE: Rgb = [236, 238, 242];
const CAPTION: Rgb = [176, 182, 192];

/// The colour map from zero to the top of the scale: both hue and lightness are ordered, so that it
/// survives greyscale print and colour blindness.
const ANCHORS: [(f32, Rgb); 7] = [
    (0.0, [8, 8, 16]),
    (0.14, [42, 24, 92]),
    (0.34, [116, 30, 128]),
    (0.54, [196, 54, 96]),
    (0.74, [240, 118, 48]),
    (0.9, [250, 204, 84]),
    (1.0, [255, 250, 222]),
];

/// Draws the differences of two textures of the same size within the regions, and writes the
/// picture.
pub(crate) fn write(
    a: &Colors,
    b: &Colors,
    regions: &[ScoredRegion],
    title: &str,
    path: &Path,
) -> anyhow::Result<()> {
    let errors = Errors::new(a, b, regions);
    Ok(errors.draw(title, errors.top()).write(path)?)
}

/// Errors in levels of 255, reduced to the size shown.
pub(crate) struct Errors {
    of: Size,
    size: Size,
    /// Texels a side covered by one value.
    block: u32,
    /// Row by row; `None` outside the regions.
    shown: Vec<Option<f32>>,
    mean: f64,
    largest: f32,
}

impl Errors {
    pub(crate) fn new(a: &Colors, b: &Colors, regions: &[ScoredRegion]) -> Self {
        let of = a.size();
        let block = of.width.max(of.height).div_ceil(LONGEST);
        let size = Size::new(of.width.div_ceil(block), of.height.div_ceil(block));
        let masks: Option<Vec<&Mask>> = regions.iter().map(|region| region.mask.as_ref()).collect();
        let counts = |index: usize| {
            masks.as_ref().is_none_or(|masks| masks.iter().any(|mask| mask.selected()[index]))
        };
        let mut shown = vec![None; size.texels()];
        let (mut sum, mut count, mut largest) = (0.0, 0usize, 0.0f32);
        let width = of.width as usize;
        for y in 0..of.height as usize {
            let row = y * width..(y + 1) * width;
            let [a, b] = [a, b].map(|colors| colors.values(row.clone()));
            let texels = a.chunks_exact(3).zip(b.chunks_exact(3)).zip(row);
            for (x, ((a, b), _)) in texels.enumerate().filter(|(_, (_, index))| counts(*index)) {
                let error = (0..3).map(|k| (a[k] - b[k]).abs() * 255.0).fold(0.0, f32::max);
                let at = y / block as usize * size.width as usize + x / block as usize;
                shown[at] = Some(error.max(shown[at].unwrap_or(0.0)));
                sum += f64::from(error);
                count += 1;
                largest = largest.max(error);
            }
        }
        Self { of, size, block, shown, mean: sum / count.max(1) as f64, largest }
    }

    /// The top of the scale: the 99.5th percentile of the values shown, rounded up to a round
    /// number, so that few extremes do not leave the rest dark. If fewer texels differ, the maximum
    /// is used.
    pub(crate) fn top(&self) -> f32 {
        let percentile = quantile(self.shown.iter().copied().flatten(), 0.995).unwrap_or(0.0);
        let wanted = if percentile > 0.0 { percentile } else { self.largest };
        nice(wanted)
    }

    /// Draws the title, what is shown, the scale up to `top`, and the panel.
    pub(crate) fn draw(&self, title: &str, top: f32) -> Sheet {
        let Size { width, height } = self.size;
        let zoom = (ENLARGED / width.max(height)).max(1);
        let (panel_width, panel_height) = (width * zoom, height * zoom);
        let content = panel_width.max(MIN_WIDTH);
        // Readable even when a large picture is shrunk to fit a window.
        let scale = if content > 1200 { 2 } else { 1 };
        let line = 14 * scale;
        let bar_height = 14 * scale;
        let title_height = 27 * scale;
        let head = MARGIN + title_height + 3 * line + 8 * scale + bar_height + 2 * line;
        let size = Size::new(content + 2 * MARGIN, head + panel_height + MARGIN);
        let mut picture = Sheet::new(size, BACKGROUND);

        let mut y = MARGIN;
        picture.text(&Sheet::fitted(title, content, 2 * scale), MARGIN, y, 2 * scale, TITLE);
        y += title_height;
        for text in captions(self, top) {
            picture.text(&Sheet::fitted(&text, content, scale), MARGIN, y, scale, CAPTION);
            y += line;
        }
        y += 4 * scale;
        draw_scale(
            &mut picture,
            [MARGIN, y],
            [content.min(720 * scale), bar_height],
            scale,
            top,
            self,
        );

        for py in 0..panel_height {
            for px in 0..panel_width {
                let at = (py / zoom) as usize * width as usize + (px / zoom) as usize;
                let color = self.shown[at].map_or(OUTSIDE, |error| color_of(error / top));
                picture.set(MARGIN + px, head + py, color);
            }
        }
        picture
    }
}

/// The least number not below `levels` with a single non-zero digit, from 0.001 to 200, then 255,
/// then 255 times powers of ten. Identical pictures get 1.
fn nice(levels: f32) -> f32 {
    if levels <= 0.0 {
        return 1.0;
    }
    if levels > 200.0 {
        let mut top = 255.0;
        // Rounding may have put white against black slightly above 255.
        while levels > top * 1.0001 {
            top *= 10.0;
        }
        return top;
    }
    (-3..3)
        .flat_map(|power| {
            [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0].map(|digit: f32| digit * 10f32.powi(power))
        })
        .find(|&step| step <= 200.0 && step * 1.0001 >= levels)
        .unwrap_or(255.0)
}

/// The colour of an error, 1.0 being the scale's top.
fn color_of(error: f32) -> Rgb {
    let error = error.clamp(0.0, 1.0);
    let upper = ANCHORS.iter().position(|(at, _)| *at >= error).unwrap_or(ANCHORS.len() - 1).max(1);
    let ((low, from), (high, to)) = (ANCHORS[upper - 1], ANCHORS[upper]);
    let share = (error - low) / (high - low);
    std::array::from_fn(|k| {
        let [from, to] = [from, to].map(|color| f32::from(color[k]));
        (from + (to - from) * share + 0.5) as u8
    })
}

fn captions(errors: &Errors, top: f32) -> [String; 3] {
    let block = errors.block;
    let reduced = match block {
        1 => "each texel".to_owned(),
        _ => format!("the largest of each block of {block}×{block} texels"),
    };
    let outside = if errors.shown.contains(&None) { "; grey: outside the mask" } else { "" };
    [
        format!("{} texels; error: largest difference of R, G and B, in levels of 255", errors.of),
        format!("mean {}, largest {}", levels(errors.mean as f32), levels(errors.largest)),
        format!("shown: {reduced}, up to {}{outside}", levels(top)),
    ]
}

/// The colour bar with numbers below it.
fn draw_scale(
    picture: &mut Sheet,
    [left, y]: [u32; 2],
    [width, height]: [u32; 2],
    scale: u32,
    top: f32,
    errors: &Errors,
) {
    for x in 0..width {
        let color = color_of(x as f32 / (width - 1) as f32);
        (0..height).for_each(|row| picture.set(left + x, y + row, color));
    }
    for step in 0..=4 {
        let share = step as f32 / 4.0;
        let above = if step == 4 && errors.largest > top * 1.001 { " and more" } else { "" };
        let text = levels(top * share) + above;
        let at = left + (share * (width - 1) as f32) as u32;
        let text_width = Sheet::text_width(&text, scale);
        let start = match step {
            0 => left,
            4 => left + width - text_width,
            _ => at - text_width / 2,
        };
        (0..4 * scale).for_each(|row| picture.set(at, y + height + row, CAPTION));
        picture.text(&text, start, y + height + 6 * scale, scale, CAPTION);
    }
}

/// A number of levels with its significant digits.
fn levels(value: f32) -> String {
    let decimals = match value {
        0.0 => 0,
        v if v < 0.01 => 5,
        v if v < 1.0 => 3,
        v if v < 100.0 => 2,
        _ => 1,
    };
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_grow_lighter() {
        let lightness = |error: f32| {
            let [r, g, b] =
                color_of(error).map(|value| f32::from(value) / 255.0).map(|v| v.powf(2.2));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for step in 0..64 {
            let (low, high) = (step as f32 / 64.0, (step + 1) as f32 / 64.0);
            assert!(lightness(low) < lightness(high), "{low}");
        }
        assert_eq!(color_of(0.0), ANCHORS[0].1);
        assert_eq!(color_of(7.0), ANCHORS[6].1);
        assert_eq!(color_of(0.14), ANCHORS[1].1);
    }

    #[test]
    fn tops_are_round() {
        let cases: &[(f32, f32)] = &[
            (0.0, 1.0),
            (0.0035, 0.004),
            (0.9, 1.0),
            (1.000_01, 1.0),
            (3.0, 3.0),
            (61.0, 80.0),
            (199.0, 200.0),
            (101.0, 200.0),
            (201.0, 255.0),
            (255.000_02, 255.0),
            (300.0, 2550.0),
        ];
        for (found, wanted) in cases {
            assert!((nice(*found) - wanted).abs() < wanted * 1e-5, "{found}: {}", nice(*found));
        }
        assert_eq!(["0", "0.05", "12.75", "200"], [0.0, 0.05, 12.75, 200.0].map(levels));
    }
}
