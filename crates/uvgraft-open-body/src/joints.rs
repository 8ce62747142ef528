//! SMPL-X's joints, and the bones of MakeHuman's default rig that stand for each.

use crate::ImportError;
use crate::base_mesh::BaseMesh;
use crate::rig::{End, Rig};

/// Number of joints.
pub(crate) const COUNT: usize = 55;

pub(crate) const PELVIS: usize = 0;
/// Joints of the left and the right arm and hand.
pub(crate) const SHOULDERS: [usize; 2] = [16, 17];
pub(crate) const ELBOWS: [usize; 2] = [18, 19];
pub(crate) const WRISTS: [usize; 2] = [20, 21];
/// The first of the hands' joints: index, middle, little and ring finger, and thumb, three each.
pub(crate) const HANDS: [usize; 2] = [25, 40];

/// Parents of the joints, in SMPL-X's order.
const PARENTS: [usize; COUNT] = [
    0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 15, 15, 15, 20, 25,
    26, 20, 28, 29, 20, 31, 32, 20, 34, 35, 20, 37, 38, 21, 40, 41, 21, 43, 44, 21, 46, 47, 21, 49,
    50, 21, 52, 53,
];

/// A joint: it lies at the mean of the heads of `starts`, and has the weights of these bones and
/// their descendants, up to those that belong to another joint.
pub(crate) struct JointBones {
    starts: Vec<String>,
}

/// The parent of a joint.
pub(crate) fn parent(joint: usize) -> Option<usize> {
    (joint > 0).then(|| PARENTS[joint])
}

/// The joints in SMPL-X's order.
pub(crate) fn all() -> Vec<JointBones> {
    // Bones whose names end in `.` exist on both sides.
    const TRUNK: [&str; 22] = [
        "pelvis.L",
        "upperleg01.",
        "",
        "spine04",
        "lowerleg01.",
        "",
        "spine03",
        "foot.",
        "",
        "spine01",
        "toes",
        "",
        "neck01",
        "clavicle.",
        "",
        "head",
        "upperarm01.",
        "",
        "lowerarm01.",
        "",
        "wrist.",
        "",
    ];
    let mut joints = Vec::with_capacity(COUNT);
    for bone in TRUNK {
        match bone {
            // The right side of the previous one.
            "" => {}
            "toes" => {
                joints.extend(["L", "R"].map(|side| {
                    (1..=5).map(|toe| format!("toe{toe}-1.{side}")).collect::<Vec<_>>()
                }));
            }
            _ if bone.ends_with('.') => {
                joints.extend(["L", "R"].map(|side| vec![format!("{bone}{side}")]));
            }
            _ => joints.push(vec![bone.to_owned()]),
        }
    }
    joints.extend(["jaw", "eye.L", "eye.R"].map(|bone| vec![bone.to_owned()]));
    for side in ["L", "R"] {
        for finger in [2, 3, 5, 4, 1] {
            joints.extend((1..=3).map(|bone| vec![format!("finger{finger}-{bone}.{side}")]));
        }
    }
    joints.into_iter().map(|starts| JointBones { starts }).collect()
}

/// The joint that each bone with weights follows.
pub(crate) fn of_bone(rig: &Rig, joints: &[JointBones], bone: &str) -> usize {
    let own = |name: &str| joints.iter().position(|joint| joint.starts.iter().any(|b| b == name));
    rig.nearest(bone, own).unwrap_or(PELVIS)
}

/// For each joint, the lists of vertices of the base mesh whose means' mean it is.
pub(crate) fn places(
    rig: &Rig,
    joints: &[JointBones],
    base: &BaseMesh,
) -> Result<Vec<Vec<Vec<u32>>>, ImportError> {
    let place = |joint: &JointBones| {
        joint.starts.iter().map(|bone| rig.end(bone, End::Head, base)).collect()
    };
    joints.iter().map(place).collect()
}

/// The tips of the index, middle, little and ring finger of both hands.
pub(crate) fn finger_tips(rig: &Rig, base: &BaseMesh) -> Result<[[Vec<u32>; 4]; 2], ImportError> {
    let tips = |side: &str| {
        let tip = |finger| rig.end(&format!("finger{finger}-3.{side}"), End::Tail, base);
        Ok::<_, ImportError>([tip(2)?, tip(3)?, tip(5)?, tip(4)?])
    };
    Ok([tips("L")?, tips("R")?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_are_those_of_smplx() {
        let joints = all();
        assert_eq!(joints.len(), COUNT);
        let bone = |joint: usize| joints[joint].starts[0].as_str();
        for (joint, wanted) in [
            (0, "pelvis.L"),
            (1, "upperleg01.L"),
            (2, "upperleg01.R"),
            (9, "spine01"),
            (11, "toe1-1.R"),
            (15, "head"),
            (SHOULDERS[0], "upperarm01.L"),
            (WRISTS[1], "wrist.R"),
            (22, "jaw"),
            (24, "eye.R"),
            (HANDS[0], "finger2-1.L"),
            (HANDS[1] + 14, "finger1-3.R"),
        ] {
            assert_eq!(bone(joint), wanted);
        }
        assert!((1..COUNT).all(|joint| parent(joint).unwrap() < joint));
        assert_eq!((parent(0), parent(HANDS[1] + 1)), (None, Some(HANDS[1])));
    }
}
