//! Posing of a scene: clip, named pose, expressions and bone rotations, and the resulting
//! triangles.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};

use super::geometry::{Mesh, Primitive};
use super::instances::InstancePose;
use super::named_pose::NamedPose;
use super::transform::{LocalTransform, from_degrees};
use super::{Node, PoseRequestError, Scene, SkinBinding, skinning};

/// A pose request for a scene. The default is the rest pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseRequest {
    /// An animation by index, and a time in seconds; times outside the clip are clamped.
    pub clip: Option<(usize, f32)>,
    /// A pose of the whole body; overrides the clip for the bones it affects.
    pub stance: NamedPose,
    /// VRM expressions or morph targets by name, with weights, usually 0 to 1.
    pub weights: Vec<(String, f32)>,
    /// Rotations of bones, by VRM name, or of any nodes, by name, in degrees about X, then Y, then
    /// Z: the axes are those of the world in the rest pose, and rotate along with the parents.
    pub rotations: Vec<(String, [f32; 3])>,
}

/// Triangles of one material in world space, ready to be drawn. Metres, Y up.
#[derive(Debug, Clone, PartialEq)]
pub struct PosedPrimitive {
    /// Position of each vertex.
    pub positions: Vec<[f32; 3]>,
    /// Normal of each vertex, of unit length unless undefined.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinate of each vertex for its material's texture; the origin is at the top left.
    pub uv: Arc<[[f32; 2]]>,
    /// Further coordinates, for textures that have their own.
    pub more_uv: Vec<Arc<[[f32; 2]]>>,
    /// Linear colour and alpha of each vertex, which multiply the material's.
    pub colors: Option<Arc<[[f32; 4]]>>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Arc<[[u32; 3]]>,
    /// Index of the material.
    pub material: usize,
}

/// World transforms of all nodes from their local transforms.
///
/// - `order`: all nodes, parents before their children.
pub(super) fn world(
    nodes: &[Node],
    order: &[usize],
    local: impl Fn(usize) -> LocalTransform,
) -> Vec<Affine3A> {
    let mut world = vec![Affine3A::IDENTITY; nodes.len()];
    for &node in order {
        let own = local(node).affine();
        world[node] = match nodes[node].parent {
            Some(parent) => world[parent] * own,
            None => own,
        };
    }
    world
}

impl SkinBinding {
    /// The transforms of its joints from the bind pose to the world.
    pub(super) fn transforms(&self, world: &[Affine3A]) -> Vec<Affine3A> {
        let bound = self.joints.iter().zip(&self.inverse_bind);
        bound.map(|(&joint, inverse)| world[joint] * *inverse).collect()
    }
}

/// - `weights`: weights of the morph targets.
fn posed(primitive: &Primitive, weights: &[f32], pose: &InstancePose<'_>) -> PosedPrimitive {
    let (positions, normals) = skinning::deformed(primitive, weights, pose);
    let triangles = if pose.is_mirrored {
        primitive.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
    } else {
        Arc::clone(&primitive.triangles)
    };
    PosedPrimitive {
        positions,
        normals,
        uv: Arc::clone(&primitive.uv),
        more_uv: primitive.more_uv.clone(),
        colors: primitive.colors.clone(),
        triangles,
        material: primitive.material,
    }
}

impl Scene {
    /// The scene's triangles in a pose. The primitives of a node's mesh follow each other, once for each
    /// of its instances.
    ///
    /// # Errors
    /// [`PoseRequestError`] for unknown names, and for numbers that are not finite.
    pub fn pose(&self, posing: &PoseRequest) -> Result<Vec<PosedPrimitive>, PoseRequestError> {
        let (placements, weights) = self.local_pose(posing)?;
        let world = self.world(|node| placements[node]);
        let mut drawn = Vec::new();
        let mut joints = HashMap::new();
        for &index in &self.shown {
            let node = &self.nodes[index];
            let Some(mesh) = node.mesh else { continue };
            let transforms = |skin: usize| self.skins[skin].transforms(&world);
            let joints = node
                .skin
                .map(|skin| joints.entry(skin).or_insert_with(|| transforms(skin)).as_slice());
            for instance in node.instances() {
                let pose = InstancePose::new(&world[index], instance, joints);
                let primitives = self.meshes[mesh].primitives.iter();
                drawn.extend(primitives.map(|primitive| posed(primitive, &weights[index], &pose)));
            }
        }
        Ok(drawn)
    }

