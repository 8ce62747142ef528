//! Body models of the SMPL family.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use uvgraft::Mesh as CoreMesh;
use uvgraft_avatar::body::{BodyError, Gender, Hand, ModelFile, ReadOptions, Shape, Shaped};
use uvgraft_avatar::rig::{Pose, RigError};
use uvgraft_io::model_mesh;

use crate::arguments::chosen_from;
use crate::arrays::{numbers, shape_text, shaped};
use crate::error::{bad_value, failed, of_reading, warn_caller};
use crate::mesh::Mesh;
use crate::threads;

/// Frames that are posed in one go, a multiple of the eight that share a pass over the correctives:
/// enough to keep threads busy, and few enough that their copy is small.
const FRAMES_AT_ONCE: usize = 32;

/// A body model: the vertices for any shape, expression and pose.
///
/// SMPL, SMPL-H, SMPL-X and FLAME, and models with their joints such as the open body of ``uvgraft body
/// import``. Results agree with the Python package ``smplx`` within a few micrometres. Models are made
/// by `load`. They may be used by any number of threads at once, and cannot be pickled: load the file
/// again instead.
///
/// Notes
/// -----
/// Parameters of a body, all optional, for one body or for a batch of ``n`` of them, called frames.
/// Those of a single body hold for all frames of a batch.
///
/// betas : array_like, shape (k,) or (n, k)
///     Coefficients of the shape's components, in standard deviations of the people that the model was
///     trained on; at most `num_betas`, missing ones are 0.
/// expression : array_like, shape (k,) or (n, k)
///     Coefficients of the components of facial expression, likewise, at most `num_expressions`; of
///     named components 1 is the full expression.
/// pose : array_like, shape (joints, 3), (3 * joints,), (n, joints, 3) or (n, 3 * joints)
///     For each joint its rotation relative to its parent: the axis times the angle in radians; by
///     default 0, the rest pose. Fingers are posed by their joints, without the hands' mean poses
///     (``use_pca=False, flat_hand_mean=True`` of ``smplx``); see `hand_pose` and `hand_mean`.
/// translation : array_like, shape (3,) or (n, 3)
///     Metres.
/// threads : int
///     Number of threads, 0 for one per processor; see `set_threads`. It does not affect results.
#[pyclass(frozen, module = "uvgraft", name = "BodyModel")]
pub(crate) struct BodyModel {
    file: ModelFile,
    /// Its template with the UV layout of the file, or why there is none.
    layout: Result<CoreMesh, String>,
    name: String,
    /// Names of the joints, and their parents.
    joints: Vec<(String, Option<usize>)>,
}

