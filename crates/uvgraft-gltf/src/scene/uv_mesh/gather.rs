//! Gathers primitives into one mesh.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use glam::Affine3A;
use uvgraft::mesh::{Mesh, MeshPart};
use uvgraft_io::textured::{TexturedMesh, WithoutUv};

use super::super::accessor::Accessors;
use super::super::appearance::UvSource;
use super::super::budget::{
    Demand, MAX_NAME_BYTES, MAX_PRIMITIVES, MAX_TRIANGLES, MAX_VERTICES, Purpose,
};
use super::super::check::too_many;
use super::super::demand::{LISTED, MESH_TRIANGLE, MESH_UV, MESH_VERTEX, REPORT_BLOCKS};
use super::super::document::{Document, Primitive};
use super::super::error::SceneError;
use super::super::geometry::{read_triangles, read_vertices};
use super::super::instances::InstancePose;
use super::super::posing::world;
use super::super::skinning::deformed;
use super::super::{Hierarchy, SkinBinding, check_influences};
use super::SceneMeshError;
use super::choice::{Shown, material_name, mesh_name};
use super::image_names::ImageNames;

/// What determines where the vertices of a node's primitives are: the accessors of positions, skin
/// and morph targets.
type Shape<'a> = (Vec<(&'a str, u32)>, Vec<Option<u32>>);

/// UV coordinates of a node: their accessor, their number, and how they are transformed. A wrong
/// number is refused when the accessor is read.
type UvKey = (usize, u32, usize, Option<[u32; 5]>);

pub(super) struct Gatherer<'a> {
    document: &'a Document,
    hierarchy: &'a Hierarchy,
    skins: &'a [SkinBinding],
    uv_set: Option<u32>,
    image_names: ImageNames,
    world: Vec<Affine3A>,
    /// Transforms of the joints of the skins used so far.
    joints: HashMap<usize, Vec<Affine3A>>,
    /// For each primitive of the meshes used so far, the first one of equal shape.
    first_alike: HashMap<usize, Vec<usize>>,
    /// First vertex and number of vertices by node and primitive.
    vertices_of: HashMap<(usize, usize), (u32, usize)>,
    uv_of: HashMap<UvKey, u32>,
    positions: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    faces: Vec<[u32; 3]>,
    uv_faces: Vec<[u32; 3]>,
    parts: Vec<MeshPart>,
    name_bytes: u64,
    /// What the file asks for.
    demand: Demand,
    without_uv: WithoutUv,
    /// The error of the first primitive without the UV set.
    first_without_uv: Option<SceneMeshError>,
}

impl<'a> Gatherer<'a> {
    pub(super) fn new(
        document: &'a Document,
        hierarchy: &'a Hierarchy,
        skins: &'a [SkinBinding],
        uv_set: Option<u32>,
        image_names: ImageNames,
    ) -> Self {
        let rest = |node: usize| hierarchy.nodes[node].rest;
        Self {
            document,
            hierarchy,
            skins,
            uv_set,
            image_names,
            world: world(&hierarchy.nodes, &hierarchy.order, rest),
            joints: HashMap::new(),
            first_alike: HashMap::new(),
            vertices_of: HashMap::new(),
            uv_of: HashMap::new(),
            positions: Vec::new(),
            uv: Vec::new(),
            faces: Vec::new(),
            uv_faces: Vec::new(),
            parts: Vec::new(),
            name_bytes: 0,
            demand: Demand::default(),
            without_uv: WithoutUv::default(),
            first_without_uv: None,
        }
    }

