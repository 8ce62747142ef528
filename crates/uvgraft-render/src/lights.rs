//! Studio lights, their shadows, and the reflection model.

use glam::Vec3;
use uvgraft::Size;
use uvgraft::easing::smoothstep;

use super::camera::Camera;
use super::geometry::Geometry;
use super::projection::project;
use super::shading::{Paint, Shading};
use super::visibility::DepthBuffer;

/// Lights that move with the camera, and the shadow map of the key light.
#[derive(Debug)]
pub(crate) struct Lights {
    key: Vec3,
    fill: Vec3,
    rim: Vec3,
    shadow_camera: Camera,
    shadow: DepthBuffer,
    /// Half the width of soft shadow edges, in texels of the shadow map: the same width everywhere.
    softness: f32,
    bias: f32,
}

const SHADOW_SIDE: u32 = 2048;

impl Lights {
    /// Lights at fixed directions relative to the camera; the faces in `casts` cast the key
    /// light's shadow.
    ///
    /// - `seen`: centre and radius of the region that the shadow map covers; nothing outside
    ///   it is shadowed.
    /// - `metre`: length of one metre in mesh units.
    pub fn new(
        camera: &Camera,
        geometry: &Geometry,
        casts: impl Fn(usize) -> bool + Sync,
        seen: (Vec3, f32),
        metre: f32,
    ) -> Self {
        let world = |x: f32, y: f32, z: f32| {
            (camera.right * x + camera.up * y + camera.towards * z).normalize_or_zero()
        };
        let key = world(-0.55, 0.62, 0.75);
        let size = Size::square(SHADOW_SIDE);
        let unit_per_px = (2.0 * seen.1 / SHADOW_SIDE as f32).max(f32::MIN_POSITIVE);
        let shadow_camera = Camera::looking(key, seen.0, unit_per_px, size);
        let parts = project(&shadow_camera, &geometry.positions, &geometry.faces, size, casts);
        let shadow = DepthBuffer::new(&parts, size, f32::NEG_INFINITY, |_, _, _| true);
        Self {
            key,
            fill: world(0.85, 0.1, 0.6),
            rim: world(0.75, 0.45, -0.62),
            shadow_camera,
            shadow,
            softness: (0.0022 * metre / unit_per_px).clamp(1.0, 6.0),
            bias: 0.0035 * metre,
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
    /// - `towards`: unit vector from the point to the camera.
    /// - `open`: the fraction of the sky that nearby geometry leaves visible.
    pub fn shade(
        &self,
        paint: &Paint,
        position: Vec3,
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
        let lit = self.lit(position, normal);
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

    /// The fraction of the key light that reaches a point, with soft edges.
    ///
    /// Percentage-closer filtering (Reeves et al. 1987): depth comparisons, not depths, are
    /// averaged, here over a square of bilinear taps. The point is raised along its normal and the
    /// depth biased, or the surface would shadow itself.
    ///
    /// - `normal`: normal of the surface at the point.
    pub fn lit(&self, position: Vec3, normal: Vec3) -> f32 {
        /// Taps along each side of the square.
        const TAPS: i32 = 6;
        let raised = position + normal * self.bias;
        let [x, y, w] = self.shadow_camera.homogeneous(raised);
        let [x, y] = [x, y].map(|at| (at / w) as f32);
        let side = SHADOW_SIDE as f32;
        if !(x >= 0.0 && y >= 0.0 && x < side && y < side) {
            return 1.0;
        }
        let height = self.shadow_camera.depth_of(raised, w) as f32 + self.bias;
        let step = 2.0 * self.softness / TAPS as f32;
        let mut sum = 0.0;
        for row in 0..TAPS {
            for column in 0..TAPS {
                let at = |tap: i32| (tap as f32 - 0.5 * (TAPS - 1) as f32) * step;
                let (px, py) = (x + at(column) - 0.5, y + at(row) - 0.5);
                let (left, top) = (px.floor(), py.floor());
                let (fx, fy) = (px - left, py - top);
                let open = |dx: i32, dy: i32| {
                    let depth = self.shadow.depth(left as i32 + dx, top as i32 + dy);
                    f32::from(u8::from(depth <= height))
                };
                let upper = open(0, 0) * (1.0 - fx) + open(1, 0) * fx;
                let lower = open(0, 1) * (1.0 - fx) + open(1, 1) * fx;
                sum += upper * (1.0 - fy) + lower * fy;
            }
        }
        sum / (TAPS * TAPS) as f32
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
