//! Light and materials of the renderer.

use uvgraft::Size;

use super::depth::{Camera, DepthBuffer};
use crate::vector::{Vec3, smoothstep, vec3};

/// How a surface answers light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Material {
    Matt,
    Skin,
    Eye,
    Hair,
    Leather,
}

impl Material {
    pub fn named(name: &str) -> Self {
        match name {
            "skin" => Self::Skin,
            "eye" => Self::Eye,
            "hair" => Self::Hair,
            "leather" => Self::Leather,
            _ => Self::Matt,
        }
    }

    /// Strength and sharpness of highlights.
    fn gloss(self) -> (f32, f32) {
        match self {
            Self::Matt => (0.015, 8.0),
            Self::Skin => (0.085, 22.0),
            Self::Eye => (0.9, 220.0),
            Self::Hair => (0.15, 20.0),
            Self::Leather => (0.08, 30.0),
        }
    }

    /// How far light creeps around into the shade, for red, green and blue: skin glows red there.
    fn wrap(self) -> [f32; 3] {
        match self {
            Self::Skin => [0.42, 0.22, 0.16],
            Self::Eye => [0.4, 0.4, 0.4],
            _ => [0.12, 0.12, 0.12],
        }
    }
}

pub(crate) struct Lights {
    key: Vec3,
    fill: Vec3,
    rim: Vec3,
    towards: Vec3,
    shadow_camera: Camera,
    shadow: DepthBuffer,
    /// Height of what the mesh stands on, and the middle and radius of its surroundings.
    floor: f32,
    middle: Vec3,
    radius: f32,
}

const SHADOW_SIDE: u32 = 1024;

impl Lights {
    /// Lights that stand beside the camera, the key's shadows cast by the mesh.
    pub fn new(camera: &Camera, positions: &[Vec3], faces: &[[u32; 3]]) -> Self {
        let beside = |x: f32, y: f32, z: f32| {
            (camera.right * x + camera.up * y + camera.towards * z).normalized()
        };
        let key = beside(-0.55, 0.62, 0.75);
        let (mut low, mut high) = (positions[0], positions[0]);
        for p in positions {
            low = vec3(low.x.min(p.x), low.y.min(p.y), low.z.min(p.z));
            high = vec3(high.x.max(p.x), high.y.max(p.y), high.z.max(p.z));
        }
        let size = Size::square(SHADOW_SIDE);
        let across = (high - low).length() / SHADOW_SIDE as f32;
        let shadow_camera = Camera::looking(key, low.lerp(high, 0.5), across, size);
        let shadow = DepthBuffer::new(&shadow_camera, positions, faces, size);
        Self {
            key,
            fill: beside(0.85, 0.1, 0.6),
            rim: beside(0.75, 0.45, -0.62),
            towards: camera.towards,
            shadow_camera,
            shadow,
            floor: low.y,
            middle: low.lerp(high, 0.5),
            radius: 0.5 * (high - low).length(),
        }
    }

    /// How bright the floor is where a line of sight meets it: 1 out of the mesh's shadow and
    /// where no floor is seen.
    pub fn floor(&self, on_sight: Vec3) -> f32 {
        let fall = self.towards.y;
        if fall < 0.02 {
            return 1.0;
        }
        let p = on_sight - self.towards * ((on_sight.y - self.floor) / fall);
        let (dx, dz) = (p.x - self.middle.x, p.z - self.middle.z);
        let near = smoothstep(1.0, 0.3, (dx * dx + dz * dz).sqrt() / self.radius);
        if near == 0.0 {
            return 1.0;
        }
        // A wide, coarse blur: the sum of shifted narrow ones.
        const SHIFTS: i32 = 3;
        let step = 0.009 * self.radius;
        let mut lit = 0.0;
        for i in -SHIFTS..=SHIFTS {
            for j in -SHIFTS..=SHIFTS {
                let shift = vec3(i as f32 * step, 0.0, j as f32 * step);
                lit += self.lit(p + shift, vec3(0.0, 1.0, 0.0));
            }
        }
        let count = (2 * SHIFTS + 1) * (2 * SHIFTS + 1);
        1.0 - 0.5 * near * (1.0 - lit / count as f32)
    }

