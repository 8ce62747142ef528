//! What a file asks for, added up from its JSON.
//!
//! Counts are those that the JSON states: readers refuse arrays that have others. What is read twice is
//! counted once where it is shared ([`SharedArrays`](super::shared::SharedArrays)); what does not exist is
//! left to them, too.

use std::collections::HashSet;

use super::appearance::UvSource;
use super::budget::{
    Demand, MAX_BINDS, MAX_BYTES, MAX_INSTANCES, MAX_MOVES, MAX_PRIMITIVES, MAX_TRIANGLES,
    MAX_VERTICES, MAX_WEIGHTS, Purpose,
};
use super::check::too_many;
use super::document::{Accessor, Compressed, Document, Node, Primitive};
use super::error::SceneError;
use super::geometry::{influence_sets, is_surface};
use super::vrm0::Vrm0;

/// Bytes of a vector while it is read, and of what is left of it.
const VECTOR: u64 = 12;
/// Bytes of UV coordinates.
const UV: u64 = 8;
/// Bytes of a colour.
const COLOR: u64 = 16;
/// Bytes of the first vertex at a position, and of the table that finds it.
const FIRST: u64 = 4;
const FIRST_TABLE: u64 = 48;
/// Bytes of a triangle, and of its corners while they are read.
const TRIANGLE: u64 = 12;
const CORNER: u64 = 8;
/// Bytes of a vertex's displacement.
const DISPLACEMENT: u64 = 16;
/// Bytes of four joints and weights, and of these while they are read.
const INFLUENCES: u64 = 32;
const READ_INFLUENCES: u64 = 64;

/// Bytes of a primitive as it is posed, with its share of all lists.
const POSED: u64 = 512;
/// Bytes of a vertex as it is posed and drawn, without colours and further UV coordinates; measured with
/// `render`.
const DRAWN_VERTEX: u64 = 96;
/// Bytes of a triangle as it is drawn; measured with `render`.
const DRAWN_TRIANGLE: u64 = 480;
/// Bytes of a vertex, a pair of UV coordinates and a triangle of a mesh with its report; measured with
/// `inspect mesh`.
pub(super) const MESH_VERTEX: u64 = 80;
pub(super) const MESH_UV: u64 = 24;
pub(super) const MESH_TRIANGLE: u64 = 240;
/// Blocks of 16 rows in a report, which is made for 2048 texels unless it is asked for more; and bytes of a
/// triangle in each block.
pub(super) const REPORT_BLOCKS: f32 = 128.0;
pub(super) const LISTED: u64 = 28;

/// Bytes of an instance: its transform, and what it is made of.
const INSTANCE: u64 = 128;
/// Bytes of a joint of a skin: its node, its matrix, and its pose.
const JOINT: u64 = 256;
/// Bytes of a node's weight of a morph target, at rest and posed.
const WEIGHT: u64 = 12;
/// Bytes of a morph target that an expression moves.
const BIND: u64 = 64;
/// Bytes of a number of an animation, and while it is read.
const KEY: u64 = 4;

/// Bytes of a face and of a point while Draco decodes them, apart from their values: tables of corners,
/// maps of points and the entropy coder's symbols.
const DRACO_FACE: u64 = 128;
const DRACO_POINT: u64 = 64;

impl Document {
    fn accessor(&self, index: u32) -> Option<&Accessor> {
        self.accessors.get(index as usize)
    }

    /// Stated number of elements; 0 without the accessor.
    fn count(&self, index: u32) -> u64 {
        self.accessor(index).map_or(0, |accessor| accessor.count)
    }

    pub fn vertices(&self, primitive: &Primitive) -> u64 {
        primitive.attributes.get("POSITION").map_or(0, |&index| self.count(index))
    }

    /// Number of corners, and of the triangles that they make.
    pub fn triangles(&self, primitive: &Primitive) -> (u64, u64) {
        let corners =
            primitive.indices.map_or_else(|| self.vertices(primitive), |it| self.count(it));
        let is_list = primitive.mode.unwrap_or(4) == 4;
        (corners, if is_list { corners / 3 } else { corners.saturating_sub(2) })
    }

