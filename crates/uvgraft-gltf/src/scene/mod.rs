//! Reads avatars from GLB, VRM and glTF files of any origin, to be posed and drawn.
//!
//! Everything that affects rendering is read: nodes, meshes with skins and morph targets,
//! animations, materials with their textures, and the humanoid bones and expressions of VRM 1.0
//! and 0.x. Compressed parts (Draco, meshoptimizer, KTX2) are decompressed first. Arrays are
//! checked against the file's real length before anything is allocated; indices, hierarchies and
//! numbers are validated before use.
//!
//! The JSON is parsed into our own types rather than by the crate `gltf`, which rejects whole files
//! for parts that rendering does not need: channels without a node, textures without a plain
//! source.

mod accessor;
mod appearance;
mod asset;
mod budget;
mod check;
mod clip;
mod contents;
mod demand;
mod document;
mod error;
mod extent;
mod geometry;
#[cfg(test)]
mod greedy_tests;
mod humanoid;
mod images;
#[cfg(test)]
mod instance_tests;
mod instances;
#[cfg(feature = "ktx2")]
mod ktx2;
mod material;
mod named_pose;
mod posing;
mod shared;
mod skinning;
#[cfg(test)]
mod tests;
mod transform;
mod unpack;
mod uv_mesh;
mod vrm0;
mod vrm1;
mod whole;
#[cfg(test)]
mod wild_tests;

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use glam::Affine3A;
use uvgraft::Texture;
use uvgraft_files::input::{Input, ReadError};

use self::accessor::Accessors;
use self::asset::{Asset, parse_within};
use self::budget::Demand;
pub use self::budget::{Budget, MemoryShares};
use self::check::find;
pub use self::clip::Clip;
pub use self::contents::{ClipContents, Contents, ImageContents, ImageUse, PartContents, contents};
use self::document::Document;
pub use self::error::{PoseRequestError, SceneError};
pub use self::extent::Extent;
use self::geometry::{Mesh, Primitive};
pub use self::material::{AlphaMode, Material, ScaledTexture, SpecularGloss, TextureUse, Wrap};
pub use self::named_pose::NamedPose;
pub use self::posing::{PoseRequest, PosedPrimitive};
pub use self::transform::LocalTransform;
pub use self::uv_mesh::{MeshChoice, SceneMeshError, load_mesh, read_mesh};
use self::vrm1::Expressions;
pub use self::whole::{whole, whole_within};

/// The contents of a file, ready to be posed.
#[derive(Debug)]
pub struct Scene {
    nodes: Vec<Node>,
    /// All nodes, parents before their children.
    order: Vec<usize>,
    /// Mesh nodes of the scene.
    shown: Vec<usize>,
    meshes: Vec<Mesh>,
    skins: Vec<SkinBinding>,
    clips: Vec<Clip>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    bones: BTreeMap<String, usize>,
    expressions: Vec<Expression>,
}

/// A node of the hierarchy.
#[derive(Debug, Default)]
struct Node {
    name: String,
    parent: Option<usize>,
    rest: LocalTransform,
    mesh: Option<usize>,
    skin: Option<usize>,
    /// Rest weights of the mesh's morph targets, one each.
    weights: Vec<f32>,
    /// Transforms from the instances of its mesh to the node, if the file states any.
    instances: Option<Vec<Affine3A>>,
}

#[derive(Debug)]
struct SkinBinding {
    joints: Vec<usize>,
    inverse_bind: Vec<Affine3A>,
}

/// The nodes of a file at rest.
struct Hierarchy {
    nodes: Vec<Node>,
    /// All nodes, parents before their children.
    order: Vec<usize>,
    /// Mesh nodes of the scene.
    shown: Vec<usize>,
}

impl Hierarchy {
    /// - `meshes`: may lack their primitives.
    /// - `accessors`: without them, instances are not read.
    fn new(
        document: &Document,
        meshes: &[Mesh],
        accessors: Option<&mut Accessors<'_>>,
    ) -> Result<Self, SceneError> {
        let mut nodes = nodes(document, meshes, accessors)?;
        if document.extensions.vrm0.is_some() && document.extensions.vrm.is_none() {
            turn_around(&mut nodes);
        }
        let order = parents_first(&nodes)?;
        let shown = shown(document, &nodes, &order)?;
        Ok(Self { nodes, order, shown })
    }
}

