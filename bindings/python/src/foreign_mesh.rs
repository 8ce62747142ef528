//! Meshes of other packages, such as trimesh, by the names of their attributes.

use std::path::PathBuf;

use pyo3::intern;
use pyo3::prelude::*;
use uvgraft::Mesh;
use uvgraft_assembly::mesh_file::LoadedMesh;
use uvgraft_io::textured::WithoutUv;

use crate::arrays::rows;
use crate::error::{failed, warn_caller};
use crate::mesh::indices;

/// Vertices of one mesh or of several, with UV coordinates each.
#[derive(Default)]
struct Joined {
    positions: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    faces: Vec<[u32; 3]>,
}

/// A mesh from an object with `vertices`, `faces` and `visual.uv`, or from a scene of these; `None` for
/// anything else.
///
/// - `what`: the name of the argument, for messages, and of the mesh where it has no file.
///
/// # Errors
/// `uvgraft.Error` without UV coordinates, and for what no mesh can have; `TypeError` and `ValueError` for
/// arrays of other dtypes and shapes.
pub(crate) fn converted(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Option<LoadedMesh>> {
    let py = given.py();
    let name = file_name(given).unwrap_or_else(|| what.to_owned());
    let parts = if is_mesh(given)? {
        vec![given.clone()]
    } else if given.hasattr(intern!(py, "geometry"))? && given.hasattr(intern!(py, "dump"))? {
        // Where their nodes put them. Joined by trimesh, they would get a layout of their own if they have
        // several textures.
        given.call_method0(intern!(py, "dump"))?.try_iter()?.collect::<PyResult<_>>()?
    } else {
        return Ok(None);
    };
    let mut joined = Joined::default();
    let mut left_out = 0;
    for part in &parts {
        let uv = match is_mesh(part)? {
            true => uv_of(part)?,
            false => None,
        };
        match uv {
            Some(uv) => joined.append(part, &uv, what)?,
            None => left_out += 1,
        }
    }
    if left_out == parts.len() {
        return Err(failed(format_args!("{name}: a mesh must have UV coordinates (visual.uv)")));
    }
    if left_out > 0 {
        let all = parts.len();
        let warning = format!(
            "{name}: {left_out} of {all} parts of the scene have no UV coordinates and are left out"
        );
        warn_caller(py, vec![warning])?;
    }
    let Joined { positions, uv, faces } = joined;
    let mesh = Mesh::from_triangles(positions, uv, &faces, &faces)
        .map_err(|error| failed(format_args!("{name}: {error}")))?;
    Ok(Some(LoadedMesh { mesh, name, without_uv: WithoutUv::default() }))
}

fn is_mesh(given: &Bound<'_, PyAny>) -> PyResult<bool> {
    let py = given.py();
    Ok(given.hasattr(intern!(py, "vertices"))? && given.hasattr(intern!(py, "faces"))?)
}

fn uv_of<'py>(mesh: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyAny>>> {
    let py = mesh.py();
    let visual = mesh.getattr_opt(intern!(py, "visual"))?;
    let uv = visual.map(|visual| visual.getattr_opt(intern!(py, "uv"))).transpose()?.flatten();
    Ok(uv.filter(|uv| !uv.is_none()))
}

impl Joined {
    /// Appends a mesh.
    fn append(
        &mut self,
        mesh: &Bound<'_, PyAny>,
        uv: &Bound<'_, PyAny>,
        what: &str,
    ) -> PyResult<()> {
        let py = mesh.py();
        let of = |attribute: &str| format!("{what}.{attribute}");
        let vertices = mesh.getattr(intern!(py, "vertices"))?;
        let positions = rows::<f32, 3>(&vertices, &of("vertices"), "float32")?;
        let faces = mesh.getattr(intern!(py, "faces"))?;
        let faces = indices(&rows::<i64, 3>(&faces, &of("faces"), "int64")?, &of("faces"))?;
        // V is up, as in OBJ files, also of glTF files. Rounded once, as by the reader of OBJ files, to which
        // maps are equal then.
        let uv = rows::<f64, 2>(uv, &of("visual.uv"), "float64")?;
        if uv.len() != positions.len() {
            return Err(failed(format_args!(
                "{what}: visual.uv must have a row for each of {} vertices, got {}",
                positions.len(),
                uv.len()
            )));
        }
        let count = positions.len();
        if let Some(index) = faces.iter().flatten().find(|&&index| index as usize >= count) {
            return Err(failed(format_args!(
                "{what}.faces: vertex {index} does not exist; there are {count}"
            )));
        }
        let first = u32::try_from(self.positions.len())
            .ok()
            .filter(|first| first.checked_add(u32::try_from(count).unwrap_or(u32::MAX)).is_some())
            .ok_or_else(|| failed(format_args!("{what}: too many vertices")))?;
        self.faces.extend(faces.into_iter().map(|face| face.map(|index| first + index)));
        self.positions.extend(positions);
        self.uv.extend(uv.into_iter().map(|[u, v]| [u as f32, (1.0 - v) as f32]));
        Ok(())
    }
}

/// The file that trimesh has read an object from, without its folder. Which attribute has it depends on
/// the version.
fn file_name(given: &Bound<'_, PyAny>) -> Option<String> {
    let of_source = || given.getattr("source")?.getattr("file_path")?.extract::<PathBuf>();
    let of_metadata = || given.getattr("metadata")?.get_item("file_name")?.extract::<PathBuf>();
    let path = of_source().or_else(|_| of_metadata()).ok()?;
    Some(path.file_name()?.to_string_lossy().into_owned())
}
