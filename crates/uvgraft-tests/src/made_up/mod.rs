//! Synthetic body models on real templates: SMPL-X and FLAME in keys and sizes, with our own
//! joints, weights and expressions, so that the true effect of every expression is known.
//!
//! Real models may not be redistributed. These use their meshes, which are in the data folder, and
//! expression components that are a random rotation of known, smooth ones: as entangled as learnt
//! components, and as expressive.

mod entangled;
mod faces;
mod joints;
mod lips;

pub use entangled::Entanglement;
pub use faces::Truth;

use uvgraft::Mesh;
use uvgraft::anatomy::Anatomy;
use uvgraft_avatar::body::BodyKind;
use uvgraft_io::arrays::{NamedArrays, NumericArray};

use crate::real;

/// A synthetic model.
#[derive(Debug, Clone)]
pub struct MadeUp {
    /// The arrays of its model file.
    pub arrays: NamedArrays,
    /// Its mesh, with the layout from the data folder.
    pub mesh: Mesh,
    /// The movements that its expression components were mixed from.
    pub truths: Vec<Truth>,
}

/// SMPL-X on its template; `None`, with a message, without real data.
///
/// # Panics
/// If a file in the folder is missing or invalid.
pub fn smplx(entanglement: &Entanglement) -> Option<MadeUp> {
    let path = real::folder()?.join("smplx_addon.obj");
    Some(model(BodyKind::SmplX, uvgraft_io::obj::read(&path).expect("a sound mesh"), entanglement))
}

/// FLAME on its template; `None`, with a message, without real data.
///
/// # Panics
/// If a file in the folder is missing or invalid.
pub fn flame(entanglement: &Entanglement) -> Option<MadeUp> {
    let path = real::folder()?.join("flame_head_template.obj");
    Some(model(BodyKind::Flame, uvgraft_io::obj::read(&path).expect("a sound mesh"), entanglement))
}

/// A model of a kind that has a face.
fn model(kind: BodyKind, mesh: Mesh, entanglement: &Entanglement) -> MadeUp {
    let anatomy = Anatomy::find(&mesh).expect("a template that shows a face");
    let vertices = mesh.positions().len();
    let rig = joints::rig(kind, &mesh, &anatomy);
    let joints = rig.places.len();
    let mut arrays = NamedArrays::new();
    let mut floats = |name: &str, shape: &[usize], values: Vec<f32>| {
        let array = NumericArray::new_f32(shape.to_vec(), values);
        arrays.insert(name, array.expect("as many values as the shape says"));
    };
    floats("v_template", &[vertices, 3], mesh.positions().as_flattened().to_vec());
    floats("weights", &[vertices, joints], rig.weights);
    floats("J_regressor", &[joints, vertices], rig.regressor);
    let shapes = joints::shapes(&mesh);
    floats("shapedirs", &[vertices, 3, shapes.len()], in_columns(&shapes));
    let truths = faces::truths(&mesh, &anatomy);
    let components = entanglement.components(&mesh, &anatomy, &truths);
    floats("exprdirs", &[vertices, 3, components.len()], in_columns(&components));
    let features = 9 * (joints - 1);
    floats("posedirs", &[vertices, 3, features], vec![0.0; vertices * 3 * features]);
    let mut integers = |name: &str, shape: &[usize], values: Vec<i64>| {
        let array = NumericArray::new_i64(shape.to_vec(), values);
        arrays.insert(name, array.expect("as many values as the shape says"));
    };
    let parents = rig.parents.iter().map(|parent| parent.map_or(0xffff_ffff, |at| at as i64));
    integers("kintree_table", &[2, joints], parents.chain(0..joints as i64).collect());
    let corners = mesh.faces().as_flattened().iter().map(|&vertex| i64::from(vertex));
    integers("f", &[mesh.faces().len(), 3], corners.collect());
    MadeUp { arrays, mesh, truths }
}

/// Vertex offsets of all components, as the columns of a matrix.
fn in_columns(components: &[Vec<[f32; 3]>]) -> Vec<f32> {
    let coordinates = components.first().map_or(0, |component| component.len() * 3);
    let row = |at: usize| components.iter().map(move |component| component[at / 3][at % 3]);
    (0..coordinates).flat_map(row).collect()
}
