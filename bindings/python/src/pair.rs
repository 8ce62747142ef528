//! Pairs of meshes whose surfaces correspond.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use uvgraft::correspond::split_vertices::{MapUse, link_by_vertex_map};
use uvgraft::correspond::surface::{Align, SurfaceOptions, SurfaceReport};
use uvgraft::correspond::{self, By, FindOptions};
use uvgraft::pair::OtherLayouts;
use uvgraft::{Choice, Side};
use uvgraft_assembly::pairing::table::TableLinks;
use uvgraft_assembly::pairing::{self, Outside, UvReading, table as by_table};
use uvgraft_assembly::recognition;
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_io::vertex_map;

use crate::arguments::chosen;
use crate::arrays::{numbers, rows, shape_text};
use crate::error::{
    bad_type, bad_value, check_file, failed, of_file, of_pipeline, of_reading, warn_caller,
    with_names,
};
use crate::files::FileKind;
use crate::keywords::extracted;
use crate::mesh::{Mesh, mesh};
use crate::threads;
use crate::work::Log;

/// The methods of pairs by a given vertex map and by a given table.
pub(crate) const VERTEX_MAP: &str = "vertex-map";
pub(crate) const TABLE: &str = "table";

/// Two meshes and the parts of their triangles that correspond.
///
/// Made once for two meshes; it serves textures of all sizes in both directions. It can be saved,
/// loaded and pickled. ``Pair(path)`` with the path of a pair file is ``Pair.load(path)``.
///
/// Parameters
/// ----------
/// source, target : Mesh, path or mesh of trimesh
///     The meshes that textures come from and go to: see `Mesh`.
/// vertex_map : array_like of int, shape (source vertices,), or path, optional
///     For each vertex of the source, the corresponding vertex of the target, or -1. Where a tool has split
///     vertices at UV seams or appended some, it may count those before that; a warning says so.
/// table : path, optional
///     A published table of where the vertices of one mesh lie on the other: a matrix (pickled SciPy matrix,
///     ``scipy.sparse.save_npz``), faces and barycentric weights for each vertex (NPZ, NPY), TF_FLAME's
///     ``texture_data_*.npy``, or ``uv_grid`` and ``pix_to_face`` (NPZ).
/// by : {"auto", "vertex-map", "table", "faces", "topology", "surface"}
///     How corresponding triangles are found without a vertex map or a table: equal faces, equal
///     connectivity, or by registering the surfaces. ``"auto"`` takes the first that links them.
/// align : {"similarity", "rigid", "none"}
///     How surfaces are aligned before they are registered.
/// landmarks : array_like of int, shape (n, 2), optional
///     Vertices of the source and the target that correspond, to guide the registration.
/// reach, visibility : float, optional
///     Limits of the registration, 0 to 1: see ``uvgraft pair --help``.
/// outside : {"unlinked", "clamp", "repeat"}
///     What becomes of triangles with UV coordinates outside the unit square: linked only between UDIM
///     tiles, clamped to the square, or moved into it as whole polygons.
/// flip_u, flip_v : {"source", "target"} or sequence of these, optional
///     The meshes whose U or V is counted from the other side, for layouts that were exported flipped.
/// note : str, optional
///     A note on licences, kept with the pair.
/// threads : int, optional
///     Number of threads, 0 for one per processor; see `set_threads`.
///
/// Raises
/// ------
/// uvgraft.Error
///     If the meshes do not correspond.
/// TypeError, ValueError
///     For arguments of other types, and values that are not allowed.
/// OSError
///     For files that cannot be read.
///
/// Warns
/// -----
/// UserWarning
///     If one of the layouts is mirrored as a whole, if hardly anything is linked, or if parts with other
///     textures, which a pair does not have, were a large share of what is linked.
#[pyclass(frozen, module = "uvgraft", name = "Pair")]
pub(crate) struct Pair {
    pub(crate) file: PairFile,
    method: Option<String>,
}

impl Pair {
    fn of_file(file: PairFile) -> Self {
        Self { file, method: None }
    }