    /// The most vertices that an array of displacements moves: those without data move none.
    fn displaced(&self, index: u32) -> u64 {
        let Some(accessor) = self.accessor(index) else { return 0 };
        let sparse = accessor.sparse.as_ref().map_or(0, |sparse| sparse.count);
        if accessor.buffer_view.is_some() { accessor.count } else { sparse.min(accessor.count) }
    }

    /// How often a node draws its mesh.
    pub fn instances(&self, node: &Node) -> u64 {
        let Some(instancing) = &node.extensions.instancing else { return 1 };
        let attributes = &instancing.attributes;
        let known = ["TRANSLATION", "ROTATION", "SCALE"].map(|name| attributes.get(name));
        let first = known.into_iter().flatten().chain(attributes.values()).next();
        first.map_or(1, |&index| self.count(index))
    }

    /// For each mesh, how often the scene draws it.
    fn drawn(&self) -> Vec<u64> {
        let mut times = vec![0_u64; self.meshes.len()];
        let mut rest: Vec<u32> = match self.scenes.get(self.scene.unwrap_or(0) as usize) {
            Some(scene) => scene.nodes.clone(),
            None => (0..self.nodes.len() as u32).collect(),
        };
        let mut is_known = vec![false; self.nodes.len()];
        while let Some(index) = rest.pop() {
            let Some(node) = self.nodes.get(index as usize) else { continue };
            if std::mem::replace(&mut is_known[index as usize], true) {
                continue;
            }
            rest.extend(&node.children);
            if let Some(times) = node.mesh.and_then(|mesh| times.get_mut(mesh as usize)) {
                *times = times.saturating_add(self.instances(node));
            }
        }
        times
    }
}

