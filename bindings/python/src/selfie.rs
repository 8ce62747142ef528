//! Textures of heads from photographs.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use uvgraft::{Mesh as CoreMesh, Texture};
use uvgraft_assembly::SelfieRequest;
use uvgraft_assembly::selfie::{FocalLength, Head, PhotoOptions};
use uvgraft_pipeline::{Input, Observer, Result};

use crate::arrays::array;
use crate::error::{bad_value, check_files, of_pipeline};
use crate::inputs;
use crate::keywords::{Keywords, extracted};
use crate::memory;
use crate::mesh::Mesh;
use crate::{threads, work};

/// What `uvgraft.Selfie` is made of: texture, known texels, mesh, cameras as JSON, report and sheet.
type SelfieTuple<'py> =
    (Bound<'py, PyAny>, Bound<'py, PyAny>, Mesh, String, String, Option<Bound<'py, PyAny>>);

/// A head from photographs, with nothing of them.
struct Found {
    texture: Texture,
    known: Texture,
    mesh: CoreMesh,
    cameras: String,
    report: String,
    sheet: Option<Texture>,
}

/// The compiled part of `uvgraft.selfie`.
#[pyfunction]
pub(crate) fn make_selfie<'py>(
    py: Python<'py>,
    arguments: &Bound<'py, PyDict>,
) -> PyResult<SelfieTuple<'py>> {
    let keywords = Keywords::new(arguments)?;
    let threads = keywords.threads()?;
    let has_sheet = keywords.flag("sheet")?;
    let head = keywords.head()?;
    let mut request = SelfieRequest::new(head, keywords.photos()?);
    request.photo_options = keywords.photo_options()?;
    request.size = keywords.size("size")?.unwrap_or(request.size);
    keywords.finish()?;
    check_files(py, &py.detach(|| request.inputs()).map_err(of_pipeline)?)?;
    let found = work::run(py, threads, move |observer| find(&request, has_sheet, observer))?.result;
    let Found { texture, known, mesh, cameras, report, sheet } = found;
    let mesh = Mesh { mesh: mesh.into(), name: "shape.obj".to_owned() };
    let sheet = sheet.map(|sheet| array(py, sheet, false)).transpose()?;
    let made = (array(py, texture, false)?, array(py, known, true)?, mesh, cameras, report, sheet);
    memory::give_back(py);
    Ok(made)
}

fn find(request: &SelfieRequest, has_sheet: bool, observer: &dyn Observer) -> Result<Found> {
    let made = request.make(observer)?;
    made.warn(observer);
    observer.check()?;
    Ok(Found {
        texture: made.texture().clone(),
        known: made.known().clone(),
        mesh: made.shaped_mesh()?,
        cameras: made.cameras_json()?,
        report: made.figures().to_string(),
        sheet: has_sheet.then(|| made.sheet()).transpose()?,
    })
}

impl Keywords<'_> {
    /// The head: a mesh, a file, or that of the built-in figure.
    fn head(&self) -> PyResult<Head> {
        let given = self.required("head")?;
        if let Ok(mesh) = given.cast::<Mesh>() {
            let Mesh { mesh, name } = mesh.get();
            return Ok(Head::Mesh { mesh: CoreMesh::clone(mesh), name: name.clone() });
        }
        match extracted::<PathBuf>(&given, "head", "a Mesh or a path")? {
            demo if demo == Path::new("demo") => Ok(Head::Figure),
            file => Ok(Head::File(file.into())),
        }
    }

    /// The photographs, at least one.
    pub(crate) fn photos(&self) -> PyResult<Vec<Input>> {
        let photos = inputs::images(&self.required("photos")?, "photos")?;
        if photos.is_empty() {
            return Err(bad_value("photos must name at least one photograph"));
        }
        Ok(photos)
    }

    /// How photographs are read.
    pub(crate) fn photo_options(&self) -> PyResult<PhotoOptions> {
        let mut options = PhotoOptions::default();
        options.face_number = self.whole("face_number", 1..=1000)?;
        options.focal = self.parsed("focal", FocalLength::parse)?;
        options.head_texture = self.image("head_texture")?;
        options.relight = self.choice("relight")?.unwrap_or(options.relight);
        options.frames = self.whole("frames", 1..=64)?;
        Ok(options)
    }

    /// A number of threads.
    pub(crate) fn threads(&self) -> PyResult<Option<usize>> {
        let threads = self.take("threads")?;
        threads::checked(threads.map(|it| extracted(&it, "threads", "an int")).transpose()?)
    }
}
