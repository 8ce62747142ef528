//! Expressions of models whose components have ARKit's names: each is a morph target and a custom
//! expression, and VRM's presets are combinations of them.

use super::Shaped;
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

impl Shaped<'_> {
    /// Whether the model's components are expressions by name.
    pub fn has_named_expressions(&self) -> bool {
        !self.model.expression_names().is_empty()
    }

    /// The named expressions of the model as morph targets; none if its components have no names.
    pub fn named_expressions(&self) -> Vec<Morph> {
        let names = self.model.expression_names().iter().enumerate();
        names.map(|(at, name)| Morph::from_dense(name, self.model.expression(at))).collect()
    }

    /// Adds the named expressions to an avatar, each as a morph target and as a custom expression,
    /// and the presets that can be made of them.
    pub(super) fn add_named_expressions(&self, avatar: &mut Avatar) {
        let first = avatar.morphs.len();
        avatar.morphs.extend(self.named_expressions());
        let number = |name: &str| {
            let names = self.model.expression_names();
            names.iter().position(|found| found == name).map(|at| first + at)
        };
        for (preset, parts) in PRESETS {
            let parts = parts.iter().map(|&(name, weight)| sides(name, weight, &number));
            if let Some(parts) = parts.collect::<Option<Vec<_>>>() {
                avatar.expressions.push(Expression::preset(preset, parts.concat()));
            }
        }
        for (at, name) in (first..).zip(self.model.expression_names()) {
            let (name, morphs) = (name.clone(), vec![(at, 1.0)]);
            avatar.expressions.push(Expression { name, preset: None, morphs });
        }
    }
}

/// The morphs of a name, with their weights; `None` if one is missing.
fn sides(
    name: &str,
    weight: f32,
    number: &impl Fn(&str) -> Option<usize>,
) -> Option<Vec<(usize, f32)>> {
    let Some(stem) = name.strip_suffix('*') else {
        return number(name).map(|at| vec![(at, weight)]);
    };
    let sides = ["Left", "Right"].map(|side| number(&format!("{stem}{side}")));
    sides.into_iter().map(|at| Some((at?, weight))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_both_sides() {
        let names = ["jawOpen", "eyeBlinkLeft", "eyeBlinkRight", "mouthSmileLeft"];
        let number = |name: &str| names.iter().position(|found| *found == name);
        assert_eq!(sides("jawOpen", 0.5, &number), Some(vec![(0, 0.5)]));
        assert_eq!(sides("eyeBlink*", 1.0, &number), Some(vec![(1, 1.0), (2, 1.0)]));
        assert_eq!(sides("mouthSmile*", 1.0, &number), None);
    }
}
