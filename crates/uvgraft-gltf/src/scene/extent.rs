//! The extent of a bone or a node, for framing a camera.

use std::collections::{HashMap, HashSet};

use super::{PoseRequest, PoseRequestError, Scene};

/// Bones that start a separate body part, by VRM name; `left` stands for both sides. Other bones,
/// such as fingers and eyes, belong to the part of their parent.
const PARTS: [&str; 13] = [
    "hips",
    "spine",
    "chest",
    "upperChest",
    "neck",
    "head",
    "leftShoulder",
    "leftUpperArm",
    "leftLowerArm",
    "leftHand",
    "leftUpperLeg",
    "leftLowerLeg",
    "leftFoot",
];

/// The extent of a bone or a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Extent {
    /// Position of its joint.
    pub joint: [f32; 3],
    /// The vertices that follow mostly the joint or its descendants, up to the next body part.
    pub points: Vec<[f32; 3]>,
}

impl Scene {
    /// The extent of a bone (by VRM name) or a node in a pose.
    ///
    /// A vertex belongs to it if more than half of its skin weight is on the joint and its
    /// descendants within the same body part.
    ///
    /// # Errors
    /// As [`Scene::pose`]; also if the name is unknown.
    pub fn extent(&self, name: &str, posing: &PoseRequest) -> Result<Extent, PoseRequestError> {
        let target = self.bone_or_node(name)?;
        let own = self.part(target);
        let drawn = self.pose(posing)?;
        let mut pieces = drawn.iter();
        let (mut points, mut of_skins) = (Vec::new(), HashMap::new());
        for &index in &self.shown {
            let node = &self.nodes[index];
            let Some(mesh) = node.mesh else { continue };
            let own_joints = |skin: usize| -> Vec<bool> {
                self.skins[skin].joints.iter().map(|&joint| own[joint]).collect()
            };
            let is_own =
                node.skin.map(|skin| &*of_skins.entry(skin).or_insert_with(|| own_joints(skin)));
            let primitives = &self.meshes[mesh].primitives;
            let all = node.instances().iter().flat_map(|_| primitives);
            for (primitive, piece) in all.zip(&mut pieces) {
                let moved = |vertex: usize| match (is_own, &primitive.influences) {
                    (Some(is_own), Some(influences)) => {
                        let entries = influences.of(vertex).iter();
                        let share: f32 = entries
                            .filter(|entry| is_own.get(usize::from(entry.0)) == Some(&true))
                            .map(|entry| entry.1)
                            .sum();
                        share > 0.5
                    }
                    _ => own[index],
                };
                let corners = piece.triangles.iter().flatten().map(|&vertex| vertex as usize);
                points.extend(
                    corners.filter(|&vertex| moved(vertex)).map(|vertex| piece.positions[vertex]),
                );
            }
        }
        let joint = self.position(target, posing)?;
        Ok(Extent { joint, points })
    }

    /// Mask of a node and its descendants; for a bone, without those in other body parts.
    fn part(&self, target: usize) -> Vec<bool> {
        let names =
            PARTS.iter().flat_map(|name| [(*name).to_owned(), name.replace("left", "right")]);
        let starts: HashSet<usize> =
            names.filter_map(|name| self.bones.get(&name).copied()).collect();
        let is_bone = self.bones.values().any(|&node| node == target);
        let mut own = vec![false; self.nodes.len()];
        for &node in &self.order {
            let above = self.nodes[node].parent.is_some_and(|parent| own[parent]);
            own[node] = node == target || (above && !(is_bone && starts.contains(&node)));
        }
        own
    }
}
