//! Named poses for humanoids of any skeleton, defined by the directions of bones rather than by
//! angles, whose meaning differs between skeletons.

use glam::{Quat, Vec3, vec3};

use super::transform::between;

/// A named pose of the whole body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NamedPose {
    /// The file's rest pose, or the pose of its clip.
    #[default]
    Rest,
    /// Arms straight out to the sides.
    TPose,
    /// Arms at 45° downwards.
    APose,
    /// Arms relaxed at the sides.
    Stand,
    /// The right hand raised to wave, the left arm relaxed.
    Wave,
    /// A walking stride.
    Walk,
}

/// A target direction for a bone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub bone: &'static str,
    /// The bone whose joint it points at: the next one in the chain.
    pub tip: &'static str,
    /// Whether skeletons may lack it.
    pub optional: bool,
    towards: Vec3,
}

impl Aim {
    /// The bone's rotation about the world's axes, as rotated by its parents:
    /// `inherited⁻¹ · arc(inherited · rest, towards) · inherited`.
    ///
    /// - `inherited`: the rotation applied by its parents.
    /// - `rest`: its direction at rest.
    pub fn turn(&self, inherited: Quat, rest: Vec3) -> Quat {
        let total = between(inherited * rest, self.towards) * inherited;
        inherited.inverse() * total
    }
}

impl NamedPose {
    /// All poses, in the order in which messages list them.
    pub const ALL: [Self; 6] =
        [Self::Rest, Self::TPose, Self::APose, Self::Stand, Self::Wave, Self::Walk];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::TPose => "t-pose",
            Self::APose => "a-pose",
            Self::Stand => "stand",
            Self::Wave => "wave",
            Self::Walk => "walk",
        }
    }

    /// The pose with this name, ignoring case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|stance| stance.name().eq_ignore_ascii_case(name))
    }

    /// The target directions of bones, parents before their children. +X is to the person's left, Y
    /// up, +Z ahead.
    pub(super) fn aims(self) -> Vec<Aim> {
        // Directions of the left side; those of the right side are mirrored.
        let ease = [vec3(0.27, -0.96, 0.02), vec3(0.16, -0.96, 0.2), vec3(0.1, -0.98, 0.16)];
        match self {
            Self::Rest => Vec::new(),
            Self::TPose => both(arm, [vec3(1.0, 0.0, 0.0); 3]),
            Self::APose => both(arm, [vec3(0.7, -0.7, 0.0); 3]),
            Self::Stand => both(arm, ease),
            Self::Wave => {
                let raised =
                    [vec3(0.86, -0.42, 0.28), vec3(0.34, 0.88, 0.3), vec3(0.1, 0.98, 0.12)];
                [arm(false, ease), arm(true, raised)].concat()
            }
            Self::Walk => {
                let back =
                    [vec3(0.22, -0.92, -0.34), vec3(0.14, -0.98, 0.04), vec3(0.08, -1.0, 0.0)];
                let ahead = [vec3(0.2, -0.93, 0.3), vec3(0.06, -0.8, 0.6), vec3(0.0, -0.84, 0.54)];
                let step = [vec3(0.02, -0.9, 0.42), vec3(0.02, -0.98, -0.1)];
                let push = [vec3(0.03, -0.97, -0.22), vec3(0.02, -0.84, -0.54)];
                [arm(false, back), arm(true, ahead), leg(false, step), leg(true, push)].concat()
            }
        }
    }
}

fn both(limb: fn(bool, [Vec3; 3]) -> Vec<Aim>, towards: [Vec3; 3]) -> Vec<Aim> {
    [limb(false, towards), limb(true, towards)].concat()
}

fn arm(right: bool, [upper, lower, hand]: [Vec3; 3]) -> Vec<Aim> {
    let aims = [
        ("leftUpperArm", "leftLowerArm", "rightUpperArm", "rightLowerArm", upper, false),
        ("leftLowerArm", "leftHand", "rightLowerArm", "rightHand", lower, false),
        ("leftHand", "leftMiddleProximal", "rightHand", "rightMiddleProximal", hand, true),
    ];
    aims.map(|aim| sided(right, aim)).to_vec()
}

fn leg(right: bool, [upper, lower]: [Vec3; 2]) -> Vec<Aim> {
    let aims = [
        ("leftUpperLeg", "leftLowerLeg", "rightUpperLeg", "rightLowerLeg", upper, false),
        ("leftLowerLeg", "leftFoot", "rightLowerLeg", "rightFoot", lower, false),
    ];
    aims.map(|aim| sided(right, aim)).to_vec()
}

type Name = &'static str;

fn sided(
    right: bool,
    (bone, tip, other_bone, other_tip, towards, optional): (Name, Name, Name, Name, Vec3, bool),
) -> Aim {
    if right {
        Aim { bone: other_bone, tip: other_tip, optional, towards: towards.with_x(-towards.x) }
    } else {
        Aim { bone, tip, optional, towards }
    }
}
