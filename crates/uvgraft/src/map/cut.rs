//! Faces with several pieces: which piece owns which texels of the face.
//!
//! Ownership among overlapping faces is decided for whole faces. Only then are the texels of a face
//! divided among its pieces, so pieces never change what a layout covers.

use uvgraft_surface::piece::{Weights, mixed};
use uvgraft_surface::raster::ScanTriangle;

use super::coverage::Span;
use crate::texture::Size;

/// The patches of each face.
pub(super) struct FacePatches {
    /// [`NONE`], the patch, or [`CUT`] and an index into `cut`.
    of_face: Vec<u32>,
    cut: Vec<CutFace>,
}

const NONE: u32 = u32::MAX;
const CORNERS: [Weights; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const CUT: u32 = 1 << 31;

/// The patches of one face.
pub(super) enum FacePatch<'a> {
    /// No piece is linked to it.
    None,
    /// One patch for all of it.
    One(u32),
    /// Several patches, or one patch for a part of the face.
    Cut(&'a CutFace),
}

/// A face whose pieces each cover a part of it.
#[derive(Default)]
pub(super) struct CutFace {
    parts: Vec<CutPart>,
}

struct CutPart {
    patch: u32,
    /// Barycentric coordinates of its corners in the face.
    weights: [Weights; 3],
    corners_px: [[f64; 2]; 3],
    texels: Option<ScanTriangle>,
}

impl FacePatches {
    pub fn none(faces: usize) -> Self {
        Self { of_face: vec![NONE; faces], cut: Vec::new() }
    }

    /// - `corners_px`: corners of the face.
    pub fn add_whole(&mut self, face: u32, patch: u32, corners_px: [[f64; 2]; 3], size: Size) {
        match self.of_face[face as usize] {
            NONE => self.of_face[face as usize] = patch,
            // Earlier parts own their texels, this one the rest.
            _ => self.add_part(face, patch, CORNERS, corners_px, size),
        }
    }

    /// - `weights`: barycentric coordinates of the part's corners in the face.
    /// - `corners_px`: corners of the face.
    pub fn add_part(
        &mut self,
        face: u32,
        patch: u32,
        weights: [Weights; 3],
        corners_px: [[f64; 2]; 3],
        size: Size,
    ) {
        let of_face = &mut self.of_face[face as usize];
        if *of_face & CUT == 0 || *of_face == NONE {
            *of_face = CUT | self.cut.len() as u32;
            self.cut.push(CutFace::default());
        }
        let corners_px = weights.map(|weights| mixed(&corners_px, weights));
        self.cut[(*of_face & !CUT) as usize].parts.push(CutPart {
            patch,
            weights,
            corners_px,
            texels: ScanTriangle::new(corners_px, size),
        });
    }

    #[inline(always)]
    pub fn of(&self, face: u32) -> FacePatch<'_> {
        match self.of_face[face as usize] {
            NONE => FacePatch::None,
            cut if cut & CUT != 0 => FacePatch::Cut(&self.cut[(cut & !CUT) as usize]),
            patch => FacePatch::One(patch),
        }
    }

    pub fn is_linked(&self, face: u32) -> bool {
        self.of_face[face as usize] != NONE
    }
}

impl CutFace {
    /// Splits a span of the face among its parts: calls `push` with each sub-span, from left to
    /// right, and the patch of its part. Where parts overlap, the first one owns the texel. Parts
    /// are rasterised by themselves, so rounding can leave texels on their edges without an owner;
    /// `patch_at_edge` closes these gaps.
    ///
    /// - `claims`: a buffer.
    pub fn split(
        &self,
        row: u32,
        span: Span,
        claims: &mut Vec<Span>,
        mut push: impl FnMut(Span, u32),
    ) {
        claims.clear();
        for (index, part) in (0..).zip(&self.parts) {
            let texels = part.texels.as_ref().map_or(0..0, |texels| texels.span(row));
            if texels.start < span.end && texels.end > span.start {
                claims.push(Span { start: texels.start, end: texels.end, face: index });
            }
        }
        let mut x = span.start;
        while x < span.end {
            // The first part that covers the texel, up to where an earlier part begins.
            let mut owner = None;
            let mut end = span.end;
            for claim in claims.iter() {
                if claim.start <= x && x < claim.end {
                    owner = Some(self.parts[claim.face as usize].patch);
                    end = end.min(claim.end);
                    break;
                }
                if x < claim.start {
                    end = end.min(claim.start);
                }
            }
            let owner = owner.or_else(|| {
                // No part covers this texel. Decide for it alone, since its neighbour may
                // belong to another part.
                end = x + 1;
                self.patch_at_edge(x, row)
            });
            if let Some(patch) = owner {
                push(Span { start: x, end, ..span }, patch);
            }
            x = end;
        }
    }

