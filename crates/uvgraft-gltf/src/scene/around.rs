//! What belongs to a bone or a node, for cameras that look at it.

use super::{Posing, PosingError, Scene};

/// Bones that begin a part of the body of its own, by VRM's names; `left` stands for both sides. What
/// hangs on others, such as fingers and eyes, goes with the bone above.
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

/// A bone or a node, and what it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Around {
    /// Where its joint is.
    pub joint: [f32; 3],
    /// The vertices that are mostly its own, or of what hangs on it short of the next part of the body.
    pub points: Vec<[f32; 3]>,
}

impl Scene {
    /// What a bone (by VRM's name) or a node moves, in a pose.
    ///
    /// # Errors
    /// As [`Scene::pose`]; also for a name that the scene does not have.
    pub fn around(&self, name: &str, posing: &Posing) -> Result<Around, PosingError> {
        let target = self.bone_or_node(name)?;
        let own = self.part(target);
        let drawn = self.pose(posing)?;
        let mut pieces = drawn.iter();
        let mut points = Vec::new();
        for &index in &self.shown {
            let node = &self.nodes[index];
            let Some(mesh) = node.mesh else { continue };
            let is_own: Option<Vec<bool>> = node
                .skin
                .map(|skin| self.skins[skin].joints.iter().map(|&joint| own[joint]).collect());
            for (primitive, piece) in self.meshes[mesh].primitives.iter().zip(&mut pieces) {
                let moved = |vertex: usize| match (&is_own, &primitive.influences) {
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
        let joint = self.place(target, posing)?;
        Ok(Around { joint, points })
    }

    /// Which nodes hang on one, but for those of the body's next parts.
    fn part(&self, target: usize) -> Vec<bool> {
        let is_part = |node: usize| {
            let starts = |name: &str| self.bones.get(name) == Some(&node);
            PARTS.iter().any(|name| starts(name) || starts(&name.replace("left", "right")))
        };
        let is_bone = self.bones.values().any(|&node| node == target);
        let mut own = vec![false; self.nodes.len()];
        for &node in &self.order {
            let above = self.nodes[node].parent.is_some_and(|parent| own[parent]);
            own[node] = node == target || (above && !(is_bone && is_part(node)));
        }
        own
    }
}
