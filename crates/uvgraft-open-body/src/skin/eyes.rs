//! Eyeballs, teeth and tongue.

use glam::Vec3;
use uvgraft::easing::smoothstep;
use uvgraft_avatar::paint::noise::{fractal, noise2};
use uvgraft_avatar::paint::texel::{Color, blend};

use super::{SkinOptions, scaled};

/// Radii of the iris and the pupil, in centimetres, on MakeHuman's large eyeballs.
const IRIS: f32 = 0.62;
const PUPIL: f32 = 0.26;
const SCLERA: Color = [0.90, 0.88, 0.86];

/// An eyeball that looks straight ahead.
pub(super) struct Eye {
    center: Vec3,
    iris: Color,
}

impl Eye {
    pub(super) const fn new(center: Vec3, options: &SkinOptions) -> Self {
        Self { center, iris: options.iris }
    }

    pub(super) fn color(&self, place: Vec3) -> Color {
        let q = place - self.center;
        let across = q.truncate().length();
        let corner = smoothstep(0.7, 1.4, q.x.abs());
        let sclera = blend(SCLERA, [0.80, 0.60, 0.56], 0.55 * corner);
        // The upper lid casts a shadow.
        let sclera = scaled(sclera, 1.0 - 0.22 * smoothstep(0.0, 0.6, q.y));
        if q.z <= 0.0 || across > 1.1 * IRIS {
            return sclera;
        }
        let r = across / IRIS;
        let angle = q.y.atan2(q.x);
        let fibres =
            noise2(angle * 14.0, 2.0 * r, 172) * 0.6 + noise2(angle * 31.0, 4.0 * r, 173) * 0.4;
        let mut iris = scaled(self.iris, 0.9 + 0.3 * fibres + 0.25 * smoothstep(0.9, 0.5, r));
        iris = scaled(iris, 1.0 - 0.55 * smoothstep(0.78, 1.0, r));
        iris = scaled(iris, 1.0 - 0.25 * smoothstep(-0.1, 0.4, q.y));
        let pupil = smoothstep(PUPIL * 1.12, PUPIL * 0.92, across);
        iris = blend(iris, [0.025; 3], pupil);
        blend(iris, sclera, smoothstep(0.97, 1.06, r))
    }
}

/// Teeth, darker towards the back of the mouth.
///
/// - `mouth`: between the lips.
pub(super) fn teeth(place: Vec3, mouth: Vec3) -> Color {
    let depth = smoothstep(0.8, 4.0, mouth.z - place.z);
    let gum = smoothstep(0.75, 1.05, (place.y - mouth.y).abs());
    let enamel = scaled([0.90, 0.87, 0.80], 1.0 + 0.03 * fractal(place * 2.0, 2, 181));
    scaled(blend(enamel, [0.70, 0.38, 0.37], 0.6 * gum), 1.0 - 0.5 * depth)
}

pub(super) fn tongue(place: Vec3) -> Color {
    scaled([0.70, 0.36, 0.36], 0.95 + 0.12 * fractal(place * 5.0, 3, 191))
}
