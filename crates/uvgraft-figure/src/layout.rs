//! The charts of each part in the two textures: the head's UV layout and the body's.
//!
//! They divide the head differently: the head's layout has one chart for the skin, cut at the back;
//! the body's has one for the face and a rotated one for the rest.

use uvgraft::easing::{mix, smoothstep};

use super::head::COLUMNS;
use super::surface::{BodyPart, PartKind, Polygon, Side};

/// One of the two UV layouts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum UvLayout {
    Head,
    Body,
}

/// The rectangle of a chart (left, top, right, bottom), and whether the chart is rotated by 90°.
struct ChartRect {
    rect: [f32; 4],
    rotated: bool,
}

const fn rect(left: f32, top: f32, right: f32, bottom: f32) -> ChartRect {
    ChartRect { rect: [left, top, right, bottom], rotated: false }
}

impl ChartRect {
    const fn rotated(self) -> Self {
        Self { rotated: true, ..self }
    }

    fn uv(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [x, y] = if self.rotated { [1.0 - y, x] } else { [x, y] };
        let [left, top, right, bottom] = self.rect;
        [mix(left, right, x), mix(top, bottom, y)]
    }
}

/// Columns of the body layout's face chart on either side of its centre.
const FACE_COLUMNS: f32 = 20.0;
const FACE_EDGE: f32 = FACE_COLUMNS / (COLUMNS as f32 / 2.0);

/// The texture coordinates of a polygon's corners, and an index that identifies its chart.
pub(crate) fn corners(layout: UvLayout, polygon: &Polygon) -> (u32, Vec<[f32; 2]>) {
    let part = polygon.part;
    if part.kind != PartKind::Face {
        let rect = self::rect_of(layout, part);
        return (part_number(part), polygon.knots.iter().map(|knot| rect.uv(knot.at)).collect());
    }
    let front = polygon.knots.iter().all(|knot| knot.at[0].abs() < FACE_EDGE + 1e-4);
    let mean: f32 = polygon.knots.iter().map(|knot| knot.at[0]).sum();
    let local = |at: [f32; 2], unrolled: f32| [0.5 + 0.5 * unrolled * narrowing(at[1]), at[1]];
    let whole = rect(0.02, 0.02, 0.98, 0.635);
    let face = rect(0.012, 0.012, 0.30, 0.325);
    let back = rect(0.315, 0.012, 0.49, 0.325).rotated();
    match (layout, front) {
        (UvLayout::Head, _) => {
            let uv = polygon.knots.iter().map(|k| whole.uv(local(k.at, k.at[0]))).collect();
            (0, uv)
        }
        (UvLayout::Body, true) => {
            let uv =
                polygon.knots.iter().map(|k| face.uv(local(k.at, k.at[0] / FACE_EDGE))).collect();
            (0, uv)
        }
        (UvLayout::Body, false) => {
            // Joined at the back, where the head's layout is cut.
            let shift = if mean > 0.0 { -1.0 } else { 1.0 };
            let uv = polygon
                .knots
                .iter()
                .map(|k| back.uv(local(k.at, (k.at[0] + shift) / (1.0 - FACE_EDGE))))
                .collect();
            (1, uv)
        }
    }
}

/// Charts narrow towards crown and neck, as the head does.
fn narrowing(t: f32) -> f32 {
    mix(0.3, 1.0, smoothstep(-0.05, 0.36, t)) * mix(1.0, 0.8, smoothstep(0.78, 1.0, t))
}

fn part_number(part: BodyPart) -> u32 {
    let kind = match part.kind {
        PartKind::Face => 0,
        PartKind::Eye => 1,
        PartKind::Ear => 2,
        PartKind::Hair => 3,
        PartKind::Chest => 4,
        PartKind::Shirt => 5,
        PartKind::Sleeve => 6,
        PartKind::Arm => 7,
        PartKind::Leg => 8,
        PartKind::Shoe => 9,
        PartKind::Finger(number) => 10 + u32::from(number),
    };
    2 + 2 * kind + u32::from(part.side == Side::Right)
}

fn rect_of(layout: UvLayout, part: BodyPart) -> ChartRect {
    let left = part.side == Side::Left;
    match (layout, part.kind, left) {
        (UvLayout::Head, PartKind::Hair, _) => rect(0.02, 0.65, 0.355, 0.985),
        (UvLayout::Head, PartKind::Eye, true) => rect(0.37, 0.65, 0.53, 0.81),
        (UvLayout::Head, PartKind::Eye, false) => rect(0.37, 0.825, 0.53, 0.985),
        (UvLayout::Head, PartKind::Ear, true) => rect(0.55, 0.65, 0.755, 0.985),
        (UvLayout::Head, _, _) => rect(0.775, 0.65, 0.98, 0.985),
        (UvLayout::Body, PartKind::Hair, _) => rect(0.012, 0.34, 0.17, 0.498).rotated(),
        // Both eyes share one disc.
        (UvLayout::Body, PartKind::Eye, _) => rect(0.187, 0.34, 0.267, 0.42),
        (UvLayout::Body, PartKind::Ear, true) => rect(0.28, 0.34, 0.375, 0.498),
        (UvLayout::Body, PartKind::Ear, false) => rect(0.39, 0.34, 0.485, 0.498),
        (UvLayout::Body, PartKind::Chest, _) => rect(0.012, 0.51, 0.49, 0.552),
        (UvLayout::Body, PartKind::Shirt, _) => rect(0.505, 0.012, 0.988, 0.4),
        (UvLayout::Body, PartKind::Sleeve, true) => rect(0.505, 0.412, 0.74, 0.552),
        (UvLayout::Body, PartKind::Sleeve, false) => rect(0.753, 0.412, 0.988, 0.552),
        (UvLayout::Body, PartKind::Leg, true) => rect(0.012, 0.565, 0.22, 0.988),
        (UvLayout::Body, PartKind::Leg, false) => rect(0.235, 0.565, 0.443, 0.988),
        (UvLayout::Body, PartKind::Arm, true) => rect(0.46, 0.565, 0.6, 0.988),
        (UvLayout::Body, PartKind::Arm, false) => rect(0.615, 0.565, 0.755, 0.988),
        (UvLayout::Body, PartKind::Shoe, true) => rect(0.77, 0.775, 0.87, 0.988),
        (UvLayout::Body, PartKind::Shoe, false) => rect(0.888, 0.775, 0.988, 0.988),
        (UvLayout::Body, PartKind::Finger(number), _) => {
            let x = 0.77 + 0.0446 * f32::from(number);
            let y = if left { 0.565 } else { 0.67 };
            rect(x, y, x + 0.0346, y + 0.09)
        }
        (UvLayout::Body, PartKind::Face, _) => rect(0.0, 0.0, 1.0, 1.0),
    }
}