    /// World position of a humanoid bone in a pose, if the scene has the bone.
    ///
    /// - `bone`: VRM name.
    ///
    /// # Errors
    /// As [`Scene::pose`].
    pub fn bone(
        &self,
        bone: &str,
        posing: &PoseRequest,
    ) -> Result<Option<[f32; 3]>, PoseRequestError> {
        self.bones.get(bone).map(|&node| self.position(node, posing)).transpose()
    }

    /// World position of a node in a pose.
    pub(super) fn position(
        &self,
        node: usize,
        posing: &PoseRequest,
    ) -> Result<[f32; 3], PoseRequestError> {
        let (placements, _) = self.local_pose(posing)?;
        Ok(self.world(|node| placements[node])[node].translation.into())
    }

    /// World transforms of all nodes from their local transforms.
    fn world(&self, local: impl Fn(usize) -> LocalTransform) -> Vec<Affine3A> {
        world(&self.nodes, &self.order, local)
    }

    /// Local transform of each node, and its morph target weights, in a pose.
    ///
    /// Order: clip, expressions, named pose, rotations. A named pose replaces the clip's rotation
    /// of a bone; rotations are applied on top. A rotation `R` about world axes becomes
    /// `P⁻¹ · R · P` in the parent's space, `P` being the parent's world rotation at rest, so the
    /// same angles mean the same in skeletons whose bone axes differ.
    fn local_pose(
        &self,
        posing: &PoseRequest,
    ) -> Result<(Vec<LocalTransform>, Vec<Vec<f32>>), PoseRequestError> {
        let mut placements: Vec<LocalTransform> = self.nodes.iter().map(|node| node.rest).collect();
        let mut weights: Vec<Vec<f32>> =
            self.nodes.iter().map(|node| node.weights.clone()).collect();
        if let Some((index, seconds)) = posing.clip {
            finite("a time", &[seconds])?;
            let clip = self.clips.get(index).ok_or_else(|| PoseRequestError::Unknown {
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
            self.add_expression(name, *weight, &mut weights)?;
        }
        let rest = self.rest_rotations();
        let mut turn = |node: usize, turn: Quat, clears: bool| {
            let parent = self.nodes[node].parent.map_or(Quat::IDENTITY, |p| rest[p]);
            let local = parent.inverse() * turn * parent;
            let from = if clears { self.nodes[node].rest } else { placements[node] };
            placements[node].rotation =
                (local * Quat::from_array(from.rotation)).normalize().into();
        };
        for (node, rotation) in self.stance_rotations(posing.stance)? {
            turn(node, rotation, true);
        }
        for (name, degrees) in &posing.rotations {
            finite("an angle", degrees)?;
            turn(self.bone_or_node(name)?, from_degrees(*degrees), false);
        }
        Ok((placements, weights))
    }

    /// World rotations of all nodes at rest.
    fn rest_rotations(&self) -> Vec<Quat> {
        let mut rotations = vec![Quat::IDENTITY; self.nodes.len()];
        for &node in &self.order {
            let own = Quat::from_array(self.nodes[node].rest.rotation);
            rotations[node] = match self.nodes[node].parent {
                Some(parent) => (rotations[parent] * own).normalize(),
                None => own,
            };
        }
        rotations
    }

    /// Bone rotations about the world's axes, in the convention of [`PoseRequest::rotations`], that
    /// produce a named pose.
    fn stance_rotations(&self, stance: NamedPose) -> Result<Vec<(usize, Quat)>, PoseRequestError> {
        let world = self.world(|node| self.nodes[node].rest);
        let mut total: Vec<Option<Quat>> = vec![None; self.nodes.len()];
        let mut rotations = Vec::new();
        for aim in stance.aims() {
            let missing = |bone| PoseRequestError::NoBone { pose: stance.name(), bone };
            let (bone, tip) = (self.bones.get(aim.bone), self.bones.get(aim.tip));
            if aim.optional && (bone.is_none() || tip.is_none()) {
                continue;
            }
            let &bone = bone.ok_or_else(|| missing(aim.bone))?;
            let &tip = tip.ok_or_else(|| missing(aim.tip))?;
            let mut above = self.nodes[bone].parent;
            while let Some(node) = above.filter(|&node| total[node].is_none()) {
                above = self.nodes[node].parent;
            }
            let inherited = above.and_then(|node| total[node]).unwrap_or(Quat::IDENTITY);
            let rest = Vec3::from(world[tip].translation - world[bone].translation);
            let own = aim.turn(inherited, rest);
            rotations.push((bone, own));
            total[bone] = Some((inherited * own).normalize());
        }
        Ok(rotations)
    }

    /// Adds an expression or a morph target, by exact name, otherwise ignoring case.
    fn add_expression(
        &self,
        name: &str,
        weight: f32,
        weights: &mut [Vec<f32>],
    ) -> Result<(), PoseRequestError> {
        let by = |same: fn(&str, &str) -> bool| {
            let expression = self.expressions.iter().find(|e| same(&e.name, name));
            if let Some(expression) = expression {
                let snapped = if weight > 0.5 { 1.0 } else { 0.0 };
                let weight = if expression.is_binary { snapped } else { weight };
                let binds = expression.binds.iter();
                return binds.map(|&(node, target, full)| (node, target, full * weight)).collect();
            }
            let target_of = |mesh: &Mesh| mesh.target_names.iter().position(|it| same(it, name));
            let targets: Vec<Option<usize>> = self.meshes.iter().map(target_of).collect();
            let nodes = self.nodes.iter().enumerate();
            let moved =
                nodes.filter_map(|(index, node)| Some((index, targets[node.mesh?]?, weight)));
            moved.collect()
        };
        let mut added: Vec<(usize, usize, f32)> = by(|a, b| a == b);
        if added.is_empty() {
            added = by(str::eq_ignore_ascii_case);
        }
        let known = self.expressions.iter().any(|e| e.name.eq_ignore_ascii_case(name));
        if added.is_empty() && !known {
            return Err(PoseRequestError::Unknown {
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

    /// Looks up a node by VRM bone name, else by node name, else by bone name ignoring case.
    pub(super) fn bone_or_node(&self, name: &str) -> Result<usize, PoseRequestError> {
        let bone = self.bones.get(name).copied();
        let bone = bone.or_else(|| self.nodes.iter().position(|node| node.name == name));
        let alike = |(bone, &node): (&String, &usize)| {
            Some(node).filter(|_| bone.eq_ignore_ascii_case(name))
        };
        bone.or_else(|| self.bones.iter().find_map(alike)).ok_or_else(|| {
            let bones = self.bones.keys().cloned();
            let nodes = self.nodes.iter().map(|node| node.name.clone());
            let named: Vec<String> = nodes.filter(|name| !name.is_empty()).collect();
            PoseRequestError::Unknown {
                what: "bone",
                name: name.to_owned(),
                choices: if self.bones.is_empty() { named } else { bones.collect() },
            }
        })
    }
}

fn finite(what: &'static str, values: &[f32]) -> Result<(), PoseRequestError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(found) => Err(PoseRequestError::NotFinite { what, found: found.to_string() }),
        None => Ok(()),
    }
}
