//! A scene at one moment: which bones are turned, which faces it makes, and what is drawn then.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};

use super::stance::Stance;
use super::transform::{Placement, from_degrees};
use super::{PosingError, Scene, skinning};

/// What a scene is asked to do. Empty for its rest pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Posing {
    /// An animation by its number, at a time in seconds; times outside stand still at its ends.
    pub clip: Option<(usize, f32)>,
    /// A pose of the whole body, in place of what the clip does to those bones.
    pub stance: Stance,
    /// VRM's expressions or morph targets by their names, with their weights; usually 0 to 1.
    pub weights: Vec<(String, f32)>,
    /// Bones by VRM's names, or any nodes by theirs, turned by degrees about X, then Y, then Z: the
    /// axes are those of the world in the rest pose, carried along by the parents.
    pub rotations: Vec<(String, [f32; 3])>,
}

/// Triangles of one material in the world, ready to be drawn. Metres, Y up.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Of each vertex.
    pub positions: Vec<[f32; 3]>,
    /// Of each vertex, of unit length where they mean anything.
    pub normals: Vec<[f32; 3]>,
    /// Of each vertex, in its material's texture; the origin is at the top left.
    pub uv: Arc<[[f32; 2]]>,
    /// The same for textures with coordinates of their own.
    pub more_uv: Vec<Arc<[[f32; 2]]>>,
    /// Of each vertex: a linear colour and opacity that multiply the material's.
    pub colors: Option<Arc<[[f32; 4]]>>,
    /// Corners, counter-clockwise where seen from the front.
    pub triangles: Arc<[[u32; 3]]>,
    /// Number of the material.
    pub material: usize,
}

impl Scene {
    /// The scene's triangles in a pose.
    ///
    /// # Errors
    /// [`PosingError`] for a name that the scene does not have, and for numbers that are not finite.
    pub fn pose(&self, posing: &Posing) -> Result<Vec<Drawn>, PosingError> {
        let (placements, weights) = self.moved(posing)?;
        let world = self.world(|node| placements[node]);
        let mut drawn = Vec::new();
        for &index in &self.shown {
            let node = &self.nodes[index];
            let Some(mesh) = node.mesh else { continue };
            let joints: Option<Vec<Affine3A>> = node.skin.map(|skin| {
                let skin = &self.skins[skin];
                let bound = skin.joints.iter().zip(&skin.inverse_bind);
                bound.map(|(&joint, inverse)| world[joint] * *inverse).collect()
            });
            let mirrored = joints.is_none() && world[index].matrix3.determinant() < 0.0;
            for primitive in &self.meshes[mesh].primitives {
                let (positions, normals) = skinning::deformed(
                    primitive,
                    &weights[index],
                    joints.as_deref(),
                    &world[index],
                );
                let triangles = if mirrored {
                    primitive.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
                } else {
                    Arc::clone(&primitive.triangles)
                };
                drawn.push(Drawn {
                    positions,
                    normals,
                    uv: Arc::clone(&primitive.uv),
                    more_uv: primitive.more_uv.clone(),
                    colors: primitive.colors.clone(),
                    triangles,
                    material: primitive.material,
                });
            }
        }
        Ok(drawn)
    }

    /// Where a humanoid bone is in a pose: its position in the world, if the scene has it.
    ///
    /// - `bone`: VRM's name.
    ///
    /// # Errors
    /// As [`Scene::pose`].
    pub fn bone(&self, bone: &str, posing: &Posing) -> Result<Option<[f32; 3]>, PosingError> {
        self.bones.get(bone).map(|&node| self.place(node, posing)).transpose()
    }

    /// Where a node is in a pose.
    pub(super) fn place(&self, node: usize, posing: &Posing) -> Result<[f32; 3], PosingError> {
        let (placements, _) = self.moved(posing)?;
        Ok(self.world(|node| placements[node])[node].translation.into())
    }

    /// Where each node is, from where each is relative to its parent.
    fn world(&self, local: impl Fn(usize) -> Placement) -> Vec<Affine3A> {
        let mut world = vec![Affine3A::IDENTITY; self.nodes.len()];
        for &node in &self.order {
            let own = local(node).affine();
            world[node] = match self.nodes[node].parent {
                Some(parent) => world[parent] * own,
                None => own,
            };
        }
        world
    }

    /// Each node's place relative to its parent, and the weights of its morph targets.
    fn moved(&self, posing: &Posing) -> Result<(Vec<Placement>, Vec<Vec<f32>>), PosingError> {
        let mut placements: Vec<Placement> = self.nodes.iter().map(|node| node.rest).collect();
        let mut weights: Vec<Vec<f32>> =
            self.nodes.iter().map(|node| node.weights.clone()).collect();
        if let Some((index, seconds)) = posing.clip {
            finite("a time", &[seconds])?;
            let clip = self.clips.get(index).ok_or_else(|| PosingError::Unknown {
                what: "clip",
                name: index.to_string(),
                choices: (0..self.clips.len()).map(|clip| clip.to_string()).collect(),
            })?;
            for channel in &clip.channels {
                let node = channel.node;
                channel.apply(seconds, &mut placements[node], &mut weights[node]);
            }
        }
        for (name, weight) in &posing.weights {
            finite("a weight", &[*weight])?;
            self.express(name, *weight, &mut weights)?;
        }
        let rest = self.rest_turns();
        let mut turn = |node: usize, turn: Quat, clears: bool| {
            let parent = self.nodes[node].parent.map_or(Quat::IDENTITY, |p| rest[p]);
            let local = parent.inverse() * turn * parent;
            let from = if clears { self.nodes[node].rest } else { placements[node] };
            placements[node].rotation =
                (local * Quat::from_array(from.rotation)).normalize().into();
        };
        for (node, rotation) in self.stance_turns(posing.stance)? {
            turn(node, rotation, true);
        }
        for (name, degrees) in &posing.rotations {
            finite("an angle", degrees)?;
            turn(self.bone_or_node(name)?, from_degrees(*degrees), false);
        }
        Ok((placements, weights))
    }

