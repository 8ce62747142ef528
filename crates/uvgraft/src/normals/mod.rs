//! Normal maps in another layout.
//!
//! A texel of a tangent-space normal map is a direction measured along the tangent frame of its
//! place (see [`crate::tangents`]). In another layout the same place has another frame, so copied
//! normals point elsewhere: where a chart is turned, so are they. Here each is brought from
//! the source's frame to object space, as renderers do, from the source mesh's pose to the
//! target's, and into the target's frame, as bakers do.
//!
//! Both frames are interpolated over the triangle as MikkTSpace has it, so the way there is the
//! renderer's to the last term, and the way back is its exact inverse.

mod frames;
mod kernel;
mod options;
mod pose;
mod walk;

pub use self::options::{NormalOptions, NormalY};

use fearless_simd::{Level, Simd, dispatch};

use self::frames::PieceFrames;
use self::pose::Pose;
use self::walk::Walk;
use crate::map::SamplingMap;
use crate::pair::{Direction, Oriented, Pair};
use crate::piece::{FacePiece, mixed, wide};
use crate::tangents::{TangentFrame, TangentFrames};
use crate::texture::{Channels, Size};
use crate::threads::{for_each_chunk, join};

/// What turns the normals of one layout into those of another, for one pair and direction. Made once,
/// for maps of any size.
#[derive(Debug, Clone)]
pub struct NormalFrames {
    direction: Direction,
    /// Over each piece.
    pieces: Vec<PieceFrames>,
}

/// Rows that one piece of work turns.
const ROWS: usize = 16;

impl NormalFrames {
    /// Computes the frames of both layouts and how the meshes are posed to each other.
    ///
    /// The meshes may be scaled, moved and turned differently, as wholes or, smoothly, part by part:
    /// around each vertex the source's frames are turned by the rotation that takes the linked edges
    /// there to the target's best, which is none where they are equal. A source that is the target's
    /// mirror image is recognised, flat ones aside. Where the two surfaces face opposite
    /// ways, as by windings, normals are turned around: what is in front for one is behind the other.
    pub fn new(pair: &Pair, direction: Direction) -> Self {
        let oriented = pair.oriented(direction);
        let (from, to) =
            join(|| TangentFrames::new(oriented.from), || TangentFrames::new(oriented.to));
        let pose = Pose::new(&oriented);
        let pieces = oriented.pieces.all().iter().map(|&piece| {
            let source = posed(&pose, &oriented, piece, &from.faces()[piece.from as usize]);
            let target = &to.faces()[piece.to as usize];
            let tgt_uv = wide(oriented.to.uv_triangle(piece.to as usize));
            if oriented.pieces.part(piece).is_none() {
                return PieceFrames::new(tgt_uv, source, target);
            }
            let target = mixed_frames(target, |values| oriented.pieces.outline(piece, values));
            PieceFrames::new(oriented.pieces.outline(piece, tgt_uv), source, &target)
        });
        Self { direction, pieces: pieces.collect() }
    }

    /// Turns the normals of a band of rows, in place: texels that were filtered from the source's
    /// normal map already, and that the map reaches; others stay as they are.
    ///
    /// - `map`: made from the same pair in the same direction, of any size.
    /// - `first_row`: the row of the target that the band starts with.
    /// - `band`: `[rows * width * channels]`, red, green and blue being a normal's parts along
    ///   tangent, bitangent and normal, `0.0..=1.0` for −1 to 1. What comes out has length 1. Opacity
    ///   stays as it is. Normals need not have length 1; those shorter than 10⁻⁴, infinite, or
    ///   no number become the flat normal, (0.5, 0.5, 1).
    ///
    /// In the gutter frames are those of the nearest point of the triangle.
    ///
    /// # Panics
    /// If the map has the other direction, there are no three colours, or the band is no whole
    /// number of rows of the target.
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
/// - `frames`: of the face that is read.
fn posed(
    pose: &Pose,
    oriented: &Oriented<'_>,
    piece: FacePiece,
    frames: &[TangentFrame; 3],
) -> [TangentFrame; 3] {
    let Oriented { to, pieces, .. } = oriented;
    let vertices = to.faces()[piece.to as usize];
    let turned = |frame: TangentFrame, turn: &dyn Fn([f32; 3]) -> [f32; 3]| TangentFrame {
        normal: turn(frame.normal),
        tangent: turn(frame.tangent),
        sign: frame.sign * pose.determinant(),
    };
    match pieces.part(piece) {
        // Between vertices the rotation is between theirs.
        Some(part) if !part.takes_corners_to_corners() => {
            let frames = mixed_frames(frames, |values| pieces.at_outline(piece, values));
            std::array::from_fn(|k| {
                turned(frames[k], &|vector| {
                    let turned = vertices.map(|vertex| pose.turned(vertex, vector));
                    mixed(&wide(turned), part.to[k]).map(|value| value as f32)
                })
            })
        }
        // Where two triangles are one, frames are between those that are turned at its corners, so it does not
        // matter where it is cut.
        _ => {
            let frames = mixed_frames(frames, |values| pieces.at_corners(piece, values));
            let at_corners: [TangentFrame; 3] = std::array::from_fn(|k| {
                turned(frames[k], &|vector| pose.turned(vertices[k], vector))
            });
            mixed_frames(&at_corners, |values| pieces.outline(piece, values))
        }
    }
}

/// Frames at other places of a triangle.
///
/// - `places`: takes values at the triangle's corners to those at the places.
fn mixed_frames(
    frames: &[TangentFrame; 3],
    places: impl Fn([[f64; 3]; 3]) -> [[f64; 3]; 3],
) -> [TangentFrame; 3] {
    let vectors = |vector: fn(&TangentFrame) -> [f32; 3]| {
        let [a, b, c] = frames;
        places(wide([a, b, c].map(vector))).map(|vector| vector.map(|value| value as f32))
    };
    let (normals, tangents) = (vectors(|frame| frame.normal), vectors(|frame| frame.tangent));
    std::array::from_fn(|k| TangentFrame {
        normal: normals[k],
        tangent: tangents[k],
        // The same at all corners, but for triangles without area.
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
