//! The geometry of a file: one primitive with its own vertices for each material of a mesh.

use glam::{Quat, Vec3};
use uvgraft::TangentFrames;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{Morph, Skin};

use super::buffer::Buffer;
use super::json::{self, ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER};
use super::material::AvatarMaterial;
use super::shading::Shading;
use super::skin;
use super::vertices::{Inputs, Vertices};

/// The triangles of one material.
pub(super) struct WrittenPrimitive {
    pub material: u8,
    pub primitive: json::Primitive,
    pub vertices: usize,
    pub triangles: usize,
    /// Whether all UV coordinates are within the unit square.
    pub is_inside: bool,
    /// For each morph, whether it moves any of the vertices.
    pub moves: Vec<bool>,
}

/// Smaller changes of normals are dropped: a tenth of a degree is invisible.
const MIN_NORMAL_CHANGE: f32 = 0.002;

/// Appends an avatar's geometry; materials without triangles get no primitive.
///
/// - `skin`: the avatar's skin, pruned to the number of influences that a file can hold.
/// - `normals`: see [`Export::normals`](super::Export::normals).
pub(super) fn write(
    avatar: &Avatar,
    skin: &Skin,
    normals: Option<&[[f32; 3]]>,
    materials: &[AvatarMaterial],
    buffer: &mut Buffer,
) -> Vec<WrittenPrimitive> {
    let shading = Shading::new(&avatar.mesh).with_normals(normals.unwrap_or_default());
    let frames = materials.iter().any(AvatarMaterial::has_tangents).then(|| {
        let shown: Vec<[f32; 3]> = shading.shown.iter().map(|&normal| normal.into()).collect();
        TangentFrames::with_normals(&avatar.mesh, &shown)
    });
    let changes =
        avatar.morphs.iter().map(|morph| shading.changes(&morph.offsets, MIN_NORMAL_CHANGE));
    let source = Source { avatar, skin, changes: changes.collect() };
    let mut parts = Vec::new();
    for (index, material) in (0_u8..=u8::MAX).zip(materials) {
        let frames = frames.as_ref().filter(|_| material.has_tangents());
        let inputs = Inputs { frames, materials: &avatar.materials, only: Some(index) };
        let vertices = Vertices::new(&avatar.mesh, &shading, inputs);
        if !vertices.indices.is_empty() {
            parts.push(source.part(index, &vertices, buffer));
        }
    }
    parts
}

struct Source<'a> {
    avatar: &'a Avatar,
    skin: &'a Skin,
    /// Changes of normals for each morph.
    changes: Vec<Vec<(u32, [f32; 3])>>,
}

impl Source<'_> {
    fn part(&self, material: u8, vertices: &Vertices, buffer: &mut Buffer) -> WrittenPrimitive {
        let joints = self.avatar.skeleton.joints().len();
        let (joint_numbers, weights) = skin::write(self.skin, joints, vertices, buffer);
        let attributes = json::Attributes {
            position: buffer.floats(&vertices.positions, Some(ARRAY_BUFFER), true),
            normal: buffer.floats(&vertices.normals, Some(ARRAY_BUFFER), false),
            tangent: vertices
                .tangents
                .as_ref()
                .map(|tangents| buffer.floats(tangents, Some(ARRAY_BUFFER), false)),
            texcoord: buffer.floats(&vertices.uv, Some(ARRAY_BUFFER), false),
            joints: joint_numbers,
            weights,
        };
        let indices = buffer.indices(&vertices.indices, Some(ELEMENT_ARRAY_BUFFER));
        let mut moves = Vec::with_capacity(self.avatar.morphs.len());
        let mut targets = Vec::with_capacity(self.avatar.morphs.len());
        for (morph, changes) in self.avatar.morphs.iter().zip(&self.changes) {
            let (target, is_moved) = target(morph, changes, vertices, buffer);
            targets.push(target);
            moves.push(is_moved);
        }
        WrittenPrimitive {
            material,
            primitive: json::Primitive {
                attributes,
                indices,
                material: usize::from(material),
                targets,
            },
            vertices: vertices.count(),
            triangles: vertices.indices.len() / 3,
            is_inside: vertices.uv.as_flattened().iter().all(|value| (0.0..=1.0).contains(value)),
            moves,
        }
    }
}

/// Appends a morph target; also returns whether it moves any of the vertices.
fn target(
    morph: &Morph,
    changes: &[(u32, [f32; 3])],
    vertices: &Vertices,
    buffer: &mut Buffer,
) -> (json::Target, bool) {
    let count = vertices.count();
    let (offsets, normals) = (vertices.spread(&morph.offsets), vertices.spread(changes));
    let tangent = vertices.tangents.as_ref().map(|tangents| {
        let changed = normals.iter().map(|&(vertex, change)| {
            let normal = Vec3::from(vertices.normals[vertex as usize]);
            (vertex, tangent_change(normal, change.into(), tangents[vertex as usize]))
        });
        let changed: Vec<_> = changed.collect();
        buffer.offsets(&changed, count, false)
    });
    let is_moved = !offsets.is_empty();
    let target = json::Target {
        position: buffer.offsets(&offsets, count, true),
        normal: buffer.offsets(&normals, count, false),
        tangent,
    };
    (target, is_moved)
}

/// Change of a tangent when its normal changes: it is rotated by the shortest arc from
/// the old normal to the new one.
fn tangent_change(normal: Vec3, change: Vec3, [x, y, z, _]: [f32; 4]) -> [f32; 3] {
    let tangent = Vec3::new(x, y, z);
    match (normal + change).try_normalize() {
        Some(moved) => (Quat::from_rotation_arc(normal, moved) * tangent - tangent).into(),
        None => [0.0; 3],
    }
}
