//! The template mesh of a body model of the SMPL family, with the UV layout stored in its file.
//!
//! Only the four arrays of the mesh are read, not the shapes and correctives, which take most of
//! such a file.
//!
//! The open body (crate `uvgraft-open-body`) also has names of its parts, and a second layout on its
//! head:
//!
//! - `part_names`: a string with a line for each part; `face_part` `[triangles]`: the part of each.
//! - `head_v` `[vertices of the head]`: indices into `v_template`; `head_f` `[triangles, 3]`: indices
//!   into `head_v`; `head_vt`, `head_ft`: its layout, as `vt` and `ft`.
//!
//! Source: the model files of SMPL-X, 1.1, and of textured FLAME models: `v_template` and `f` as in
//! every model, `vt` and `ft` as in an OBJ file, with `v` upwards.

use uvgraft::mesh::{Mesh, MeshError, MeshPart};

use crate::arrays::{ArrayFile, ArraySelection, ArraysError, NamedArrays};
use uvgraft_files::input::{Input, ReadError};

const POSITIONS: &str = "v_template";
const FACES: &str = "f";
const UV: &str = "vt";
const UV_FACES: &str = "ft";
const PART_NAMES: &str = "part_names";
const FACE_PART: &str = "face_part";
const HEAD: [&str; 4] = ["head_v", "head_f", "head_vt", "head_ft"];

/// Why the arrays of a file are not a mesh with a UV layout.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelMeshError {
    /// The file cannot be read, or has no mesh.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// A model without texture coordinates, as most are published.
    #[error(
        "the model file has no UV layout (array `{missing}`); use an OBJ file of the model with \
         UV coordinates (`vt`) instead"
    )]
    NoLayout {
        /// The array that is missing.
        missing: &'static str,
    },
    /// An array has another shape.
    #[error("array `{name}` must have shape [{wanted}], got {found:?}")]
    Shape {
        /// Name of the array.
        name: &'static str,
        /// Its shape in words.
        wanted: &'static str,
        /// Its actual shape.
        found: Vec<usize>,
    },
    /// Indices are not whole numbers from 0.
    #[error("array `{name}` must hold indices from 0 to 4294967295")]
    Indices {
        /// Name of the array.
        name: &'static str,
    },
    /// The mesh as a whole was rejected.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A model whose head has no layout of its own.
    #[error("the head of the model has no layout of its own (array `{missing}`)")]
    NoHead {
        /// The array that is missing.
        missing: &'static str,
    },
    /// Parts do not cover the triangles.
    #[error("array `{FACE_PART}` must hold a line of `{PART_NAMES}` for each triangle")]
    Parts,
}

/// Makes a mesh from the arrays of a model.
///
/// - `v_template`: `[vertices, 3]`, in metres.
/// - `f`: `[triangles, 3]`, indices into `v_template`.
/// - `vt`: `[uv coordinates, 2]`, with the origin at the bottom left. `v` is flipped, to `1 - v` in
///   64 bits before it is rounded to 32.
/// - `ft`: `[triangles, 3]`, indices into `vt`, parallel to `f`.
///
/// Vertices, texture coordinates and triangles keep their order.
///
/// # Errors
/// [`ModelMeshError`] if an array is missing, has another shape, or refers to what does not exist.
pub fn from_arrays(arrays: &NamedArrays) -> Result<Mesh, ModelMeshError> {
    let positions = rows::<3>(arrays, POSITIONS, "vertices, 3")?;
    let faces = indices(arrays, FACES)?;
    for missing in [UV, UV_FACES] {
        if matches!(arrays.require(missing), Err(ArraysError::Missing { .. })) {
            return Err(ModelMeshError::NoLayout { missing });
        }
    }
    let uv = rows::<2>(arrays, UV, "uv coordinates, 2")?;
    let uv_faces = indices(arrays, UV_FACES)?;
    let parts = parts(arrays, faces.len())?;
    Ok(mesh(positions, uv, &faces, &uv_faces)?.with_parts(parts))
}

