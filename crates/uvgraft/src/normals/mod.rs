//! Transfers tangent-space normal maps to another layout.
//!
//! A texel of a tangent-space normal map is a direction in the local tangent frame (see
//! [`uvgraft_surface::tangents`]). Another layout has another frame at the same surface point, so copied
//! normals point elsewhere: where a chart is rotated, they rotate with it. Here each normal is
//! transformed from the source's tangent frame to object space, as renderers do, then from the
//! source mesh's pose to the target's, and finally into the target's tangent frame, as bakers do.
//!
//! Both frames are interpolated over the triangle as MikkTSpace specifies, so decoding matches
//! renderers term by term, and encoding is its exact inverse.

mod frames;
mod kernel;
mod options;
mod pose;
mod walk;

pub use self::options::{NormalOptions, NormalY};

use fearless_simd::{Level, Simd, dispatch};
use uvgraft_surface::pair::{Direction, Oriented, Pair};
use uvgraft_surface::piece::{FacePiece, mixed, wide};
use uvgraft_surface::tangents::{TangentFrame, TangentFrames};
use uvgraft_surface::threads::{for_each_chunk, join, map_indices};

use self::frames::PieceFrames;
use self::pose::Pose;
use self::walk::Walk;
use crate::map::SamplingMap;
use crate::texture::{Channels, Size};

/// Reorients normals from one layout to another, for one pair and direction. Computed once,
/// and valid for maps of any size.
#[derive(Debug, Clone)]
pub struct NormalFrames {
    direction: Direction,
    /// The frames over each piece.
    pieces: Vec<PieceFrames>,
}

/// Rows per parallel task.
const ROWS: usize = 16;

impl NormalFrames {
    /// Computes the tangent frames of both layouts and the rotation between the meshes' poses.
    ///
    /// The meshes may differ in scale, position and orientation, globally or, smoothly, part by
    /// part: around each vertex the source's frames are rotated by the least-squares rotation
    /// from the linked source edges to the target's, which is the identity where they are
    /// equal. A source that is the target's mirror image is detected, unless it is flat. Where
    /// the two surfaces face opposite ways, for instance because of opposite windings, normals
    /// are negated: the front of one is the back of the other.
    pub fn new(pair: &Pair, direction: Direction) -> Self {
        let oriented = pair.oriented(direction);
        let ((from, to), pose) = join(
            || join(|| TangentFrames::new(oriented.from), || TangentFrames::new(oriented.to)),
            || Pose::new(&oriented),
        );
        let pieces = map_indices(oriented.pieces.all().len(), |index| {
            let piece = oriented.pieces.all()[index];
            let source = posed(&pose, &oriented, piece, &from.faces()[piece.from as usize]);
            let target = &to.faces()[piece.to as usize];
            let tgt_uv = wide(oriented.to.uv_triangle(piece.to as usize));
            if oriented.pieces.part(piece).is_none() {
                return PieceFrames::new(tgt_uv, source, target);
            }
            let target = frames_at(target, |values| oriented.pieces.outline(piece, values));
            PieceFrames::new(oriented.pieces.outline(piece, tgt_uv), source, &target)
        });
        Self { direction, pieces }
    }

    /// Reorients the normals of a band of rows in place. The band holds texels already resampled
    /// from the source's normal map; texels that the map does not cover are left as they are.
    ///
    /// - `map`: made from the same pair in the same direction, of any size.
    /// - `first_row`: the row of the target at which the band starts.
    /// - `band`: `[rows * width * channels]`; red, green and blue are the components along
    ///   tangent, bitangent and normal, `0.0..=1.0` for −1 to 1. Results have length 1; alpha
    ///   is left as it is. Input normals need not have length 1; those that are shorter than
    ///   10⁻⁴, infinite or NaN become the flat normal, (0.5, 0.5, 1).
    ///
    /// In the gutter, frames are those of the triangle's nearest point.
    ///
    /// # Panics
    /// If the map has the other direction, there are fewer than three colour channels, or the
    /// band is not a whole number of the target's rows.
    pub fn turn(
        &self,
        map: &SamplingMap,
        options: NormalOptions,
        first_row: u32,
        band: &mut [f32],
        channels: Channels,
    ) {
        let Size { width, height } = map.size();
        let row = width as usize * channels.count();
        let rows = band.len() / row;
        assert_eq!(map.direction(), self.direction, "a map of another direction");
        assert!(channels.has_color(), "normals have three parts");
        assert!(
            band.len().is_multiple_of(row) && first_row as usize + rows <= height as usize,
            "{} values from row {first_row} on do not fill whole rows of {}",
            band.len(),
            map.size()
        );
        for_each_chunk(band, row * ROWS, |chunk, rows| {
            let first_row = first_row + (chunk * ROWS) as u32;
            let level = Level::new();
            match channels {
                Channels::Rgba => dispatch!(level, simd =>
                    turn_rows::<_, 4>(simd, self, map, options, first_row, rows)),
                _ => dispatch!(level, simd =>
                    turn_rows::<_, 3>(simd, self, map, options, first_row, rows)),
            }
        });
    }
}