impl Demand {
    /// Adds what becomes of compressed parts.
    ///
    /// # Errors
    /// For too much.
    pub fn add_unpacked(&mut self, document: &Document) -> Result<(), SceneError> {
        let views = document.buffer_views.iter();
        let streams = views.filter_map(|view| view.extensions.meshopt.as_ref());
        let bytes = streams.map(Compressed::decoded_length).fold(0, u64::saturating_add);
        too_many("decompressed bytes", bytes, MAX_BYTES)?;
        self.add(Purpose::Geometry, bytes, 1);
        for primitive in document.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            let Some(draco) = &primitive.extensions.draco else { continue };
            let (corners, faces) = document.triangles(primitive);
            let points = document.vertices(primitive);
            self.add(Purpose::Geometry, corners, 4);
            let known = draco.attributes.keys().filter_map(|name| primitive.attributes.get(name));
            for accessor in known.filter_map(|&index| document.accessor(index)) {
                // Floats of at most four components, also where they are stored as bytes.
                self.add(Purpose::Geometry, accessor.count, 2 * 16);
            }
            self.pass(Purpose::Geometry, faces.saturating_mul(DRACO_FACE));
            self.pass(Purpose::Geometry, points.saturating_mul(DRACO_POINT));
        }
        Ok(())
    }

    /// Adds nodes: their weights and their instances.
    ///
    /// # Errors
    /// For too many.
    pub fn add_nodes(&mut self, document: &Document) -> Result<(), SceneError> {
        let (mut weights, mut instances) = (0_u64, 0_u64);
        let targets = |primitive: &Primitive| primitive.targets.len();
        let of_meshes: Vec<u64> = document
            .meshes
            .iter()
            .map(|mesh| mesh.primitives.iter().map(targets).max().unwrap_or(0) as u64)
            .collect();
        for node in &document.nodes {
            let Some(mesh) = node.mesh else { continue };
            let of_mesh = of_meshes.get(mesh as usize).copied().unwrap_or(0);
            weights = weights.saturating_add(of_mesh);
            if node.extensions.instancing.is_some() {
                instances = instances.saturating_add(document.instances(node));
            }
        }
        too_many("weights of morph targets", weights, MAX_WEIGHTS)?;
        too_many("instances", instances, MAX_INSTANCES)?;
        self.add(Purpose::Motion, weights, WEIGHT);
        self.add(Purpose::Geometry, instances, INSTANCE);
        for skin in &document.skins {
            self.add(Purpose::Motion, skin.joints.len() as u64, JOINT);
            let matrices = skin.inverse_bind_matrices.map_or(0, |index| document.count(index));
            self.pass(Purpose::Motion, matrices.saturating_mul(64));
        }
        Ok(())
    }

    /// Adds animations.
    ///
    /// # Errors
    /// For too many weights of morph targets in a pose.
    pub fn add_clips(&mut self, document: &Document) -> Result<(), SceneError> {
        let mut known = HashSet::new();
        let mut weights = 0_u64;
        for animation in &document.animations {
            for channel in &animation.channels {
                let sampler = animation.samplers.get(channel.sampler as usize);
                let Some(sampler) = sampler.filter(|_| channel.target.node.is_some()) else {
                    continue;
                };
                if channel.target.path == "weights" {
                    let [keys, values] = [sampler.input, sampler.output]
                        .map(|it| it.map_or(0, |it| document.count(it)));
                    weights = weights.saturating_add(values / keys.max(1));
                }
                for index in [sampler.input, sampler.output].into_iter().flatten() {
                    if !known.insert(index) {
                        continue;
                    }
                    let numbers = document.count(index).saturating_mul(4);
                    self.add(Purpose::Motion, numbers, KEY);
                    self.pass(Purpose::Motion, numbers.saturating_mul(2 * KEY));
                }
            }
        }
        too_many("weights in a pose of an animation", weights, MAX_MOVES)
    }

    /// Adds the morph targets that the expressions of VRM 0.x move: they refer to meshes.
    ///
    /// # Errors
    /// For too many.
    pub fn add_expressions(&mut self, document: &Document) -> Result<(), SceneError> {
        let mut shows = vec![0_u64; document.meshes.len()];
        for mesh in document.nodes.iter().filter_map(|node| node.mesh) {
            shows.get_mut(mesh as usize).into_iter().for_each(|count| *count += 1);
        }
        let binds = document.extensions.vrm0.iter().flat_map(Vrm0::bound_meshes);
        let binds = binds.map(|mesh| shows.get(mesh as usize).copied().unwrap_or(0)).sum();
        too_many("morph targets of expressions, for all nodes of a mesh", binds, MAX_BINDS)?;
        self.add(Purpose::Motion, binds, BIND);
        Ok(())
    }

    /// Adds all meshes, as read and as drawn.
    ///
    /// # Errors
    /// For too many.
    pub fn add_meshes(&mut self, document: &Document) -> Result<(), SceneError> {
        let sources = sources(document);
        let drawn_sets = sources.iter().map(Vec::len).max().unwrap_or(1) as u64;
        let is_colored = |primitive: &Primitive| primitive.attributes.contains_key("COLOR_0");
        let mut all = document.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let colored = if all.any(is_colored) { COLOR } else { 0 };
        let a_vertex = DRAWN_VERTEX + UV * (drawn_sets - 1) + colored;
        let (mut primitives, mut vertices, mut triangles, mut moves) = (0_u64, 0_u64, 0_u64, 0_u64);
        let mut read = Arrays::default();
        for (mesh, times) in document.meshes.iter().zip(document.drawn()) {
            for primitive in mesh.primitives.iter().filter(|primitive| is_surface(primitive)) {
                let of_vertices = document.vertices(primitive);
                let of_triangles = document.triangles(primitive).1;
                let at_least_once =
                    |sum: u64, count: u64| sum.saturating_add(count.saturating_mul(times.max(1)));
                primitives = at_least_once(primitives, 1);
                vertices = at_least_once(vertices, of_vertices);
                triangles = at_least_once(triangles, of_triangles);
                moves = at_least_once(moves, document.moves(primitive));
                self.add(Purpose::Geometry, times, POSED);
                self.add(Purpose::Geometry, of_vertices.saturating_mul(times), a_vertex);
                self.add(Purpose::Geometry, of_triangles.saturating_mul(times), DRAWN_TRIANGLE);
                let material = primitive.material.map(|index| index as usize);
                let own = material.and_then(|index| sources.get(index));
                read.add(primitive, own.or(sources.last()), document, self);
            }
        }
        too_many("primitives, of all nodes and instances", primitives, MAX_PRIMITIVES)?;
        too_many("vertices, of all meshes, nodes and instances", vertices, MAX_VERTICES)?;
        too_many("triangles, of all meshes, nodes and instances", triangles, MAX_TRIANGLES)?;
        too_many("movements of vertices by morph targets and joints", moves, MAX_MOVES)
    }
}

