//! The nodes and meshes of a file.
//!
//! Source of levels: Microsoft, "MSFT_lod" (vendor extension of glTF, 2017).

use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::Pose;

use super::json;
use super::material::AvatarMaterial;
use super::parts::WrittenPrimitive;

/// The extension of levels of detail.
pub(super) const LEVELS: &str = "MSFT_lod";

/// Screen coverage below which the first coarser level is shown. The threshold halves for each
/// further level, as the number of triangles does.
const FIRST_COVERAGE: f32 = 0.25;

/// The scene graph of a file.
pub(super) struct Graph {
    pub nodes: Vec<json::Node>,
    pub meshes: Vec<json::Mesh>,
    pub scene: json::Scene,
    /// The scene's nodes that have a mesh.
    pub shown: Vec<MeshNode>,
}

/// A node with a mesh.
pub(super) struct MeshNode {
    pub node: usize,
    /// For each morph, whether it moves any vertex of the mesh.
    pub moves: Vec<bool>,
    /// Whether the whole mesh blocks the view from the avatar's eyes.
    pub is_head: bool,
}

/// One node for each joint, then the mesh nodes. Skinned meshes are at the root of the scene
/// because readers ignore the transforms of their parents.
///
/// - `stand`: the pose that the joint nodes are in.
/// - `is_divided`: whether heads with their own material become separate meshes.
/// - `levels`: coarser levels, whose nodes are in no scene.
pub(super) fn graph(
    avatar: &Avatar,
    stand: &Pose,
    name: &str,
    materials: &[AvatarMaterial],
    is_divided: bool,
    parts: Vec<WrittenPrimitive>,
    levels: Vec<Vec<WrittenPrimitive>>,
) -> Graph {
    let mut nodes = joints(avatar, stand);
    let mut names = Names { avatar, taken: Vec::new() };
    let target_names: Vec<String> = avatar.morphs.iter().map(|morph| morph.name.clone()).collect();
    let mut meshes = Vec::new();
    let mut add = |parts: Vec<WrittenPrimitive>, name: &str, nodes: &mut Vec<json::Node>| {
        let primitives = parts.into_iter().map(|part| part.primitive).collect();
        meshes.push(json::Mesh {
            name: name.to_owned(),
            primitives,
            weights: vec![0.0; target_names.len()],
            extras: (!target_names.is_empty())
                .then(|| json::MeshExtras { target_names: target_names.clone() }),
        });
        let node = nodes.len();
        let (name, mesh) = (names.unique(name), Some(meshes.len() - 1));
        nodes.push(json::Node { name, mesh, skin: Some(0), ..json::Node::default() });
        node
    };
    let is_head =
        |part: &WrittenPrimitive| is_divided && materials[usize::from(part.material)].is_head;
    let (head, body): (Vec<WrittenPrimitive>, Vec<WrittenPrimitive>) =
        parts.into_iter().partition(is_head);
    let mut shown = Vec::new();
    for (parts, is_head) in [(body, false), (head, true)] {
        if parts.is_empty() {
            continue;
        }
        let moves = (0..avatar.morphs.len())
            .map(|morph| parts.iter().any(|part| part.moves[morph]))
            .collect();
        let name = if is_head { format!("{name} head") } else { name.to_owned() };
        shown.push(MeshNode { node: add(parts, &name, &mut nodes), moves, is_head });
    }
    let coarser: Vec<usize> = (1..)
        .zip(levels)
        .map(|(level, parts)| add(parts, &format!("{name} level {level}"), &mut nodes))
        .collect();
    if let (Some(finest), false) = (shown.first(), coarser.is_empty()) {
        let changes = (0..coarser.len() as i32).map(|level| FIRST_COVERAGE * 0.5_f32.powi(level));
        // The last value is the coverage below which the coarsest level is culled: never.
        let screen_coverage = changes.chain([0.0]).collect();
        let node = &mut nodes[finest.node];
        node.extensions = Some(json::NodeExtensions { levels: json::LevelNodes { ids: coarser } });
        node.extras = Some(json::NodeExtras { screen_coverage });
    }
    let roots = [0].into_iter().chain(shown.iter().map(|shown| shown.node)).collect();
    let scene = json::Scene { name: name.to_owned(), nodes: roots };
    Graph { nodes, meshes, scene, shown }
}

fn joints(avatar: &Avatar, stand: &Pose) -> Vec<json::Node> {
    let joints = avatar.skeleton.joints();
    let mut nodes: Vec<json::Node> = Vec::with_capacity(joints.len() + 2);
    for (index, joint) in joints.iter().enumerate() {
        // The pose translates the root only; other joints keep their offsets from their parents.
        let moved = glam::Vec3::from(stand.translation);
        let from = joint.parent.map_or(-moved, |parent| joints[parent].position.into());
        let offset = glam::Vec3::from(joint.position) - from;
        let turn = stand.rotations[index];
        nodes.push(json::Node {
            name: joint.name.clone(),
            translation: Some(offset.into()),
            rotation: (turn != [0.0, 0.0, 0.0, 1.0]).then_some(turn),
            ..json::Node::default()
        });
        if let Some(parent) = joint.parent {
            nodes[parent].children.push(index);
        }
    }
    nodes
}

/// Assigns names to mesh nodes.
struct Names<'a> {
    avatar: &'a Avatar,
    taken: Vec<String>,
}

impl Names<'_> {
    /// A name that no other node has, since players find nodes by name.
    fn unique(&mut self, name: &str) -> String {
        let mut name = name.to_owned();
        let joints = self.avatar.skeleton.joints();
        while self.taken.contains(&name) || joints.iter().any(|joint| joint.name == name) {
            name.push_str(" mesh");
        }
        self.taken.push(name.clone());
        name
    }
}