/// A named VRM expression, a combination of morph targets.
#[derive(Debug)]
struct Expression {
    name: String,
    /// Node, morph target, and the target's weight when the expression's weight is 1.
    binds: Vec<(usize, usize, f32)>,
    /// Whether its weight is either 0 or 1.
    is_binary: bool,
}

impl Scene {
    /// Reads a self-contained GLB, VRM or glTF file: buffers and images are in the GLB or in data
    /// URIs.
    ///
    /// # Errors
    /// [`SceneError`] for anything truncated, damaged or too large, and for dangling references.
    pub fn read(bytes: &[u8]) -> Result<Self, SceneError> {
        Self::read_in(bytes, None, Budget::default())
    }

    /// Reads a GLB, VRM or glTF file and the external files that it refers to, which bytes cannot
    /// have.
    ///
    /// # Errors
    /// As [`Scene::read`], with the path or name; also if it refers to a file outside its folder.
    pub fn load(input: impl Into<Input>) -> Result<Self, ReadError<SceneError>> {
        Self::load_within(input, Budget::default())
    }

    /// As [`Scene::load`], with a bound on the memory that reading and drawing the scene takes.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_within(
        input: impl Into<Input>,
        budget: Budget,
    ) -> Result<Self, ReadError<SceneError>> {
        parse_within(&input.into(), budget, |bytes, folder| Self::read_in(bytes, folder, budget))
    }

    /// As [`Scene::read`], with a bound on the memory that reading and drawing the scene takes.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn read_within(bytes: &[u8], budget: Budget) -> Result<Self, SceneError> {
        Self::read_in(bytes, None, budget)
    }

    fn read_in(bytes: &[u8], folder: Option<&Path>, budget: Budget) -> Result<Self, SceneError> {
        let mut asset = Asset::new(bytes, folder, budget)?;
        let mut buffers = asset.buffers()?;
        let demand = demand_of(&asset)?;
        unpack::unpack(&mut asset.document, &mut buffers)?;
        let document = &asset.document;
        let mut accessors = Accessors::new(document, &buffers);
        let appearance = appearance::appearance(&asset, &accessors, demand)?;
        let meshes = geometry::meshes(document, &mut accessors, &appearance.uv_sources)?;
        let vrm0 = &document.extensions.vrm0;
        let Hierarchy { nodes, order, shown } =
            Hierarchy::new(document, &meshes, Some(&mut accessors))?;
        let skins = skins(document, &mut accessors)?;
        check_joints(&shown, &nodes, &meshes, &skins)?;
        let targets: Vec<usize> = nodes.iter().map(|node| node.weights.len()).collect();
        let from_vrm0 = vrm0.as_ref().map(|vrm0| vrm0.as_vrm1(document)).transpose()?;
        let vrm = document.extensions.vrm.as_ref().or(from_vrm0.as_ref());
        Ok(Self {
            clips: clip::clips(document, &mut accessors, &targets)?,
            bones: humanoid::bones(vrm, &document.nodes)?,
            expressions: match vrm {
                Some(vrm) => expressions(&vrm.expressions, &targets)?,
                None => Vec::new(),
            },
            materials: appearance.materials,
            textures: appearance.textures,
            nodes,
            order,
            shown,
            meshes,
            skins,
        })
    }

    /// Its animations.
    pub fn clips(&self) -> &[Clip] {
        &self.clips
    }

    /// Its materials. The last one is for primitives without a material.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The textures that its materials use.
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }

    /// VRM names of the humanoid bones that were found.
    pub fn bones(&self) -> impl Iterator<Item = &str> {
        self.bones.keys().map(String::as_str)
    }

    /// Names of the VRM expressions, then of the morph targets, without duplicates.
    pub fn expressions(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.expressions.iter().map(|e| e.name.as_str()).collect();
        names.extend(self.meshes.iter().flat_map(|mesh| &mesh.target_names).map(String::as_str));
        let mut known = HashSet::new();
        names.retain(|name| known.insert(*name));
        names
    }

    /// Number of triangles drawn.
    pub fn triangles(&self) -> usize {
        let of_node = |&node: &usize| {
            let node = &self.nodes[node];
            let primitives = node.mesh.map_or(&[][..], |mesh| &self.meshes[mesh].primitives);
            let triangles = primitives.iter().map(|primitive| primitive.triangles.len());
            node.instances().len() * triangles.sum::<usize>()
        };
        self.shown.iter().map(of_node).sum()
    }
}

