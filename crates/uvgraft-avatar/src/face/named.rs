//! Expressions by name: each is a morph target and a custom expression, and VRM's presets are
//! combinations of them if they have ARKit's names.

use super::Face;
use super::measures::{Quantity, row, value};
use super::targets::{Of, TARGETS, Target};
use crate::Avatar;
use crate::rig::{Expression, ExpressionPreset as Preset, Morph};

/// VRM's presets by ARKit's blend shapes. Names that end in `*` stand for both sides. Weights leave
/// room for a mouth that speaks and eyes that blink at the same time.
const PRESETS: [(Preset, &[(&str, f32)]); 17] = [
    (
        Preset::Happy,
        &[("mouthSmile*", 0.8), ("cheekSquint*", 0.5), ("eyeSquint*", 0.3), ("mouthDimple*", 0.2)],
    ),
    (
        Preset::Angry,
        &[
            ("browDown*", 1.0),
            ("eyeSquint*", 0.4),
            ("noseSneer*", 0.5),
            ("mouthPress*", 0.5),
            ("mouthFrown*", 0.4),
        ],
    ),
    (
        Preset::Sad,
        &[
            ("browInnerUp", 0.9),
            ("mouthFrown*", 0.8),
            ("mouthShrugLower", 0.4),
            ("eyeSquint*", 0.2),
        ],
    ),
    (Preset::Relaxed, &[("mouthSmile*", 0.35), ("eyeBlink*", 0.25), ("browInnerUp", 0.15)]),
    (
        Preset::Surprised,
        &[("browInnerUp", 0.8), ("browOuterUp*", 0.8), ("eyeWide*", 0.8), ("jawOpen", 0.35)],
    ),
    (Preset::Aa, &[("jawOpen", 0.7), ("mouthUpperUp*", 0.15), ("mouthLowerDown*", 0.2)]),
    (Preset::Ih, &[("jawOpen", 0.25), ("mouthStretch*", 0.4), ("mouthLowerDown*", 0.25)]),
    (Preset::Ou, &[("jawOpen", 0.15), ("mouthPucker", 0.7), ("mouthFunnel", 0.3)]),
    (Preset::Ee, &[("jawOpen", 0.15), ("mouthSmile*", 0.4), ("mouthStretch*", 0.5)]),
    (Preset::Oh, &[("jawOpen", 0.45), ("mouthFunnel", 0.6)]),
    (Preset::BlinkLeft, &[("eyeBlinkLeft", 1.0)]),
    (Preset::BlinkRight, &[("eyeBlinkRight", 1.0)]),
    (Preset::Blink, &[("eyeBlink*", 1.0)]),
    (Preset::LookUp, &[("eyeLookUp*", 1.0)]),
    (Preset::LookDown, &[("eyeLookDown*", 1.0)]),
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
    for (preset, recipe) in PRESETS {
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

/// The numbers of a recipe's morphs, and their weights; `None` if one of the strongest is missing.
fn mixture(morphs: &[Morph], recipe: &[(&str, f32)]) -> Option<Vec<(usize, f32)>> {
    let strongest = recipe.iter().map(|&(_, weight)| weight).fold(0.0, f32::max);
    let mut mixture = Vec::new();
    for &(name, weight) in recipe {
        let names = match name.strip_suffix('*') {
            Some(stem) => vec![format!("{stem}Left"), format!("{stem}Right")],
            None => vec![name.to_owned()],
        };
        for name in names {
            match morphs.iter().position(|morph| morph.name == name) {
                Some(number) => mixture.push((number, weight)),
                None if weight == strongest => return None,
                None => {}
            }
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

#[cfg(test)]
#[path = "named_tests.rs"]
mod tests;