    /// Adds up what primitives ask for, before they are added.
    ///
    /// - `demand`: what the file asks for without them.
    pub(super) fn check_demand(
        &mut self,
        chosen: &[Shown<'_>],
        mut demand: Demand,
    ) -> Result<(), SceneMeshError> {
        let (mut primitives, mut vertices, mut triangles) = (0_u64, 0_u64, 0_u64);
        let (mut known, mut known_uv) = (HashSet::new(), HashSet::new());
        for shown in chosen {
            let instances = self.hierarchy.nodes[shown.node].instances().len() as u64;
            let times = |count: u64| count.saturating_mul(instances);
            let attributes = &shown.primitive.attributes;
            primitives = primitives.saturating_add(instances);
            let faces = times(self.document.triangles(shown.primitive).1);
            triangles = triangles.saturating_add(faces);
            let uv = attributes.get(&format!("TEXCOORD_{}", self.set(shown)?));
            // Without UV coordinates it is only counted.
            let Some(&uv) = uv else { continue };
            demand.add(Purpose::Geometry, faces, MESH_TRIANGLE);
            let count = self.document.vertices(shown.primitive);
            if known.insert((shown.node, self.alike(shown))) {
                vertices = vertices.saturating_add(times(count));
                let node = &self.hierarchy.nodes[shown.node];
                let is_skinned = node.skin.is_some();
                let moving = self.document.moving_bytes(shown.primitive, &node.weights, is_skinned);
                demand.pass(Purpose::Geometry, moving);
            }
            if known_uv.insert((shown.node, uv, shown.primitive.material)) {
                demand.add(Purpose::Geometry, times(count), MESH_UV);
            }
        }
        too_many("primitives, of all nodes and instances", primitives, MAX_PRIMITIVES)?;
        too_many("vertices, of all nodes and instances", vertices, MAX_VERTICES)?;
        too_many("triangles, of all nodes and instances", triangles, MAX_TRIANGLES)?;
        demand.add(Purpose::Geometry, vertices, MESH_VERTEX);
        demand.check()?;
        self.demand = demand;
        Ok(())
    }

    /// Adds up what a report of the layout takes for triangles by their height in it: each is listed in every block
    /// of rows that it touches, so copies that fill the layout take far more than their corners.
    fn check_heights(&mut self) -> Result<(), SceneError> {
        let blocks = self.uv_faces.iter().map(|face| {
            let v = face.map(|corner| self.uv[corner as usize][1].clamp(0.0, 1.0));
            let height = v.into_iter().fold(0.0, f32::max) - v.into_iter().fold(1.0, f32::min);
            (height.max(0.0) * REPORT_BLOCKS) as u64 + 1
        });
        self.demand.add(Purpose::Geometry, blocks.sum(), LISTED);
        self.demand.check()
    }

    /// The first primitive of its mesh whose vertices are the same.
    fn alike(&mut self, shown: &Shown<'_>) -> usize {
        let first = self.first_alike.entry(shown.mesh);
        first.or_insert_with(|| first_alike(&self.document.meshes[shown.mesh].primitives))
            [shown.number]
    }

    pub(super) fn add(
        &mut self,
        shown: &Shown<'_>,
        accessors: &mut Accessors<'_>,
    ) -> Result<(), SceneMeshError> {
        let set = self.set(shown)?;
        let attributes = &shown.primitive.attributes;
        let Some(&accessor) = attributes.get(&format!("TEXCOORD_{set}")) else {
            return self.leave_out(shown, set);
        };
        let place = shown.place();
        let (first, count) = self.vertices(shown, accessors)?;
        let first_uv = self.coordinates(shown, (set, accessor), count, accessors)?;
        let triangles = read_triangles(shown.primitive, count, &place, accessors)?;
        let (hierarchy, start) = (self.hierarchy, self.faces.len());
        let node = &hierarchy.nodes[shown.node];
        for (index, instance) in node.instances().iter().enumerate() {
            let is_mirrored = self.pose(shown.node, instance).is_mirrored;
            let moved = (index * count) as u32;
            for &[a, b, c] in &triangles {
                let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
                self.faces.push(corners.map(|corner| first + moved + corner));
                self.uv_faces.push(corners.map(|corner| first_uv + moved + corner));
            }
        }
        self.add_part(shown, start as u32)?;
        Ok(())
    }

    /// How the vertices of an instance of a node get to the world; its skin must have been used.
    fn pose(&self, node: usize, instance: &Affine3A) -> InstancePose<'_> {
        let skin = self.hierarchy.nodes[node].skin;
        let joints = skin.and_then(|skin| self.joints.get(&skin)).map(Vec::as_slice);
        InstancePose::new(&self.world[node], instance, joints)
    }

