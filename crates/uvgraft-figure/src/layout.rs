//! Where each part lies in the two textures: the head's own layout and the body's.
//!
//! The two divide the head differently: its own layout has one chart for the skin, cut at the back;
//! the body's has one for the face and one, turned on its side, for the rest.

use uvgraft_avatar::paint::easing::{mix, smoothstep};

use super::head::COLUMNS;
use super::surface::{Kind, Part, Polygon, Side};

/// Which of the two textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layout {
    Head,
    Body,
}

/// A chart's place: left, top, right and bottom, and whether it is turned by 90°.
struct Place {
    rect: [f32; 4],
    turned: bool,
}

const fn place(left: f32, top: f32, right: f32, bottom: f32) -> Place {
    Place { rect: [left, top, right, bottom], turned: false }
}

impl Place {
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
pub(crate) fn corners(layout: Layout, polygon: &Polygon) -> (u32, Vec<[f32; 2]>) {
    let part = polygon.part;
    if part.kind != Kind::Face {
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
        (Layout::Head, _) => {
            let uv = polygon.knots.iter().map(|k| whole.uv(local(k.at, k.at[0]))).collect();
            (0, uv)
        }
        (Layout::Body, true) => {
            let uv =
                polygon.knots.iter().map(|k| face.uv(local(k.at, k.at[0] / FACE_EDGE))).collect();
            (0, uv)
        }
        (Layout::Body, false) => {
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

fn part_number(part: Part) -> u32 {
    let kind = match part.kind {
        Kind::Face => 0,
        Kind::Eye => 1,
        Kind::Ear => 2,
        Kind::Hair => 3,
        Kind::Chest => 4,
        Kind::Shirt => 5,
        Kind::Sleeve => 6,
        Kind::Arm => 7,
        Kind::Leg => 8,
        Kind::Shoe => 9,
        Kind::Finger(number) => 10 + u32::from(number),
    };
    2 + 2 * kind + u32::from(part.side == Side::Right)
}

fn place_of(layout: Layout, part: Part) -> Place {
    let left = part.side == Side::Left;
    match (layout, part.kind, left) {
        (Layout::Head, Kind::Hair, _) => place(0.02, 0.65, 0.355, 0.985),
        (Layout::Head, Kind::Eye, true) => place(0.37, 0.65, 0.53, 0.81),
        (Layout::Head, Kind::Eye, false) => place(0.37, 0.825, 0.53, 0.985),
        (Layout::Head, Kind::Ear, true) => place(0.55, 0.65, 0.755, 0.985),
        (Layout::Head, _, _) => place(0.775, 0.65, 0.98, 0.985),
        (Layout::Body, Kind::Hair, _) => place(0.012, 0.34, 0.17, 0.498).turned(),
        // Both eyes on one disc.
        (Layout::Body, Kind::Eye, _) => place(0.187, 0.34, 0.267, 0.42),
        (Layout::Body, Kind::Ear, true) => place(0.28, 0.34, 0.375, 0.498),
        (Layout::Body, Kind::Ear, false) => place(0.39, 0.34, 0.485, 0.498),
        (Layout::Body, Kind::Chest, _) => place(0.012, 0.51, 0.49, 0.552),
        (Layout::Body, Kind::Shirt, _) => place(0.505, 0.012, 0.988, 0.4),
        (Layout::Body, Kind::Sleeve, true) => place(0.505, 0.412, 0.74, 0.552),
        (Layout::Body, Kind::Sleeve, false) => place(0.753, 0.412, 0.988, 0.552),
        (Layout::Body, Kind::Leg, true) => place(0.012, 0.565, 0.22, 0.988),
        (Layout::Body, Kind::Leg, false) => place(0.235, 0.565, 0.443, 0.988),
        (Layout::Body, Kind::Arm, true) => place(0.46, 0.565, 0.6, 0.988),
        (Layout::Body, Kind::Arm, false) => place(0.615, 0.565, 0.755, 0.988),
        (Layout::Body, Kind::Shoe, true) => place(0.77, 0.775, 0.87, 0.988),
        (Layout::Body, Kind::Shoe, false) => place(0.888, 0.775, 0.988, 0.988),
        (Layout::Body, Kind::Finger(number), _) => {
            let x = 0.77 + 0.0446 * f32::from(number);
            let y = if left { 0.565 } else { 0.67 };
            place(x, y, x + 0.0346, y + 0.09)
        }
        (Layout::Body, Kind::Face, _) => place(0.0, 0.0, 1.0, 1.0),
    }
}
