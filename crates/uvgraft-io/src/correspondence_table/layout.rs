//! TF_FLAME's `texture_data_*.npy`: FLAME's UV layout, texel by texel.
//!
//! Source: `build_texture_from_image.py` of TF_FLAME reads them, `cache_data` in `col_to_tex.py` of
//! BFM_to_FLAME shows how they were computed, and issue 19 of TF_FLAME describes them. Texel centres
//! are at `x = column + 0.5` and `y = row + 0.5`, rows go from the top down (images are written as
//! `texture[int(y), int(x)]`), and centres are compared with UV coordinates as `x = u * width` and
//! `y = height - v * height`, v upwards as in OBJ. So `(x / width, y / height)` is a UV coordinate in
//! this crate's convention, exactly.

use uvgraft::{Size, Weights};

use super::{CorrespondenceError, form};
use crate::arrays::{ArraysError, NamedArrays, NumericArray};

const IDS: &str = "valid_pixel_ids";
const VERTICES: &str = "valid_pixel_3d_faces";
const WEIGHTS: &str = "valid_pixel_b_coords";

/// The keys that tell such a file.
pub(super) const KEYS: [&str; 3] = [IDS, VERTICES, WEIGHTS];

/// Maximum number of texels on a side.
const MAX_SIDE: f32 = 65_536.0;

/// Vertices must be below this: a mesh is made with as many as the largest index claims.
const MAX_VERTICES: i64 = 1 << 22;

/// How far weights may be outside of 0 to 1, and their sum from 1.
const TOLERANCE: f64 = 1e-2;

/// The texels of a layout that lie on a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelLayout {
    /// Size of the grid of texels.
    pub size: Size,
    /// `[texels]` centres, in texels, origin at the top left.
    pub centres_px: Vec<[f32; 2]>,
    /// `[texels]` vertices of the mesh's triangle at each.
    pub vertices: Vec<[u32; 3]>,
    /// `[texels]` barycentric weights of these vertices.
    pub weights: Vec<Weights>,
    /// The layout itself, which TF_FLAME's files have beside the texels (`vt` and `ft`).
    pub uv: Option<LayoutUv>,
}

/// UV coordinates and the faces between them, without the mesh's vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct LayoutUv {
    /// UV coordinates, origin at the top left.
    pub uv: Vec<[f32; 2]>,
    /// Faces of indices into `uv`.
    pub faces: Vec<[u32; 3]>,
}

pub(super) fn read(arrays: &NamedArrays) -> Result<TexelLayout, CorrespondenceError> {
    let ids = list(arrays, IDS, 1)?.integers();
    let ids = ids.ok_or_else(|| form(IDS, "hold integers", "floats"))?;
    let grid = [coordinates(arrays, "x_coords")?, coordinates(arrays, "y_coords")?];
    if grid[0].len() != grid[1].len() {
        let wanted = format!("have as many values as `x_coords`, {}", grid[0].len());
        return Err(form("y_coords", wanted, grid[1].len()));
    }
    let size = size(arrays, &grid)?;
    // Some tools write columns and rows instead of centres.
    let are_indices = grid.iter().flatten().all(|value| value.fract() == 0.0);
    let half = if are_indices { 0.5 } else { 0.0 };
    let centre = |&id: &i64| {
        let at = usize::try_from(id).ok().filter(|&at| at < grid[0].len());
        let at = at.ok_or_else(|| {
            form(IDS, format!("be indices into `x_coords`, below {}", grid[0].len()), id)
        })?;
        Ok([grid[0][at] + half, grid[1][at] + half])
    };
    let centres_px = ids.iter().map(centre).collect::<Result<Vec<_>, CorrespondenceError>>()?;
    let vertices = triples(arrays, VERTICES, ids.len())?.integers();
    let vertices = vertices.ok_or_else(|| form(VERTICES, "hold integers", "floats"))?;
    if let Some(found) = vertices.iter().find(|index| !(0..MAX_VERTICES).contains(index)) {
        return Err(form(VERTICES, format!("be vertices from 0 to {}", MAX_VERTICES - 1), found));
    }
    let narrow = |triple: &[i64; 3]| triple.map(|index| index as u32);
    let vertices = vertices.as_chunks::<3>().0.iter().map(narrow).collect();
    let weights = triples(arrays, WEIGHTS, ids.len())?.f64s();
    let weights: Vec<Weights> = weights.as_chunks::<3>().0.to_vec();
    if let Some(found) = weights.iter().find(|weights| !are_barycentric(weights)) {
        let wanted = "be barycentric weights, from 0 to 1 with a sum of 1";
        return Err(form(WEIGHTS, wanted, format!("{found:?}")));
    }
    Ok(TexelLayout { size, centres_px, vertices, weights, uv: layout_uv(arrays)? })
}

