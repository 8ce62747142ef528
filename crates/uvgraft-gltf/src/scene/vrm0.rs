//! Converts VRM 0.x to the terms of VRM 1.0: bones, and blend shape groups as expressions.
//!
//! # Source
//! VRM Consortium, "VRM 0.0" (`humanoid`, `blendShapeMaster`), and its guide on migrating to 1.0
//! for renamed items.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::check::find;
use super::document::Document;
use super::error::SceneError;
use super::vrm1::{Expression, Expressions, HumanBone, Humanoid, MorphTargetBind, Vrm};

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Vrm0 {
    humanoid: Bones,
    blend_shape_master: Groups,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Bones {
    human_bones: Vec<Bone>,
}

#[derive(Debug, Deserialize)]
struct Bone {
    bone: String,
    /// -1 if there is none.
    node: i64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Groups {
    blend_shape_groups: Vec<Group>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Group {
    name: String,
    preset_name: Option<String>,
    is_binary: bool,
    binds: Vec<Bind>,
}

/// Refers to a mesh, unlike VRM 1.0, which refers to a node; weights are in percent.
#[derive(Debug, Deserialize)]
struct Bind {
    mesh: u32,
    index: u32,
    weight: f32,
}

impl Vrm0 {
    /// The mesh of each morph target that a blend shape moves; those of a mesh are as often there as they
    /// are moved.
    pub fn bound_meshes(&self) -> impl Iterator<Item = u32> {
        let groups = self.blend_shape_master.blend_shape_groups.iter();
        groups.flat_map(|group| group.binds.iter().map(|bind| bind.mesh))
    }

    /// Converts to VRM 1.0.
    ///
    /// # Errors
    /// [`SceneError`] if a blend shape refers to a missing mesh.
    pub fn as_vrm1(&self, document: &Document) -> Result<Vrm, SceneError> {
        let mut nodes_of = vec![Vec::new(); document.meshes.len()];
        for (number, node) in (0..).zip(&document.nodes) {
            let nodes = node.mesh.and_then(|mesh| nodes_of.get_mut(mesh as usize));
            nodes.into_iter().for_each(|nodes| nodes.push(number));
        }
        let mut human_bones = BTreeMap::new();
        for bone in &self.humanoid.human_bones {
            if let Ok(node) = u32::try_from(bone.node) {
                human_bones.insert(bone_name(&bone.bone), HumanBone { node });
            }
        }
        let mut expressions = Expressions::default();
        for group in &self.blend_shape_master.blend_shape_groups {
            let preset = group.preset_name.as_deref().and_then(preset_name);
            let name = preset.map_or_else(|| group.name.clone(), str::to_owned);
            let (list, binds) = (&mut expressions, group.binds(&nodes_of, &name)?);
            let list = if preset.is_some() { &mut list.preset } else { &mut list.custom };
            list.entry(name)
                .or_insert(Expression { morph_target_binds: binds, is_binary: group.is_binary });
        }
        Ok(Vrm { humanoid: Humanoid { human_bones }, expressions })
    }
}

impl Group {
    /// - `nodes_of`: for each mesh, the nodes that show it.
    fn binds(&self, nodes_of: &[Vec<u32>], name: &str) -> Result<Vec<MorphTargetBind>, SceneError> {
        let place = format!("VRM's blend shape {name}");
        let mut binds = Vec::new();
        for bind in &self.binds {
            let (index, weight) = (bind.index, bind.weight / 100.0);
            let nodes = find(nodes_of, bind.mesh, "mesh", &place)?.iter();
            binds.extend(nodes.map(|&node| MorphTargetBind { node, index, weight }));
        }
        Ok(binds)
    }
}

/// In VRM 1.0 the thumb's first bone is the metacarpal, so thumb names shift by one.
fn bone_name(name: &str) -> String {
    match name.split_once("Thumb") {
        Some((side, "Proximal")) => format!("{side}ThumbMetacarpal"),
        Some((side, "Intermediate")) => format!("{side}ThumbProximal"),
        _ => name.to_owned(),
    }
}

fn preset_name(name: &str) -> Option<&'static str> {
    Some(match name.to_ascii_lowercase().as_str() {
        "neutral" => "neutral",
        "a" => "aa",
        "i" => "ih",
        "u" => "ou",
        "e" => "ee",
        "o" => "oh",
        "blink" => "blink",
        "blink_l" => "blinkLeft",
        "blink_r" => "blinkRight",
        "joy" => "happy",
        "angry" => "angry",
        "sorrow" => "sad",
        "fun" => "relaxed",
        "lookup" => "lookUp",
        "lookdown" => "lookDown",
        "lookleft" => "lookLeft",
        "lookright" => "lookRight",
        _ => return None,
    })
}
