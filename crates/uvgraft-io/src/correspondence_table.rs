//! Correspondences of two meshes as others publish them: sparse matrices, points on faces, texel by
//! texel.
//!
//! | content | known from |
//! |---|---|
//! | [`Matrix`](CorrespondenceFile::Matrix) | `model_transfer` of SMPL-X (`smpl2smplx_deftrafo_setup.pkl`), `scipy.sparse.save_npz` |
//! | [`Points`](CorrespondenceFile::Points) | FLAME's landmark embeddings, results of closest-point queries |
//! | [`Corners`](CorrespondenceFile::Corners) | SMPL-X's `smplx_flip_correspondences.npz`, `smplx_to_smpl.pkl` |
//! | [`Layout`](CorrespondenceFile::Layout) | TF_FLAME's `texture_data_512.npy` |
//! | [`Grid`](CorrespondenceFile::Grid) | the code of Song et al. (arXiv 2508.19518), `uvgraft map` |
//!
//! Pickles are parsed, never run; see [`crate::pickle`].

mod grid;
mod layout;
mod layout_mesh;
mod points;
#[cfg(test)]
mod tests;
mod vertex_tables;

use uvgraft::Weights;

pub use self::grid::TexelGrid;
pub use self::layout::{LayoutUv, TexelLayout};
pub use self::layout_mesh::{LayoutMesh, layout_mesh};
pub use self::vertex_tables::{FoundTable, TableFitError, vertex_tables};
use crate::arrays::collect::{Collector, single};
use crate::arrays::error::{Unread, foreign_file};
use crate::arrays::listed;
use crate::arrays::named::Held;
use crate::arrays::npy::{self, Content};
use crate::arrays::{
    ArraysError, MAX_FILE_BYTES, MAX_NUMBERS, NamedArrays, NumericArray, SparseMatrix,
};
use crate::pickle::{self, Value};
use uvgraft_files::input::{Input, ReadError};

/// The content of a file of correspondences. Only the format is checked: whether vertices and faces
/// exist depends on the meshes.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum CorrespondenceFile {
    /// A matrix that takes the vertices of one mesh to those of another: a row for each vertex, with
    /// its weights of the other mesh's vertices. With twice as many columns, the second half belongs
    /// to vertex normals.
    Matrix(SparseMatrix),
    /// For each vertex a face of the other mesh, or -1, and barycentric weights of its corners.
    Points {
        /// `[vertices]` faces, at least -1.
        faces: Vec<i64>,
        /// `[vertices]` weights, finite where there is a face.
        weights: Vec<Weights>,
    },
    /// For each vertex three vertices of the other mesh, and their weights.
    Corners {
        /// `[vertices]` vertices, at least -1.
        vertices: Vec<[i64; 3]>,
        /// `[vertices]` weights, finite unless the first vertex is -1.
        weights: Vec<Weights>,
    },
    /// The texels of a mesh's layout, with their points on the mesh.
    Layout(TexelLayout),
    /// The texels of a layout, with their positions in another layout.
    Grid(TexelGrid),
}

/// Why a file of correspondences was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CorrespondenceError {
    /// It cannot be read as arrays.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// It has arrays, but none that are known as correspondences.
    #[error(
        "must have a matrix (`mtx`, `matrix` or scipy.sparse.save_npz), faces and barycentric weights \
         (such as `face_ids` and `bary_coords`, or `closest_faces` and `bc`), `uv_grid` and \
         `pix_to_face`, or `valid_pixel_ids`; the file has {}",
        listed(names)
    )]
    Unknown {
        /// The names of its arrays.
        names: Vec<String>,
    },
    /// An array does not have the form that its name promises.
    #[error("{} must {wanted}, got {found}", named(name))]
    Form {
        /// The name of the array, empty for the only one of a file.
        name: String,
        /// What it must have or be.
        wanted: String,
        /// What it has or is.
        found: String,
    },
}

fn named(name: &str) -> String {
    if name.is_empty() { "the array".to_owned() } else { format!("`{name}`") }
}

fn form(
    name: &str,
    wanted: impl Into<String>,
    found: impl std::fmt::Display,
) -> CorrespondenceError {
    let (name, wanted, found) = (name.to_owned(), wanted.into(), found.to_string());
    CorrespondenceError::Form { name, wanted, found }
}

