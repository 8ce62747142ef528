//! Finds the primitives of a name.

use std::collections::HashSet;

use super::super::budget::MAX_PRIMITIVES;
use super::super::check::{find, too_many};
use super::super::document::{Document, Primitive};
use super::super::error::SceneError;
use super::super::geometry::is_surface;
use super::super::{Hierarchy, Node};
use super::SceneMeshError;

/// Names in messages are cut off after this many characters.
const MAX_SHOWN: usize = 40;

/// A primitive as a node shows it.
pub(super) struct Shown<'a> {
    pub node: usize,
    pub mesh: usize,
    pub number: usize,
    pub primitive: &'a Primitive,
}

impl Shown<'_> {
    /// For messages.
    pub(super) fn place(&self) -> String {
        format!("mesh {}, primitive {}", self.mesh, self.number)
    }
}

/// The primitives with triangles that have a name, or all, in the order of the file.
pub(super) fn chosen<'a>(
    document: &'a Document,
    hierarchy: &Hierarchy,
    name: Option<&str>,
) -> Result<Vec<Shown<'a>>, SceneMeshError> {
    let all = shown(document, hierarchy)?;
    if all.is_empty() {
        return Err(SceneMeshError::NoTriangles);
    }
    let Some(name) = name else { return Ok(all) };
    let in_nodes = in_nodes_named(hierarchy, name);
    let kinds: [&dyn Fn(&Shown<'_>) -> bool; 3] =
        [&|shown| in_nodes[shown.node], &|shown| mesh_name(document, shown) == name, &|shown| {
            material_name(document, shown) == name
        }];
    let Some(kind) = kinds.into_iter().find(|kind| all.iter().any(kind)) else {
        let choices = names(document, &hierarchy.nodes, &all);
        return Err(SceneMeshError::Unknown { name: shortened(name), choices });
    };
    Ok(all.into_iter().filter(kind).collect())
}

fn shown<'a>(document: &'a Document, hierarchy: &Hierarchy) -> Result<Vec<Shown<'a>>, SceneError> {
    let mut all = Vec::new();
    for &node in &hierarchy.shown {
        let instances = hierarchy.nodes[node].instances().len();
        let Some(mesh) = hierarchy.nodes[node].mesh.filter(|_| instances > 0) else { continue };
        let primitives = &document.meshes[mesh].primitives;
        let count = (all.len() + primitives.len()) as u64;
        too_many("primitives, of all nodes", count, MAX_PRIMITIVES)?;
        for (number, primitive) in primitives.iter().enumerate() {
            if is_surface(primitive) {
                let shown = Shown { node, mesh, number, primitive };
                if let Some(material) = primitive.material {
                    find(&document.materials, material, "material", &shown.place())?;
                }
                all.push(shown);
            }
        }
    }
    Ok(all)
}

/// Whether each node has the name, or is below a node of the name without a mesh.
fn in_nodes_named(hierarchy: &Hierarchy, name: &str) -> Vec<bool> {
    let nodes = &hierarchy.nodes;
    let mut below = vec![false; nodes.len()];
    for &node in &hierarchy.order {
        let group = nodes[node].name == name && nodes[node].mesh.is_none();
        below[node] = group || nodes[node].parent.is_some_and(|parent| below[parent]);
    }
    (0..nodes.len()).map(|node| below[node] || nodes[node].name == name).collect()
}

/// The name of a primitive's mesh; empty if it has none.
pub(super) fn mesh_name<'a>(document: &'a Document, shown: &Shown<'_>) -> &'a str {
    document.meshes[shown.mesh].name.as_deref().unwrap_or_default()
}

/// The name of a primitive's material; empty if it has none.
pub(super) fn material_name<'a>(document: &'a Document, shown: &Shown<'_>) -> &'a str {
    let material =
        shown.primitive.material.and_then(|index| document.materials.get(index as usize));
    material.and_then(|material| material.name.as_deref()).unwrap_or_default()
}

/// The names that can be chosen, nodes first, without repetition.
fn names(document: &Document, nodes: &[Node], all: &[Shown<'_>]) -> Vec<String> {
    // Far more than a message lists, which says how many more there are.
    const MAX: usize = 1024;
    let (mut names, mut known): (Vec<String>, HashSet<String>) = Default::default();
    let of_nodes = all.iter().map(|shown| &*nodes[shown.node].name);
    let of_meshes = all.iter().map(|shown| mesh_name(document, shown));
    let of_materials = all.iter().map(|shown| material_name(document, shown));
    for name in of_nodes.chain(of_meshes).chain(of_materials) {
        let name = shortened(name);
        if names.len() < MAX && !name.is_empty() && known.insert(name.clone()) {
            names.push(name);
        }
    }
    names
}

fn shortened(name: &str) -> String {
    let printable = name.chars().filter(|character| !character.is_control());
    let mut text: String = printable.take(MAX_SHOWN + 1).collect();
    if text.chars().count() > MAX_SHOWN {
        text.pop();
        text.push('…');
    }
    text
}