    /// A pair from a pair file alone.
    ///
    /// - `options`: what is for two meshes, and whether it is given.
    fn of_one(
        py: Python<'_>,
        given: &Bound<'_, PyAny>,
        options: &[(&str, bool)],
    ) -> PyResult<Self> {
        let missing = "Pair() takes two meshes, or the path of a pair file; target is missing";
        let path: PathBuf = given.extract().map_err(|_| bad_type(missing))?;
        if FileKind::of(&path)? != FileKind::Pair {
            return Err(bad_type(format_args!(
                "{missing}, and {} is not a pair file",
                path.display()
            )));
        }
        if let Some((name, _)) = options.iter().find(|(_, is_given)| *is_given) {
            return Err(bad_type(format_args!(
                "{name} is for two meshes, which {} has linked already",
                path.display()
            )));
        }
        Self::load(py, path)
    }
}

/// A pair from an object or the path of a pair file.
///
/// - `wanted`: what an argument must be that is neither.
///
/// # Errors
/// `TypeError` for anything else, and those of [`Pair::load`].
pub(crate) fn pair<'py>(given: &Bound<'py, PyAny>, wanted: &str) -> PyResult<Bound<'py, Pair>> {
    if let Ok(pair) = given.cast::<Pair>() {
        return Ok(pair.clone());
    }
    let path = extracted::<PathBuf>(given, "pair", wanted)?;
    Bound::new(given.py(), Pair::load(given.py(), path)?)
}

/// How the triangles of two meshes are linked.
enum LinkMethod {
    VertexMap(Vec<i64>),
    Table(PathBuf),
    Search(By),
}

/// Two linked meshes.
struct Linked {
    pair: uvgraft::Pair,
    other_layouts: Vec<OtherLayouts>,
    /// What [`Pair`] calls the method.
    method: String,
    registered: Option<SurfaceReport>,
    /// What was assumed about a vertex map.
    assumed: Option<String>,
}

impl LinkMethod {
    /// The method that the arguments of [`Pair`] ask for.
    fn new(
        vertex_map: Option<&Bound<'_, PyAny>>,
        table: Option<PathBuf>,
        by: &str,
    ) -> PyResult<Self> {
        let ids = vertex_map.map(read_vertex_map).transpose()?;
        if ids.is_some() && table.is_some() {
            return Err(bad_type("Pair() takes either vertex_map or table, got both"));
        }
        let given = [("vertex_map", VERTEX_MAP, ids.is_some()), ("table", TABLE, table.is_some())];
        for (name, method, is_given) in given {
            if is_given && ![By::Any.name(), method].contains(&by) {
                return Err(bad_value(format_args!(
                    "{name} is used only with by={method:?} or \"auto\", got {by:?}"
                )));
            }
            if !is_given && by == method {
                return Err(bad_value(format_args!("by={method:?} needs {name}")));
            }
        }
        table.as_deref().map_or(Ok(()), check_file)?;
        Ok(match (ids, table) {
            (Some(ids), _) => Self::VertexMap(ids),
            (None, Some(table)) => Self::Table(table),
            (None, None) => Self::Search(chosen("by", by)?),
        })
    }

    fn link(
        self,
        source: uvgraft::Mesh,
        target: uvgraft::Mesh,
        options: &SurfaceOptions,
    ) -> PyResult<Linked> {
        match self {
            Self::VertexMap(ids) => {
                let links = link_by_vertex_map(&source, &target, &ids).map_err(of_linking)?;
                let method = match links.used {
                    MapUse::Connectivity(_) => By::Topology.name(),
                    _ => VERTEX_MAP,
                };
                let (method, assumed) = (method.to_owned(), links.used.assumed());
                let (pair, other_layouts) = links.pair.in_one_layout();
                Ok(Linked { pair, other_layouts, method, registered: None, assumed })
            }
            Self::Table(path) => {
                let links = by_table::link(&path, &source, &target, options);
                let TableLinks { pair, other_layouts, .. } = links.map_err(of_pipeline)?;
                let method = TABLE.to_owned();
                Ok(Linked { pair, other_layouts, method, registered: None, assumed: None })
            }
            Self::Search(by) => {
                let mut search = FindOptions::default();
                search.by = by;
                search.surface = options.clone();
                let found = correspond::find(source, target, &search).map_err(of_linking)?;
                let method = found.method.by().name().to_owned();
                let registered = found.method.registered().cloned();
                let (pair, other_layouts) = (found.pair, found.other_layouts);
                Ok(Linked { pair, other_layouts, method, registered, assumed: None })
            }
        }
    }
}