/// The source's frames at a piece's corners, in the target's space.
///
/// - `frames`: at the corners of the source face.
fn posed(
    pose: &Pose,
    oriented: &Oriented<'_>,
    piece: FacePiece,
    frames: &[TangentFrame; 3],
) -> [TangentFrame; 3] {
    let Oriented { to, pieces, .. } = oriented;
    let vertices = to.faces()[piece.to as usize];
    let rotated = |frame: TangentFrame, turn: &dyn Fn([f32; 3]) -> [f32; 3]| TangentFrame {
        normal: turn(frame.normal),
        tangent: turn(frame.tangent),
        sign: frame.sign * pose.determinant(),
    };
    match pieces.part(piece) {
        // Rotations are given at vertices: rotate by all three, then interpolate to the part's
        // corners.
        Some(part) if !part.maps_corners_exactly() => {
            let frames = frames_at(frames, |values| pieces.at_outline(piece, values));
            std::array::from_fn(|k| {
                rotated(frames[k], &|vector| {
                    let vectors = vertices.map(|vertex| pose.rotate(vertex, vector));
                    mixed(&wide(vectors), part.to[k]).map(|value| value as f32)
                })
            })
        }
        // The part's mapping takes the whole triangle to the whole other one: rotate at the
        // triangle's corners and interpolate, so the result does not depend on where it is cut.
        _ => {
            let frames = frames_at(frames, |values| pieces.at_corners(piece, values));
            let at_corners: [TangentFrame; 3] = std::array::from_fn(|k| {
                rotated(frames[k], &|vector| pose.rotate(vertices[k], vector))
            });
            frames_at(&at_corners, |values| pieces.outline(piece, values))
        }
    }
}

/// Interpolates a triangle's corner frames at three other points.
///
/// - `interpolate`: maps values at the triangle's corners to values at these points.
fn frames_at(
    frames: &[TangentFrame; 3],
    interpolate: impl Fn([[f64; 3]; 3]) -> [[f64; 3]; 3],
) -> [TangentFrame; 3] {
    let vectors = |vector: fn(&TangentFrame) -> [f32; 3]| {
        let [a, b, c] = frames;
        interpolate(wide([a, b, c].map(vector))).map(|vector| vector.map(|value| value as f32))
    };
    let (normals, tangents) = (vectors(|frame| frame.normal), vectors(|frame| frame.tangent));
    std::array::from_fn(|k| TangentFrame {
        normal: normals[k],
        tangent: tangents[k],
        // Equal at all corners except on degenerate triangles.
        sign: frames[k].sign,
    })
}

#[inline(always)]
fn turn_rows<S: Simd, const C: usize>(
    simd: S,
    frames: &NormalFrames,
    map: &SamplingMap,
    options: NormalOptions,
    first_row: u32,
    rows: &mut [f32],
) {
    let width = map.size().width as usize * C;
    for (row, texels) in (first_row..).zip(rows.chunks_exact_mut(width)) {
        for &run in map.row(row) {
            let frames = &frames.pieces[map.patches()[run.patch as usize].piece as usize];
            let walk = Walk::new(frames, options, map, row, run);
            let texels = &mut texels[run.x as usize * C..][..run.len as usize * C];
            kernel::turn::<S, C>(simd, &walk, texels);
        }
    }
}
