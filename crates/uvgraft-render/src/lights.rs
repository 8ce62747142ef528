//! Studio lights and the reflection model.

use glam::Vec3;
use uvgraft::easing::smoothstep;

use super::camera::Camera;
use super::shading::{Paint, Shading};

/// Lights that move with the camera.
#[derive(Debug)]
pub(crate) struct Lights {
    pub key: Vec3,
    fill: Vec3,
    rim: Vec3,
}

impl Lights {
    /// Lights at fixed directions relative to the camera.
    pub fn new(camera: &Camera) -> Self {
        let world = |x: f32, y: f32, z: f32| {
            (camera.right * x + camera.up * y + camera.towards * z).normalize_or_zero()
        };
        Self {
            key: world(-0.55, 0.62, 0.75),
            fill: world(0.85, 0.1, 0.6),
            rim: world(0.75, 0.45, -0.62),
        }
    }

    /// Light that leaves a point towards the camera; linear in and out.
    ///
    /// Diffuse light wraps around by `w`, for each channel: `max(0, (n·l + w) / (1 + w))`, since
    /// skin scatters red light into the shade. Highlights are `(n·h)^sharpness` (Blinn 1977), with
    /// a sheen towards the silhouette. Surfaces with gloss values from a file (`glint`) use a
    /// normalised lobe instead and reflect a two-colour sky; the mirrored fraction is removed from
    /// their diffuse part.
    ///
    /// - `lit`: the fraction of the key light that reaches the point.
    /// - `towards`: unit vector from the point to the camera.
    /// - `open`: the fraction of the sky that nearby geometry leaves visible.
    pub fn shade(
        &self,
        paint: &Paint,
        lit: f32,
        normal: Vec3,
        towards: Vec3,
        open: f32,
    ) -> [f32; 3] {
        const KEY: [f32; 3] = [1.0, 0.955, 0.90];
        const FILL: [f32; 3] = [0.20, 0.225, 0.27];
        const RIM: [f32; 3] = [0.55, 0.58, 0.66];
        const SKY: [f32; 3] = [0.36, 0.38, 0.42];
        const GROUND: [f32; 3] = [0.23, 0.19, 0.17];
        let Paint { shading, albedo, glint: mirrored } = *paint;
        // Near the terminator a cast shadow would draw a hard edge into the soft falloff.
        let grazing = smoothstep(0.35, -0.1, normal.dot(self.key));
        let lit = lit + (1.0 - lit) * 0.8 * grazing;
        let (strength, sharpness) = shading.gloss();
        let half = (self.key + towards).normalize_or_zero();
        let mut glint = strength * normal.dot(half).max(0.0).powf(sharpness) * lit;
        let facing = normal.dot(towards).max(0.0);
        glint += 0.25 * strength * (1.0 - facing).powi(3) * open;
        let own = mirrored.map_or(1.0, |glint| glint.rest());
        let peak = mirrored.map_or(0.0, |glint| {
            glint.peak(normal.dot(half)) * normal.dot(self.key).max(0.0) * lit
        });
        if mirrored.is_some() {
            glint = 0.0;
        }
        // The sky's fraction of the mirrored surroundings.
        let above = 0.5 + 0.5 * (normal * (2.0 * normal.dot(towards)) - towards).y;
        let up = 0.5 + 0.5 * normal.y;
        let rim = normal.dot(self.rim).max(0.0) * (1.0 - facing).powi(2);
        let wrap = shading.wrap();
        let shade = 0.35 + 0.65 * open;
        [0, 1, 2].map(|k| {
            let around = |light: Vec3| ((normal.dot(light) + wrap[k]) / (1.0 + wrap[k])).max(0.0);
            // Shadows on skin keep a little light, which has scattered through it.
            let reached = lit + (1.0 - lit) * 0.25 * wrap[k];
            let light = KEY[k] * around(self.key) * reached * (0.6 + 0.4 * open)
                + FILL[k] * around(self.fill) * shade
                + (GROUND[k] + (SKY[k] - GROUND[k]) * up) * shade * open
                + RIM[k] * rim * open;
            let tint = if shading == Shading::Hair { 0.35 + 3.5 * albedo[k] } else { 1.0 };
            let around = (GROUND[k] + (SKY[k] - GROUND[k]) * above) * shade * open;
            let mirrored = mirrored.map_or(0.0, |glint| glint.color[k] * (KEY[k] * peak + around));
            soft(albedo[k] * own * light * 1.08 + glint * KEY[k] * tint + mirrored)
        })
    }
}

/// Compresses values above the knee smoothly towards white, so that highlights do not clip hard.
fn soft(value: f32) -> f32 {
    const KNEE: f32 = 0.75;
    if value < KNEE {
        value
    } else {
        KNEE + (1.0 - KNEE) * (1.0 - (-(value - KNEE) / (1.0 - KNEE)).exp())
    }
}

/// A neutral studio backdrop, sRGB; `x` and `y` run from 0 to 1, `y` downwards.
pub(crate) fn backdrop(x: f32, y: f32) -> [f32; 3] {
    let (dx, dy) = (x - 0.5, y - 0.42);
    let glow = smoothstep(0.85, 0.0, (dx * dx + dy * dy).sqrt());
    [0.66, 0.68, 0.71].map(|value| value + 0.22 * glow)
}
