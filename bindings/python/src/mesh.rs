//! Meshes.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use uvgraft::Mesh as CoreMesh;
use uvgraft_assembly::mesh_file::{self, LoadedMesh};
use uvgraft_io::textured::WithoutUv;

use crate::arguments::chosen_from;
use crate::arrays::{rows, shaped};
use crate::error::{bad_type, bad_value, failed, of_any_file, warn_caller};
use crate::foreign_mesh;

/// A triangle mesh with a UV layout. It cannot be changed.
///
/// ``Mesh(path)`` is ``Mesh.load(path)``. ``Mesh(mesh)`` takes a mesh or a scene of trimesh, or any object with
/// `vertices`, `faces` and `visual.uv` as trimesh has them: UV coordinates of each vertex, with their origin
/// at the bottom left.
///
/// Parameters
/// ----------
/// positions : array_like of float32, shape (vertices, 3)
///     In the mesh's own unit, usually metres; or a path or an object, without the other arrays.
/// faces : array_like of int, shape (triangles, 3)
///     Indices into `positions`.
/// uv : array_like of float32, shape (coordinates, 2)
///     0 to 1 inside the texture.
/// uv_faces : array_like of int, shape (triangles, 3), optional
///     Indices into `uv`; by default those of `faces`.
/// uv_origin : {"bottom-left", "top-left"}
///     Where `uv` has its origin: at the bottom left as in OBJ files and Blender, or at the top left
///     as in glTF and in image arrays.
/// name : str, optional
///     What messages and pair files call it; by default the file, or ``"mesh"``.
///
/// Raises
/// ------
/// TypeError, ValueError
///     For arrays of other dtypes and shapes.
/// uvgraft.Error
///     For coordinates that are not finite, and indices that do not exist.
#[pyclass(frozen, module = "uvgraft", name = "Mesh")]
pub(crate) struct Mesh {
    pub(crate) mesh: Arc<CoreMesh>,
    pub(crate) name: String,
}

