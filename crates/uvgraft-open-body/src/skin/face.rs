//! Lips, brows, cheeks and the scalp, by their places relative to the eyes.

use glam::{Vec2, Vec3};
use uvgraft::easing::{bell, smoothstep};
use uvgraft_avatar::paint::bake::Spot;
use uvgraft_avatar::paint::noise::{fractal, noise2};
use uvgraft_avatar::paint::texel::{Color, blend};

use super::{SkinOptions, SkinTone, scaled};

/// Half the distance of the eyes that the measures below are made for, in centimetres.
const HALF_EYES: f32 = 2.89;
/// Between the lips, from the middle of the eyes.
const MOUTH: Vec3 = Vec3::new(0.0, -6.65, 2.6);
/// The corner of the mouth is so far from its middle.
const HALF_MOUTH: f32 = 2.35;
/// The middle line of a brow from the eye's centre, from the nose outwards, and its half width.
const BROW: [(Vec2, f32); 4] = [
    (Vec2::new(-1.55, 1.35), 0.30),
    (Vec2::new(-0.3, 1.75), 0.33),
    (Vec2::new(1.2, 1.95), 0.24),
    (Vec2::new(2.3, 1.45), 0.06),
];

/// The face, placed by the eyes.
pub(super) struct Face {
    middle: Vec3,
    scale: f32,
    brows: Color,
    hair: Option<Color>,
}

impl Face {
    pub(super) fn new(joint: &impl Fn(usize) -> Vec3, options: &SkinOptions) -> Self {
        let [left, right] = [23, 24].map(joint);
        let scale = ((left.x - right.x) / (2.0 * HALF_EYES)).max(1e-3);
        let middle = (left + right) / 2.0;
        Self { middle, scale, brows: options.brows, hair: options.hair }
    }

    /// The middle of the lips.
    pub(super) fn mouth(&self) -> Vec3 {
        self.middle + MOUTH * self.scale
    }

    /// A place in centimetres of the mean face, from the middle of the eyes, on the left side.
    fn local(&self, place: Vec3) -> Vec3 {
        let local = (place - self.middle) / self.scale;
        Vec3::new(local.x.abs(), local.y, local.z)
    }

    /// Share of blood: cheeks, nose, ears and chin.
    pub(super) fn flush(&self, place: Vec3) -> f32 {
        let q = self.local(place);
        if q.y < -12.0 || q.y > 6.0 {
            return 0.0;
        }
        let at = |x: f32, y: f32, radius: f32| {
            bell(Vec2::new(q.x - x, q.y - y).length(), radius) * smoothstep(-6.0, -1.0, q.z)
        };
        let ear = smoothstep(7.2, 7.9, q.x) * smoothstep(-1.5, -4.0, q.z);
        0.30 * at(3.9, -3.2, 1.8)
            + 0.25 * at(0.0, -3.2, 1.2)
            + 0.12 * at(0.0, -9.5, 1.5)
            + 0.2 * ear
    }

    /// Paints the features over the skin.
    pub(super) fn over(&self, color: Color, spot: &Spot, tone: &SkinTone) -> Color {
        let q = self.local(spot.position);
        if q.y < -14.0 {
            return color;
        }
        let color = blend(color, self.lips(spot.position, tone), lips(q));
        let color = self.brow(color, q);
        match self.hair {
            Some(hair) => blend(color, strands(hair, q), scalp(q)),
            None => color,
        }
    }

    /// The inner mouth, darker towards the throat, and the backs of the lids.
    pub(super) fn inside(&self, place: Vec3, tone: &SkinTone) -> Color {
        let depth = (self.mouth().z - place.z) / self.scale;
        let is_eye = place.y > self.middle.y - 3.5 * self.scale;
        let shade = if is_eye { 0.85 } else { 0.85 - 0.55 * smoothstep(0.5, 4.5, depth) };
        scaled(blend(tone.blood(), [0.62, 0.30, 0.29], 0.5), shade)
    }

    fn lips(&self, place: Vec3, tone: &SkinTone) -> Color {
        let lines = fractal(Vec3::new(place.x * 9.0, place.y * 1.5, place.z), 2, 151);
        scaled(tone.blood(), 0.92 + 0.07 * lines)
    }

    fn brow(&self, color: Color, q: Vec3) -> Color {
        let place = Vec2::new(q.x - HALF_EYES, q.y);
        if q.z < -1.5 || !(0.5..3.0).contains(&q.y) {
            return color;
        }
        let mut cover: f32 = 0.0;
        for pair in BROW.windows(2) {
            let [(from, wide), (to, narrow)] = [pair[0], pair[1]];
            let along =
                ((place - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
            let distance = place.distance(from.lerp(to, along));
            let width = wide + (narrow - wide) * along;
            cover = cover.max(smoothstep(width * 1.25, width * 0.55, distance));
        }
        // Hairs that slant outwards.
        let hairs = noise2(place.x * 22.0 - place.y * 16.0, place.y * 3.0, 161);
        blend(color, self.brows, cover * (0.74 + 0.22 * hairs).clamp(0.0, 1.0))
    }
}

/// Coverage by the lips.
fn lips(q: Vec3) -> f32 {
    let (x, y) = (q.x / HALF_MOUTH, q.y - MOUTH.y);
    if x > 1.05 || q.z < 0.4 {
        return 0.0;
    }
    // Full in the middle, and pointed at the corners; the upper lip has a bow.
    let taper = (1.0 - x * x).max(0.0).sqrt();
    let bow = 0.10 * bell(x - 0.16, 0.12) - 0.06 * bell(x, 0.09);
    let (upper, lower) = ((0.58 + bow) * taper, 0.86 * taper);
    let edge = if y > 0.0 { y / upper.max(0.02) } else { -y / lower.max(0.02) };
    smoothstep(1.10, 0.88, edge) * smoothstep(1.05, 0.97, x)
}

/// Coverage of the scalp by hair: behind a line from the forehead past the ears to the nape.
fn scalp(q: Vec3) -> f32 {
    // Around the head's middle, 7.5 cm behind the eyes.
    let p = Vec3::new(q.x, q.y - 1.0, q.z + 7.5);
    // Angle from straight ahead, and height of the hairline above the eyes there.
    let angle = p.x.atan2(p.z).abs().to_degrees();
    let line = |from: f32, to: f32| smoothstep(from, to, angle);
    let height = 5.6
        - 0.6 * line(10.0, 35.0)
        - 2.9 * line(38.0, 62.0)
        - 0.9 * line(66.0, 80.0)
        - 1.2 * line(92.0, 112.0)
        - 5.6 * line(112.0, 145.0);
    let ear = smoothstep(7.0, 7.5, q.x) * smoothstep(2.0, 1.0, q.y) * smoothstep(-10.0, -9.0, q.z);
    let rough = 0.16 * noise2(angle * 0.7, p.y * 0.8, 165) + 0.16 * noise2(angle * 2.6, p.y, 166);
    smoothstep(-0.30, 0.30, p.y - height + rough) * (1.0 - ear)
}

fn strands(hair: Color, q: Vec3) -> Color {
    let p = Vec3::new(q.x, q.y - 1.0, q.z + 7.5);
    let turn = p.x.atan2(-p.z) * 30.0;
    let along = (p.y / p.length().max(1e-3)).acos() * 3.0;
    scaled(hair, 0.9 + 0.25 * noise2(turn, along, 167) + 0.15 * noise2(2.7 * turn, along, 168))
}
