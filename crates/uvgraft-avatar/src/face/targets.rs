//! The goals of VRM's expressions, in terms of measurements.

use super::measures::Quantity::{self, *};
use crate::rig::ExpressionPreset as Preset;

/// The length that a change is relative to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Of {
    /// The distance between the lids at rest.
    Gap,
    /// The width of the mouth at rest, about 50 mm.
    Mouth,
    /// The distance between the eyes, about 64 mm.
    Eyes,
}

/// The zone of an expression; the skin elsewhere should not move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Zone {
    LeftEye,
    RightEye,
    Mouth,
    Brows,
    Face,
}

/// An expression to be solved for.
#[derive(Debug)]
pub(super) struct Target {
    pub preset: Preset,
    pub zone: Zone,
    /// Whether the jaw may contribute.
    pub jaw: bool,
    /// Changes of quantities. All others should stay unchanged.
    pub goals: &'static [(Quantity, f32, Of)],
    /// Quantities that may change freely.
    pub free: &'static [Quantity],
}

/// Quantities that change with the jaw: lips move back, corners down.
const WITH_JAW: &[Quantity] = &[LipDepth, CornerHeight(0), CornerHeight(1)];

const fn target(
    preset: Preset,
    zone: Zone,
    goals: &'static [(Quantity, f32, Of)],
    free: &'static [Quantity],
) -> Target {
    Target { preset, zone, jaw: false, goals, free }
}

const fn with_jaw(
    preset: Preset,
    zone: Zone,
    goals: &'static [(Quantity, f32, Of)],
    free: &'static [Quantity],
) -> Target {
    Target { preset, zone, jaw: true, goals, free }
}

/// All expressions except `blink`, which is both of its sides, and the gaze directions.
///
/// In speech, mouths open by 4 to 20 mm, spread lips are a seventh wider and rounded ones a fifth
/// narrower than at rest; brows rise and fall by 4 to 6 mm.
pub(super) const TARGETS: [Target; 12] = [
    target(Preset::BlinkLeft, Zone::LeftEye, &[(LidGap(0), -1.0, Of::Gap)], &[]),
    target(Preset::BlinkRight, Zone::RightEye, &[(LidGap(1), -1.0, Of::Gap)], &[]),
    with_jaw(
        Preset::Aa,
        Zone::Mouth,
        &[(LipOpening, 0.38, Of::Mouth), (MouthWidth, -0.03, Of::Mouth)],
        WITH_JAW,
    ),
    with_jaw(
        Preset::Ih,
        Zone::Mouth,
        &[(LipOpening, 0.14, Of::Mouth), (MouthWidth, 0.07, Of::Mouth)],
        WITH_JAW,
    ),
    with_jaw(
        Preset::Ou,
        Zone::Mouth,
        &[
            (MouthWidth, -0.22, Of::Mouth),
            (LipDepth, 0.1, Of::Mouth),
            (LipOpening, 0.08, Of::Mouth),
        ],
        &[],
    ),
    with_jaw(
        Preset::Ee,
        Zone::Mouth,
        &[(MouthWidth, 0.15, Of::Mouth), (LipOpening, 0.07, Of::Mouth)],
        &[LipDepth],
    ),
    with_jaw(
        Preset::Oh,
        Zone::Mouth,
        &[(LipOpening, 0.25, Of::Mouth), (MouthWidth, -0.14, Of::Mouth)],
        WITH_JAW,
    ),
    target(
        Preset::Happy,
        Zone::Mouth,
        &[
            (CornerHeight(0), 0.11, Of::Mouth),
            (CornerHeight(1), 0.11, Of::Mouth),
            (MouthWidth, 0.16, Of::Mouth),
        ],
        &[LipDepth],
    ),
    target(
        Preset::Angry,
        Zone::Brows,
        &[
            (InnerBrow(0), -0.07, Of::Eyes),
            (InnerBrow(1), -0.07, Of::Eyes),
            (BrowDistance, -0.04, Of::Eyes),
        ],
        &[OuterBrow(0), OuterBrow(1)],
    ),
    target(
        Preset::Sad,
        Zone::Face,
        &[
            (CornerHeight(0), -0.08, Of::Mouth),
            (CornerHeight(1), -0.08, Of::Mouth),
            (InnerBrow(0), 0.07, Of::Eyes),
            (InnerBrow(1), 0.07, Of::Eyes),
        ],
        &[OuterBrow(0), OuterBrow(1), LipDepth],
    ),
    target(
        Preset::Relaxed,
        Zone::Mouth,
        &[
            (CornerHeight(0), 0.05, Of::Mouth),
            (CornerHeight(1), 0.05, Of::Mouth),
            (MouthWidth, 0.07, Of::Mouth),
        ],
        &[LipDepth],
    ),
    with_jaw(
        Preset::Surprised,
        Zone::Face,
        &[
            (InnerBrow(0), 0.08, Of::Eyes),
            (InnerBrow(1), 0.08, Of::Eyes),
            (OuterBrow(0), 0.08, Of::Eyes),
            (OuterBrow(1), 0.08, Of::Eyes),
            (LidGap(0), 0.18, Of::Gap),
            (LidGap(1), 0.18, Of::Gap),
            (LipOpening, 0.18, Of::Mouth),
        ],
        WITH_JAW,
    ),
];