/// Makes a mesh of the head alone, in its own layout, from the arrays of a model that has one; see
/// the [module](self).
///
/// # Errors
/// [`ModelMeshError::NoHead`] if it has none; otherwise as [`from_arrays`].
pub fn head_from_arrays(arrays: &NamedArrays) -> Result<Mesh, ModelMeshError> {
    for missing in HEAD {
        if matches!(arrays.require(missing), Err(ArraysError::Missing { .. })) {
            return Err(ModelMeshError::NoHead { missing });
        }
    }
    let positions = rows::<3>(arrays, POSITIONS, "vertices, 3")?;
    let positions = head_vertices(arrays)?
        .into_iter()
        .map(|vertex| positions.get(vertex as usize).copied())
        .collect::<Option<Vec<_>>>()
        .ok_or(ModelMeshError::Indices { name: HEAD[0] })?;
    let faces = indices(arrays, HEAD[1])?;
    let uv = rows::<2>(arrays, HEAD[2], "uv coordinates, 2")?;
    let uv_faces = indices(arrays, HEAD[3])?;
    mesh(positions, uv, &faces, &uv_faces)
}

/// For each vertex of [`head_from_arrays`], its index in the model.
///
/// # Errors
/// [`ModelMeshError`] if the array is missing or malformed.
pub fn head_vertices(arrays: &NamedArrays) -> Result<Vec<u32>, ModelMeshError> {
    let name = HEAD[0];
    let array = arrays.require(name)?;
    let [_] = array.shape() else {
        let found = array.shape().to_vec();
        return Err(ModelMeshError::Shape { name, wanted: "vertices", found });
    };
    let numbers = array.integers().ok_or(ModelMeshError::Indices { name })?;
    let numbers: Result<Vec<u32>, _> = numbers.into_iter().map(u32::try_from).collect();
    numbers.map_err(|_| ModelMeshError::Indices { name })
}

fn mesh(
    positions: Vec<[f64; 3]>,
    uv: Vec<[f64; 2]>,
    faces: &[[u32; 3]],
    uv_faces: &[[u32; 3]],
) -> Result<Mesh, ModelMeshError> {
    let positions = positions.into_iter().map(|position| position.map(|x| x as f32)).collect();
    let uv = uv.into_iter().map(|[u, v]| [u as f32, (1.0 - v) as f32]).collect();
    Ok(Mesh::from_triangles(positions, uv, faces, uv_faces)?)
}

/// The parts of a model that names any, as groups.
fn parts(arrays: &NamedArrays, triangles: usize) -> Result<Vec<MeshPart>, ModelMeshError> {
    let Some(names) = arrays.text(PART_NAMES) else { return Ok(Vec::new()) };
    let names: Vec<&str> = names.lines().collect();
    let numbers = arrays.require(FACE_PART)?.integers().unwrap_or_default();
    if numbers.len() != triangles {
        return Err(ModelMeshError::Parts);
    }
    let mut parts: Vec<MeshPart> = Vec::new();
    let mut last = None;
    for (face, number) in (0..).zip(numbers) {
        if last == Some(number)
            && let Some(part) = parts.last_mut()
        {
            part.polygons.end = face + 1;
            continue;
        }
        let name = usize::try_from(number).ok().and_then(|number| names.get(number));
        let group = (*name.ok_or(ModelMeshError::Parts)?).to_owned();
        last = Some(number);
        parts.push(MeshPart { group, polygons: face..face + 1, ..MeshPart::default() });
    }
    Ok(parts)
}

/// Reads the mesh of a model file (NPZ or pickle); see [`from_arrays`], and
/// [`arrays::parse`](crate::arrays::parse) for the formats.
///
/// # Errors
/// [`ReadError`] if the file cannot be read, or its arrays are rejected by [`from_arrays`]. Each
/// names the file.
pub fn read(input: impl Into<Input>) -> Result<Mesh, ReadError<ModelMeshError>> {
    let names = [POSITIONS, FACES, UV, UV_FACES, PART_NAMES, FACE_PART];
    read_arrays(input.into(), &names, from_arrays)
}

/// Reads the mesh of a model's head in its own layout; see [`head_from_arrays`].
///
/// # Errors
/// As [`read`].
pub fn read_head(input: impl Into<Input>) -> Result<Mesh, ReadError<ModelMeshError>> {
    let [vertices, faces, uv, uv_faces] = HEAD;
    read_arrays(input.into(), &[POSITIONS, vertices, faces, uv, uv_faces], head_from_arrays)
}

