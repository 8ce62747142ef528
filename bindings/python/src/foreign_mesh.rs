//! Meshes of other packages, such as trimesh, by the names of their attributes.

use std::path::PathBuf;

use pyo3::intern;
use pyo3::prelude::*;
use uvgraft::Mesh;
use uvgraft_assembly::mesh_file::LoadedMesh;
use uvgraft_io::textured::WithoutUv;

use crate::arrays::rows;
use crate::error::{bad_type, failed};
use crate::mesh::indices;

/// A mesh from an object with `vertices`, `faces` and `visual.uv`; `None` if it has not the first two.
///
/// - `what`: the name of the argument, for messages, and of the mesh where it has no file.
///
/// # Errors
/// `uvgraft.Error` without UV coordinates, and for what no mesh can have; `TypeError` and `ValueError` for
/// arrays of other dtypes and shapes, and for scenes, which are several meshes.
pub(crate) fn converted(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Option<LoadedMesh>> {
    let py = given.py();
    let vertices = given.getattr_opt(intern!(py, "vertices"))?;
    let faces = given.getattr_opt(intern!(py, "faces"))?;
    let (Some(vertices), Some(faces)) = (vertices, faces) else {
        if given.hasattr(intern!(py, "geometry"))? && given.hasattr(intern!(py, "graph"))? {
            return Err(bad_type(format_args!(
                "{what} must be one mesh, got a scene; scene.to_mesh() makes one of those in it"
            )));
        }
        return Ok(None);
    };
    let name = file_name(given).unwrap_or_else(|| what.to_owned());
    let visual = given.getattr_opt(intern!(py, "visual"))?;
    let uv = visual.map(|visual| visual.getattr_opt(intern!(py, "uv"))).transpose()?.flatten();
    let Some(uv) = uv.filter(|uv| !uv.is_none()) else {
        return Err(failed(format_args!("{name}: a mesh must have UV coordinates (visual.uv)")));
    };
    let of = |attribute: &str| format!("{what}.{attribute}");
    let positions = rows::<f32, 3>(&vertices, &of("vertices"), "float32")?;
    let faces = rows::<i64, 3>(&faces, &of("faces"), "int64")?;
    let faces = indices(&faces, &of("faces"))?;
    // V is up, as in OBJ files, also of glTF files. Rounded once, as by the reader of OBJ files, to which maps are
    // equal then.
    let uv = rows::<f64, 2>(&uv, &of("visual.uv"), "float64")?;
    let uv = uv.into_iter().map(|[u, v]| [u as f32, (1.0 - v) as f32]).collect();
    let mesh = Mesh::from_triangles(positions, uv, &faces, &faces)
        .map_err(|error| failed(format_args!("{name}: {error}")))?;
    Ok(Some(LoadedMesh { mesh, name, without_uv: WithoutUv::default() }))
}

/// The file that trimesh has read an object from, without its folder. Which attribute has it depends on the version.
fn file_name(given: &Bound<'_, PyAny>) -> Option<String> {
    let of_source = || given.getattr("source")?.getattr("file_path")?.extract::<PathBuf>();
    let of_metadata = || given.getattr("metadata")?.get_item("file_name")?.extract::<PathBuf>();
    let path = of_source().or_else(|_| of_metadata()).ok()?;
    Some(path.file_name()?.to_string_lossy().into_owned())
}
