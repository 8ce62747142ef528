//! Faces, or their vertices, with barycentric weights.

use uvgraft::Weights;

use super::{CorrespondenceError, CorrespondenceFile, form};
use crate::arrays::{NamedArrays, NumericArray};

/// The names of faces, the most specific first. `closest_faces` and `bc` are SMPL-X's,
/// `lmk_face_idx` and `lmk_b_coords` are FLAME's, `nearest_faces` and `b_coords` come with subdivided
/// SMPL-X meshes, `triangle_id` is what trimesh calls it.
const FACES: [&str; 19] = [
    "face_ids",
    "face_id",
    "fids",
    "fid",
    "closest_faces",
    "closest_face",
    "nearest_faces",
    "nearest_face",
    "triangle_ids",
    "triangle_id",
    "tri_ids",
    "face_idx",
    "faces_idx",
    "face_indices",
    "face_index",
    "lmk_face_idx",
    "lmk_faces_idx",
    "index_tri",
    "faces",
];

/// The names of barycentric weights.
const WEIGHTS: [&str; 17] = [
    "bary_coords",
    "bary",
    "barys",
    "barycentric",
    "barycentrics",
    "barycentric_coords",
    "barycentric_coordinates",
    "barycentric_weights",
    "bary_weights",
    "b_coords",
    "bcoords",
    "bcs",
    "bc",
    "lmk_b_coords",
    "lmk_bary_coords",
    "closest_bcs",
    "weights",
];

/// The points of a file with arrays of both kinds; `None` for others.
pub(super) fn by_name(
    arrays: &NamedArrays,
) -> Result<Option<CorrespondenceFile>, CorrespondenceError> {
    let known = |names: &[&'static str]| {
        let has = |name: &&&str| arrays.get(name).is_some() || arrays.left_out(name).is_some();
        names.iter().find(has).copied()
    };
    let (Some(faces), Some(weights)) = (known(&FACES), known(&WEIGHTS)) else { return Ok(None) };
    read([faces, weights], arrays.require(faces)?, arrays.require(weights)?).map(Some)
}

fn read(
    [faces_name, weights_name]: [&str; 2],
    faces: &NumericArray,
    weights: &NumericArray,
) -> Result<CorrespondenceFile, CorrespondenceError> {
    let (count, are_vertices) = match *faces.shape() {
        [count] | [count, 1] => (count, false),
        [count, 3] => (count, true),
        ref found => {
            let wanted = "have shape (n) with a face, or (n, 3) with its vertices";
            return Err(form(faces_name, wanted, format!("{found:?}")));
        }
    };
    if *weights.shape() != [count, 3] {
        let wanted = format!("have shape ({count}, 3) like `{faces_name}`");
        return Err(form(weights_name, wanted, format!("{:?}", weights.shape())));
    }
    let indices = faces.integers();
    let indices = indices.ok_or_else(|| form(faces_name, "hold integers", "floats"))?;
    if let Some((at, found)) = indices.iter().enumerate().find(|(_, index)| **index < -1) {
        let at = if are_vertices { at / 3 } else { at };
        return Err(form(
            faces_name,
            "be at least 0, or -1 for none",
            format!("{found} in row {at}"),
        ));
    }
    let weights: Vec<Weights> = weights.f64s().as_chunks::<3>().0.to_vec();
    let step = if are_vertices { 3 } else { 1 };
    check(weights_name, &weights, |row| indices.get(row * step).is_some_and(|&index| index >= 0))?;
    Ok(if are_vertices {
        CorrespondenceFile::Corners { vertices: indices.as_chunks::<3>().0.to_vec(), weights }
    } else {
        CorrespondenceFile::Points { faces: indices, weights }
    })
}

/// Checks that weights are finite where there is a face.
fn check(
    name: &str,
    weights: &[Weights],
    is_used: impl Fn(usize) -> bool,
) -> Result<(), CorrespondenceError> {
    let is_broken = |row: &usize| is_used(*row) && !weights[*row].iter().all(|w| w.is_finite());
    match (0..weights.len()).find(is_broken) {
        Some(row) => {
            let found = format!("{:?} in row {row}", weights[row]);
            Err(form(name, "hold finite weights", found))
        }
        None => Ok(()),
    }
}

/// Rows of a face and three weights. A face that is NaN is none.
pub(super) fn from_rows(array: &NumericArray) -> Result<CorrespondenceFile, CorrespondenceError> {
    const WANTED: &str = "have a face, an integer from 0, or -1 for none, in its first column";
    let values = array.f64s();
    let rows = values.as_chunks::<4>().0;
    let mut faces = Vec::with_capacity(rows.len());
    for (at, row) in rows.iter().enumerate() {
        let face = if row[0].is_nan() { -1.0 } else { row[0] };
        if face.fract() != 0.0 || !(-1.0..=f64::from(u32::MAX)).contains(&face) {
            return Err(form("", WANTED, format!("{face} in row {at}")));
        }
        faces.push(face as i64);
    }
    let weights: Vec<Weights> = rows.iter().map(|&[_, a, b, c]| [a, b, c]).collect();
    check("", &weights, |row| faces[row] >= 0)?;
    Ok(CorrespondenceFile::Points { faces, weights })
}