#[pymethods]
impl BodyModel {
    /// Read a model file.
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     NPZ or pickle, also with arrays of chumpy; the format is detected from the content, and no code
    ///     in pickles is run.
    /// max_betas : int, optional
    ///     Read no more than this number of shape components.
    /// correctives : bool
    ///     Whether to read the pose correctives, most of a file. Without them poses are skinning alone,
    ///     but for the jaw, which keeps its own. Correctives in an array of unknown shape, such as STAR's, are
    ///     left out with a warning.
    ///
    /// Returns
    /// -------
    /// BodyModel
    ///
    /// Raises
    /// ------
    /// OSError
    ///     If the file cannot be read.
    /// uvgraft.Error
    ///     If it is not a body model, or is damaged.
    #[staticmethod]
    #[pyo3(signature = (path, *, max_betas=None, correctives=true))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        max_betas: Option<i64>,
        correctives: bool,
    ) -> PyResult<Self> {
        let betas = match max_betas.map(usize::try_from) {
            None => usize::MAX,
            Some(Ok(betas)) if betas > 0 => betas,
            Some(_) => return Err(bad_value("max_betas must be at least 1")),
        };
        let needs = ReadOptions { betas, correctives };
        let read = threads::run(py, None, || {
            let file = ModelFile::read(&path, &needs)?;
            let layout = model_mesh::read(&path).map_err(|error| error.to_string());
            Ok((file, layout))
        })?;
        let (file, layout) = read.map_err(of_reading)?;
        if let Some(why) = file.model.correctives_left_out() {
            let text = format!("{}: pose correctives are left out: {why}", path.display());
            warn_caller(py, vec![text])?;
        }
        let rest = file.model.shaped(&Shape::default()).map_err(failed)?;
        let joints = rest.skeleton().joints().iter();
        let joints = joints.map(|joint| (joint.name.clone(), joint.parent)).collect();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { file, layout, name, joints })
    }

    /// "SMPL", "SMPL-H", "SMPL-X" or "FLAME", by the model's joints.
    #[getter]
    fn kind(&self) -> &'static str {
        self.file.model.kind().name()
    }

    /// "neutral", "male" or "female", if the file or its name states it.
    #[getter]
    fn gender(&self) -> Option<&'static str> {
        self.file.gender.map(Gender::name)
    }

    /// The terms of the model, if the file states them.
    #[getter]
    fn license(&self) -> Option<&str> {
        self.file.license.as_deref()
    }

    /// Names of the joints, as in ``smplx``.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.joints.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// For each joint the index of its parent, -1 for the root.
    #[getter]
    fn parents(&self) -> Vec<i64> {
        self.joints.iter().map(|(_, parent)| parent.map_or(-1, |index| index as i64)).collect()
    }

    /// Number of vertices.
    #[getter]
    fn num_vertices(&self) -> usize {
        self.file.model.vertices()
    }

    /// Number of joints.
    #[getter]
    fn num_joints(&self) -> usize {
        self.joints.len()
    }

    /// Number of shape components.
    #[getter]
    fn num_betas(&self) -> usize {
        self.file.model.betas()
    }

    /// Number of expression components.
    #[getter]
    fn num_expressions(&self) -> usize {
        self.file.model.expressions()
    }

    /// Names of the expression components, such as those of ARKit; empty for learnt components.
    #[getter]
    fn expression_names(&self) -> Vec<String> {
        self.file.model.expression_names().to_vec()
    }

    /// Names that `named_betas` takes; empty for models of learnt shapes.
    #[getter]
    fn shape_names(&self) -> Vec<&str> {
        self.file.model.named_shapes().map_or_else(Vec::new, |shapes| shapes.names().collect())
    }

    /// Whether poses have correctives.
    #[getter]
    fn has_correctives(&self) -> bool {
        self.file.model.has_correctives()
    }

    /// Triangles: uint32 of shape (triangles, 3), indices of vertices, a new array each time.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let faces = self.file.model.triangles();
        shaped(py, faces.as_flattened().to_vec(), vec![faces.len(), 3])
    }

    /// Return the positions of the vertices of a body or of a batch.
    ///
    /// Frames of one shape and expression share the work; a batch is much faster than its frames one by
    /// one, with identical results.
    ///
    /// Parameters
    /// ----------
    /// betas, expression, pose, translation, threads
    ///     See the class.
    ///
    /// Returns
    /// -------
    /// ndarray of float32, shape (num_vertices, 3) or (n, num_vertices, 3)
    ///     Metres, Y up, facing +Z.
    ///
    /// Raises
    /// ------
    /// TypeError
    ///     For values that are not numbers.
    /// ValueError
    ///     For other shapes, more coefficients than the model has components, values that are NaN or
    ///     infinite, and batches of different lengths.
    #[pyo3(signature = (
        *, betas=None, expression=None, pose=None, translation=None, threads=None
    ))]
    fn vertices<'py>(
        &self,
        py: Python<'py>,
        betas: Option<&Bound<'py, PyAny>>,
        expression: Option<&Bound<'py, PyAny>>,
        pose: Option<&Bound<'py, PyAny>>,
        translation: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let bodies = self.bodies([betas, expression, pose, translation])?;
        self.points(py, &bodies, self.num_vertices(), threads, place_vertices)
    }

    /// Return the positions of the joints of a body or of a batch.
    ///
    /// Parameters
    /// ----------
    /// betas, expression, pose, translation, threads
    ///     See the class.
    ///
    /// Returns
    /// -------
    /// ndarray of float32, shape (num_joints, 3) or (n, num_joints, 3)
    ///     Metres, in the order of `joint_names`.
    ///
    /// Raises
    /// ------
    /// TypeError, ValueError
    ///     As `vertices`.
    #[pyo3(signature = (
        *, betas=None, expression=None, pose=None, translation=None, threads=None
    ))]
    fn joints<'py>(
        &self,
        py: Python<'py>,
        betas: Option<&Bound<'py, PyAny>>,
        expression: Option<&Bound<'py, PyAny>>,
        pose: Option<&Bound<'py, PyAny>>,
        translation: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let bodies = self.bodies([betas, expression, pose, translation])?;
        self.points(py, &bodies, self.num_joints(), threads, place_joints)
    }

    /// Return a body as a mesh with a UV layout.
    ///
    /// Parameters
    /// ----------
    /// layout : Mesh, optional
    ///     A mesh with the model's vertices and triangles, whose layout the result has; by default the
    ///     layout of the model file, which most published models lack.
    /// betas, expression, pose, translation, threads
    ///     See the class; of a single body.
    ///
    /// Returns
    /// -------
    /// Mesh
    ///     In metres.
    ///
    /// Raises
    /// ------
    /// TypeError, ValueError
    ///     As `vertices`; and for batches, and meshes with other triangles.
    /// uvgraft.Error
    ///     If the file has no layout and none is given.
    #[pyo3(signature = (
        layout=None, *, betas=None, expression=None, pose=None, translation=None, threads=None
    ))]
    fn mesh<'py>(
        &self,
        py: Python<'py>,
        layout: Option<&Bound<'py, Mesh>>,
        betas: Option<&Bound<'py, PyAny>>,
        expression: Option<&Bound<'py, PyAny>>,
        pose: Option<&Bound<'py, PyAny>>,
        translation: Option<&Bound<'py, PyAny>>,
        threads: Option<i64>,
    ) -> PyResult<Mesh> {
        let bodies = self.bodies([betas, expression, pose, translation])?;
        if bodies.frames.is_some_and(|count| count != 1) {
            return Err(bad_value("a mesh is of a single body, not of a batch"));
        }
        let (layout, name) = match (layout, &self.layout) {
            (Some(layout), _) => (CoreMesh::clone(&layout.get().mesh), layout.get().name.clone()),
            (None, Ok(layout)) => (layout.clone(), self.name.clone()),
            (None, Err(reason)) => {
                return Err(failed(format_args!("{reason}; or give a mesh as layout")));
            }
        };
        let threads = threads::checked(threads)?;
        let mesh = threads::run(py, threads, || {
            let shaped = self.file.model.shaped(&bodies.shapes[0])?;
            let posed = shaped.posed(&bodies.poses[0])?;
            // Checks that the layout's triangles are the model's.
            Ok((shaped.avatar(layout)?.mesh, posed))
        })?;
        let (mesh, posed) = mesh.map_err(|error: BodyError| bad_value(error))?;
        let mesh = mesh.with_positions(posed).map_err(bad_value)?;
        Ok(Mesh { mesh: Arc::new(mesh), name })
    }

    /// Return the coefficients of a shape by names, of models that have such: the open body.
    ///
    /// Parameters
    /// ----------
    /// **values : float
    ///     Of `shape_names`; others have their defaults. ``height`` is in metres.
    ///
    /// Returns
    /// -------
    /// ndarray of float32, shape (num_betas,)
    ///     For `vertices` and others.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For names that do not exist, values out of range, and models without names.
    #[pyo3(signature = (**values), text_signature = "($self, **values)")]
    fn named_betas<'py>(
        &self,
        py: Python<'py>,
        values: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut named: Vec<(String, f32)> = Vec::new();
        for (name, value) in values.into_iter().flatten() {
            named.push((name.extract()?, value.extract()?));
        }
        if let Some((name, value)) = named.iter().find(|(_, value)| !value.is_finite()) {
            return Err(bad_value(format_args!("{name} must be finite, got {value}")));
        }
        let mut betas = py.detach(|| self.file.model.named_shape(&named)).map_err(bad_value)?.betas;
        betas.resize(self.num_betas(), 0.0);
        let count = betas.len();
        shaped(py, betas, vec![count])
    }

    /// Return the rotations of a hand's 15 joints by principal components, without the mean pose.
    ///
    /// Parameters
    /// ----------
    /// side : {"left", "right"}
    ///     The hand, from the person's own point of view.
    /// coefficients : array_like, shape (k,)
    ///     ``k`` is ``num_pca_comps`` of ``smplx``.
    ///
    /// Returns
    /// -------
    /// ndarray of float32, shape (15, 3)
    ///     Rotation vectors for the joints of the hand in a pose: of SMPL-H 22 to 36 (left) and 37 to 51,
    ///     of SMPL-X 25 to 39 and 40 to 54.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For more coefficients than the model has components.
    fn hand_pose<'py>(
        &self,
        py: Python<'py>,
        side: &str,
        coefficients: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let side = hand(side)?;
        let (shape, values) = numbers::<f32>(coefficients, "coefficients", "float32")?;
        if shape.len() != 1 {
            return Err(bad_value(format_args!(
                "coefficients must have shape (k,), got {}",
                shape_text(&shape)
            )));
        }
        let turns = self.file.model.hand_turns(side, &values).map_err(bad_value)?;
        shaped(py, turns.as_flattened().to_vec(), vec![turns.len(), 3])
    }

    /// Return the mean pose of a hand, float32 of shape (15, 3); None if the model has none.
    ///
    /// Parameters
    /// ----------
    /// side : {"left", "right"}
    ///     The hand, from the person's own point of view.
    fn hand_mean<'py>(&self, py: Python<'py>, side: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let mean = self.file.model.hand_mean(hand(side)?);
        mean.map(|turns| shaped(py, turns.as_flattened().to_vec(), vec![turns.len(), 3]))
            .transpose()
    }

    fn __repr__(&self) -> String {
        format!(
            "<uvgraft.BodyModel {:?}: {}, {} vertices, {} betas, {} expressions>",
            self.name,
            self.kind(),
            self.num_vertices(),
            self.num_betas(),
            self.num_expressions()
        )
    }
}