/// What a scene asks for, apart from its images.
fn demand_of(asset: &Asset<'_>) -> Result<Demand, SceneError> {
    let mut demand = asset.demand();
    demand.add_nodes(&asset.document)?;
    demand.add_meshes(&asset.document)?;
    demand.add_clips(&asset.document)?;
    demand.add_expressions(&asset.document)?;
    demand.add_unpacked(&asset.document)?;
    demand.check()?;
    Ok(demand)
}

fn nodes(
    document: &Document,
    meshes: &[Mesh],
    mut accessors: Option<&mut Accessors<'_>>,
) -> Result<Vec<Node>, SceneError> {
    let mut nodes = Vec::with_capacity(document.nodes.len());
    for (index, node) in document.nodes.iter().enumerate() {
        let place = format!("node {index}");
        let rest = placement(node, &place)?;
        let mesh = node.mesh.map(|mesh| find(meshes, mesh, "mesh", &place)).transpose()?;
        if let Some(skin) = node.skin {
            find(&document.skins, skin, "skin", &place)?;
        }
        if node.weights.iter().any(|weight| !weight.is_finite()) {
            return Err(SceneError::content(place, "weights must be finite"));
        }
        let mut weights = mesh.map_or_else(Vec::new, |mesh| mesh.weights.clone());
        for (weight, own) in weights.iter_mut().zip(&node.weights) {
            *weight = *own;
        }
        nodes.push(Node {
            name: node.name.clone().unwrap_or_default(),
            parent: None,
            rest,
            mesh: node.mesh.map(|mesh| mesh as usize),
            skin: node.skin.map(|skin| skin as usize),
            weights,
            instances: match accessors.as_deref_mut() {
                Some(accessors) => instances::read(node, accessors)?,
                None => None,
            },
        });
    }
    for (parent, node) in document.nodes.iter().enumerate() {
        for &child in &node.children {
            let place = format!("node {parent}");
            find(&document.nodes, child, "node", &place)?;
            if let Some(first) = nodes[child as usize].parent.replace(parent) {
                let reason = format!("child {child} already has the parent {first}");
                return Err(SceneError::content(place, reason));
            }
        }
    }
    Ok(nodes)
}

fn placement(node: &document::Node, place: &str) -> Result<LocalTransform, SceneError> {
    let not_finite = || SceneError::content(place, "world transform must be finite");
    if let Some(matrix) = &node.matrix {
        if !matrix.iter().all(|value| value.is_finite()) {
            return Err(not_finite());
        }
        return Ok(LocalTransform::nearest(&transform::affine_from_columns(matrix)));
    }
    let rest = LocalTransform::default();
    let placement = LocalTransform {
        translation: node.translation.unwrap_or(rest.translation),
        rotation: transform::unit(node.rotation.unwrap_or(rest.rotation)).into(),
        scale: node.scale.unwrap_or(rest.scale),
    };
    let numbers = placement.translation.iter().chain(&placement.scale);
    let turns = node.rotation.unwrap_or_default();
    if numbers.chain(&turns).all(|value| value.is_finite()) {
        Ok(placement)
    } else {
        Err(not_finite())
    }
}

/// Adds a root node that rotates everything by 180° about Y, since VRM 0.x models face -Z and ours
/// +Z.
fn turn_around(nodes: &mut Vec<Node>) {
    let above = nodes.len();
    for root in nodes.iter_mut().filter(|node| node.parent.is_none()) {
        root.parent = Some(above);
    }
    let rest = LocalTransform { rotation: [0.0, 1.0, 0.0, 0.0], ..LocalTransform::default() };
    nodes.push(Node { rest, ..Node::default() });
}

/// All nodes in breadth-first order, so parents come first.
fn parents_first(nodes: &[Node]) -> Result<Vec<usize>, SceneError> {
    let mut children = vec![Vec::new(); nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            children[parent].push(index);
        }
    }
    let mut order: Vec<usize> =
        (0..nodes.len()).filter(|&node| nodes[node].parent.is_none()).collect();
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        order.append(&mut children[node]);
        next += 1;
    }
    // Every node has at most one parent, so nodes that no root reaches are in or below a cycle.
    if order.len() < nodes.len() {
        let mut reached = vec![false; nodes.len()];
        order.iter().for_each(|&node| reached[node] = true);
        let node = reached.iter().position(|reached| !reached).unwrap_or_default();
        return Err(SceneError::content(format!("node {node}"), "must not be its own ancestor"));
    }
    Ok(order)
}

