//! The features of painted faces: skin, eyes, mouth, hair, collar and glasses.

use uvgraft::easing::{bell, mix, smoothstep};

use super::face_look::{Beard, Collar, FaceLook, HairColor};
use super::noise::{Point, curve, fractal, noise};
use super::skin::{blend, linear, scaled};
use super::{Color, HeadFrame};

impl FaceLook {
    /// Skin with varying blood supply, shaded hollows, and gloss.
    pub(super) fn lit_skin(&self, frame: &HeadFrame, p: Point, normal: [f32; 3]) -> Color {
        let (x, y, z) = (p[0].abs(), p[1], p[2]);
        let front = smoothstep(-3.5, 0.0, z);
        let [nose_y, nose_z] = frame.nose;
        let cheek = bell(x - 4.2, 2.7) * bell(y - nose_y - 0.1, 2.6) * front;
        let nose = bell(x, 1.3) * bell(y - nose_y, 1.2) * smoothstep(nose_z - 2.5, nose_z, z);
        let chin = bell(x, 1.8) * bell(y - frame.chin - 1.2, 1.2) * front;
        let ear = smoothstep(7.2, 8.2, x) * smoothstep(3.5, 1.5, y) * smoothstep(-8.0, -5.0, y);
        let flush = 0.9 * cheek + 0.8 * nose + 0.3 * chin + 0.8 * ear
            - 0.35 * smoothstep(frame.chin, frame.chin - 6.0, y);
        let mut color = self.skin.at(p, flush, self.seed);
        let socket = bell(x - frame.eye[0] + 0.5, 2.0) * bell(y - 0.5, 1.2);
        let bag = bell(x - frame.eye[0], 1.5) * bell(y + 1.6, 0.4);
        let wing = bell(x - 1.75, 0.35) * bell(y - nose_y + 0.7, 0.9) * smoothstep(0.5, 2.0, z);
        let nostril =
            bell(x - 0.7, 0.38) * bell(y - nose_y + 1.0, 0.32) * smoothstep(-0.1, -0.5, normal[1]);
        let under_lip = bell(x, 1.5) * bell(y - frame.lips[2] + 0.6, 0.45) * front;
        let under_chin =
            smoothstep(0.1, -0.7, normal[1]) * smoothstep(frame.chin + 3.0, frame.chin, y);
        let neck = smoothstep(frame.chin + 1.0, frame.chin - 2.5, y);
        let behind = smoothstep(-1.0, -13.0, z) * smoothstep(5.0, 0.0, y);
        let hollow = 0.34 * socket
            + 0.15 * bag
            + 0.4 * wing
            + 0.9 * nostril
            + 0.2 * under_lip
            + 0.35 * under_chin
            + self.neck_shade * neck
            + 0.15 * behind;
        let light = 0.92 + 0.08 * normal[1] + 0.08 * normal[2];
        // Light reaches hollows partly through skin, and is redder there.
        let dim = (1.0 - hollow).clamp(0.06, 1.0);
        let gain = if self.skin.is_grey() {
            [dim; 3]
        } else {
            [dim.powf(0.85), dim, dim * dim.powf(0.06)]
        };
        color = [0, 1, 2].map(|k| color[k] * gain[k] * light);
        let gloss =
            0.16 * bell(x, 0.5) * bell(y - nose_y - 0.3, 0.8) * smoothstep(nose_z - 1.5, nose_z, z)
                + 0.09 * bell(x - 1.0, 2.2) * bell(y - 0.65 * frame.hairline, 1.2) * front
                + 0.035 * bell(x - 4.6, 1.4) * bell(y + 1.9, 0.9) * front;
        // Oil shines as brightly on dark skin, but less of the gloss is scattered below the
        // surface.
        let rough = 1.0 + 0.6 * fractal(p, 0.5, self.seed + 51);
        let rough = rough * (0.3 + 0.7 * self.skin.0[1]);
        color.map(|value| value + gloss * rough)
    }

    pub(super) fn eye(&self, frame: &HeadFrame, p: Point) -> Color {
        let q = [p[0].abs() - frame.eye[0], p[1] - frame.eye[1], p[2] - frame.eye[2]];
        let across = q[0].hypot(q[1]) / frame.eye_radius;
        let side = p[0].signum();
        let veins =
            smoothstep(0.8, 1.0, 1.0 - noise([q[0] * 5.0, q[1] * 7.0, side], self.seed + 61).abs());
        let mut color = blend(
            linear([0.86, 0.83, 0.80]),
            linear([0.75, 0.50, 0.45]),
            0.35 * veins * smoothstep(0.5, 0.9, across),
        );
        color = scaled(color, 1.0 - 0.3 * smoothstep(0.0, 0.6, q[1]));
        if q[2] > 0.0 {
            let angle = q[1].atan2(q[0]);
            let fibres = noise([angle * 9.0, across * 6.0, side], self.seed + 62);
            let iris = scaled(linear([0.33, 0.22, 0.13]), 1.0 + 0.5 * fibres);
            color = blend(color, iris, smoothstep(0.49, 0.45, across));
            color = blend(color, [0.004; 3], smoothstep(0.21, 0.18, across));
            let glint = (q[0] * side + 0.25).hypot(q[1] - 0.25) / frame.eye_radius;
            color = blend(color, [0.85; 3], smoothstep(0.11, 0.08, glint));
        }
        blend(color, linear([0.45, 0.2, 0.17]), smoothstep(0.3, -0.3, q[2]))
    }

