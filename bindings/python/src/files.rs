//! Files of any kind that the package reads, by their content.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use uvgraft_assembly::mesh_file;
use uvgraft_image::Format;
use uvgraft_io::pair_file;

use crate::error::{failed, of_file};
use crate::images::read_image;
use crate::mesh::Mesh;
use crate::pair::Pair;

/// Bytes that tell what a file is.
const START_BYTES: u64 = 512;

/// The extension of pair files, where the content does not tell.
const PAIR: &str = "uvpair";

/// What is in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileKind {
    Image,
    Pair,
    Mesh,
}

impl FileKind {
    /// The kind of a file: by its content, or by its extension where that is of no known kind, so that a
    /// damaged file is refused as what it was meant to be. Meshes may have the selector of a part.
    ///
    /// # Errors
    /// The subclass of `OSError` for a file that cannot be read, and `uvgraft.Error` for one of no kind.
    pub(crate) fn of(path: &Path) -> PyResult<Self> {
        let shown = path.display();
        let metadata = match path.metadata() {
            Ok(metadata) => metadata,
            // The reader of meshes finds the file in front of the selector.
            Err(_) if path.to_string_lossy().contains('#') => return Ok(Self::Mesh),
            Err(reason) => return Err(of_file(&reason, path)),
        };
        let wanted = format!(
            "must be an image ({}), a mesh (OBJ, PLY, GLB, glTF, or a body model as NPZ or pickle) or a \
             pair file",
            Format::names()
        );
        if !metadata.is_file() {
            return Err(failed(format_args!("{shown}: {wanted}, got no file")));
        }
        let mut start = Vec::new();
        let read = File::open(path).and_then(|file| file.take(START_BYTES).read_to_end(&mut start));
        read.map_err(|reason| of_file(&reason, path))?;
        let by_extension = || {
            let extension = path.extension()?.to_str()?.to_lowercase();
            match &*extension {
                PAIR => Some(Self::Pair),
                mesh if mesh_file::EXTENSIONS.contains(&mesh) => Some(Self::Mesh),
                other => Format::from_extension(other).map(|_| Self::Image),
            }
        };
        if start.starts_with(b"\x93NUMPY") {
            return Err(failed(format_args!(
                "{shown}: {wanted}, got a NumPy array; numpy.load reads these"
            )));
        }
        if Format::detect(&start).is_some() {
            Ok(Self::Image)
        } else if pair_file::is_pair_file(&start) {
            Ok(Self::Pair)
        } else if let Some(named) = by_extension() {
            Ok(named)
        } else if mesh_file::may_be_mesh(&start) {
            Ok(Self::Mesh)
        } else {
            let start = start[..start.len().min(8)].escape_ascii().to_string();
            Err(failed(format_args!("{shown}: {wanted}, got a file that begins with \"{start}\"")))
        }
    }
}

/// Load a file as what it is: an image, a mesh or a pair.
///
/// Parameters
/// ----------
/// path : path
///     An image (PNG, JPEG, WebP, TIFF, EXR), a mesh (OBJ, PLY, GLB, glTF, or a body model with a UV layout
///     as NPZ or pickle) or a pair file, detected from the content; where the content is of no known kind,
///     the extension says what it should be. A part of a mesh is selected by ``"FILE#NAME"``, a UV set by
///     ``"FILE#1"``.
///
/// Returns
/// -------
/// ndarray, Mesh or Pair
///     As `read_image`, `Mesh.load` and `Pair.load` return it.
///
/// Raises
/// ------
/// OSError
///     If the file cannot be read.
/// uvgraft.Error
///     If it is none of these, or damaged.
#[pyfunction]
pub(crate) fn load(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    match FileKind::of(&path)? {
        FileKind::Image => read_image(py, path),
        FileKind::Pair => Ok(Bound::new(py, Pair::load(py, path)?)?.into_any()),
        FileKind::Mesh => Ok(Bound::new(py, Mesh::load(py, path)?)?.into_any()),
    }
}

/// Return whether a file is that of a pair; errors are those of `load`.
#[pyfunction]
pub(crate) fn is_pair_file(path: PathBuf) -> PyResult<bool> {
    Ok(FileKind::of(&path)? == FileKind::Pair)
}