fn hand(side: &str) -> PyResult<Hand> {
    chosen_from("side", side, &[("left", Hand::Left), ("right", Hand::Right)])
}

/// Bodies in the parameters of a model. Lists have a single item for all frames, or one for each.
struct Bodies {
    shapes: Vec<Shape>,
    poses: Vec<Pose>,
    /// `None` for a single body.
    frames: Option<usize>,
}

impl Bodies {
    /// Frames that follow each other in one shape, with their poses.
    fn groups(&self) -> impl Iterator<Item = (&Shape, Vec<Pose>)> {
        let count = self.frames.unwrap_or(1);
        let mut first = 0;
        std::iter::from_fn(move || {
            if first == count {
                return None;
            }
            let shape = of_frame(&self.shapes, first);
            let most = count.min(first + FRAMES_AT_ONCE);
            let last =
                (first..most).find(|&frame| of_frame(&self.shapes, frame) != shape).unwrap_or(most);
            let poses = (first..last).map(|frame| of_frame(&self.poses, frame).clone()).collect();
            first = last;
            Some((shape, poses))
        })
    }
}

/// The item of a frame, in a list with a single one for all frames, or one for each.
fn of_frame<T>(items: &[T], frame: usize) -> &T {
    &items[if items.len() == 1 { 0 } else { frame }]
}