    /// First vertex and number of vertices of a primitive, which are added unless an earlier one of
    /// the node has the same. Those of further instances follow.
    fn vertices(
        &mut self,
        shown: &Shown<'_>,
        accessors: &mut Accessors<'_>,
    ) -> Result<(u32, usize), SceneError> {
        let key = (shown.node, self.alike(shown));
        if let Some(&known) = self.vertices_of.get(&key) {
            return Ok(known);
        }
        let hierarchy = self.hierarchy;
        let node = &hierarchy.nodes[shown.node];
        let primitive =
            read_vertices(shown.primitive, &node.weights, node.skin.is_some(), accessors)?;
        let count = primitive.positions.len();
        if let Some(skin) = node.skin {
            check_influences(&primitive, shown.node, (shown.mesh, skin), self.skins)?;
            let transforms = || self.skins[skin].transforms(&self.world);
            self.joints.entry(skin).or_insert_with(transforms);
        }
        let known = (self.positions.len() as u32, count);
        for instance in node.instances() {
            let pose = self.pose(shown.node, instance);
            let (positions, _) = deformed(&primitive, &node.weights, &pose);
            self.positions.extend(positions);
        }
        self.vertices_of.insert(key, known);
        Ok(known)
    }

    /// The UV set that is read of a primitive.
    fn set(&self, shown: &Shown<'_>) -> Result<u32, SceneError> {
        let material = shown.primitive.material;
        let material = material.and_then(|index| self.document.materials.get(index as usize));
        match (self.uv_set, material) {
            (Some(set), _) => Ok(set),
            (None, Some(material)) => Ok(UvSource::of_base_color(material, &shown.place())?.set),
            (None, None) => Ok(0),
        }
    }

    /// First UV coordinate of a primitive; those of further instances follow.
    fn coordinates(
        &mut self,
        shown: &Shown<'_>,
        (set, accessor): (u32, u32),
        count: usize,
        accessors: &mut Accessors<'_>,
    ) -> Result<u32, SceneMeshError> {
        let material = shown.primitive.material.map(|index| index as usize);
        let source = match material.and_then(|index| self.document.materials.get(index)) {
            Some(material) => UvSource::of_set(material, set, &shown.place())?,
            None => UvSource::default(),
        };
        let known = match self.uv_of.entry((shown.node, accessor, count, source.transform_bits())) {
            Entry::Occupied(known) => return Ok(*known.get()),
            Entry::Vacant(entry) => entry,
        };
        let mut uv = accessors.floats::<2>(accessor, Some(count))?;
        source.transform(&mut uv);
        let first = self.uv.len() as u32;
        let instances = self.hierarchy.nodes[shown.node].instances().len();
        let total = self.uv.len() + instances * uv.len();
        too_many("UV coordinates", total as u64, MAX_VERTICES)?;
        (0..instances).for_each(|_| self.uv.extend(&uv));
        Ok(*known.insert(first))
    }

