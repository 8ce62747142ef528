//! Shorts and a top, painted on the skin.

use glam::Vec3;
use uvgraft::easing::smoothstep;
use uvgraft_avatar::paint::bake::Spot;
use uvgraft_avatar::paint::noise::noise;
use uvgraft_avatar::paint::texel::{Color, blend};

use super::{SkinOptions, scaled};

/// Half width of hems, in centimetres.
const HEM: f32 = 0.9;
/// Softness of edges, in centimetres.
const EDGE: f32 = 0.12;

/// The lines that clothes end at, in centimetres.
pub(super) struct Clothes {
    colors: [Color; 2],
    pelvis: Vec3,
    waist: f32,
    knee: f32,
    hip: f32,
    shoulder: Vec3,
    neck: Vec3,
}

impl Clothes {
    pub(super) fn new(joint: &impl Fn(usize) -> Vec3, options: &SkinOptions) -> Self {
        Self {
            colors: options.clothes,
            pelvis: joint(0),
            hip: joint(1).y,
            knee: joint(4).y,
            waist: joint(3).y + 0.35 * (joint(6).y - joint(3).y),
            shoulder: joint(16),
            neck: joint(12),
        }
    }

    /// Paints the clothes over the skin.
    pub(super) fn over(&self, color: Color, spot: &Spot) -> Color {
        let p = spot.position;
        let inside = |distance: f32| smoothstep(-EDGE, EDGE, distance);
        let weave = 1.0 + 0.05 * noise(p * 22.0, 201) + 0.03 * noise(p * 2.0, 202);
        let cloth = |base: Color, distance: f32| {
            let seam = smoothstep(HEM, HEM - 0.1, distance);
            let stitch = smoothstep(0.08, 0.0, (distance - HEM).abs());
            scaled(base, weave * (1.0 - 0.10 * seam - 0.18 * stitch))
        };
        let shorts = self.shorts(p);
        let color = blend(color, cloth(self.colors[1], shorts), inside(shorts));
        let top = self.top(p);
        blend(color, cloth(self.colors[0], top), inside(top))
    }

    /// Distance into the shorts: from the waist to a third of the thighs.
    fn shorts(&self, p: Vec3) -> f32 {
        let hem = self.hip + 0.36 * (self.knee - self.hip);
        // Hands at the ends of horizontal arms are far above.
        (self.waist - p.y).min(p.y - hem)
    }

    /// Distance into the top: without sleeves, with a round neck.
    fn top(&self, p: Vec3) -> f32 {
        let lower = p.y - self.waist;
        let side = 0.86 * self.shoulder.x - p.x.abs();
        // An ellipse around the neck, lower in front.
        let front = smoothstep(self.pelvis.z - 4.0, self.pelvis.z + 8.0, p.z);
        let center = Vec3::new(0.0, self.neck.y + 1.5 - 1.0 * front, self.neck.z);
        let depth = 5.0 + 4.5 * front;
        let across = p.x / 8.6;
        let around = (across * across + ((p.y - center.y) / depth).powi(2)).sqrt();
        let neck = (around - 1.0) * 6.0;
        let above = self.neck.y + 1.5 - p.y;
        lower.min(side).min(neck).min(above)
    }
}
