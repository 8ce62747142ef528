//! Lines and circles over a picture: the only code that calls the rasteriser.
//!
//! UV coordinates and projected points may lie anywhere, but `tiny-skia` panics on lines far outside
//! its canvas. Lines are therefore clipped first, to a rectangle somewhat larger than the canvas, so
//! that ends and joins of what is cut off do not show.

use tiny_skia::{Color, FillRule, LineCap, Paint, Path, PathBuilder, PixmapMut, Stroke, Transform};
use uvgraft::Size;

use super::sheet::Rgb;

/// Beyond the canvas, in pixels: wider than any line.
const MARGIN: f64 = 64.0;

/// A canvas of pixels to draw on.
pub struct Canvas<'a> {
    pixmap: PixmapMut<'a>,
}

/// How lines are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Pen {
    color: Rgb,
    opacity: u8,
    width: f32,
    line_cap: LineCap,
}

/// Lines to be drawn at once: where they cross, they do not cover each other twice.
pub struct Lines {
    path: PathBuilder,
    /// The highest coordinates that lines may have; the lowest are `-MARGIN`.
    limit: [f64; 2],
}

impl Pen {
    /// Lines that end at their end points.
    ///
    /// - `opacity`: from 0 (invisible) to 255.
    /// - `width`: in pixels.
    pub fn flat(color: Rgb, opacity: u8, width: f32) -> Self {
        Self { color, opacity, width, line_cap: LineCap::Butt }
    }

    /// As [`Pen::flat`], but lines end in half circles around their end points.
    pub fn round(color: Rgb, opacity: u8, width: f32) -> Self {
        Self { line_cap: LineCap::Round, ..Self::flat(color, opacity, width) }
    }
}

impl<'a> Canvas<'a> {
    /// A canvas of RGBA pixels; `None` if they are not as many as the size says.
    pub fn new(rgba: &'a mut [u8], size: Size) -> Option<Self> {
        let pixmap = PixmapMut::from_bytes(rgba, size.width, size.height)?;
        Some(Self { pixmap })
    }

    /// No lines yet.
    pub fn lines(&self) -> Lines {
        let size = [self.pixmap.width(), self.pixmap.height()];
        let limit = size.map(|side| f64::from(side) + MARGIN);
        Lines { path: PathBuilder::new(), limit }
    }

    /// Draws lines.
    pub fn draw(&mut self, lines: Lines, pen: Pen) {
        self.stroke(lines.path.finish(), pen);
    }

    /// Draws a line.
    pub fn line(&mut self, ends: [[f64; 2]; 2], pen: Pen) {
        let mut lines = self.lines();
        lines.add(ends);
        self.draw(lines, pen);
    }

    /// Draws a circle around a position.
    pub fn ring(&mut self, center: [f64; 2], radius: f32, pen: Pen) {
        if self.is_near(center) {
            let [x, y] = center.map(|value| value as f32);
            self.stroke(PathBuilder::from_circle(x, y, radius), pen);
        }
    }

    /// Fills small circles around positions.
    pub fn dots(
        &mut self,
        centers: impl IntoIterator<Item = [f64; 2]>,
        radius: f32,
        color: Rgb,
        opacity: u8,
    ) {
        let mut path = PathBuilder::new();
        for center in centers {
            if self.is_near(center) {
                let [x, y] = center.map(|value| value as f32);
                path.push_circle(x, y, radius);
            }
        }
        if let Some(path) = path.finish() {
            let paint = paint(color, opacity);
            self.pixmap.fill_path(&path, &paint, FillRule::Winding, Transform::identity(), None);
        }
    }

    /// Whether a small circle around a position may be seen; never for NaN.
    fn is_near(&self, position: [f64; 2]) -> bool {
        let Lines { limit, .. } = self.lines();
        (0..2).all(|k| (-MARGIN..=limit[k]).contains(&position[k]))
    }

    fn stroke(&mut self, path: Option<Path>, pen: Pen) {
        let Pen { width, line_cap, .. } = pen;
        let stroke = Stroke { width, line_cap, ..Stroke::default() };
        if let Some(path) = path {
            let paint = paint(pen.color, pen.opacity);
            self.pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
        }
    }
}

impl Lines {
    /// Adds a line.
    pub fn add(&mut self, ends: [[f64; 2]; 2]) {
        if let Some([from, to]) = clipped(ends, self.limit) {
            self.path.move_to(from[0] as f32, from[1] as f32);
            self.path.line_to(to[0] as f32, to[1] as f32);
        }
    }

