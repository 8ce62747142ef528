//! Areas as functions of position, normal and component in the head's coordinates.
//!
//! Each weight is a product of soft steps. Bounds are relative to landmarks and otherwise fixed, in
//! distances between the eyes.

use glam::DVec3;

use super::Area;
use super::body;
use super::landmarks::Face;
use super::points::Points;
use super::relief::Relief;
use crate::easing::smoothstep_f64;

/// 1 between two bounds, falling to 0 within `soft` outside them.
fn band(low: f64, high: f64, soft: f64, value: f64) -> f64 {
    smoothstep_f64(low - soft, low, value) * smoothstep_f64(high + soft, high, value)
}

/// 1 within an axis-aligned ellipse, falling to 0 at `outer` times its size.
fn ellipse([x, y]: [f64; 2], [rx, ry]: [f64; 2], outer: f64) -> f64 {
    smoothstep_f64(outer, 1.0, (x / rx).hypot(y / ry))
}

pub(super) struct Areas<'a> {
    pub points: &'a Points,
    pub face: &'a Face,
    pub relief: &'a Relief,
}

/// The properties of a point that areas depend on.
struct Point {
    at: DVec3,
    /// Distance from the plane of symmetry.
    x: f64,
    y: f64,
    z: f64,
    normal: DVec3,
    /// Depth behind the foremost surface at its position.
    behind: f64,
    is_skin: bool,
    is_eye: bool,
    may_be_ear: bool,
}