    /// The patch of a part on whose edge a texel's centre lies, within rounding: the edges of parts
    /// that lie on the face's own edges, or on each other, do not match them to the bit.
    fn patch_at_edge(&self, x: u32, row: u32) -> Option<u32> {
        const ROUNDING_PX: f64 = 1e-6;
        let centre = [f64::from(x) + 0.5, f64::from(row) + 0.5];
        let is_near = |part: &&CutPart| {
            let [a, b, c] = part.corners_px;
            let is_around = |axis: usize| {
                let (least, most) =
                    (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
                (least - ROUNDING_PX..=most + ROUNDING_PX).contains(&centre[axis])
            };
            is_around(0)
                && is_around(1)
                && [(a, b), (b, c), (c, a)]
                    .into_iter()
                    .any(|(from, to)| distance(centre, from, to) < ROUNDING_PX)
        };
        self.parts.iter().find(is_near).map(|part| part.patch)
    }

    /// Divides one of the face's edges among its parts: parameter ranges along the edge, within 0
    /// to 1, each with the patch of the part that it bounds.
    ///
    /// - `corner`: the corner of the face at which the edge begins.
    pub fn along(&self, corner: usize) -> impl Iterator<Item = ([f64; 2], Option<u32>)> {
        const ROUNDING: f64 = 1e-9;
        let (next, opposite) = ((corner + 1) % 3, (corner + 2) % 3);
        let mut parts: Vec<(f64, f64, u32)> = Vec::new();
        for part in &self.parts {
            for k in 0..3 {
                let (a, b) = (part.weights[k], part.weights[(k + 1) % 3]);
                if a[opposite].abs() < ROUNDING && b[opposite].abs() < ROUNDING {
                    let (from, to) = (a[next].min(b[next]), a[next].max(b[next]));
                    parts.push((from, to, part.patch));
                }
            }
        }
        let mut joints: Vec<f64> = parts.iter().flat_map(|&(from, to, _)| [from, to]).collect();
        joints.push(1.0);
        joints.sort_by(f64::total_cmp);
        let mut stretches: Vec<(f64, f64, Option<u32>)> = Vec::new();
        let mut at = 0.0;
        for joint in joints {
            if joint <= at + ROUNDING {
                continue;
            }
            // Where parts overlap, the first one owns the range, as inside the face.
            let middle = 0.5 * (at + joint);
            let owner = parts.iter().find(|&&(from, to, _)| from < middle && middle < to);
            let patch = owner.map(|&(.., patch)| patch);
            match stretches.last_mut() {
                Some(last) if last.2 == patch => last.1 = joint,
                _ => stretches.push((at, joint, patch)),
            }
            at = joint;
        }
        // Snap to the ends of the edge, so that they match to the bit.
        let end = |t: f64| {
            if t <= ROUNDING {
                0.0
            } else if t >= 1.0 - ROUNDING {
                1.0
            } else {
                t
            }
        };
        stretches.into_iter().map(move |(from, to, patch)| ([end(from), end(to)], patch))
    }
}

/// The distance between a point and a line segment.
fn distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let offset = [point[0] - from[0], point[1] - from[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let t = (offset[0] * along[0] + offset[1] * along[1]) / squared;
    // A segment without length is its first end (`t` is NaN).
    let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
    (offset[0] - t * along[0]).hypot(offset[1] - t * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(parts: &[[Weights; 3]], corners_px: [[f64; 2]; 3]) -> FacePatches {
        let mut of_faces = FacePatches::none(1);
        for (patch, &weights) in (0..).zip(parts) {
            of_faces.add_part(0, patch, weights, corners_px, Size::square(64));
        }
        of_faces
    }

    fn cut(of_faces: &FacePatches) -> &CutFace {
        match of_faces.of(0) {
            FacePatch::Cut(face) => face,
            _ => panic!("a face with parts"),
        }
    }

    #[test]
    fn parts_share_all_texels_of_a_face() {
        let mut rng = fastrand::Rng::with_seed(4);
        for round in 0..200 {
            // Also on whole and half texels, where edges run through texel centres.
            let grain = [0.0, 0.5, 1.0][round % 3];
            let mut place = || {
                let at = rng.f64() * 64.0;
                if grain > 0.0 { (at / grain).round() * grain } else { at }
            };
            let corners_px = [(); 3].map(|()| [place(), place()]);
            let (s, t) = (rng.f64(), rng.f64());
            let middle = [s * t, s * (1.0 - t), 1.0 - s];
            let half = [1.0 - s, s, 0.0];
            let fans = [
                [0, 1, 2].map(|k| [CORNERS[k], CORNERS[(k + 1) % 3], middle]).to_vec(),
                vec![[CORNERS[0], half, CORNERS[2]], [CORNERS[2], half, CORNERS[1]]],
            ];
            let Some(whole) = ScanTriangle::new(corners_px, Size::square(64)) else { continue };
            for fan in fans {
                let of_faces = face(&fan, corners_px);
                for row in whole.rows() {
                    let span = whole.span(row);
                    let span = Span { start: span.start, end: span.end, face: 0 };
                    let mut x = span.start;
                    cut(&of_faces).split(row, span, &mut Vec::new(), |part, _| {
                        assert_eq!(part.start, x, "row {row} of {corners_px:?}");
                        x = part.end;
                    });
                    assert!(span.start >= span.end || x == span.end, "row {row} of {corners_px:?}");
                }
            }
        }
    }

    #[test]
    fn texels_of_no_part_stay_free() {
        // The upper half of a square's upper left triangle.
        let corners_px = [[0.0, 0.0], [32.0, 0.0], [0.0, 32.0]];
        let half = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.5]];
        let of_faces = face(&[half], corners_px);
        let mut found = Vec::new();
        let span = Span { start: 0, end: 22, face: 0 };
        cut(&of_faces).split(9, span, &mut Vec::new(), |part, patch| {
            found.push((part.start, part.end, patch));
        });
        // Its lower edge meets row 9, whose centres are at 9.5, at x = 13.
        assert_eq!(found, [(0, 13, 0)]);
        let edge = |corner: usize| cut(&of_faces).along(corner).collect::<Vec<_>>();
        assert_eq!(edge(0), [([0.0, 1.0], Some(0))]);
        assert_eq!(edge(1), [([0.0, 1.0], None)]);
        assert_eq!(edge(2), [([0.0, 0.5], None), ([0.5, 1.0], Some(0))]);
    }

    #[test]
    fn the_first_of_overlapping_parts_owns() {
        let corners_px = [[0.0, 0.0], [32.0, 0.0], [0.0, 32.0]];
        let left = [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 1.0]];
        let of_faces = face(&[left, CORNERS], corners_px);
        let mut found = Vec::new();
        let span = Span { start: 0, end: 31, face: 0 };
        cut(&of_faces).split(0, span, &mut Vec::new(), |part, patch| {
            found.push((part.start, part.end, patch));
        });
        assert_eq!(found, [(0, 16, 0), (16, 31, 1)]);
    }

    /// A whole piece added after a part gets what the part leaves, inside and along the edges.
    #[test]
    fn a_whole_fills_what_parts_leave() {
        let corners_px = [[0.0, 0.0], [32.0, 0.0], [0.0, 32.0]];
        let inner = [[0.75, 0.25, 0.0], [0.25, 0.75, 0.0], [0.0, 0.0, 1.0]];
        let mut of_faces = face(&[inner], corners_px);
        of_faces.add_whole(0, 1, corners_px, Size::square(64));
        let mut found = Vec::new();
        let span = Span { start: 0, end: 31, face: 0 };
        cut(&of_faces).split(0, span, &mut Vec::new(), |part, patch| {
            found.push((part.start, part.end, patch));
        });
        assert_eq!(found, [(0, 8, 1), (8, 24, 0), (24, 31, 1)]);
        let edge = |corner: usize| cut(&of_faces).along(corner).collect::<Vec<_>>();
        let patches = [([0.0, 0.25], Some(1)), ([0.25, 0.75], Some(0)), ([0.75, 1.0], Some(1))];
        assert_eq!(edge(0), patches);
        assert_eq!(edge(1), [([0.0, 1.0], Some(1))]);
    }
}