    /// Adds the outline of a triangle.
    pub fn add_triangle(&mut self, corners: [[f64; 2]; 3]) {
        let [a, b, c] = corners;
        let sides = [[a, b], [b, c], [c, a]];
        if sides.iter().all(|&side| clipped(side, self.limit) == Some(side)) {
            // In one piece, so that its sides are joined.
            self.path.move_to(a[0] as f32, a[1] as f32);
            self.path.line_to(b[0] as f32, b[1] as f32);
            self.path.line_to(c[0] as f32, c[1] as f32);
            self.path.close();
        } else {
            sides.into_iter().for_each(|side| self.add(side));
        }
    }
}

fn paint(color: Rgb, opacity: u8) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    let [red, green, blue] = color;
    paint.set_color(Color::from_rgba8(red, green, blue, opacity));
    paint
}

/// The part of a line within `-MARGIN..=limit`, if there is any; none of lines with NaN.
///
/// Cut at one side of the rectangle after the other, where the cut end gets exactly the side's
/// coordinate, however far away the other end is.
fn clipped(mut ends: [[f64; 2]; 2], limit: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    if !ends.iter().flatten().all(|value| value.is_finite()) {
        return None;
    }
    for k in 0..2 {
        for (side, sign) in [(-MARGIN, 1.0), (limit[k], -1.0)] {
            let is_inside = ends.map(|end| (end[k] - side) * sign >= 0.0);
            // From the end inside, whose coordinates are small and exact.
            let cut = |inside: [f64; 2], outside: [f64; 2]| {
                let share = (side - inside[k]) / (outside[k] - inside[k]);
                let mut at = [side; 2];
                at[1 - k] = inside[1 - k] + (outside[1 - k] - inside[1 - k]) * share;
                at
            };
            match is_inside {
                [true, true] => {}
                [true, false] => ends[1] = cut(ends[0], ends[1]),
                [false, true] => ends[0] = cut(ends[1], ends[0]),
                [false, false] => return None,
            }
        }
    }
    Some(ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: [f64; 2] = [100.0, 100.0];
    const PEN: Pen = Pen { color: [255; 3], opacity: 255, width: 2.0, line_cap: LineCap::Butt };

    fn drawn(draw: impl FnOnce(&mut Canvas<'_>)) -> Vec<u8> {
        let mut rgba = vec![0; 36 * 36 * 4];
        draw(&mut Canvas::new(&mut rgba, Size::square(36)).unwrap());
        rgba
    }

    #[test]
    fn lines_are_clipped_on_every_side() {
        let inside = [[1.0, 2.0], [3.0, 4.0]];
        assert_eq!(clipped(inside, LIMIT), Some(inside));
        let across = [[-1000.0, 50.0], [1000.0, 50.0]];
        assert_eq!(clipped(across, LIMIT), Some([[-MARGIN, 50.0], [100.0, 50.0]]));
        let diagonal = clipped([[1e30, 1e30], [0.0, 0.0]], LIMIT).unwrap();
        assert!(diagonal[0].iter().all(|value| (value - 100.0).abs() < 1e-9), "{diagonal:?}");
        assert_eq!(clipped([[200.0, 0.0], [200.0, 50.0]], LIMIT), None);
        assert_eq!(clipped([[-300.0, 0.0], [0.0, 300.0]], LIMIT), None);
        assert_eq!(clipped([[f64::NAN, 0.0], [0.0, 0.0]], LIMIT), None);
        assert_eq!(clipped([[f64::INFINITY, 0.0], [0.0, 0.0]], LIMIT), None);
    }

    #[test]
    fn what_lies_far_outside_is_drawn_as_far_as_it_is_seen() {
        // The part inside is the same as of a short line.
        let far = drawn(|canvas| canvas.line([[-3e38, 18.0], [3e38, 18.0]], PEN));
        assert_eq!(far, drawn(|canvas| canvas.line([[-50.0, 18.0], [90.0, 18.0]], PEN)));
        assert!(far.iter().any(|&value| value > 0));
        // Nothing of these is seen, and nothing panics.
        let none = drawn(|canvas| {
            for at in [1e9, -1e9, 3e38, f64::NAN, f64::NEG_INFINITY] {
                canvas.ring([at, 8.0], 3.0, PEN);
                canvas.dots([[at, at]], 2.0, [255; 3], 255);
                canvas.line([[at, 0.0], [at, 36.0]], PEN);
            }
        });
        assert!(none.iter().all(|&value| value == 0));
        let triangle = drawn(|canvas| {
            let mut lines = canvas.lines();
            lines.add_triangle([[5.0, 5.0], [1e30, 5.0], [5.0, -1e30]]);
            canvas.draw(lines, PEN);
        });
        assert!(triangle.iter().any(|&value| value > 0));
    }
}