    /// Counts a primitive without the UV set.
    fn leave_out(&mut self, shown: &Shown<'_>, set: u32) -> Result<(), SceneMeshError> {
        let attributes = &shown.primitive.attributes;
        // As stated: nothing of it is unpacked.
        let triangles = self.document.triangles(shown.primitive).1;
        if triangles == 0 {
            return Ok(());
        }
        let names = self.names(shown);
        let parts = self.without_uv.parts.len();
        let instances = self.hierarchy.nodes[shown.node].instances().len();
        let count = triangles.saturating_mul(instances as u64);
        self.without_uv.add(names, usize::try_from(count).unwrap_or(usize::MAX));
        if self.without_uv.parts.len() > parts {
            self.spend_names(names)?;
        }
        if self.first_without_uv.is_none() {
            // Sets are numbered without gaps, and few viewers know more than two.
            let sets = attributes.keys().filter(|name| name.starts_with("TEXCOORD_")).take(8);
            let sets = sets.map(|name| name.chars().take(20).collect()).collect();
            let place = self.named(shown);
            self.first_without_uv = Some(SceneMeshError::NoUvSet { place, set, sets });
        }
        Ok(())
    }

    /// The names of a primitive's node, mesh and material.
    fn names(&self, shown: &Shown<'_>) -> [&'a str; 3] {
        let node = self.hierarchy.nodes[shown.node].name.as_str();
        [node, mesh_name(self.document, shown), material_name(self.document, shown)]
    }

    /// Counts the names of a new part towards the limit.
    fn spend_names(&mut self, names: [&str; 3]) -> Result<(), SceneError> {
        self.name_bytes += names.map(str::len).iter().sum::<usize>() as u64;
        too_many("bytes of names", self.name_bytes, MAX_NAME_BYTES)
    }

    /// A primitive by its names, for messages.
    fn named(&self, shown: &Shown<'_>) -> String {
        let node: String = self.hierarchy.nodes[shown.node].name.chars().take(40).collect();
        let place = shown.place();
        if node.is_empty() { place } else { format!("node {node:?}, {place}") }
    }

    /// Names the triangles from `start` on.
    fn add_part(&mut self, shown: &Shown<'_>, start: u32) -> Result<(), SceneError> {
        let end = self.faces.len() as u32;
        let names = self.names(shown);
        let [object, group, material] = names;
        let image = self.image_names.of(shown.primitive).to_owned();
        if let Some(last) = self.parts.last_mut()
            && (&*last.object, &*last.group, &*last.material) == (object, group, material)
            && last.image.as_ref() == Some(&image)
        {
            last.polygons.end = end;
            return Ok(());
        }
        if start == end {
            return Ok(());
        }
        self.spend_names(names)?;
        self.name_bytes += image.len() as u64;
        self.parts.push(MeshPart {
            object: object.to_owned(),
            group: group.to_owned(),
            material: material.to_owned(),
            image: Some(image),
            polygons: start..end,
        });
        Ok(())
    }

    pub(super) fn finish(mut self) -> Result<TexturedMesh, SceneMeshError> {
        if self.faces.is_empty() {
            return Err(self.first_without_uv.unwrap_or(SceneMeshError::NoTriangles));
        }
        self.check_heights()?;
        let is_named = |part: &MeshPart| {
            let names = [&part.object, &part.group, &part.material];
            names.into_iter().chain(&part.image).any(|name| !name.is_empty())
        };
        let is_named = self.parts.iter().any(is_named);
        let mesh = Mesh::from_triangles(self.positions, self.uv, &self.faces, &self.uv_faces)?;
        let mesh = if is_named { mesh.with_parts(self.parts) } else { mesh };
        Ok(TexturedMesh { mesh, without_uv: self.without_uv })
    }
}

/// For each primitive the first one whose vertices are the same.
fn first_alike(primitives: &[Primitive]) -> Vec<usize> {
    let mut known: HashMap<Shape<'_>, usize> = HashMap::new();
    let shapes = primitives.iter().map(|primitive| -> Shape<'_> {
        let moves = |name: &str| {
            name == "POSITION" || name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_")
        };
        let attributes = primitive.attributes.iter().filter(|(name, _)| moves(name));
        let targets = primitive.targets.iter().map(|target| target.get("POSITION").copied());
        (attributes.map(|(name, &accessor)| (name.as_str(), accessor)).collect(), targets.collect())
    });
    shapes.enumerate().map(|(index, shape)| *known.entry(shape).or_insert(index)).collect()
}