    /// Light that leaves a point towards the camera; linear in and out.
    pub fn shade(
        &self,
        material: Material,
        albedo: [f32; 3],
        position: Vec3,
        normal: Vec3,
        open: f32,
    ) -> [f32; 3] {
        const KEY: [f32; 3] = [1.0, 0.955, 0.90];
        const FILL: [f32; 3] = [0.20, 0.225, 0.27];
        const RIM: [f32; 3] = [0.55, 0.58, 0.66];
        const SKY: [f32; 3] = [0.36, 0.38, 0.42];
        const GROUND: [f32; 3] = [0.23, 0.19, 0.17];
        // Where the light only grazes, a cast shadow would draw a hard edge into the soft one.
        let grazing = smoothstep(0.35, -0.1, normal.dot(self.key));
        let lit = self.lit(position, normal);
        let lit = lit + (1.0 - lit) * 0.8 * grazing;
        let (strength, sharpness) = material.gloss();
        let half = (self.key + self.towards).normalized();
        let mut glint = strength * normal.dot(half).max(0.0).powf(sharpness) * lit;
        let facing = normal.dot(self.towards).max(0.0);
        glint += 0.25 * strength * (1.0 - facing).powi(3) * open;
        let up = 0.5 + 0.5 * normal.y;
        let rim = normal.dot(self.rim).max(0.0) * (1.0 - facing).powi(2);
        let wrap = material.wrap();
        let shade = 0.35 + 0.65 * open;
        [0, 1, 2].map(|k| {
            let around = |light: Vec3| ((normal.dot(light) + wrap[k]) / (1.0 + wrap[k])).max(0.0);
            // Shadows on skin keep a little of the light that has crept through it.
            let reached = lit + (1.0 - lit) * 0.25 * wrap[k];
            let light = KEY[k] * around(self.key) * reached * (0.6 + 0.4 * open)
                + FILL[k] * around(self.fill) * shade
                + (GROUND[k] + (SKY[k] - GROUND[k]) * up) * shade * open
                + RIM[k] * rim * open;
            let tint = if material == Material::Hair { 0.35 + 3.5 * albedo[k] } else { 1.0 };
            soft(albedo[k] * light * 1.08 + glint * KEY[k] * tint)
        })
    }

    /// The part of the key light that reaches a point, with soft edges.
    fn lit(&self, position: Vec3, normal: Vec3) -> f32 {
        const BIAS: f32 = 0.004;
        let p = self.shadow_camera.project(position + normal * 0.004);
        let (left, top) = ((p.x - 0.5).floor(), (p.y - 0.5).floor());
        let (fx, fy) = (p.x - 0.5 - left, p.y - 0.5 - top);
        let mut sum = 0.0;
        const REACH: i32 = 1;
        for dy in -REACH..=REACH + 1 {
            for dx in -REACH..=REACH + 1 {
                // A box one texel wider than an even number, sliding with the point.
                let weight = |d: i32, f: f32| {
                    if d == -REACH {
                        1.0 - f
                    } else if d == REACH + 1 {
                        f
                    } else {
                        1.0
                    }
                };
                let depth = self.shadow.depth(left as i32 + dx, top as i32 + dy);
                if depth <= p.z + BIAS {
                    sum += weight(dx, fx) * weight(dy, fy);
                }
            }
        }
        let side = (2 * REACH + 1) as f32;
        sum / (side * side)
    }
}

/// Keeps what is brighter than white from clipping hard.
fn soft(value: f32) -> f32 {
    const KNEE: f32 = 0.75;
    if value < KNEE {
        value
    } else {
        KNEE + (1.0 - KNEE) * (1.0 - (-(value - KNEE) / (1.0 - KNEE)).exp())
    }
}

/// A neutral studio backdrop, sRGB; `x` and `y` run from 0 to 1, `y` downwards.
pub(crate) fn background(x: f32, y: f32) -> [f32; 3] {
    let (dx, dy) = (x - 0.5, y - 0.42);
    let glow = smoothstep(0.85, 0.0, (dx * dx + dy * dy).sqrt());
    [0.66, 0.68, 0.71].map(|value| value + 0.22 * glow)
}