/// Reads correspondences. The format is detected from the content:
/// - A pickle, or an NPY file of an object: a SciPy matrix (CSC, CSR or COO), or a dict with `mtx` or
///   `matrix`, sparse or dense; otherwise a dict of arrays.
/// - An NPZ archive: `scipy.sparse.save_npz`, or arrays by name. Torch files of tensors likewise.
/// - An NPY array of shape `(n, 4)` with a face and three weights, of shape `(height, width, 2)` with
///   UV coordinates, or of any other two axes as a dense matrix.
///
/// Arrays are recognised by their names:
/// - `uv_grid` and `pix_to_face`: [`TexelGrid`].
/// - `valid_pixel_ids`, `valid_pixel_3d_faces`, ...: [`TexelLayout`].
/// - Faces: `face_ids`, `faces`, `closest_faces`, `lmk_face_idx` and others; with shape `(n, 3)` they
///   are vertices. Weights: `bary_coords`, `barycentric`, `bc`, `lmk_b_coords` and others.
///
/// # Errors
/// [`CorrespondenceError`], which names the array and what it must be.
pub fn parse(bytes: &[u8]) -> Result<CorrespondenceFile, CorrespondenceError> {
    const WANTED: &str = "an NPZ archive, an NPY array or a pickle of correspondences";
    match bytes {
        [b'P', b'K', ..] => from_arrays(&crate::arrays::parse(bytes)?),
        _ if bytes.starts_with(crate::numpy::MAGIC) => from_npy(bytes),
        // The possible first bytes of a pickle, as in `arrays::parse`.
        [0x80 | b'(' | b'}' | b']' | b'c', ..] if !bytes.starts_with(crate::torch::OLD_MAGIC) => {
            from_pickle(bytes)
        }
        _ => Err(ArraysError::Foreign { found: foreign_file(bytes), wanted: WANTED }.into()),
    }
}

/// Reads correspondences from a file, regardless of its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(input: impl Into<Input>) -> Result<CorrespondenceFile, ReadError<CorrespondenceError>> {
    input.into().parse(MAX_FILE_BYTES, parse)
}

/// The keys of matrices in deformation-transfer pickles.
const MATRICES: [&str; 2] = ["mtx", "matrix"];

fn from_npy(bytes: &[u8]) -> Result<CorrespondenceFile, CorrespondenceError> {
    let spend = |count| {
        let most = MAX_NUMBERS as u64;
        let refusal = Unread::Refused(ArraysError::TooMany { what: "numbers", most });
        if count > MAX_NUMBERS { Err(refusal) } else { Ok(()) }
    };
    match npy::read(bytes, spend) {
        Ok(Content::Pickle(bytes)) => from_pickle(bytes),
        Ok(Content::Held(Held::Array(array))) => from_array(&array),
        Ok(Content::Held(_)) => Err(form("", "hold numbers", "a string")),
        Err(unread) => Err(unread.into_error("").into()),
    }
}

fn from_pickle(bytes: &[u8]) -> Result<CorrespondenceFile, CorrespondenceError> {
    let pickle = pickle::parse(bytes).map_err(ArraysError::from)?;
    let root = single(pickle.root());
    if let Some(matrix) = matrix(root, "") {
        return Ok(CorrespondenceFile::Matrix(matrix?));
    }
    // Looked for before anything else is read: as dense arrays these would be too large.
    for key in MATRICES {
        let Some(value) = root.get(key) else { continue };
        let value = single(value);
        let dense = || SparseMatrix::from_dense(&value.as_array()?, key);
        return match matrix(value, key).or_else(dense) {
            Some(matrix) => Ok(CorrespondenceFile::Matrix(matrix?)),
            None => Err(form(key, "be a matrix, sparse or of two axes", value.kind())),
        };
    }
    let arrays = Collector::new(None, bytes.len()).collect(root)?;
    match arrays.get("") {
        Some(array) if root.entries().is_none() => from_array(array),
        _ => from_arrays(&arrays),
    }
}

fn matrix(value: Value<'_>, name: &str) -> Option<Result<SparseMatrix, ArraysError>> {
    SparseMatrix::from_pickle(value, name)
}

/// A single array without a name.
fn from_array(array: &NumericArray) -> Result<CorrespondenceFile, CorrespondenceError> {
    const WANTED: &str = "have shape (n, 4) with a face and its weights, (height, width, 2) with UV \
                          coordinates, or (vertices, vertices of the other mesh)";
    match *array.shape() {
        [_, 4] => points::from_rows(array),
        [_, columns] if columns > 4 => match SparseMatrix::from_numeric(array, "") {
            Some(matrix) => Ok(CorrespondenceFile::Matrix(matrix?)),
            None => Err(form("", WANTED, "another one")),
        },
        [height, width, 2] => grid::plain(array, height, width).map(CorrespondenceFile::Grid),
        ref shape => Err(form("", WANTED, format!("{shape:?}"))),
    }
}

fn from_arrays(arrays: &NamedArrays) -> Result<CorrespondenceFile, CorrespondenceError> {
    if let Some(matrix) = SparseMatrix::from_npz(arrays) {
        return Ok(CorrespondenceFile::Matrix(matrix?));
    }
    if arrays.names().any(|name| name == grid::UV_GRID) {
        return grid::reference(arrays).map(CorrespondenceFile::Grid);
    }
    if arrays.names().any(|name| layout::KEYS.contains(&name)) {
        return layout::read(arrays).map(CorrespondenceFile::Layout);
    }
    if let Some(points) = points::by_name(arrays)? {
        return Ok(points);
    }
    for key in MATRICES {
        if let Some(array) = arrays.get(key) {
            let wanted = "be a matrix of two axes";
            let matrix = SparseMatrix::from_numeric(array, key);
            let matrix = matrix.ok_or_else(|| form(key, wanted, format!("{:?}", array.shape())))?;
            return Ok(CorrespondenceFile::Matrix(matrix?));
        }
        if arrays.left_out(key).is_some() {
            arrays.require(key)?;
        }
    }
    Err(CorrespondenceError::Unknown { names: arrays.names().map(str::to_owned).collect() })
}
