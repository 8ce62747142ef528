//! Hands and feet of whole bodies.

use glam::DVec3;

use super::landmarks::Face;
use crate::directions::direction;
use crate::easing::smoothstep_f64;

/// A whole body extends at least this far below the eyes, in distances between them. Half a metre,
/// where eyes are 63 mm apart.
const MIN_HEIGHT: f64 = 8.0;
/// Length of a hand and height of the ankle, as fractions of the body's height. R. Drillis and R.
/// Contini, "Body segment parameters", 1966, have 0.108 and 0.039.
const HAND: f64 = 0.103;
const ANKLE: f64 = 0.043;

/// Each point's weights for hands and for feet.
pub(super) fn extremities(face: &Face) -> [Vec<f32>; 2] {
    let at = &face.local.positions;
    let nothing = vec![0.0; at.len()];
    if face.bottom > -MIN_HEIGHT {
        return [nothing.clone(), nothing];
    }
    let height = face.crown.y - face.bottom;
    let hands = hands(face, height).unwrap_or_else(|| nothing.clone());
    [hands, feet(at, face, height).unwrap_or(nothing)]
}

/// Weights of the points beyond the wrist of each arm, within a cylinder around the hand's axis.
fn hands(face: &Face, height: f64) -> Option<Vec<f32>> {
    let at = &face.local.positions;
    let mut values = vec![0.0; at.len()];
    let mut is_any = false;
    for side in [1.0, -1.0] {
        let Some(arm) = Arm::new(at, side, face, height) else { continue };
        is_any = true;
        for (value, &p) in values.iter_mut().zip(at) {
            let along = (arm.tip - p).dot(arm.towards);
            let aside = (arm.tip - p - arm.towards * along).length();
            if p.x * side > 0.0 && aside < 0.09 * height {
                let soft = 0.006 * height;
                *value = smoothstep_f64(arm.length + soft, arm.length - soft, along) as f32;
            }
        }
    }
    is_any.then_some(values)
}

/// The end of an arm, from the wrist to the finger tips.
struct Arm {
    tip: DVec3,
    /// From the forearm to the tip.
    towards: DVec3,
    /// From the tip to the wrist.
    length: f64,
}

impl Arm {
    /// Finds the hand on one side of the body. `None` if it is not wider than the wrist.
    ///
    /// The tip is the body's farthest point to the side and a little downwards; the axis runs
    /// from the forearm's centroid to the hand's. The wrist is the narrowest slice at 6 to 16 %
    /// of the body's height from the tip.
    fn new(at: &[DVec3], side: f64, face: &Face, height: f64) -> Option<Self> {
        // Outwards and a little downwards, which finds the finger tips in T-pose and A-pose alike.
        let out = direction(DVec3::new(side, -0.25, 0.0))?;
        let is_arm = |p: &&DVec3| p.y < face.jaw_bottom.y && p.y > face.bottom + 0.25 * height;
        let tip = *at.iter().filter(is_arm).max_by(|a, b| a.dot(out).total_cmp(&b.dot(out)))?;
        if tip.x * side < 0.14 * height {
            return None;
        }
        let mean = |from: f64, to: f64| {
            let near = |p: &&DVec3| {
                let distance = p.distance(tip);
                p.x * side > 0.0 && (from * height..to * height).contains(&distance)
            };
            let found: Vec<DVec3> = at.iter().filter(near).copied().collect();
            let sum: DVec3 = found.iter().sum();
            (found.len() > 6).then(|| sum / found.len() as f64)
        };
        let towards = direction(mean(0.0, 0.08)? - mean(0.11, 0.2)?)?;
        let tip = at
            .iter()
            .filter(|p| p.distance(tip) < 0.08 * height)
            .max_by(|a, b| a.dot(towards).total_cmp(&b.dot(towards)))
            .copied()?;
        let widths = Self::widths(at, tip, towards, height);
        let wrist = (6..16).min_by(|&a, &b| widths[a].total_cmp(&widths[b]))?;
        let palm = widths[2..wrist].iter().copied();
        if widths[wrist] > 0.85 * palm.fold(0.0, f64::max) || widths[wrist] <= 0.0 {
            return None;
        }
        // Forearms may be as thin as the wrist over a long stretch, so limit hands to a usual
        // length.
        let length = (wrist as f64 + 0.5) * 0.01 * height;
        Some(Self { tip, towards, length: length.clamp(0.9 * HAND * height, 1.12 * HAND * height) })
    }

    /// The radius around its centroid of each slice from the tip; slices are 1 % of the body's
    /// height.
    fn widths(at: &[DVec3], tip: DVec3, towards: DVec3, height: f64) -> [f64; 20] {
        let mut slices: [Vec<DVec3>; 20] = Default::default();
        for &p in at {
            let along = (tip - p).dot(towards) / (0.01 * height);
            let is_near = p.distance(tip) < 0.22 * height;
            if is_near && (0.0..20.0).contains(&along) {
                slices[along as usize].push(p);
            }
        }
        let own = slices.map(|slice| {
            let middle = slice.iter().sum::<DVec3>() / slice.len().max(1) as f64;
            let widths = slice.iter().map(|&p| {
                let offset = p - middle;
                (offset - towards * offset.dot(towards)).length()
            });
            widths.fold(0.0, f64::max)
        });
        // Slices of coarse arms may have points on one side only, so take the maximum with both
        // neighbours.
        std::array::from_fn(|k| {
            own[k.saturating_sub(1)..(k + 2).min(20)].iter().copied().fold(0.0, f64::max)
        })
    }
}

/// Weights of the points below the ankles; `None` unless the mesh ends in two separate legs.
fn feet(at: &[DVec3], face: &Face, height: f64) -> Option<Vec<f32>> {
    let low = |p: &&DVec3| p.y < face.bottom + 0.1 * height;
    let (mut left, mut right, mut middle) = (0, 0, 0);
    for p in at.iter().filter(low) {
        match p.x / height {
            x if x > 0.02 => left += 1,
            x if x < -0.02 => right += 1,
            _ => middle += 1,
        }
    }
    if left < 8 || right < 8 || middle > (left + right) / 4 {
        return None;
    }
    let ankle = face.bottom + ANKLE * height;
    let soft = 0.008 * height;
    Some(at.iter().map(|p| smoothstep_f64(ankle + soft, ankle - soft, p.y) as f32).collect())
}