/// The mesh nodes in the file's scene.
fn shown(document: &Document, nodes: &[Node], order: &[usize]) -> Result<Vec<usize>, SceneError> {
    let scene = document.scene.unwrap_or(0);
    let mut is_shown = vec![document.scenes.is_empty(); nodes.len()];
    if !document.scenes.is_empty() {
        for &root in &find(&document.scenes, scene, "scene", "the file")?.nodes {
            find(nodes, root, "node", &format!("scene {scene}"))?;
            is_shown[root as usize] = true;
        }
    }
    for &node in order {
        is_shown[node] |= nodes[node].parent.is_some_and(|parent| is_shown[parent]);
    }
    Ok((0..nodes.len()).filter(|&node| is_shown[node] && nodes[node].mesh.is_some()).collect())
}

fn skins(
    document: &Document,
    accessors: &mut Accessors<'_>,
) -> Result<Vec<SkinBinding>, SceneError> {
    let mut skins = Vec::new();
    for (index, skin) in document.skins.iter().enumerate() {
        let place = format!("skin {index}");
        for &joint in &skin.joints {
            find(&document.nodes, joint, "node", &place)?;
        }
        let joints: Vec<usize> = skin.joints.iter().map(|&joint| joint as usize).collect();
        let inverse_bind = match skin.inverse_bind_matrices {
            None => vec![Affine3A::IDENTITY; joints.len()],
            Some(accessor) => {
                let mut matrices = accessors.floats::<16>(accessor, None)?;
                if matrices.len() < joints.len() {
                    let (found, wanted) = (matrices.len(), joints.len());
                    let reason =
                        format!("must have {wanted} matrices, one for each joint, got {found}");
                    return Err(SceneError::content(place, reason));
                }
                matrices.truncate(joints.len());
                matrices.iter().map(transform::affine_from_columns).collect()
            }
        };
        skins.push(SkinBinding { joints, inverse_bind });
    }
    Ok(skins)
}

fn check_joints(
    shown: &[usize],
    nodes: &[Node],
    meshes: &[Mesh],
    skins: &[SkinBinding],
) -> Result<(), SceneError> {
    for &index in shown {
        let (Some(mesh), Some(skin)) = (nodes[index].mesh, nodes[index].skin) else { continue };
        for primitive in &meshes[mesh].primitives {
            check_influences(primitive, index, (mesh, skin), skins)?;
        }
    }
    Ok(())
}

/// Checks that a skin has all joints that a primitive of a node uses.
fn check_influences(
    primitive: &Primitive,
    node: usize,
    (mesh, skin): (usize, usize),
    skins: &[SkinBinding],
) -> Result<(), SceneError> {
    let found = skins[skin].joints.len();
    match primitive.influences.as_ref().map(|influences| influences.joints) {
        Some(wanted) if wanted > found => {
            let reason =
                format!("mesh {mesh} uses joint {}, but skin {skin} has {found}", wanted - 1);
            Err(SceneError::content(format!("node {node}"), reason))
        }
        _ => Ok(()),
    }
}

fn expressions(
    expressions: &Expressions,
    targets: &[usize],
) -> Result<Vec<Expression>, SceneError> {
    let mut result = Vec::new();
    for (name, expression) in expressions.preset.iter().chain(&expressions.custom) {
        let place = format!("VRM's expression {name}");
        let mut binds = Vec::new();
        for bind in &expression.morph_target_binds {
            let &found = find(targets, bind.node, "node", &place)?;
            if bind.index as usize >= found {
                let reason = format!(
                    "refers to morph target {}, but node {} has {found}",
                    bind.index, bind.node
                );
                return Err(SceneError::content(place, reason));
            }
            if !bind.weight.is_finite() {
                return Err(SceneError::content(place, "weight must be finite"));
            }
            binds.push((bind.node as usize, bind.index as usize, bind.weight));
        }
        result.push(Expression { name: name.clone(), binds, is_binary: expression.is_binary });
    }
    Ok(result)
}