impl Document {
    /// Bytes that are needed for a while to find how morph targets and a skin move a primitive's vertices.
    ///
    /// - `weights`: targets of weight 0 are not read.
    pub fn moving_bytes(&self, primitive: &Primitive, weights: &[f32], is_skinned: bool) -> u64 {
        let vertices = self.vertices(primitive);
        let targets = primitive.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
        let positions = targets.filter_map(|(target, _)| target.get("POSITION"));
        let moved = positions.map(|&index| self.displaced(index)).fold(0, u64::saturating_add);
        let sets = if is_skinned { influence_sets(primitive).len() as u64 } else { 0 };
        let by_joints = vertices.saturating_mul(sets * (INFLUENCES + READ_INFLUENCES));
        moved.saturating_mul(2 * DISPLACEMENT).saturating_add(by_joints)
    }

    /// How often vertices of a primitive are moved by all of its morph targets and joints.
    fn moves(&self, primitive: &Primitive) -> u64 {
        let targets = primitive.targets.iter().flat_map(|target| target.values());
        let by_targets = targets.map(|&index| self.displaced(index)).fold(0, u64::saturating_add);
        let joints = 4 * influence_sets(primitive).len() as u64;
        by_targets.saturating_add(self.vertices(primitive).saturating_mul(joints))
    }
}

/// Where the textures of each material find their coordinates; the last entry is for primitives
/// without one. Sources that cannot be read are left out.
fn sources(document: &Document) -> Vec<Vec<UvSource>> {
    let of_material = |material| UvSource::of_all(material);
    let all = document.materials.iter().map(of_material);
    all.chain([vec![UvSource::default()]]).collect()
}

/// Arrays that are read, each once.
#[derive(Default)]
struct Arrays {
    vectors: HashSet<u32>,
    first: HashSet<u32>,
    uv: HashSet<(Option<u32>, u64, Option<[u32; 5]>)>,
    colors: HashSet<u32>,
    triangles: HashSet<(Option<u32>, u32, u64)>,
    displacements: HashSet<u32>,
    influences: HashSet<Vec<[u32; 2]>>,
}

impl Arrays {
    fn add(
        &mut self,
        primitive: &Primitive,
        sources: Option<&Vec<UvSource>>,
        document: &Document,
        demand: &mut Demand,
    ) {
        let mut geometry = |count: u64, kept: u64, passing: u64| {
            demand.add(Purpose::Geometry, count, kept);
            demand.pass(Purpose::Geometry, count.saturating_mul(passing));
        };
        let attribute = |name: &str| primitive.attributes.get(name).copied();
        let vertices = document.vertices(primitive);
        for index in ["POSITION", "NORMAL"].into_iter().filter_map(attribute) {
            if self.vectors.insert(index) {
                geometry(document.count(index), VECTOR, VECTOR);
            }
        }
        let positions = attribute("POSITION").filter(|_| attribute("NORMAL").is_none());
        if positions.is_some_and(|index| self.first.insert(index)) {
            geometry(vertices, FIRST, FIRST_TABLE);
        }
        for source in sources.into_iter().flatten() {
            let stored = attribute(&format!("TEXCOORD_{}", source.set));
            if self.uv.insert((stored, vertices, source.transform_bits())) {
                geometry(vertices, UV, UV);
            }
        }
        if attribute("COLOR_0").is_some_and(|index| self.colors.insert(index)) {
            geometry(vertices, COLOR, 2 * COLOR);
        }
        let (corners, triangles) = document.triangles(primitive);
        if self.triangles.insert((primitive.indices, primitive.mode.unwrap_or(4), vertices)) {
            geometry(triangles, TRIANGLE, TRIANGLE);
            geometry(corners, 0, CORNER);
        }
        for &index in primitive.targets.iter().flat_map(|target| target.values()) {
            if self.displacements.insert(index) {
                geometry(document.displaced(index), DISPLACEMENT, DISPLACEMENT);
                geometry(document.count(index), 0, VECTOR);
            }
        }
        let sets = influence_sets(primitive);
        let count = sets.len() as u64;
        if count > 0 && self.influences.insert(sets) {
            geometry(vertices, INFLUENCES * count + 4, READ_INFLUENCES * count);
        }
    }
}