    /// How each node is turned in the world at rest.
    fn rest_turns(&self) -> Vec<Quat> {
        let mut turns = vec![Quat::IDENTITY; self.nodes.len()];
        for &node in &self.order {
            let own = Quat::from_array(self.nodes[node].rest.rotation);
            turns[node] = match self.nodes[node].parent {
                Some(parent) => (turns[parent] * own).normalize(),
                None => own,
            };
        }
        turns
    }

    /// Turns of bones about the world's axes, as [`Posing::rotations`] has them, that make a pose.
    fn stance_turns(&self, stance: Stance) -> Result<Vec<(usize, Quat)>, PosingError> {
        let world = self.world(|node| self.nodes[node].rest);
        let mut whole: Vec<Option<Quat>> = vec![None; self.nodes.len()];
        let mut turns = Vec::new();
        for aim in stance.aims() {
            let missing = |bone| PosingError::NoBone { pose: stance.name(), bone };
            let (bone, tip) = (self.bones.get(aim.bone), self.bones.get(aim.tip));
            if aim.optional && (bone.is_none() || tip.is_none()) {
                continue;
            }
            let &bone = bone.ok_or_else(|| missing(aim.bone))?;
            let &tip = tip.ok_or_else(|| missing(aim.tip))?;
            let mut above = self.nodes[bone].parent;
            while let Some(node) = above.filter(|&node| whole[node].is_none()) {
                above = self.nodes[node].parent;
            }
            let carried = above.and_then(|node| whole[node]).unwrap_or(Quat::IDENTITY);
            let rest = Vec3::from(world[tip].translation - world[bone].translation);
            let own = aim.turn(carried, rest);
            turns.push((bone, own));
            whole[bone] = Some((carried * own).normalize());
        }
        Ok(turns)
    }

    /// Adds an expression or a morph target.
    fn express(
        &self,
        name: &str,
        weight: f32,
        weights: &mut [Vec<f32>],
    ) -> Result<(), PosingError> {
        let by = |same: fn(&str, &str) -> bool| {
            let expression = self.expressions.iter().find(|e| same(&e.name, name));
            if let Some(expression) = expression {
                let snapped = if weight > 0.5 { 1.0 } else { 0.0 };
                let weight = if expression.is_binary { snapped } else { weight };
                let binds = expression.binds.iter();
                return binds.map(|&(node, target, full)| (node, target, full * weight)).collect();
            }
            let mut found = Vec::new();
            for (index, node) in self.nodes.iter().enumerate() {
                let Some(mesh) = node.mesh else { continue };
                let names = &self.meshes[mesh].target_names;
                let target = names.iter().position(|target| same(target, name));
                found.extend(target.map(|target| (index, target, weight)));
            }
            found
        };
        let mut added: Vec<(usize, usize, f32)> = by(|a, b| a == b);
        if added.is_empty() {
            added = by(str::eq_ignore_ascii_case);
        }
        let known = self.expressions.iter().any(|e| e.name.eq_ignore_ascii_case(name));
        if added.is_empty() && !known {
            return Err(PosingError::Unknown {
                what: "expression",
                name: name.to_owned(),
                choices: self.expressions().into_iter().map(str::to_owned).collect(),
            });
        }
        for (node, target, weight) in added {
            if let Some(sum) = weights[node].get_mut(target) {
                *sum += weight;
            }
        }
        Ok(())
    }

    pub(super) fn bone_or_node(&self, name: &str) -> Result<usize, PosingError> {
        let bone = self.bones.get(name).copied();
        let bone = bone.or_else(|| self.nodes.iter().position(|node| node.name == name));
        let alike = |(bone, &node): (&String, &usize)| {
            Some(node).filter(|_| bone.eq_ignore_ascii_case(name))
        };
        bone.or_else(|| self.bones.iter().find_map(alike)).ok_or_else(|| {
            let bones = self.bones.keys().cloned();
            let nodes = self.nodes.iter().map(|node| node.name.clone());
            let named: Vec<String> = nodes.filter(|name| !name.is_empty()).collect();
            PosingError::Unknown {
                what: "bone",
                name: name.to_owned(),
                choices: if self.bones.is_empty() { named } else { bones.collect() },
            }
        })
    }
}

fn finite(what: &'static str, values: &[f32]) -> Result<(), PosingError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(found) => Err(PosingError::NotFinite { what, found: found.to_string() }),
        None => Ok(()),
    }
}