fn read_arrays(
    input: Input,
    names: &[&str],
    make: fn(&NamedArrays) -> Result<Mesh, ModelMeshError>,
) -> Result<Mesh, ReadError<ModelMeshError>> {
    let refused = |error: ReadError<ArraysError>| error.map_content(ModelMeshError::from);
    let path = input.name().to_path_buf();
    let mut file = ArrayFile::open(input).map_err(refused)?;
    let wanted = |name: &str, _: &[usize]| {
        if names.contains(&name) { ArraySelection::All } else { ArraySelection::Nothing }
    };
    let arrays = file.read(wanted).map_err(refused)?;
    make(&arrays).map_err(|reason| ReadError::Content { path, reason })
}

fn rows<const N: usize>(
    arrays: &NamedArrays,
    name: &'static str,
    wanted: &'static str,
) -> Result<Vec<[f64; N]>, ModelMeshError> {
    let array = arrays.require(name)?;
    match array.shape() {
        &[_, width] if width == N => Ok(array.f64s().as_chunks::<N>().0.to_vec()),
        found => Err(ModelMeshError::Shape { name, wanted, found: found.to_vec() }),
    }
}

fn indices(arrays: &NamedArrays, name: &'static str) -> Result<Vec<[u32; 3]>, ModelMeshError> {
    let array = arrays.require(name)?;
    let [_, 3] = array.shape() else {
        let found = array.shape().to_vec();
        return Err(ModelMeshError::Shape { name, wanted: "triangles, 3", found });
    };
    let numbers = array.integers().ok_or(ModelMeshError::Indices { name })?;
    let numbers: Result<Vec<u32>, _> = numbers.into_iter().map(u32::try_from).collect();
    let numbers = numbers.map_err(|_| ModelMeshError::Indices { name })?;
    Ok(numbers.as_chunks::<3>().0.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrays::{NumericArray, save_npz};

    /// A square of two triangles whose layout has a seam along the diagonal.
    fn model() -> NamedArrays {
        let mut arrays = NamedArrays::new();
        let mut put = |name: &str, array: Option<NumericArray>| arrays.insert(name, array.unwrap());
        let square = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]].concat();
        put(POSITIONS, NumericArray::new_f64(vec![4, 3], square));
        put(FACES, NumericArray::new_i64(vec![2, 3], vec![0, 1, 2, 0, 2, 3]));
        let uv = vec![0.0, 0.0, 0.5, 0.0, 0.5, 0.75, 0.5, 0.0, 1.0, 0.75, 0.5, 1.0];
        put(UV, NumericArray::new_f64(vec![6, 2], uv));
        put(UV_FACES, NumericArray::new_i64(vec![2, 3], vec![0, 1, 2, 3, 4, 5]));
        put("shapedirs", NumericArray::new_f32(vec![4, 3, 2], vec![0.0; 24]));
        arrays
    }

    #[test]
    fn a_model_with_a_layout_is_a_mesh() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.npz");
        save_npz(&model(), &path).unwrap();
        let mesh = read(&path).unwrap();
        assert_eq!(mesh, from_arrays(&model()).unwrap());
        assert_eq!(mesh.faces(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.uv_faces(), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!((mesh.positions()[2], mesh.uv()[2]), ([1.0, 1.0, 0.5], [0.5, 0.25]));
    }

    #[test]
    fn heads_have_a_layout_of_their_own_and_parts_have_names() {
        let mut arrays = model();
        let missing = head_from_arrays(&arrays).unwrap_err();
        assert_eq!(missing, ModelMeshError::NoHead { missing: "head_v" });
        let integers = |shape: &[usize], values: &[i64]| {
            NumericArray::new_i64(shape.to_vec(), values.to_vec()).unwrap()
        };
        arrays.insert(HEAD[0], integers(&[3], &[0, 2, 3]));
        arrays.insert(HEAD[1], integers(&[1, 3], &[0, 1, 2]));
        let uv = vec![0.0, 0.0, 1.0, 0.0, 1.0, 0.75];
        arrays.insert(HEAD[2], NumericArray::new_f64(vec![3, 2], uv).unwrap());
        arrays.insert(HEAD[3], integers(&[1, 3], &[0, 1, 2]));
        arrays.insert_text(PART_NAMES, "skin\neye");
        arrays.insert(FACE_PART, integers(&[2], &[0, 1]));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.npz");
        save_npz(&arrays, &path).unwrap();
        let head = read_head(&path).unwrap();
        assert_eq!(head.faces(), [[0, 1, 2]]);
        assert_eq!((head.positions()[1], head.uv()[2]), ([1.0, 1.0, 0.5], [1.0, 0.25]));
        let whole = read(&path).unwrap();
        let names: Vec<_> = whole.parts().iter().map(|p| (&*p.group, p.polygons.clone())).collect();
        assert_eq!(names, [("skin", 0..1), ("eye", 1..2)]);
        arrays.insert(HEAD[0], integers(&[3], &[0, 2, 4]));
        head_from_arrays(&arrays).unwrap_err();
        arrays.insert(FACE_PART, integers(&[2], &[0, 2]));
        assert_eq!(from_arrays(&arrays), Err(ModelMeshError::Parts));
    }

    #[test]
    fn models_without_a_layout_say_what_to_use_instead() {
        for (name, wanted) in [
            (UV, "model.npz: the model file has no UV layout (array `vt`); use an OBJ file"),
            (UV_FACES, "no UV layout (array `ft`)"),
            (POSITIONS, "no array `v_template`; the file has `f`, `vt`, `ft`, `shapedirs`"),
            (FACES, "no array `f`"),
        ] {
            let mut arrays = model();
            arrays.take(name);
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("model.npz");
            save_npz(&arrays, &path).unwrap();
            let error = read(&path).unwrap_err().to_string();
            assert!(error.contains(wanted), "{error}");
        }
    }

    #[test]
    fn inconsistent_arrays_are_refused() {
        let integers = |shape: [usize; 2], values: &[i64]| {
            NumericArray::new_i64(shape.to_vec(), values.to_vec()).unwrap()
        };
        let floats = |shape: &[usize], value: f32| {
            let count = shape.iter().product();
            NumericArray::new_f32(shape.to_vec(), vec![value; count]).unwrap()
        };
        for (name, array, wanted) in [
            (
                FACES,
                integers([2, 3], &[0, 1, 2, 0, 2, 4]),
                "uses vertex 4, but the mesh has only 4",
            ),
            (FACES, integers([1, 3], &[0, 1, 2]), "must have 1 UV faces, got 2"),
            (FACES, integers([0, 3], &[]), "must have 0 UV faces, got 2"),
            (FACES, integers([2, 3], &[0, 1, 2, 0, 2, -1]), "`f` must hold indices from 0"),
            (FACES, floats(&[2, 3], 0.5), "`f` must hold indices"),
            (FACES, integers([1, 4], &[0; 4]), "`f` must have shape [triangles, 3], got [1, 4]"),
            (UV_FACES, integers([2, 3], &[0, 1, 2, 0, 2, 6]), "uses UV coordinate 6"),
            (UV, floats(&[6, 3], 0.5), "must have shape [uv coordinates, 2], got [6, 3]"),
            (UV, floats(&[6, 2], f32::NAN), "UV coordinate 0 must be finite"),
            (POSITIONS, floats(&[12], 0.0), "must have shape [vertices, 3], got [12]"),
        ] {
            let mut arrays = model();
            arrays.insert(name, array);
            let error = from_arrays(&arrays).expect_err(wanted).to_string();
            assert!(error.contains(wanted), "{error}");
        }
    }

    #[test]
    fn no_bytes_make_it_panic() {
        let mut file = std::io::Cursor::new(Vec::new());
        crate::arrays::write_npz(&model(), &mut file).unwrap();
        let file = file.into_inner();
        let mut random = fastrand::Rng::with_seed(3);
        let mut accepted = 0;
        for _ in 0..5_000 {
            let mut bytes = file.clone();
            let at = random.usize(0..bytes.len());
            match random.u32(0..8) {
                0 => bytes.truncate(at),
                _ => bytes[at] = random.u8(..),
            }
            let mesh = crate::arrays::parse(&bytes).map(|arrays| from_arrays(&arrays));
            accepted += usize::from(matches!(mesh, Ok(Ok(_))));
        }
        assert!((100..4_500).contains(&accepted), "{accepted} accepted: not a test of both ways");
    }
}