fn are_barycentric(weights: &Weights) -> bool {
    weights.iter().all(|weight| (-TOLERANCE..=1.0 + TOLERANCE).contains(weight))
        && (weights.iter().sum::<f64>() - 1.0).abs() <= TOLERANCE
}

/// An array with one axis longer than 1 at most, or with rows of `width`.
fn list<'a>(
    arrays: &'a NamedArrays,
    name: &str,
    width: usize,
) -> Result<&'a NumericArray, CorrespondenceError> {
    let array = arrays.require(name)?;
    match (array.shape(), width) {
        ([_] | [_, 1] | [1, _], 1) => Ok(array),
        ([_, found], width) if width > 1 && *found == width => Ok(array),
        (found, 1) => Err(form(name, "have shape (n)", format!("{found:?}"))),
        (found, _) => Err(form(name, format!("have shape (n, {width})"), format!("{found:?}"))),
    }
}

fn triples<'a>(
    arrays: &'a NamedArrays,
    name: &str,
    count: usize,
) -> Result<&'a NumericArray, CorrespondenceError> {
    let array = list(arrays, name, 3)?;
    if array.shape()[0] != count {
        let wanted = format!("have shape ({count}, 3), a row for each of `{IDS}`");
        return Err(form(name, wanted, format!("{:?}", array.shape())));
    }
    Ok(array)
}

fn coordinates(arrays: &NamedArrays, name: &str) -> Result<Vec<f32>, CorrespondenceError> {
    let found = list(arrays, name, 1)?.f32s().into_owned();
    match found.iter().find(|value| !(0.0..MAX_SIDE).contains(*value)) {
        Some(value) => Err(form(name, "be texel positions from 0 to 65535", value)),
        None => Ok(found),
    }
}

/// The size of the image: `img_size` where it is given, or that of the grid, which has all texels.
fn size(arrays: &NamedArrays, grid: &[Vec<f32>; 2]) -> Result<Size, CorrespondenceError> {
    const SIDE: &str = "img_size";
    let needed = |axis: usize| grid[axis].iter().fold(0.0_f32, |a, &b| a.max(b)) as u32 + 1;
    let needed = [needed(0), needed(1)];
    let Some(side) = arrays.get(SIDE) else { return Ok(Size::new(needed[0], needed[1])) };
    let sides = side.integers().unwrap_or_default();
    let side = sides.first().filter(|side| sides.iter().all(|other| other == *side));
    let most = needed[0].max(needed[1]);
    let side = side.and_then(|&side| u32::try_from(side).ok());
    match side.filter(|&side| side >= most && f64::from(side) <= f64::from(MAX_SIDE)) {
        Some(side) => Ok(Size::square(side)),
        None => {
            let wanted = format!("be one length of at least {most}, where the last texel is");
            Err(form(SIDE, wanted, format!("{sides:?}")))
        }
    }
}

/// The layout, if the file has it.
fn layout_uv(arrays: &NamedArrays) -> Result<Option<LayoutUv>, CorrespondenceError> {
    if arrays.get("vt").is_none() || arrays.get("ft").is_none() {
        return Ok(None);
    }
    let vt = arrays.require("vt")?;
    let width = match *vt.shape() {
        [_, width @ (2 | 3)] => width,
        ref found => return Err(form("vt", "have shape (n, 2)", format!("{found:?}"))),
    };
    let vt = vt.f32s();
    if let Some(found) = vt.iter().find(|value| !value.is_finite()) {
        return Err(form("vt", "be finite", found));
    }
    // Upwards in the file.
    let uv: Vec<[f32; 2]> = vt.chunks_exact(width).map(|uv| [uv[0], 1.0 - uv[1]]).collect();
    let ft = list(arrays, "ft", 3)?.integers();
    let ft = ft.ok_or_else(|| form("ft", "hold integers", "floats"))?;
    let index = |&found: &i64| {
        let index = u32::try_from(found).ok().filter(|&index| (index as usize) < uv.len());
        index.ok_or_else(|| form("ft", format!("be indices into `vt`, below {}", uv.len()), found))
    };
    let indices = ft.iter().map(index).collect::<Result<Vec<u32>, _>>()?;
    if indices.is_empty() {
        return Err(ArraysError::array("ft", "must have faces").into());
    }
    Ok(Some(LayoutUv { faces: indices.as_chunks::<3>().0.to_vec(), uv }))
}
