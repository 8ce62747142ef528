//! Maps VRM bone names to nodes: from VRM's own mapping, or from node names.

use std::collections::BTreeMap;

use super::check::find;
use super::document::Node;
use super::error::SceneError;
use super::vrm1::Vrm;

/// Bones used by poses and cameras, by VRM name, and their names in two other families of
/// skeletons: SMPL and Mixamo. `left` stands for both sides. The other families' names are in lower
/// case.
const BONES: [[&str; 3]; 17] = [
    ["hips", "pelvis", "hips"],
    ["spine", "spine1", "spine"],
    ["chest", "spine2", "spine1"],
    ["upperChest", "spine3", "spine2"],
    ["neck", "neck", "neck"],
    ["head", "head", "head"],
    ["jaw", "jaw", "jaw"],
    ["leftEye", "lefteyesmplhf", "lefteye"],
    ["leftShoulder", "leftcollar", "leftshoulder"],
    ["leftUpperArm", "leftshoulder", "leftarm"],
    ["leftLowerArm", "leftelbow", "leftforearm"],
    ["leftHand", "leftwrist", "lefthand"],
    ["leftUpperLeg", "lefthip", "leftupleg"],
    ["leftLowerLeg", "leftknee", "leftleg"],
    ["leftFoot", "leftankle", "leftfoot"],
    ["leftToes", "leftfoot", "lefttoebase"],
    ["leftMiddleProximal", "leftmiddle1", "lefthandmiddle1"],
];

/// Nodes by bone name.
pub(super) fn bones(
    vrm: Option<&Vrm>,
    nodes: &[Node],
) -> Result<BTreeMap<String, usize>, SceneError> {
    let Some(vrm) = vrm.filter(|vrm| !vrm.humanoid.human_bones.is_empty()) else {
        return Ok(by_name(nodes));
    };
    let mut bones = BTreeMap::new();
    for (bone, human) in &vrm.humanoid.human_bones {
        find(nodes, human.node, "node", &format!("VRM's bone {bone}"))?;
        bones.insert(bone.clone(), human.node as usize);
    }
    Ok(bones)
}

/// Identifies bones by node names, using the family of names that matches most bones.
fn by_name(nodes: &[Node]) -> BTreeMap<String, usize> {
    let mut numbers: BTreeMap<String, usize> = BTreeMap::new();
    for (index, node) in nodes.iter().enumerate() {
        let name = plain(node.name.as_deref().unwrap_or_default());
        if !name.is_empty() {
            numbers.entry(name).or_insert(index);
        }
    }
    let family = |column: usize| {
        let mut bones = BTreeMap::new();
        for row in &BONES {
            for side in ["left", "right"] {
                let found = numbers.get(&row[column].to_lowercase().replace("left", side));
                if let Some(&node) = found {
                    bones.insert(row[0].replace("left", side), node);
                }
            }
        }
        bones
    };
    let families = [family(0), family(1), family(2)];
    // `max_by_key` returns the last maximum, so reversing prefers the first family.
    families.into_iter().rev().max_by_key(BTreeMap::len).unwrap_or_default()
}

/// A name in lower case, without prefix and punctuation.
fn plain(name: &str) -> String {
    let name = name.rsplit([':', '|']).next().unwrap_or_default();
    let name = name.strip_prefix("mixamorig").unwrap_or(name);
    name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(names: &[&str]) -> BTreeMap<String, usize> {
        let nodes: Vec<Node> = names
            .iter()
            .map(|name| serde_json::from_value(serde_json::json!({ "name": name })).unwrap())
            .collect();
        by_name(&nodes)
    }

    #[test]
    fn shoulders_follow_the_naming_family() {
        let smpl = found(&["pelvis", "left_collar", "left_shoulder", "left_elbow", "head"]);
        assert_eq!((smpl["leftUpperArm"], smpl["leftShoulder"], smpl["hips"]), (2, 1, 0));
        let mixamo =
            found(&["mixamorig:Hips", "mixamorig:LeftShoulder", "mixamorig:LeftArm", "Head"]);
        assert_eq!((mixamo["leftUpperArm"], mixamo["leftShoulder"], mixamo["head"]), (2, 1, 3));
        let vrm = found(&["hips", "leftShoulder", "leftUpperArm", "rightUpperArm"]);
        assert_eq!((vrm["leftUpperArm"], vrm["rightUpperArm"]), (2, 3));
        assert!(found(&["Cube", ""]).is_empty());
    }
}