/// Writes the points of a shape in some poses.
type Placing = fn(&Shaped<'_>, &[Pose], &mut Vec<f32>) -> Result<(), RigError>;

fn place_vertices(body: &Shaped<'_>, poses: &[Pose], out: &mut Vec<f32>) -> Result<(), RigError> {
    for frame in body.posed_frames(poses)? {
        out.extend_from_slice(frame.as_flattened());
    }
    Ok(())
}

fn place_joints(body: &Shaped<'_>, poses: &[Pose], out: &mut Vec<f32>) -> Result<(), RigError> {
    for pose in poses {
        out.extend_from_slice(body.joints(pose)?.as_flattened());
    }
    Ok(())
}

impl BodyModel {
    /// - `given`: betas, expression, pose and translation.
    fn bodies(&self, given: [Option<&Bound<'_, PyAny>>; 4]) -> PyResult<Bodies> {
        let [betas, expression, pose, translation] = given;
        let model = &self.file.model;
        let betas = Rows::coefficients(betas, "betas", model.betas())?;
        let expression = Rows::coefficients(expression, "expression", model.expressions())?;
        let pose = Rows::pose(pose, self.num_joints())?;
        let translation = Rows::translation(translation)?;
        let frames = common_frames([&betas, &expression, &pose, &translation])?;
        let shapes = (0..count([&betas, &expression]))
            .map(|frame| Shape {
                betas: betas.of(frame).to_vec(),
                expression: expression.of(frame).to_vec(),
            })
            .collect();
        let poses = (0..count([&pose, &translation]))
            .map(|frame| {
                let place = translation.of(frame).first_chunk().copied().unwrap_or_default();
                Pose::from_axis_angles(place, pose.of(frame).as_chunks::<3>().0)
            })
            .collect();
        Ok(Bodies { shapes, poses, frames })
    }

    /// Points of all frames as an array.
    ///
    /// - `count`: of the points of a frame.
    fn points<'py>(
        &self,
        py: Python<'py>,
        bodies: &Bodies,
        count: usize,
        threads: Option<i64>,
        place: Placing,
    ) -> PyResult<Bound<'py, PyAny>> {
        let frames = bodies.frames.unwrap_or(1);
        let mut points: Vec<f32> = Vec::new();
        let reserved = frames
            .checked_mul(3 * count)
            .is_some_and(|values| points.try_reserve_exact(values).is_ok());
        if !reserved {
            return Err(PyMemoryError::new_err(format!("not enough memory for {frames} frames")));
        }
        let threads = threads::checked(threads)?;
        let points = threads::run(py, threads, move || {
            for (shape, poses) in bodies.groups() {
                let shaped = self.file.model.shaped(shape)?;
                place(&shaped, &poses, &mut points)?;
            }
            Ok(points)
        })?;
        let points = points.map_err(|error: BodyError| bad_value(error))?;
        let mut shape: Vec<usize> = bodies.frames.into_iter().collect();
        shape.extend([count, 3]);
        shaped(py, points, shape)
    }
}

