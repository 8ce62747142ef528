//! The mapping from joints to human bones, and the hierarchy that VRM requires.

use uvgraft_avatar::rig::{HumanBone, Skeleton};

use super::VrmError;
use super::json;

/// The parent of a bone in VRM's hierarchy; if the skeleton lacks it, its parent takes its place.
fn parent(bone: HumanBone) -> Option<HumanBone> {
    use HumanBone as B;
    Some(match bone {
        B::Hips => return None,
        B::Spine | B::LeftUpperLeg => B::Hips,
        B::Chest => B::Spine,
        B::UpperChest => B::Chest,
        B::Neck | B::LeftShoulder => B::UpperChest,
        B::Head => B::Neck,
        B::LeftEye | B::Jaw => B::Head,
        B::LeftLowerLeg => B::LeftUpperLeg,
        B::LeftFoot => B::LeftLowerLeg,
        B::LeftToes => B::LeftFoot,
        B::LeftUpperArm => B::LeftShoulder,
        B::LeftLowerArm => B::LeftUpperArm,
        B::LeftHand => B::LeftLowerArm,
        B::LeftThumbMetacarpal
        | B::LeftIndexProximal
        | B::LeftMiddleProximal
        | B::LeftRingProximal
        | B::LeftLittleProximal => B::LeftHand,
        B::LeftThumbProximal => B::LeftThumbMetacarpal,
        B::LeftThumbDistal => B::LeftThumbProximal,
        B::LeftIndexIntermediate => B::LeftIndexProximal,
        B::LeftIndexDistal => B::LeftIndexIntermediate,
        B::LeftMiddleIntermediate => B::LeftMiddleProximal,
        B::LeftMiddleDistal => B::LeftMiddleIntermediate,
        B::LeftRingIntermediate => B::LeftRingProximal,
        B::LeftRingDistal => B::LeftRingIntermediate,
        B::LeftLittleIntermediate => B::LeftLittleProximal,
        B::LeftLittleDistal => B::LeftLittleIntermediate,
        right => return parent(right.mirrored()).map(HumanBone::mirrored),
    })
}

/// Whether a bone requires its parent: true for the upper chest, and for all finger bones but the
/// first.
fn needs_parent(bone: HumanBone) -> bool {
    let is_further = bone.name().ends_with("Intermediate") || bone.name().ends_with("Distal");
    let is_thumb = matches!(bone, HumanBone::LeftThumbProximal | HumanBone::RightThumbProximal);
    bone == HumanBone::UpperChest || is_further || is_thumb
}

/// Checks that the required bones exist, and that each is a descendant of its nearest existing
/// parent.
pub(super) fn check(skeleton: &Skeleton) -> Result<(), VrmError> {
    let bones = skeleton.missing_bones();
    if !bones.is_empty() {
        return Err(VrmError::MissingBones { bones });
    }
    for &bone in HumanBone::ALL {
        let Some(joint) = skeleton.human(bone) else { continue };
        if let Some(missing) = parent(bone).filter(|&above| skeleton.human(above).is_none())
            && needs_parent(bone)
        {
            return Err(VrmError::Alone { bone, parent: missing });
        }
        let mut above = parent(bone);
        let present = loop {
            let Some(candidate) = above else { break None };
            if let Some(joint) = skeleton.human(candidate) {
                break Some((candidate, joint));
            }
            above = parent(candidate);
        };
        let Some((parent, parent_joint)) = present else { continue };
        let up = |&joint: &usize| skeleton.joints()[joint].parent;
        if !std::iter::successors(up(&joint), up).any(|above| above == parent_joint) {
            return Err(VrmError::Hierarchy { bone, parent });
        }
    }
    Ok(())
}

/// The bones, keyed by VRM's names.
pub(super) fn json(skeleton: &Skeleton) -> json::Humanoid {
    let node = |&bone: &HumanBone| {
        skeleton.human(bone).map(|node| (bone.name(), json::HumanBoneNode { node }))
    };
    json::Humanoid { human_bones: HumanBone::ALL.iter().filter_map(node).collect() }
}

#[cfg(test)]
mod tests {
    use uvgraft_avatar::rig::Joint;

    use super::*;

    /// A skeleton of these bones, each attached to its nearest existing parent.
    fn skeleton(bones: &[HumanBone]) -> Skeleton {
        let mut joints: Vec<Joint> = Vec::new();
        for &bone in bones {
            let mut above = parent(bone);
            let found = loop {
                let Some(candidate) = above else { break None };
                let joint = joints.iter().position(|joint| joint.human == Some(candidate));
                if joint.is_some() {
                    break joint;
                }
                above = parent(candidate);
            };
            let (name, position) = (bone.name().to_owned(), [0.0; 3]);
            let parent = found.or((!joints.is_empty()).then_some(0));
            joints.push(Joint { name, parent, position, human: Some(bone) });
        }
        Skeleton::new(joints).unwrap()
    }

    #[test]
    fn required_bones_suffice() {
        let required: Vec<HumanBone> =
            HumanBone::ALL.iter().copied().filter(|bone| bone.required()).collect();
        check(&skeleton(&required)).unwrap();
        check(&skeleton(HumanBone::ALL)).unwrap();
        assert_eq!(json(&skeleton(HumanBone::ALL)).human_bones.len(), 55);

        let error = check(&skeleton(&required[..required.len() - 2])).unwrap_err();
        let bones = vec![HumanBone::RightLowerArm, HumanBone::RightHand];
        assert_eq!(error, VrmError::MissingBones { bones });
        let text = "the skeleton of a VRM file must have the bones `rightLowerArm`, `rightHand`";
        assert_eq!(error.to_string(), text);

        let with = |bone| [&required[..], &[bone]].concat();
        let error = check(&skeleton(&with(HumanBone::UpperChest))).unwrap_err();
        let (bone, parent) = (HumanBone::UpperChest, HumanBone::Chest);
        assert_eq!(error, VrmError::Alone { bone, parent });
    }

    #[test]
    fn bones_must_be_descendants_of_their_parents() {
        let required = HumanBone::ALL.iter().copied().filter(|bone| bone.required());
        let mut joints = skeleton(&required.collect::<Vec<_>>()).joints().to_vec();
        let foot = joints.iter().position(|joint| joint.human == Some(HumanBone::LeftFoot));
        joints[foot.unwrap()].parent = Some(0);
        let error = check(&Skeleton::new(joints).unwrap()).unwrap_err();
        let (bone, parent) = (HumanBone::LeftFoot, HumanBone::LeftLowerLeg);
        assert_eq!(error, VrmError::Hierarchy { bone, parent });
    }
}