    pub(super) fn mouth_inside(&self, frame: &HeadFrame, p: Point) -> Option<Color> {
        let x = p[0] / frame.mouth_width;
        let [top, middle, bottom] = frame.lips;
        let depth = frame.mouth_depth - 1.2 * x * x;
        // Below the lower lip the chin lies in front of the floor of the mouth.
        let depth = if p[1] < bottom + 0.2 { depth - 0.9 } else { depth };
        if x.abs() > 1.0 || !(bottom - 0.7..top).contains(&p[1]) || p[2] > depth || p[2] < -1.0 {
            return None;
        }
        let gap = smoothstep(0.06, 0.02, (p[0] / 0.75 - (p[0] / 0.75).floor() - 0.5).abs());
        let tooth = smoothstep(middle - 0.75, middle - 0.6, p[1]) * (1.0 - 0.75 * gap);
        Some(blend(linear([0.20, 0.06, 0.06]), linear([0.80, 0.76, 0.68]), tooth))
    }

    pub(super) fn lip(&self, frame: &HeadFrame, p: Point) -> Color {
        let skin = linear(self.skin.0);
        let red = [skin[0] * 0.80, skin[1] * 0.44, skin[2] * 0.50];
        let red = if self.skin.is_grey() { scaled(skin, 0.5) } else { red };
        let creases = noise([p[0] * 5.0, p[1] * 0.8, 0.0], self.seed + 71);
        let upper = if p[1] > frame.lips[1] { 0.85 } else { 1.05 };
        let line = 1.0 - 0.75 * bell(p[1] - lip_line(frame, p), 0.12);
        scaled(red, upper * line * (1.0 + 0.14 * creases))
    }

    /// Colour of strands of hair; `calm` from 0 to 1 fades the gloss, for brows and the like.
    pub(super) fn strands(&self, p: Point, calm: f32) -> Color {
        let q = [p[0], p[1] - 7.0, p[2] + 9.0];
        let around = q[0].atan2(q[2]) + 0.25 * noise(p.map(|value| value * 0.25), self.seed + 80);
        let polar = q[0].hypot(q[2]).atan2(q[1]);
        let strand = 0.5 * noise([around * 26.0, polar * 1.5, 0.0], self.seed + 81)
            + 0.5 * noise([around * 60.0, polar * 3.0, 0.0], self.seed + 82);
        let lock = noise([around * 7.0, polar, 0.0], self.seed + 83);
        let gloss = bell(polar - 0.8 - 0.1 * lock, 0.25) * (1.0 - calm);
        let light = 0.8 + 0.45 * strand + 0.25 * lock + 0.55 * gloss;
        let base = linear(self.hair.color());
        let spread = if self.hair == HairColor::Grey { 0.5 * strand } else { 0.0 };
        scaled(base, (light + spread).max(0.15))
    }

    /// Colour of short hairs that hang down.
    pub(super) fn whiskers(&self, p: Point) -> Color {
        let curl = 0.4 * noise(p, self.seed + 92);
        let strand = noise([p[0] * 5.0 + curl, p[1] * 1.1, p[2] * 5.0], self.seed + 93);
        let finer = noise([p[0] * 11.0 + curl, p[1] * 2.4, p[2] * 11.0], self.seed + 94);
        let light = 0.75 + 0.3 * strand + 0.3 * finer + 0.15 * fractal(p, 2.0, self.seed + 95);
        scaled(linear(self.hair.color()), light.max(0.15))
    }

    pub(super) fn hair_cover(&self, frame: &HeadFrame, p: Point) -> f32 {
        let around = p[0].abs().atan2(p[2] + 7.2);
        let top = frame.hairline;
        let fringe = if self.fringe { 0.48 * top } else { top };
        let line = curve(
            &[
                (0.0, fringe),
                (0.6, fringe - 0.3),
                (0.95, mix(fringe, 3.2, 0.6)),
                (1.12, 0.5),
                (1.22, -2.6),
                (1.45, -2.0),
                (1.52, 2.6),
                (1.95, 2.2),
                (2.05, -3.0),
                (2.5, -7.5),
                (3.2, -9.0),
            ],
            around,
        );
        let ragged = 0.45 * noise([around * 9.0, 0.0, 0.0], self.seed + 84)
            + 0.35 * noise([around * 40.0, p[1] * 0.4, 0.0], self.seed + 85);
        let ragged = ragged * if self.fringe { 1.8 } else { 1.0 };
        // Hair leaves the ears free.
        let ear = smoothstep(8.0, 8.2, p[0].abs()) * smoothstep(4.2, 3.9, p[1]);
        smoothstep(-0.35, 0.35, p[1] - line + ragged) * (1.0 - ear)
    }

