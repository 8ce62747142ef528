//! VRM's presets, made of ARKit's blend shapes.

use super::super::Face;
use super::super::measures::Quantity;
use super::super::measures::{row, value};
use super::super::targets::{Of, TARGETS, Target};
use crate::Avatar;
use crate::rig::{Expression, ExpressionPreset as Preset, Morph};

/// A preset, and the blend shapes that make it. Those with a single side stand for it, the others are
/// for both: `Both` is replaced by `Left` and `Right`.
type Recipe = (Preset, &'static [(&'static str, f32)]);

const RECIPES: [Recipe; 17] = [
    (Preset::BlinkLeft, &[("eyeBlinkLeft", 1.0)]),
    (Preset::BlinkRight, &[("eyeBlinkRight", 1.0)]),
    (Preset::Blink, &[("eyeBlinkBoth", 1.0)]),
    (Preset::Aa, &[("jawOpen", 0.6)]),
    (Preset::Ih, &[("jawOpen", 0.2), ("mouthStretchBoth", 0.4)]),
    (Preset::Ou, &[("mouthPucker", 0.8), ("mouthFunnel", 0.25), ("jawOpen", 0.05)]),
    (
        Preset::Ee,
        &[
            ("mouthStretchBoth", 0.6),
            ("mouthSmileBoth", 0.25),
            ("mouthLowerDownBoth", 0.5),
            ("mouthUpperUpBoth", 0.3),
        ],
    ),
    (Preset::Oh, &[("jawOpen", 0.35), ("mouthFunnel", 0.5), ("mouthPucker", 0.25)]),
    (Preset::Happy, &[("mouthSmileBoth", 0.7), ("cheekSquintBoth", 0.4), ("eyeSquintBoth", 0.2)]),
    (Preset::Angry, &[("browDownBoth", 0.9), ("noseSneerBoth", 0.3), ("mouthPressBoth", 0.3)]),
    (Preset::Sad, &[("browInnerUp", 0.9), ("mouthFrownBoth", 0.8)]),
    (Preset::Relaxed, &[("mouthSmileBoth", 0.3), ("eyeSquintBoth", 0.2)]),
    (
        Preset::Surprised,
        &[("browInnerUp", 0.8), ("browOuterUpBoth", 0.8), ("eyeWideBoth", 0.6), ("jawOpen", 0.25)],
    ),
    (Preset::LookUp, &[("eyeLookUpBoth", 1.0)]),
    (Preset::LookDown, &[("eyeLookDownBoth", 1.0)]),
    (Preset::LookLeft, &[("eyeLookOutLeft", 1.0), ("eyeLookInRight", 1.0)]),
    (Preset::LookRight, &[("eyeLookInLeft", 1.0), ("eyeLookOutRight", 1.0)]),
];

/// The result of adding named expressions to an avatar.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AddedExpressions {
    /// How many morph targets, each of them a custom expression, were added.
    pub named: usize,
    /// Presets that were made of them, because the avatar had none.
    pub presets: Vec<Preset>,
    /// Morphs that were left out, because the avatar has a morph or an expression of the name.
    pub taken: Vec<String>,
}

/// Adds named morphs to an avatar, each with an expression of its name, and the presets of VRM that
/// the avatar lacks and that the morphs can make: all but `neutral` if they have ARKit's names.
///
/// Presets are as strong as the solved ones of body models: a mixture is scaled so that lids, lips
/// and brows move as far as they should, if the face can be measured.
///
/// # Panics
/// If a morph moves a vertex that the avatar's mesh does not have.
pub fn add_named(avatar: &mut Avatar, morphs: Vec<Morph>) -> AddedExpressions {
    let mut added = AddedExpressions::default();
    let face = Face::find(&avatar.mesh).ok();
    for morph in morphs {
        let is_taken = avatar.morphs.iter().any(|other| other.name == morph.name)
            || avatar.expressions.iter().any(|other| other.name == morph.name);
        if is_taken {
            added.taken.push(morph.name);
            continue;
        }
        let number = avatar.morphs.len();
        let name = morph.name.clone();
        avatar.expressions.push(Expression { name, preset: None, morphs: vec![(number, 1.0)] });
        avatar.morphs.push(morph);
        added.named += 1;
    }
    for (preset, recipe) in RECIPES {
        if avatar.expressions.iter().any(|expression| expression.preset == Some(preset)) {
            continue;
        }
        let Some(mut mixture) = mixture(&avatar.morphs, recipe) else { continue };
        let target = TARGETS.iter().find(|target| target.preset == preset);
        // Closed lids are closed, and eyes look as far as they look.
        let target = target.filter(|_| !matches!(preset, Preset::BlinkLeft | Preset::BlinkRight));
        if let Some((face, target)) = face.as_ref().zip(target) {
            let scale = scale(face, avatar, target, &mixture);
            mixture.iter_mut().for_each(|(_, weight)| *weight *= scale);
        }
        avatar.expressions.push(Expression::preset(preset, mixture));
        added.presets.push(preset);
    }
    added
}

/// The numbers of a recipe's morphs, and their weights; `None` if one is missing.
fn mixture(morphs: &[Morph], recipe: &[(&str, f32)]) -> Option<Vec<(usize, f32)>> {
    let mut mixture = Vec::new();
    for &(name, weight) in recipe {
        let names = match name.strip_suffix("Both") {
            Some(stem) => vec![format!("{stem}Left"), format!("{stem}Right")],
            None => vec![name.to_owned()],
        };
        for name in names {
            mixture.push((morphs.iter().position(|morph| morph.name == name)?, weight));
        }
    }
    Some(mixture)
}

/// The factor at which a mixture comes closest to the goals of a preset, within the range of the
/// morphs' weights.
fn scale(face: &Face, avatar: &Avatar, target: &Target, mixture: &[(usize, f32)]) -> f32 {
    const LEAST: f32 = 0.4;
    let mut offsets = vec![[0.0; 3]; avatar.mesh.positions().len()];
    for &(morph, weight) in mixture {
        avatar.morphs[morph].add(weight, &mut offsets);
    }
    let rest = face.measure(avatar.mesh.positions());
    let unit = face.frame.unit as f32;
    let (mut reached, mut moved) = (0.0, 0.0);
    for &(quantity, share, of) in target.goals {
        let whole = match (of, quantity) {
            (Of::Gap, Quantity::LidGap(side)) => rest.lid_gap[side],
            (Of::Mouth, _) => face.mouth_width * unit,
            _ => unit,
        };
        let found = value(&row(face, quantity), &offsets);
        reached += found * share * whole;
        moved += found * found;
    }
    let most = mixture.iter().map(|&(_, weight)| weight.recip()).fold(f32::INFINITY, f32::min);
    if moved > 0.0 { (reached / moved).clamp(LEAST, most.max(LEAST)) } else { 1.0 }
}
