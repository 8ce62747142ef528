//! What each of VRM's expressions does, in measures.

use super::measures::Quantity::{self, *};
use crate::rig::ExpressionPreset as Preset;

/// What a change is a part of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Of {
    /// How far lids are apart at rest.
    Gap,
    /// How wide the mouth is at rest, some 50 mm.
    Mouth,
    /// How far the eyes are apart, some 64 mm.
    Eyes,
}

/// Where an expression is: what is elsewhere had better be still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Zone {
    LeftEye,
    RightEye,
    Mouth,
    Brows,
    Face,
}

/// An expression to be found.
#[derive(Debug)]
pub(super) struct Target {
    pub preset: Preset,
    pub zone: Zone,
    /// Whether the jaw may help.
    pub jaw: bool,
    /// By how much quantities change. All others stay as they are.
    pub goals: &'static [(Quantity, f32, Of)],
    /// What may come along.
    pub free: &'static [Quantity],
}

/// What a jaw takes along: lips go back, corners down.
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

/// All expressions but `blink`, which is both of its sides, and those that turn eyes.
///
/// Mouths in speech open by 4 to 20 mm, spread lips are a seventh wider and rounded ones a fifth narrower than at
/// rest; brows rise and fall by 4 to 6 mm.
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
