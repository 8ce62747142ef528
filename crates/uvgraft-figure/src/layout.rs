//! Where each part lies in the two textures: the head's own layout and the body's.
//!
//! The two divide the head differently: its own layout has one chart for the skin, cut at the back;
//! the body's has one for the face and one, turned on its side, for the rest.

use uvgraft::easing::{mix, smoothstep};

use super::head::COLUMNS;
use super::surface::{BodyPart, PartKind, Polygon, Side};

/// Which of the two textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum UvLayout {
    Head,
    Body,
}

/// A chart's place: left, top, right and bottom, and whether it is turned by 90°.
struct ChartPlace {
    rect: [f32; 4],
    turned: bool,
}

const fn place(left: f32, top: f32, right: f32, bottom: f32) -> ChartPlace {
    ChartPlace { rect: [left, top, right, bottom], turned: false }
}

impl ChartPlace {
    const fn turned(self) -> Self {
        Self { turned: true, ..self }
    }

    fn uv(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [x, y] = if self.turned { [1.0 - y, x] } else { [x, y] };
        let [left, top, right, bottom] = self.rect;
        [mix(left, right, x), mix(top, bottom, y)]
    }
}

/// Columns on either side of the middle that the body layout's face chart has.
const FACE_COLUMNS: f32 = 20.0;
const FACE_EDGE: f32 = FACE_COLUMNS / (COLUMNS as f32 / 2.0);

/// The texture coordinates of a polygon's corners, and a number that tells charts apart.
pub(crate) fn corners(layout: UvLayout, polygon: &Polygon) -> (u32, Vec<[f32; 2]>) {
    let part = polygon.part;
    if part.kind != PartKind::Face {
        let place = self::place_of(layout, part);
        return (part_number(part), polygon.knots.iter().map(|knot| place.uv(knot.at)).collect());
    }
    let front = polygon.knots.iter().all(|knot| knot.at[0].abs() < FACE_EDGE + 1e-4);
    let mean: f32 = polygon.knots.iter().map(|knot| knot.at[0]).sum();
    let local = |at: [f32; 2], unrolled: f32| [0.5 + 0.5 * unrolled * narrowing(at[1]), at[1]];
    let whole = place(0.02, 0.02, 0.98, 0.635);
    let face = place(0.012, 0.012, 0.30, 0.325);
    let back = place(0.315, 0.012, 0.49, 0.325).turned();
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
            // Joined at the back, where the other layout is cut.
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

/// Charts get narrower towards crown and neck, as the head does.
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

fn place_of(layout: UvLayout, part: BodyPart) -> ChartPlace {
    let left = part.side == Side::Left;
    match (layout, part.kind, left) {
        (UvLayout::Head, PartKind::Hair, _) => place(0.02, 0.65, 0.355, 0.985),
        (UvLayout::Head, PartKind::Eye, true) => place(0.37, 0.65, 0.53, 0.81),
        (UvLayout::Head, PartKind::Eye, false) => place(0.37, 0.825, 0.53, 0.985),
        (UvLayout::Head, PartKind::Ear, true) => place(0.55, 0.65, 0.755, 0.985),
        (UvLayout::Head, _, _) => place(0.775, 0.65, 0.98, 0.985),
        (UvLayout::Body, PartKind::Hair, _) => place(0.012, 0.34, 0.17, 0.498).turned(),
        // Both eyes on one disc.
        (UvLayout::Body, PartKind::Eye, _) => place(0.187, 0.34, 0.267, 0.42),
        (UvLayout::Body, PartKind::Ear, true) => place(0.28, 0.34, 0.375, 0.498),
        (UvLayout::Body, PartKind::Ear, false) => place(0.39, 0.34, 0.485, 0.498),
        (UvLayout::Body, PartKind::Chest, _) => place(0.012, 0.51, 0.49, 0.552),
        (UvLayout::Body, PartKind::Shirt, _) => place(0.505, 0.012, 0.988, 0.4),
        (UvLayout::Body, PartKind::Sleeve, true) => place(0.505, 0.412, 0.74, 0.552),
        (UvLayout::Body, PartKind::Sleeve, false) => place(0.753, 0.412, 0.988, 0.552),
        (UvLayout::Body, PartKind::Leg, true) => place(0.012, 0.565, 0.22, 0.988),
        (UvLayout::Body, PartKind::Leg, false) => place(0.235, 0.565, 0.443, 0.988),
        (UvLayout::Body, PartKind::Arm, true) => place(0.46, 0.565, 0.6, 0.988),
        (UvLayout::Body, PartKind::Arm, false) => place(0.615, 0.565, 0.755, 0.988),
        (UvLayout::Body, PartKind::Shoe, true) => place(0.77, 0.775, 0.87, 0.988),
        (UvLayout::Body, PartKind::Shoe, false) => place(0.888, 0.775, 0.988, 0.988),
        (UvLayout::Body, PartKind::Finger(number), _) => {
            let x = 0.77 + 0.0446 * f32::from(number);
            let y = if left { 0.565 } else { 0.67 };
            place(x, y, x + 0.0346, y + 0.09)
        }
        (UvLayout::Body, PartKind::Face, _) => place(0.0, 0.0, 1.0, 1.0),
    }
}