    pub(super) fn brow_cover(&self, frame: &HeadFrame, p: Point) -> f32 {
        let x = p[0].abs() - frame.eye[0] + 3.2;
        if !(1.0..6.2).contains(&x) || p[2] < -3.5 {
            return 0.0;
        }
        let arch = curve(&[(1.2, -0.25), (2.4, 0.0), (3.9, 0.3), (4.8, 0.15), (5.7, -0.5)], x);
        let half = curve(&[(1.2, 0.30), (1.8, 0.48), (3.4, 0.42), (4.6, 0.28), (5.8, 0.04)], x);
        let off = p[1] - frame.brow - arch;
        let strand = noise([(x - off * 1.2) * 8.0, off * 2.0, 0.0], self.seed + 86);
        let body = 1.0 - (off / half).abs() + 0.45 * strand;
        0.92 * smoothstep(0.0, 0.55, body) * smoothstep(1.1, 1.7, x) * smoothstep(5.9, 5.2, x)
    }

    /// Coverage of the beard, and whether it is hair rather than skin with dots.
    pub(super) fn beard_cover(&self, frame: &HeadFrame, p: Point) -> (f32, bool) {
        if self.beard == Beard::Shaved {
            return (0.0, false);
        }
        let x = p[0].abs();
        let under = frame.lips[0] + 0.9 - 0.04 * (x - 2.0).powi(2);
        let sideburn = smoothstep(-2.2, -4.2, p[2]) * smoothstep(-7.0, -5.5, p[2]);
        let upper = mix(under - 0.25 * (x - 2.0).max(0.0), -1.0, sideburn);
        let ragged = 0.5 * noise(p, self.seed + 87)
            + 0.3 * noise(p.map(|value| value * 3.0), self.seed + 88);
        let below = smoothstep(0.3, -0.4, p[1] - upper + ragged)
            * smoothstep(frame.chin - 3.4, frame.chin - 2.4, p[1] + ragged)
            * smoothstep(-7.2, -6.0, p[2]);
        let below = below * (1.0 - lip_cover(frame, p));
        let dots = noise(p.map(|value| value * 7.0), self.seed + 89);
        match self.beard {
            Beard::Full => (below * (0.94 + 0.06 * dots), true),
            _ => (below * (0.24 + 0.16 * dots), false),
        }
    }
}

impl Collar {
    /// Height of a point above the collar's upper edge, in centimetres.
    pub(super) fn above(&self, frame: &HeadFrame, p: Point, seed: u32) -> f32 {
        let [slope, crew, polo] = frame.collar;
        let beyond = 0.6 * (p[0].abs() - 4.5).max(0.0) * (1.0 - self.height);
        let around = p[0].atan2(p[2] + 9.0);
        let wave = noise([around * 2.6, 0.0, 0.5], seed + 90)
            + 0.3 * noise([around * 9.0, 0.0, 0.5], seed + 91);
        p[1] + slope * p[2] - beyond - mix(crew, polo, self.height) - self.unevenness * wave
    }
}

fn lip_line(frame: &HeadFrame, p: Point) -> f32 {
    frame.lips[1] + 0.25 * (p[0] / frame.mouth_width).powi(2)
}

pub(super) fn lip_cover(frame: &HeadFrame, p: Point) -> f32 {
    let x = (p[0] / frame.mouth_width).abs();
    if x > 1.0 || p[2] < -1.0 {
        return 0.0;
    }
    let arch = (1.0 - x * x).max(0.0).powf(0.8);
    let line = lip_line(frame, p);
    let top = line + (frame.lips[0] - frame.lips[1]) * arch - 0.12 * bell(p[0], 0.4);
    let bottom = line + (frame.lips[2] - frame.lips[1]) * arch;
    smoothstep(0.08, -0.08, p[1] - top) * smoothstep(-0.1, 0.1, p[1] - bottom)
}

pub(super) fn lash_cover(frame: &HeadFrame, p: Point) -> f32 {
    let width = 1.15 * frame.eye_radius;
    let x = (p[0].abs() - frame.eye[0]) / width;
    if x.abs() > 1.0 || p[2] < -0.6 * frame.eye_radius {
        return 0.0;
    }
    let arch = (1.0 - x * x).sqrt();
    let [upper, lower] = frame.lids;
    let line =
        bell(p[1] - upper * arch - 0.05, 0.13) + 0.35 * bell(p[1] - lower * arch + 0.03, 0.08);
    (0.9 * line).min(0.9)
}

/// Coverage of glasses: round lenses, a bridge, and arms to the ears.
pub(super) fn glasses_cover(frame: &HeadFrame, p: Point) -> f32 {
    let x = p[0].abs();
    let ring = ((x - frame.eye[0] - 0.1) / 2.55).hypot((p[1] + 0.35) / 2.2) - 1.0;
    let bridge = bell(p[1] - 0.25, 0.22) * smoothstep(0.9, 0.7, x);
    let arm = bell(p[1] - 0.4, 0.24) * smoothstep(5.6, 5.9, x) * smoothstep(-8.5, -8.0, p[2]);
    let front = smoothstep(-3.0, -2.0, p[2]);
    (front * (smoothstep(0.10, 0.06, ring.abs()) + bridge) + arm).min(1.0)
}