/// A parameter: a row for all frames, or one for each.
struct Rows {
    what: &'static str,
    values: Vec<f32>,
    width: usize,
    /// `None` for a single row that is no batch.
    frames: Option<usize>,
}

impl Rows {
    fn single(what: &'static str, values: Vec<f32>) -> Self {
        Self { what, width: values.len(), values, frames: None }
    }

    /// Numbers in an array, with its shape; all of them finite.
    fn read(given: &Bound<'_, PyAny>, what: &str) -> PyResult<(Vec<usize>, Vec<f32>)> {
        let (shape, values) = numbers::<f32>(given, what, "float32")?;
        match values.iter().position(|value| !value.is_finite()) {
            Some(at) => Err(bad_value(format_args!(
                "{what} must be finite in float32, got {} at flat index {at}",
                values[at]
            ))),
            None => Ok((shape, values)),
        }
    }

    fn coefficients(
        given: Option<&Bound<'_, PyAny>>,
        what: &'static str,
        most: usize,
    ) -> PyResult<Self> {
        let Some(given) = given else { return Ok(Self::single(what, Vec::new())) };
        let (shape, values) = Self::read(given, what)?;
        match shape[..] {
            [width] if width <= most => Ok(Self::single(what, values)),
            [frames, width] if width <= most => {
                Ok(Self { what, values, width, frames: Some(frames) })
            }
            _ => Err(bad_value(format_args!(
                "{what} must have shape (k,) or (n, k) with k up to {most}, got {}",
                shape_text(&shape)
            ))),
        }
    }

    fn pose(given: Option<&Bound<'_, PyAny>>, joints: usize) -> PyResult<Self> {
        let (what, width) = ("pose", 3 * joints);
        let Some(given) = given else { return Ok(Self::single(what, vec![0.0; width])) };
        let (shape, values) = Self::read(given, what)?;
        match shape[..] {
            [all] if all == width => Ok(Self::single(what, values)),
            [rows, 3] if rows == joints => Ok(Self::single(what, values)),
            [frames, all] if all == width => Ok(Self { what, values, width, frames: Some(frames) }),
            [frames, rows, 3] if rows == joints => {
                Ok(Self { what, values, width, frames: Some(frames) })
            }
            _ => Err(bad_value(format_args!(
                "pose must have shape ({joints}, 3), ({width},), (n, {joints}, 3) or (n, {width}), \
                 got {}",
                shape_text(&shape)
            ))),
        }
    }

    fn translation(given: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let what = "translation";
        let Some(given) = given else { return Ok(Self::single(what, vec![0.0; 3])) };
        let (shape, values) = Self::read(given, what)?;
        match shape[..] {
            [3] => Ok(Self::single(what, values)),
            [frames, 3] => Ok(Self { what, values, width: 3, frames: Some(frames) }),
            _ => Err(bad_value(format_args!(
                "translation must have shape (3,) or (n, 3), got {}",
                shape_text(&shape)
            ))),
        }
    }

    /// The row of a frame.
    fn of(&self, frame: usize) -> &[f32] {
        let row = if self.frames.is_none_or(|count| count == 1) { 0 } else { frame };
        &self.values[row * self.width..][..self.width]
    }
}

/// The number of different rows in two parameters together: those of the batch that is not repeated.
fn count(both: [&Rows; 2]) -> usize {
    let mut frames = both.into_iter().filter_map(|rows| rows.frames);
    frames.find(|&count| count != 1).unwrap_or(1)
}

/// The number of frames of a batch; `None` if no parameter is one. A batch of a single frame is
/// repeated like a parameter that is no batch, as SMPL's betas often are.
fn common_frames(all: [&Rows; 4]) -> PyResult<Option<usize>> {
    let mut longest: Option<(&str, usize)> = None;
    for rows in all {
        let Some(found) = rows.frames else { continue };
        longest = match longest {
            Some((what, wanted)) if found != wanted && found != 1 && wanted != 1 => {
                return Err(bad_value(format_args!(
                    "batches must have the same length: {what} has {wanted} frames, {} has {found}",
                    rows.what
                )));
            }
            Some((what, wanted)) if found == 1 => Some((what, wanted)),
            _ => Some((rows.what, found)),
        };
    }
    Ok(longest.map(|(_, frames)| frames))
}
