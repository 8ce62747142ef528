//! Joints and their hierarchy.

use std::collections::HashSet;

use glam::{Quat, Vec3};

use super::{HumanBone, Pose, RigError, Rigid};

/// A joint at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique among the joints.
    pub name: String,
    /// Index of the parent joint; only the first joint has none.
    pub parent: Option<usize>,
    /// World position at rest, in metres.
    pub position: [f32; 3],
    /// The humanoid bone that starts here.
    pub human: Option<HumanBone>,
}

/// Joints, parents before their children and the root first.
#[derive(Debug, Clone, PartialEq)]
pub struct Skeleton {
    joints: Vec<Joint>,
}

impl Skeleton {
    /// # Errors
    /// [`RigError`] unless the first joint is the only one without a parent, parents come before
    /// their children, names and bones are unique, and positions are finite.
    pub fn new(joints: Vec<Joint>) -> Result<Self, RigError> {
        if joints.is_empty() || joints.len() > usize::from(u16::MAX) {
            return Err(RigError::JointCount { found: joints.len() });
        }
        let (mut names, mut bones) = (HashSet::new(), HashSet::new());
        for (index, joint) in joints.iter().enumerate() {
            let is_ordered = match joint.parent {
                None => index == 0,
                Some(parent) => parent < index,
            };
            if !is_ordered {
                return Err(RigError::Parent { joint: index, name: joint.name.clone() });
            }
            if !names.insert(&joint.name) {
                return Err(RigError::JointName { name: joint.name.clone() });
            }
            if let Some(bone) = joint.human.filter(|&bone| !bones.insert(bone)) {
                return Err(RigError::Bone { bone: bone.name() });
            }
            if !joint.position.iter().all(|value| value.is_finite()) {
                let what = format!("the position of joint `{}`", joint.name);
                return Err(RigError::NotFinite { what });
            }
        }
        Ok(Self { joints })
    }

    /// Its joints.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Index of the joint with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Index of the joint for this bone.
    pub fn human(&self, bone: HumanBone) -> Option<usize> {
        self.joints.iter().position(|joint| joint.human == Some(bone))
    }

    /// The bones required in a VRM file that no joint stands for.
    pub fn missing_bones(&self) -> Vec<HumanBone> {
        let missing = |bone: &HumanBone| bone.required() && self.human(*bone).is_none();
        HumanBone::ALL.iter().copied().filter(missing).collect()
    }

    /// The rigid motion of each joint in a pose, in world coordinates: it maps points
    /// fixed to the joint from rest to the pose.
    ///
    /// # Errors
    /// See [`Pose::check`].
    pub fn motions(&self, pose: &Pose) -> Result<Vec<Rigid>, RigError> {
        pose.check(self.joints.len())?;
        let joints = self.joints.iter().zip(&pose.rotations).map(|(joint, &rotation)| {
            (joint.parent, joint.position.into(), Quat::from_array(rotation).normalize())
        });
        let world = posed_joints(joints, pose.translation.into());
        let motion = |(joint, &(rotation, place)): (&Joint, &(Quat, Vec3))| Rigid {
            rotation: rotation.into(),
            translation: (place - rotation * Vec3::from(joint.position)).into(),
        };
        Ok(self.joints.iter().zip(&world).map(motion).collect())
    }
}

/// The rotation and the position of joints in the world, accumulated from the root.
///
/// - `joints`: each one's parent, position at rest, and rotation.
/// - `translation`: how far the root is moved.
pub(crate) fn posed_joints(
    joints: impl ExactSizeIterator<Item = (Option<usize>, Vec3, Quat)>,
    translation: Vec3,
) -> Vec<(Quat, Vec3)> {
    let mut rests: Vec<Vec3> = Vec::with_capacity(joints.len());
    let mut world: Vec<(Quat, Vec3)> = Vec::with_capacity(joints.len());
    for (parent, rest, rotation) in joints {
        world.push(match parent {
            None => (rotation, rest + translation),
            Some(parent) => {
                let (turned, place) = world[parent];
                ((turned * rotation).normalize(), place + turned * (rest - rests[parent]))
            }
        });
        rests.push(rest);
    }
    world
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use super::*;

    fn joint(name: &str, parent: Option<usize>, position: [f32; 3]) -> Joint {
        Joint { name: name.to_owned(), parent, position, human: None }
    }

    /// Up, and then towards the left.
    fn arm() -> Skeleton {
        Skeleton::new(vec![
            joint("root", None, [0.0, 0.0, 0.0]),
            joint("shoulder", Some(0), [0.0, 1.0, 0.0]),
            joint("elbow", Some(1), [1.0, 1.0, 0.0]),
        ])
        .unwrap()
    }

    #[test]
    fn joints_rotate_their_descendants() {
        let quarter = [0.0, 0.0, FRAC_PI_2];
        let turns = [[0.0; 3], quarter, quarter];
        let pose = Pose::from_axis_angles([0.0, 0.0, 5.0], &turns);
        let motions = arm().motions(&pose).unwrap();
        let close = |found: [f32; 3], wanted: [f32; 3]| {
            assert!(Vec3::from(found).abs_diff_eq(wanted.into(), 1e-6), "{found:?} {wanted:?}");
        };
        close(motions[0].point([0.0, 0.5, 0.0]), [0.0, 0.5, 5.0]);
        // The upper arm points up, the lower arm to the right.
        close(motions[1].point([1.0, 1.0, 0.0]), [0.0, 2.0, 5.0]);
        close(motions[2].point([2.0, 1.0, 0.0]), [-1.0, 2.0, 5.0]);
    }

    #[test]
    fn at_rest_nothing_moves() {
        for motion in arm().motions(&Pose::rest(3)).unwrap() {
            assert_eq!(motion.point([0.3, 0.4, 0.5]), [0.3, 0.4, 0.5]);
        }
    }

    #[test]
    fn invalid_skeletons_are_refused() {
        let root = joint("a", None, [0.0; 3]);
        let refused = |joints: &[Joint]| Skeleton::new(joints.to_vec()).unwrap_err();
        assert_eq!(refused(&[]), RigError::JointCount { found: 0 });
        assert!(matches!(
            refused(&[root.clone(), joint("b", None, [0.0; 3])]),
            RigError::Parent { joint: 1, .. }
        ));
        assert!(matches!(
            refused(&[root.clone(), joint("b", Some(1), [0.0; 3])]),
            RigError::Parent { joint: 1, .. }
        ));
        assert!(matches!(
            refused(&[root.clone(), joint("a", Some(0), [0.0; 3])]),
            RigError::JointName { .. }
        ));
        assert!(matches!(
            refused(&[root, joint("b", Some(0), [f32::NAN, 0.0, 0.0])]),
            RigError::NotFinite { .. }
        ));
        let mut pose = Pose::rest(3);
        pose.rotations[1] = [f32::NAN; 4];
        assert!(matches!(arm().motions(&pose), Err(RigError::NotFinite { .. })));
        assert!(matches!(arm().motions(&Pose::rest(2)), Err(RigError::Count { .. })));
    }
}
