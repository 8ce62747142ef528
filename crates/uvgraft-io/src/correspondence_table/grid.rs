//! Grids of source positions, one for each texel of the target's layout.

use uvgraft::Size;

use super::{CorrespondenceError, form};
use crate::arrays::{NamedArrays, NumericArray};

pub(super) const UV_GRID: &str = "uv_grid";
const PIX_TO_FACE: &str = "pix_to_face";

/// Positions this far outside of the source are none, in UV units: an edge's rounding is less.
const MARGIN: f32 = 1e-3;

/// For each texel of a target layout the position in a source layout.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelGrid {
    /// Size of the target.
    pub size: Size,
    /// `[height * width]` UV coordinates at the centres of texels, row by row, origin at the top left;
    /// NaN for none.
    ///
    /// From the `uv_grid` of Song et al. they are `(g + 1) / 2`: their code computes UV coordinates of
    /// the source at texel centres and stores `2 * uv - 1`. That is where the texel lies on the
    /// source's surface, which correspondences need. It is not quite where their code samples, by
    /// `torch.nn.functional.grid_sample` with `align_corners=True`: there -1 and 1 are the centres of
    /// the first and last texel rather than the edges of the image, half a texel off at most.
    pub uv: Vec<[f32; 2]>,
}

impl TexelGrid {
    /// Number of texels that have a position.
    pub fn count(&self) -> usize {
        self.uv.iter().filter(|uv| !uv[0].is_nan()).count()
    }
}

/// A grid of UV coordinates, as `uvgraft map` writes it: `[height, width, 2]`.
pub(super) fn plain(
    array: &NumericArray,
    height: usize,
    width: usize,
) -> Result<TexelGrid, CorrespondenceError> {
    let size = size("", height, width)?;
    let uv = array.f32s().as_chunks::<2>().0.iter().map(|&uv| inside(uv)).collect();
    Ok(TexelGrid { size, uv })
}

/// The archive of Song et al.: `uv_grid` of `[1, height, width, 2]` or without the first axis, and
/// `pix_to_face` of `[height, width]`, -1 where there is no position (which are 0 in `uv_grid`).
pub(super) fn reference(arrays: &NamedArrays) -> Result<TexelGrid, CorrespondenceError> {
    let grid = arrays.require(UV_GRID)?;
    let (height, width) = match *grid.shape() {
        [height, width, 2] | [1, height, width, 2] => (height, width),
        ref found => {
            let wanted = "have shape (height, width, 2) or (1, height, width, 2)";
            return Err(form(UV_GRID, wanted, format!("{found:?}")));
        }
    };
    let size = size(UV_GRID, height, width)?;
    let faces = arrays.require(PIX_TO_FACE)?;
    let without_ones = |shape: &[usize]| -> Vec<usize> {
        shape.iter().copied().filter(|&length| length != 1).collect()
    };
    if without_ones(faces.shape()) != without_ones(&[height, width]) {
        let wanted = format!("have shape ({height}, {width}) like `{UV_GRID}`");
        return Err(form(PIX_TO_FACE, wanted, format!("{:?}", faces.shape())));
    }
    let faces = faces.f32s();
    let position = |(&[x, y], &face): (&[f32; 2], &f32)| {
        let uv = [f32::midpoint(x, 1.0), f32::midpoint(y, 1.0)];
        // Not written as `<`: NaN is none too.
        if face >= 0.0 { inside(uv) } else { [f32::NAN; 2] }
    };
    let uv = grid.f32s().as_chunks::<2>().0.iter().zip(faces.iter()).map(position).collect();
    Ok(TexelGrid { size, uv })
}

fn size(name: &str, height: usize, width: usize) -> Result<Size, CorrespondenceError> {
    let side = |side: usize| u32::try_from(side).ok().filter(|&side| side > 0 && side <= 1 << 16);
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok(Size::new(width, height)),
        _ => {
            let found = format!("{width}×{height}");
            Err(form(name, "have from 1 to 65536 texels on each side", found))
        }
    }
}

fn inside(uv: [f32; 2]) -> [f32; 2] {
    let is_inside = uv.iter().all(|value| (-MARGIN..=1.0 + MARGIN).contains(value));
    if is_inside { uv } else { [f32::NAN; 2] }
}