impl Areas<'_> {
    /// Each point's weights for all areas, in the order of [`Area`].
    pub fn all(&self) -> Vec<Vec<f32>> {
        let count = self.points.positions.len();
        let mut areas = vec![vec![0.0_f32; count]; Area::ALL.len()];
        for index in 0..count {
            let point = self.point(index);
            if point.at.abs().cmplt(DVec3::splat(6.0)).all() {
                for (area, value) in self.head(&point) {
                    areas[area as usize][index] = value.clamp(0.0, 1.0) as f32;
                }
            }
        }
        let [hands, feet] = body::extremities(self.face);
        areas[Area::Hands as usize] = hands;
        areas[Area::Feet as usize] = feet;
        areas
    }

    fn point(&self, index: usize) -> Point {
        let at = self.face.local.positions[index];
        let component = self.points.component[index];
        let foremost = self.relief.around(at.x, at.y).unwrap_or(f64::NEG_INFINITY);
        Point {
            at,
            x: at.x.abs(),
            y: at.y,
            z: at.z,
            normal: self.face.local.normals[index],
            behind: foremost - at.z,
            is_skin: component == self.face.eyes.skin,
            is_eye: self.face.eyes.components[component as usize],
            may_be_ear: self.face.may_be_ear[component as usize],
        }
    }

    fn head(&self, point: &Point) -> [(Area, f64); 13] {
        let eyes = self.eyes(point);
        let interior = self.mouth_interior(point) * (1.0 - eyes);
        let ears = self.ears(point) * (1.0 - eyes);
        // The outer surface, without the inside of lids and lips.
        let skin = (1.0 - eyes) * (1.0 - interior) * (1.0 - ears);
        let skin = if point.is_eye { 0.0 } else { skin };
        let seen = skin * smoothstep_f64(0.25, 0.1, point.behind);
        let lips = self.lips(point) * seen;
        let face = seen * if point.is_skin { 1.0 } else { 0.0 };
        let sockets = self.sockets(point) * face;
        let neck = self.neck(point) * skin;
        [
            (Area::Cheeks, self.cheeks(point) * face * (1.0 - sockets) * (1.0 - lips)),
            (Area::Forehead, self.forehead(point) * face),
            (Area::Nose, self.nose(point) * face),
            (Area::Jaw, self.jaw(point) * skin * (1.0 - lips)),
            (Area::Lips, lips),
            (Area::MouthInterior, interior),
            (Area::Eyes, eyes),
            (Area::EyeSockets, sockets),
            (Area::Brows, self.brows(point) * seen),
            (Area::Ears, ears),
            (Area::Scalp, self.scalp(point) * skin),
            (Area::Neck, neck),
            (Area::Chest, self.chest(point) * skin * (1.0 - neck)),
        ]
    }

    fn eyes(&self, point: &Point) -> f64 {
        if point.is_eye {
            return 1.0;
        }
        let nearest = |&center: &DVec3| point.at.distance(center);
        let distance = self.face.eyes.centers.iter().map(nearest).fold(f64::INFINITY, f64::min);
        let Some(radius) = self.face.eyes.radius else { return self.hollow_eyes(point) };
        if self.face.eyes.components.contains(&true) {
            // Lids lie on the eyeball, their inner lining within its radius.
            return smoothstep_f64(1.02, 0.94, distance / radius);
        }
        let [dx, dy] = [point.x - 0.5, point.y];
        smoothstep_f64(1.07, 1.03, distance / radius) * ellipse([dx, dy], [0.24, 0.14], 1.2)
    }

    /// Eyes of a mesh without eyeballs: the inside of the sockets, well behind the lids.
    fn hollow_eyes(&self, point: &Point) -> f64 {
        let [dx, dy] = [point.x - 0.5, point.y];
        if dx.abs() > 0.45 || dy.abs() > 0.45 || point.z < -0.8 {
            return 0.0;
        }
        let lids = [0.2, -0.28].map(|y| self.relief.both(point.x, y).unwrap_or(-1.0));
        ellipse([dx, dy], [0.36, 0.34], 1.15)
            * smoothstep_f64(0.1, 0.15, lids[0].min(lids[1]) - point.z)
    }

    fn sockets(&self, point: &Point) -> f64 {
        let radius = self.face.eyes.radius.unwrap_or(0.2);
        let [dx, dy] = [point.x - 0.5, point.y];
        let ry = if dy > 0.0 { 0.24_f64.max(1.15 * radius) } else { 0.3_f64.max(1.3 * radius) };
        ellipse([dx, dy], [0.36_f64.max(1.6 * radius), ry], 1.25)
            * smoothstep_f64(-1.0, -0.7, point.z)
    }

    fn brows(&self, point: &Point) -> f64 {
        let radius = self.face.eyes.radius.unwrap_or(0.2);
        // The band rises outwards from the nose, then bends down around the eye.
        let middle = 0.36_f64.max(1.5 * radius) + 0.04 - 0.25 * (point.x - 0.55).powi(2);
        band(0.16, 0.85, 0.08, point.x)
            * band(middle - 0.08, middle + 0.08, 0.06, point.y)
            * smoothstep_f64(-0.7, -0.5, point.z)
    }

    fn forehead(&self, point: &Point) -> f64 {
        let low = self.face.brow.y.max(0.3) + 0.2;
        let high = self.face.brow.y.max(0.3) + 0.42 * (self.face.crown.y - self.face.brow.y);
        let side = self.face.half_width * 0.72;
        band(low, high.max(low + 0.1), 0.1, point.y)
            * smoothstep_f64(side + 0.1, side - 0.1, point.x)
            * smoothstep_f64(0.2, 0.45, point.normal.z)
    }

    fn nose(&self, point: &Point) -> f64 {
        let tip = self.face.nose_tip;
        let down = (point.y / tip.y.min(-0.2)).clamp(0.0, 1.2);
        let width = 0.08 + 0.1 * down;
        band(tip.y - 0.05, -0.05, 0.06, point.y)
            * smoothstep_f64(width + 0.08, width, point.x)
            * smoothstep_f64(-0.5, -0.25, point.normal.y)
            * smoothstep_f64(0.1, 0.3, point.normal.z)
    }

    fn cheeks(&self, point: &Point) -> f64 {
        let top = -0.36_f64.max(1.5 * self.face.eyes.radius.unwrap_or(0.2));
        let low = self.face.nose_base.y - 0.02;
        let side = self.face.half_width * 0.86;
        // The nasolabial fold runs outwards as it goes down.
        let inner = 0.44 + 0.25 * (top - point.y).max(0.0);
        band(low.min(top - 0.15), top, 0.09, point.y)
            * smoothstep_f64(inner - 0.06, inner + 0.06, point.x)
            * smoothstep_f64(side + 0.08, side - 0.08, point.x)
            * smoothstep_f64(0.1, 0.35, point.normal.z)
            * smoothstep_f64(-1.0, -0.7, point.z)
    }

    fn lips(&self, point: &Point) -> f64 {
        let corner = self.face.mouth_corner;
        let t = (point.x / corner.x).min(1.0);
        let line = self.face.mouth.y + (corner.y - self.face.mouth.y) * t * t;
        let above = 0.35 * (self.face.nose_base.y - self.face.mouth.y).clamp(0.2, 0.5);
        let below = 0.32 * (self.face.mouth.y - self.face.chin.y).clamp(0.35, 0.7);
        let dy = point.y - line;
        let height = if dy > 0.0 { above } else { below };
        ellipse([point.x, dy], [corner.x + 0.01, height * 0.95], 1.22)
            * smoothstep_f64(-0.55, -0.4, point.z - self.face.mouth.z)
    }

    /// Surfaces well behind the lips at their height, hidden by the skin of the face.
    fn mouth_interior(&self, point: &Point) -> f64 {
        let mouth = self.face.mouth;
        let depth = mouth.z - point.z;
        ellipse([point.x, point.y - mouth.y], [0.6, 0.5], 1.15)
            * smoothstep_f64(0.05, 0.11, point.behind)
            * smoothstep_f64(0.02, 0.08, depth)
            * smoothstep_f64(1.45, 1.3, depth)
            // Nostrils, which are not far behind the lips, are excluded.
            * smoothstep_f64(0.03, -0.07, point.y - self.face.nose_base.y - smoothstep_f64(0.3, 0.6, depth))
            * smoothstep_f64(self.face.jaw_bottom.y - 0.05, self.face.jaw_bottom.y + 0.1, point.y)
    }

    fn jaw(&self, point: &Point) -> f64 {
        let mouth = self.face.mouth.y;
        // Upper bound: below the mouth, rising towards the ear lobes at the sides.
        let upper = mouth - 0.14 + 0.35 * smoothstep_f64(0.4, 1.0, point.x);
        smoothstep_f64(upper + 0.1, upper - 0.02, point.y)
            * smoothstep_f64(-0.04, 0.08, self.above_jaw_line(point))
            * smoothstep_f64(-1.25, -1.0, point.z)
    }

    /// Height of a point above the line from the underside of the chin to the angle of the jaw.
    fn above_jaw_line(&self, point: &Point) -> f64 {
        let DVec3 { y, z, .. } = self.face.jaw_bottom;
        let angle = [self.face.mouth.y - 0.1, -0.95];
        let along = ((z - point.z) / (z - angle[1]).max(0.3)).clamp(-0.3, 1.3);
        point.y - (y + along * (angle[0] - y))
    }

    fn ears(&self, point: &Point) -> f64 {
        let side = usize::from(point.at.x < 0.0);
        let Some(ear) = self.face.ears[side].filter(|_| point.may_be_ear) else { return 0.0 };
        // Heads are wider above the ears and narrower below them.
        let width = self.face.half_width
            + (self.face.upper_half_width - self.face.half_width)
                * smoothstep_f64(-0.2, 0.3, point.y)
            - 0.25 * (-0.4 - point.y).max(0.0);
        let [dy, dz] = [point.y - (ear.y - 0.25), point.z - (ear.z + 0.2)];
        smoothstep_f64(width - 0.03, width + 0.06, point.x)
            * ellipse([dz, dy], [0.42, 0.6], 1.25)
            * smoothstep_f64(ear.x.abs() + 0.4, ear.x.abs() + 0.2, point.x)
    }

    fn scalp(&self, point: &Point) -> f64 {
        let hairline =
            self.face.brow.y.max(0.3) + 0.58 * (self.face.crown.y - self.face.brow.y).max(0.5);
        // Depth and height of the hairline, from the forehead over the temples and past the ears,
        // in front and behind, to the nape.
        let line = [
            [0.5, hairline],
            [0.1, hairline],
            [-0.35, 0.75],
            [-0.6, 0.35],
            [-0.8, 0.0],
            [-1.1, -0.1],
            [-1.5, -0.5],
            [-1.75, -1.0],
            [-4.0, -1.1],
        ];
        let height = piecewise(&line, point.z);
        smoothstep_f64(height - 0.08, height + 0.08, point.y)
    }

    fn neck(&self, point: &Point) -> f64 {
        let Some(base) = self.face.neck_base else { return 0.0 };
        // The base rises towards the back, as collars do.
        let low =
            base.y + 0.3 * (base.z - point.z).clamp(0.0, 2.0) + 0.8 * (point.x - 0.8).max(0.0);
        let nape = -1.2;
        let top = smoothstep_f64(0.06, -0.06, self.above_jaw_line(point)).min(smoothstep_f64(
            nape + 0.1,
            nape - 0.05,
            point.y - 0.5 * (point.z + 1.7).max(0.0),
        ));
        smoothstep_f64(low - 0.12, low + 0.05, point.y) * top * smoothstep_f64(1.9, 1.5, point.x)
    }

    fn chest(&self, point: &Point) -> f64 {
        let Some(base) = self.face.neck_base else { return 0.0 };
        let has_more = self.face.bottom < base.y - 0.25;
        if !has_more {
            return 0.0;
        }
        band(base.y - 2.4, base.y + 0.35, 0.2, point.y)
            * smoothstep_f64(3.2, 2.8, point.x)
            * smoothstep_f64(-0.05, 0.2, point.normal.z)
            * smoothstep_f64(base.z - 2.2, base.z - 1.6, point.z)
    }
}

/// The height of a polyline at a depth; its depths are descending.
fn piecewise(line: &[[f64; 2]], depth: f64) -> f64 {
    for pair in line.windows(2) {
        let [[from, a], [to, b]] = [pair[0], pair[1]];
        if depth >= to {
            return a + (b - a) * ((from - depth) / (from - to)).clamp(0.0, 1.0);
        }
    }
    line.last().map_or(0.0, |point| point[1])
}
