//! Poses by name for humanoids of any skeleton: not angles, which mean something else in each, but
//! where bones point to.

use glam::{Quat, Vec3, vec3};

use super::transform::between;

/// A pose of the whole body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stance {
    /// As the file has it, or as its clip moves it.
    #[default]
    Rest,
    /// Arms straight out to the sides.
    TPose,
    /// Arms halfway down.
    APose,
    /// Arms at ease beside the body.
    Stand,
    /// The right hand is raised, the left arm at ease.
    Wave,
    /// A stride.
    Walk,
}

/// A bone that points somewhere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub bone: &'static str,
    /// What it points with: the bone that starts at its end.
    pub tip: &'static str,
    /// Whether skeletons may lack it.
    pub optional: bool,
    towards: Vec3,
}

impl Aim {
    /// How the bone turns about the world's axes, as they are carried along.
    ///
    /// - `carried`: how its parents have turned it.
    /// - `rest`: where it pointed before.
    pub fn turn(&self, carried: Quat, rest: Vec3) -> Quat {
        let whole = between(carried * rest, self.towards) * carried;
        carried.inverse() * whole
    }
}

impl Stance {
    /// All of them, in the order in which messages list them.
    pub const ALL: [Self; 6] =
        [Self::Rest, Self::TPose, Self::APose, Self::Stand, Self::Wave, Self::Walk];

    /// What it is called.
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

    /// The pose of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|stance| stance.name().eq_ignore_ascii_case(name))
    }

    /// Where it wants bones to point, parents before their children. Directions have +X to the
    /// person's left, Y up and +Z ahead.
    pub(super) fn aims(self) -> Vec<Aim> {
        // Of the left side; the right one's is mirrored.
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

type Names = &'static str;

fn sided(
    right: bool,
    (bone, tip, other_bone, other_tip, towards, optional): (Names, Names, Names, Names, Vec3, bool),
) -> Aim {
    if right {
        Aim { bone: other_bone, tip: other_tip, optional, towards: towards.with_x(-towards.x) }
    } else {
        Aim { bone, tip, optional, towards }
    }
}