#[pymethods]
impl Mesh {
    #[new]
    #[pyo3(signature = (
        positions, faces=None, uv=None, uv_faces=None, *, uv_origin=None, name=None
    ))]
    fn new(
        positions: &Bound<'_, PyAny>,
        faces: Option<&Bound<'_, PyAny>>,
        uv: Option<&Bound<'_, PyAny>>,
        uv_faces: Option<&Bound<'_, PyAny>>,
        uv_origin: Option<&str>,
        name: Option<String>,
    ) -> PyResult<Self> {
        let arrays = [
            ("faces", faces.is_some()),
            ("uv", uv.is_some()),
            ("uv_origin", uv_origin.is_some()),
            ("uv_faces", uv_faces.is_some()),
        ];
        if let Some(loaded) = whole(positions, "mesh")? {
            if let Some((name, _)) = arrays.iter().find(|(_, is_given)| *is_given) {
                return Err(bad_type(format_args!(
                    "{name} is for arrays of positions; {} has all of a mesh",
                    loaded.name
                )));
            }
            return Ok(Self { mesh: Arc::new(loaded.mesh), name: name.unwrap_or(loaded.name) });
        }
        let (Some(faces), Some(uv), Some(uv_origin)) = (faces, uv, uv_origin) else {
            let missing =
                arrays.iter().find(|(_, is_given)| !is_given).map_or("", |(name, _)| name);
            return Err(bad_type(format_args!(
                "Mesh() takes a path, a mesh of trimesh, or positions, faces, uv and uv_origin; \
                 {missing} is missing"
            )));
        };
        let name = name.unwrap_or_else(|| "mesh".to_owned());
        let is_v_up =
            chosen_from("uv_origin", uv_origin, &[("top-left", false), ("bottom-left", true)])?;
        let positions = rows::<f32, 3>(positions, "positions", "float32")?;
        let mut uv = rows::<f32, 2>(uv, "uv", "float32")?;
        if is_v_up {
            uv.iter_mut().for_each(|[_, v]| *v = 1.0 - *v);
        }
        let faces = indices(&rows::<i64, 3>(faces, "faces", "int64")?, "faces")?;
        let uv_faces = match uv_faces {
            Some(given) => indices(&rows::<i64, 3>(given, "uv_faces", "int64")?, "uv_faces")?,
            None => faces.clone(),
        };
        let mesh = CoreMesh::from_triangles(positions, uv, &faces, &uv_faces).map_err(failed)?;
        Ok(Self { mesh: Arc::new(mesh), name })
    }

    /// Load a mesh file.
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     OBJ, PLY, GLB, glTF or a body model (NPZ, pickle, which is never executed); the format is
    ///     detected from the content. A part is selected by ``"FILE#NAME"``, a UV set by ``"FILE#1"``.
    ///     Polygons without UV coordinates among others are left out with a warning.
    ///
    /// Raises
    /// ------
    /// OSError
    ///     If the file cannot be read.
    /// uvgraft.Error
    ///     If it is not a mesh with UV coordinates.
    #[staticmethod]
    pub(crate) fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let loaded =
            py.detach(|| mesh_file::read(&path)).map_err(|error| of_any_file(&error, &path))?;
        warn_caller(py, loaded.left_out().into_iter().collect())?;
        Ok(Self { mesh: Arc::new(loaded.mesh), name: loaded.name })
    }

    /// What messages call it: usually the name of its file.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Positions, float32 of shape (vertices, 3), in the mesh's unit. A copy.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = self.mesh.positions();
        shaped(py, values.as_flattened().to_vec(), vec![values.len(), 3])
    }

    /// UV coordinates, float32 of shape (coordinates, 2), origin at the top left. A copy.
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = self.mesh.uv();
        shaped(py, values.as_flattened().to_vec(), vec![values.len(), 2])
    }

    /// Indices into `positions`, uint32 of shape (triangles, 3). A copy.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = self.mesh.faces();
        shaped(py, values.as_flattened().to_vec(), vec![values.len(), 3])
    }

    /// Indices into `uv`, uint32 of shape (triangles, 3). A copy.
    #[getter]
    fn uv_faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = self.mesh.uv_faces();
        shaped(py, values.as_flattened().to_vec(), vec![values.len(), 3])
    }

    fn __repr__(&self) -> String {
        let mesh = &self.mesh;
        format!(
            "<uvgraft.Mesh {:?}: {} vertices, {} triangles>",
            self.name,
            mesh.positions().len(),
            mesh.faces().len()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let mesh = slf.get();
        let made_of = (
            mesh.positions(py)?,
            mesh.faces(py)?,
            mesh.uv(py)?,
            mesh.uv_faces(py)?,
            mesh.name.as_str(),
        );
        let remake = py.import("uvgraft._pickling")?.getattr("mesh")?;
        (remake, made_of).into_pyobject(py)
    }
}

/// A mesh from whatever is one.
///
/// - `what`: the name of the argument.
///
/// # Errors
/// As [`whole`], and `TypeError` for anything else.
pub(crate) fn mesh(given: &Bound<'_, PyAny>, what: &str) -> PyResult<LoadedMesh> {
    if let Some(loaded) = whole(given, what)? {
        return Ok(loaded);
    }
    let found = given.get_type().name()?.to_string();
    Err(bad_type(format_args!("{what} must be a Mesh, a path or a mesh of trimesh, got {found}")))
}

/// A mesh from an object or a path; `None` for anything else.
///
/// # Errors
/// Those of [`Mesh::load`] and of [`foreign_mesh::converted`].
fn whole(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Option<LoadedMesh>> {
    if let Ok(mesh) = given.cast::<Mesh>() {
        let Mesh { mesh, name } = mesh.get();
        return Ok(Some(LoadedMesh {
            mesh: CoreMesh::clone(mesh),
            name: name.clone(),
            without_uv: WithoutUv::default(),
        }));
    }
    let Ok(path) = given.extract::<PathBuf>() else {
        return foreign_mesh::converted(given, what);
    };
    let read = given.py().detach(|| mesh_file::read(&path));
    let loaded = read.map_err(|error| of_any_file(&error, &path))?;
    warn_caller(given.py(), loaded.left_out().into_iter().collect())?;
    Ok(Some(loaded))
}

/// Indices that are not negative.
pub(crate) fn indices(rows: &[[i64; 3]], what: &str) -> PyResult<Vec<[u32; 3]>> {
    let index = |value: i64| {
        u32::try_from(value).map_err(|_| bad_value(format_args!("{what}: {value} is not an index")))
    };
    rows.iter().map(|&[a, b, c]| Ok([index(a)?, index(b)?, index(c)?])).collect()
}