/// The note of a pair that is given none.
fn license_note(source: &str, target: &str) -> String {
    format!("made from {source} and {target}, whose licences hold for this pair too")
}

fn surface_options(
    align: &str,
    reach: Option<f64>,
    visibility: Option<f64>,
    landmarks: Option<&Bound<'_, PyAny>>,
) -> PyResult<SurfaceOptions> {
    let mut options = SurfaceOptions::default();
    options.align = chosen("align", align)?;
    for (name, given, option) in
        [("reach", reach, &mut options.reach), ("visibility", visibility, &mut options.visibility)]
    {
        match given {
            Some(value) if (0.0..=1.0).contains(&value) => *option = value,
            Some(value) => {
                return Err(bad_value(format_args!("{name} must be from 0 to 1, got {value}")));
            }
            None => {}
        }
    }
    if let Some(given) = landmarks {
        options.landmarks = read_landmarks(given)?;
    }
    Ok(options)
}

#[pymethods]
impl Pair {
    #[new]
    #[pyo3(signature = (
        source, target=None, *, vertex_map=None, table=None, by="auto", align="similarity",
        landmarks=None, reach=None, visibility=None, outside="unlinked", flip_u=None, flip_v=None,
        note=None, threads=None
    ))]
    fn new(
        py: Python<'_>,
        source: &Bound<'_, PyAny>,
        target: Option<&Bound<'_, PyAny>>,
        vertex_map: Option<&Bound<'_, PyAny>>,
        table: Option<PathBuf>,
        by: &str,
        align: &str,
        landmarks: Option<&Bound<'_, PyAny>>,
        reach: Option<f64>,
        visibility: Option<f64>,
        outside: &str,
        flip_u: Option<&Bound<'_, PyAny>>,
        flip_v: Option<&Bound<'_, PyAny>>,
        note: Option<String>,
        threads: Option<i64>,
    ) -> PyResult<Self> {
        let Some(target) = target else {
            let options = [
                ("vertex_map", vertex_map.is_some()),
                ("table", table.is_some()),
                ("by", by != By::Any.name()),
                ("align", align != Align::default().name()),
                ("landmarks", landmarks.is_some()),
                ("reach", reach.is_some()),
                ("visibility", visibility.is_some()),
                ("outside", outside != Outside::default().name()),
                ("flip_u", flip_u.is_some()),
                ("flip_v", flip_v.is_some()),
                ("note", note.is_some()),
            ];
            return Self::of_one(py, source, &options);
        };
        let reading = UvReading {
            flip_u: sides("flip_u", flip_u)?,
            flip_v: sides("flip_v", flip_v)?,
            outside: chosen("outside", outside)?,
        };
        let said = Log::default();
        let source = reading.apply(mesh(source, "source")?, Side::Source, &said);
        let target = reading.apply(mesh(target, "target")?, Side::Target, &said);
        warn_caller(py, said.warnings())?;
        let (source, source_name) = (source.mesh, source.name);
        let (target, target_name) = (target.mesh, target.name);
        let method = LinkMethod::new(vertex_map, table, by)?;
        let options = surface_options(align, reach, visibility, landmarks)?;
        let note = note.unwrap_or_else(|| license_note(&source_name, &target_name));
        let threads = threads::checked(threads)?;
        let linked = threads::run(py, threads, move || method.link(source, target, &options))??;
        let assumed = linked.assumed.map(|assumed| format!("vertex_map: {assumed}"));
        warn_caller(py, assumed.into_iter().collect())?;
        let file = PairFile { pair: Arc::new(linked.pair), source_name, target_name, note };
        let said = Log::default();
        let recognised = recognition::recognised(&file);
        let (registered, others) = (linked.registered.as_ref(), &linked.other_layouts);
        pairing::remark(&file, registered, others, &recognised, &said);
        warn_caller(py, said.warnings())?;
        Ok(Self { file, method: Some(linked.method) })
    }

    /// Load a pair file.
    ///
    /// Raises
    /// ------
    /// OSError
    ///     If the file cannot be read.
    /// uvgraft.Error
    ///     If it is not a whole pair file of a known version.
    #[staticmethod]
    pub(crate) fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| pair_file::read(&path)).map(Self::of_file).map_err(of_reading)
    }

    /// Make a pair from the content of a pair file; errors are those of `load`.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        py.detach(|| pair_file::decode(data)).map(Self::of_file).map_err(failed)
    }

    /// Write a pair file, whole or not at all.
    ///
    /// Raises
    /// ------
    /// OSError
    ///     If it cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| pair_file::write(&self.file, &path)).map_err(|reason| of_file(&reason, &path))
    }

    /// Return the content of a pair file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| pair_file::encode(&self.file)).map_err(failed)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The mesh that textures come from.
    #[getter]
    fn source(&self) -> Mesh {
        Mesh {
            mesh: Arc::new(self.file.pair.source().clone()),
            name: self.file.source_name.clone(),
        }
    }

    /// The mesh that textures go to.
    #[getter]
    fn target(&self) -> Mesh {
        Mesh {
            mesh: Arc::new(self.file.pair.target().clone()),
            name: self.file.target_name.clone(),
        }
    }

    /// A note from the owners of the meshes.
    #[getter]
    fn note(&self) -> &str {
        &self.file.note
    }

    /// How the meshes were linked; None for a pair that was loaded.
    #[getter]
    fn method(&self) -> Option<&str> {
        self.method.as_deref()
    }

    /// Number of parts of triangles that correspond.
    #[getter]
    fn piece_count(&self) -> usize {
        self.file.pair.piece_count()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.file == other.file
    }

    fn __hash__(&self) -> usize {
        // Pairs that are equal have as many pieces.
        self.file.pair.piece_count()
    }

    fn __repr__(&self) -> String {
        let PairFile { pair, source_name, target_name, .. } = &self.file;
        let pieces = pair.piece_count();
        format!("<uvgraft.Pair {source_name:?} to {target_name:?}: {pieces} pieces>")
    }

    /// What notebooks show.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("uvgraft._notebook")?.call_method1("pair_html", (slf,))
    }

    fn _repr_png_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("uvgraft._notebook")?.call_method1("pair_png", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let remake = slf.get_type().getattr("from_bytes")?;
        (remake, (slf.get().to_bytes(py)?,)).into_pyobject(py)
    }
}

fn read_vertex_map(given: &Bound<'_, PyAny>) -> PyResult<Vec<i64>> {
    if let Ok(path) = given.extract::<PathBuf>() {
        return vertex_map::read(&path).map_err(of_reading);
    }
    let (shape, ids) = numbers::<i64>(given, "vertex_map", "int64")?;
    if shape.len() == 1 {
        return Ok(ids);
    }
    Err(bad_value(format_args!(
        "vertex_map must have shape (vertices,), got {}",
        shape_text(&shape)
    )))
}

fn read_landmarks(given: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 2]>> {
    let index = |value: i64| {
        u32::try_from(value)
            .map_err(|_| bad_value(format_args!("landmarks: {value} is not a vertex index")))
    };
    let pairs = rows::<i64, 2>(given, "landmarks", "int64")?;
    pairs.into_iter().map(|[from, to]| Ok([index(from)?, index(to)?])).collect()
}

/// One of the meshes or several, source or target.
fn sides(name: &str, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Side>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    let sides = match given.extract::<String>() {
        Ok(side) => vec![side],
        Err(_) => extracted(given, name, "\"source\", \"target\" or a sequence of these")?,
    };
    sides.iter().map(|side| chosen(name, side)).collect()
}

fn of_linking(error: impl std::error::Error) -> PyErr {
    failed(with_names(&error.to_string()))
}
