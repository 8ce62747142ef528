//! Pieces: a part of a target triangle and the corresponding part of a source triangle.
//!
//! Every method of finding correspondences produces pieces. A piece usually spans both triangles
//! entirely; where two meshes subdivide a surface differently, it is a triangle within each, given
//! by the barycentric weights of its corners. Polygons are split into fans of such triangles, so a
//! piece is affine by construction and means the same in both directions.

use std::ops::Range;

use crate::mesh::Mesh;

/// Barycentric weights of a triangle's three corners; they add up to 1.
pub type Weights = [f64; 3];

/// A part of a target triangle and the corresponding part of a source triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Face of the target mesh.
    pub target: u32,
    /// Face of the source mesh.
    pub source: u32,
    /// The part of both faces that it spans.
    pub extent: Extent,
}

/// The part of its two triangles that a [`Piece`] spans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Extent {
    /// All of both: corner `k` of the target face corresponds to corner `corners[k]` of the source
    /// face. A permutation of 0, 1, 2; an odd one if the windings differ.
    Whole([u8; 3]),
    /// A triangle within each, given by its corners: corner `k` is at `target[k]` in the target
    /// face and at `source[k]` in the source face.
    Part {
        /// Corners in the target face.
        target: [Weights; 3],
        /// Corners in the source face.
        source: [Weights; 3],
    },
}

/// Why a piece was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PieceError {
    /// A face index out of range.
    #[error("{side} face {found} does not exist: the {side} mesh has {faces} faces")]
    Face {
        /// `"source"` or `"target"`.
        side: &'static str,
        /// The piece's face index.
        found: u32,
        /// Number of faces of the mesh.
        faces: usize,
    },
    /// Corners that are not a permutation.
    #[error("corners must be a permutation of 0, 1, 2, got {0:?}")]
    Corners([u8; 3]),
    /// Weights that lie outside the triangle, or do not add up to 1.
    #[error("the weights of a corner in the {side} face must be between 0 and 1 and sum to 1")]
    Weights {
        /// `"source"` or `"target"`.
        side: &'static str,
    },
}

impl Piece {
    /// Two whole triangles; see [`Extent::Whole`].
    pub const fn whole(target: u32, source: u32, corners: [u8; 3]) -> Self {
        Self { target, source, extent: Extent::Whole(corners) }
    }

    /// A triangle within each of two triangles; see [`Extent::Part`].
    pub const fn part(target: (u32, [Weights; 3]), source: (u32, [Weights; 3])) -> Self {
        let extent = Extent::Part { target: target.1, source: source.1 };
        Self { target: target.0, source: source.0, extent }
    }

    /// The same piece with source and target exchanged.
    pub(crate) fn swapped(self) -> Self {
        let Self { target, source, extent } = self;
        let extent = match extent {
            Extent::Whole(corners) => {
                let mut inverse = [0; 3];
                for (k, &corner) in corners.iter().enumerate() {
                    inverse[usize::from(corner)] = k as u8;
                }
                Extent::Whole(inverse)
            }
            Extent::Part { target, source } => Extent::Part { target: source, source: target },
        };
        Self { target: source, source: target, extent }
    }

    /// Whether the two triangles have opposite windings.
    pub fn flips(&self) -> bool {
        match &self.extent {
            Extent::Whole(corners) => !matches!(corners, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]),
            Extent::Part { target, source } => determinant(target) * determinant(source) < 0.0,
        }
    }

    /// The UV coordinates of its corners, in the target's layout and in the source's, in the same
    /// order.
    pub fn uv(&self, target: &Mesh, source: &Mesh) -> [[[f64; 2]; 3]; 2] {
        let target_uv = wide(target.uv_triangle(self.target as usize));
        let source_uv = wide(source.uv_triangle(self.source as usize));
        match &self.extent {
            Extent::Whole(corners) => {
                [target_uv, corners.map(|corner| source_uv[usize::from(corner)])]
            }
            Extent::Part { target, source } => [
                target.map(|weights| mixed(&target_uv, weights)),
                source.map(|weights| mixed(&source_uv, weights)),
            ],
        }
    }

    /// Validates a piece against the face counts of its meshes.
    pub(crate) fn check(&self, target_faces: usize, source_faces: usize) -> Result<(), PieceError> {
        for (side, found, faces) in
            [("target", self.target, target_faces), ("source", self.source, source_faces)]
        {
            if found as usize >= faces {
                return Err(PieceError::Face { side, found, faces });
            }
        }
        match self.extent {
            Extent::Whole(corners) => {
                let mut sorted = corners;
                sorted.sort_unstable();
                if sorted == [0, 1, 2] { Ok(()) } else { Err(PieceError::Corners(corners)) }
            }
            Extent::Part { target, source } => {
                for (side, corners) in [("target", target), ("source", source)] {
                    if !corners.iter().all(is_within) {
                        return Err(PieceError::Weights { side });
                    }
                }
                Ok(())
            }
        }
    }
}

/// Whether barycentric weights are inside the triangle, within rounding.
fn is_within(weights: &Weights) -> bool {
    const ROUNDING: f64 = 1e-6;
    let in_range = |weight: &f64| (-ROUNDING..=1.0 + ROUNDING).contains(weight);
    weights.iter().all(in_range) && (weights.iter().sum::<f64>() - 1.0).abs() <= ROUNDING
}

/// Converts coordinates to `f64`.
pub fn wide<const N: usize>(corners: [[f32; N]; 3]) -> [[f64; N]; 3] {
    corners.map(|corner| corner.map(f64::from))
}

/// Interpolates corner values at barycentric weights.
pub fn mixed<const N: usize>(corners: &[[f64; N]; 3], weights: Weights) -> [f64; N] {
    std::array::from_fn(|k| (0..3).map(|corner| weights[corner] * corners[corner][k]).sum())
}

/// The pieces of a pair, stored compactly: twelve bytes for a whole one.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Pieces {
    stored: Vec<Stored>,
    /// Corners of the partial pieces, in the order of `stored`.
    parts: Vec<[[Weights; 3]; 2]>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Stored {
    target: u32,
    source: u32,
    /// A permutation, or [`PART`] for a partial piece.
    corners: [u8; 3],
}

const PART: [u8; 3] = [3; 3];

impl Pieces {
    /// With capacity for this many whole pieces.
    pub fn with_capacity(pieces: usize) -> Self {
        Self { stored: Vec::with_capacity(pieces), parts: Vec::new() }
    }

    pub fn push(&mut self, piece: Piece) {
        let Piece { target, source, extent } = piece;
        let corners = match extent {
            Extent::Whole(corners) => corners,
            Extent::Part { target, source } => {
                self.parts.push([target, source]);
                PART
            }
        };
        self.stored.push(Stored { target, source, corners });
    }

    pub fn len(&self) -> usize {
        self.stored.len()
    }

    /// Stably sorted by target face.
    pub fn sorted(&self) -> Self {
        let mut all: Vec<Piece> = self.iter().collect();
        all.sort_by_key(|piece| piece.target);
        let mut sorted = Self::default();
        all.into_iter().for_each(|piece| sorted.push(piece));
        sorted
    }

    /// Target and source face of a duplicate piece; the pieces must be sorted.
    pub fn repeated(&self) -> Option<[u32; 2]> {
        // Fast path: usually no face has two pieces.
        if self.stored.windows(2).all(|pair| pair[0].target != pair[1].target) {
            return None;
        }
        let mut of_face: Vec<Piece> = Vec::new();
        for piece in self.iter() {
            if of_face.first().is_some_and(|first| first.target != piece.target) {
                of_face.clear();
            }
            if of_face.contains(&piece) {
                return Some([piece.target, piece.source]);
            }
            of_face.push(piece);
        }
        None
    }

    /// The pieces as seen from their target faces; parts are numbered in order.
    fn mapped(&self) -> impl ExactSizeIterator<Item = FacePiece> + Clone {
        let mut parts = 0..;
        self.stored.iter().map(move |&Stored { target: to, source: from, corners }| {
            let mapping = match corners {
                PART => Mapping::Part(parts.next().expect("no end")),
                corners => Mapping::Whole(corners),
            };
            FacePiece { to, from, mapping }
        })
    }

    pub fn iter(&self) -> impl ExactSizeIterator<Item = Piece> + Clone {
        self.mapped().map(|FacePiece { to: target, from: source, mapping }| {
            let extent = match mapping {
                Mapping::Whole(corners) => Extent::Whole(corners),
                Mapping::Part(index) => {
                    let [target, source] = self.parts[index as usize];
                    Extent::Part { target, source }
                }
            };
            Piece { target, source, extent }
        })
    }
}

/// The pieces of a pair in one direction, grouped by the face that they fill.
#[derive(Debug, Clone)]
pub struct FacePieces {
    /// `faces + 1` offsets into `pieces`.
    first: Vec<u32>,
    pieces: Vec<FacePiece>,
    parts: Vec<FacePart>,
}

/// A piece of a face that is filled, in one direction.
#[derive(Debug, Clone, Copy)]
pub struct FacePiece {
    /// The face that is filled.
    pub to: u32,
    /// The face that is read.
    pub from: u32,
    mapping: Mapping,
}

/// How the face that is filled maps to the one that is read.
#[derive(Debug, Clone, Copy)]
enum Mapping {
    /// Corner `k` of the filled face corresponds to corner `corners[k]` of the one that is read.
    Whole([u8; 3]),
    /// Index into [`FacePieces::parts`].
    Part(u32),
}

/// A triangle within each of two faces.
#[derive(Debug, Clone)]
pub struct FacePart {
    /// Its corners in the face that is filled.
    pub to: [Weights; 3],
    /// Its corners in the face that is read.
    pub from: [Weights; 3],
    /// The corners of the whole filled face, extrapolated into the face that is read:
    /// `from_of_to[k]` are the weights of corner `k`, below 0 or above 1 where it would lie
    /// outside.
    from_of_to: [Weights; 3],
}

impl FacePart {
    /// `from_of_to = to⁻¹ · from`. `None` for a part without area in the face that is filled.
    fn new(to: [Weights; 3], from: [Weights; 3]) -> Option<Self> {
        /// Matrices are rounded to multiples of this, so that parts of one triangle with the same
        /// mapping have bitwise equal matrices, wherever the triangle was cut.
        const GRAIN: f64 = 1.0 / (1_u64 << 40) as f64;
        let inverse = inverse(&to)?;
        let rounded = |value: f64| (value / GRAIN).round() * GRAIN;
        let from_of_to = inverse.map(|row| mixed(&from, row).map(rounded));
        from_of_to.as_flattened().iter().all(|value| value.is_finite()).then_some(Self {
            to,
            from,
            from_of_to,
        })
    }

    /// Whether the part's mapping takes the corners of one face exactly to those of the other.
    pub fn maps_corners_exactly(&self) -> bool {
        let ones = self.from_of_to.map(|row| row.iter().position(|&weight| weight == 1.0));
        let is_zero_or_one = |&weight: &f64| weight == 0.0 || weight == 1.0;
        let [a, b, c] = ones;
        self.from_of_to.as_flattened().iter().all(is_zero_or_one)
            && ones.iter().all(Option::is_some)
            && a != b
            && b != c
            && c != a
    }

    /// Whether a point of the filled face is inside the part, within rounding.
    fn contains(&self, weights: Weights) -> bool {
        const ROUNDING: f64 = 1e-9;
        inverse(&self.to).is_some_and(|inverse| {
            // Weights in the face times the inverse are weights in the part.
            let inside = mixed(&inverse, weights);
            inside.iter().all(|&weight| weight >= -ROUNDING)
        })
    }
}

fn determinant([a, b, c]: &[Weights; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// The inverse of a matrix given by its rows; `None` if it is singular or not finite.
fn inverse(rows: &[Weights; 3]) -> Option<[Weights; 3]> {
    let determinant = determinant(rows);
    let cofactor = |i: usize, k: usize| {
        let (i1, i2, k1, k2) = ((i + 1) % 3, (i + 2) % 3, (k + 1) % 3, (k + 2) % 3);
        rows[i1][k1] * rows[i2][k2] - rows[i1][k2] * rows[i2][k1]
    };
    let inverse = [0, 1, 2].map(|k| [0, 1, 2].map(|i| cofactor(i, k) / determinant));
    inverse.as_flattened().iter().all(|value| value.is_finite()).then_some(inverse)
}

impl FacePieces {
    /// - `faces`: number of faces of the mesh that is filled.
    /// - `pieces`: in any order. Where pieces of one face overlap, the first owns the overlap; a
    ///   whole piece hides all that follow it.
    pub(crate) fn forward(faces: usize, pieces: &Pieces) -> Self {
        Self::new(faces, pieces, pieces.mapped(), |part| FacePart::new(part[0], part[1]))
    }

    /// As [`FacePieces::forward`], in the opposite direction.
    pub(crate) fn reverse(faces: usize, pieces: &Pieces) -> Self {
        let reversed = |FacePiece { to, from, mapping }| {
            let mapping = match mapping {
                Mapping::Whole(corners) => Mapping::Whole(inverted(corners)),
                part => part,
            };
            FacePiece { to: from, from: to, mapping }
        };
        Self::new(faces, pieces, pieces.mapped().map(reversed), |part| {
            FacePart::new(part[1], part[0])
        })
    }

    /// Every face paired with itself.
    pub fn identity(faces: usize) -> Self {
        let mapping = Mapping::Whole([0, 1, 2]);
        let pieces = (0..faces as u32).map(|face| FacePiece { to: face, from: face, mapping });
        Self { first: (0..=faces as u32).collect(), pieces: pieces.collect(), parts: Vec::new() }
    }

    /// Groups pieces by face with a counting sort, which is stable.
    ///
    /// - `mapped`: the pieces in the direction needed.
    /// - `part`: makes a part in that direction from its corners in the target face and in the
    ///   source face; `None` if it has no area in the face that is filled.
    fn new(
        faces: usize,
        pieces: &Pieces,
        mapped: impl Iterator<Item = FacePiece> + Clone,
        part: impl Fn(&[[Weights; 3]; 2]) -> Option<FacePart>,
    ) -> Self {
        let mut first = vec![0; faces + 1];
        for piece in mapped.clone() {
            first[piece.to as usize + 1] += 1;
        }
        let mut is_one_each = true;
        for face in 0..faces {
            is_one_each &= first[face + 1] <= 1;
            first[face + 1] += first[face];
        }
        let nothing = FacePiece { to: 0, from: 0, mapping: Mapping::Whole([0; 3]) };
        let mut of_faces = vec![nothing; first[faces] as usize];
        let mut next = first.clone();
        for piece in mapped {
            let next = &mut next[piece.to as usize];
            of_faces[*next as usize] = piece;
            *next += 1;
        }
        if is_one_each && pieces.parts.is_empty() {
            return Self { first, pieces: of_faces, parts: Vec::new() };
        }
        let mut kept = Self { first: vec![0], pieces: Vec::new(), parts: Vec::new() };
        for range in first.windows(2) {
            for &piece in &of_faces[range[0] as usize..range[1] as usize] {
                match piece.mapping {
                    Mapping::Whole(_) => {
                        kept.pieces.push(piece);
                        break;
                    }
                    Mapping::Part(index) => {
                        let Some(part) = part(&pieces.parts[index as usize]) else { continue };
                        let mapping = Mapping::Part(kept.parts.len() as u32);
                        kept.parts.push(part);
                        kept.pieces.push(FacePiece { mapping, ..piece });
                    }
                }
            }
            kept.first.push(kept.pieces.len() as u32);
        }
        kept
    }

    /// All pieces, in ascending order of the face that they fill.
    pub fn all(&self) -> &[FacePiece] {
        &self.pieces
    }

    /// The index range of a face's pieces in [`FacePieces::all`].
    pub fn numbers(&self, face: usize) -> Range<usize> {
        self.first[face] as usize..self.first[face + 1] as usize
    }

    /// The pieces of a face.
    pub fn of_face(&self, face: usize) -> &[FacePiece] {
        &self.pieces[self.numbers(face)]
    }

    /// Number of faces, filled or not.
    pub fn faces(&self) -> usize {
        self.first.len() - 1
    }

    /// The part of its faces that a piece spans; `None` if it spans all of them.
    pub fn part(&self, piece: FacePiece) -> Option<&FacePart> {
        match piece.mapping {
            Mapping::Whole(_) => None,
            Mapping::Part(index) => Some(&self.parts[index as usize]),
        }
    }

    /// Transfers corner values of the face that is read to the corners of the face that is filled,
    /// for linear interpolation over it; extrapolated where a corner maps outside the face that is
    /// read.
    pub fn at_corners<const N: usize>(
        &self,
        piece: FacePiece,
        from: [[f64; N]; 3],
    ) -> [[f64; N]; 3] {
        match piece.mapping {
            Mapping::Whole(corners) => corners.map(|corner| from[usize::from(corner)]),
            Mapping::Part(index) => {
                self.parts[index as usize].from_of_to.map(|weights| mixed(&from, weights))
            }
        }
    }

    /// Interpolates corner values of the face that is read at the piece's own corners.
    pub fn at_outline<const N: usize>(
        &self,
        piece: FacePiece,
        from: [[f64; N]; 3],
    ) -> [[f64; N]; 3] {
        match self.part(piece) {
            None => self.at_corners(piece, from),
            Some(part) => part.from.map(|weights| mixed(&from, weights)),
        }
    }

    /// Interpolates corner values of the face that is filled at the piece's own corners.
    pub fn outline<const N: usize>(&self, piece: FacePiece, to: [[f64; N]; 3]) -> [[f64; N]; 3] {
        match self.part(piece) {
            None => to,
            Some(part) => part.to.map(|weights| mixed(&to, weights)),
        }
    }

    /// The fraction of a face's area that a piece covers.
    pub fn share(&self, piece: FacePiece) -> f64 {
        self.part(piece).map_or(1.0, |part| determinant(&part.to).abs())
    }

    /// Whether pieces cover a face up to a hundredth of its area: methods that cut surfaces into
    /// parts drop slivers.
    pub fn is_filled(&self, face: usize) -> bool {
        const SLIVERS: f64 = 0.01;
        let mut parts = Vec::new();
        for &piece in self.of_face(face) {
            let Some(part) = self.part(piece) else { return true };
            parts.push(part);
        }
        if parts.is_empty() {
            return false;
        }
        let mut left = vec![CORNERS.to_vec()];
        for part in parts {
            left = left.into_iter().flat_map(|polygon| outside(polygon, &part.to)).collect();
        }
        left.iter().map(|polygon| share_of_face(polygon)).sum::<f64>() <= SLIVERS
    }

    /// The piece that contains a point of a face, given by its weights.
    pub fn at(&self, face: usize, weights: Weights) -> Option<FacePiece> {
        self.of_face(face)
            .iter()
            .copied()
            .find(|&piece| self.part(piece).is_none_or(|part| part.contains(weights)))
    }
}

/// The corners of a face, as weights.
const CORNERS: [Weights; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The part of a convex polygon outside a triangle of the same face, as convex polygons: one for
/// each edge, cut from what is inside the edges before it.
fn outside(polygon: Vec<Weights>, triangle: &[Weights; 3]) -> Vec<Vec<Weights>> {
    let [a, b, c] = *triangle;
    let sign = determinant(triangle).signum();
    let (mut outside, mut inside) = (Vec::new(), polygon);
    for [from, to] in [[a, b], [b, c], [c, a]] {
        let height = |at: &Weights| sign * determinant(&[from, to, *at]);
        outside.push(clipped(&inside, |at| -height(at)));
        inside = clipped(&inside, height);
    }
    outside.retain(|polygon| polygon.len() > 2);
    outside
}

/// Clips a convex polygon to where a linear function is not negative (Sutherland and Hodgman 1974).
fn clipped(polygon: &[Weights], height: impl Fn(&Weights) -> f64) -> Vec<Weights> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (above, next) = (height(a), height(b));
        if above >= 0.0 {
            kept.push(*a);
        }
        if above * next < 0.0 {
            let t = above / (above - next);
            kept.push([0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t));
        }
    }
    kept
}

/// The area of a convex polygon, as a fraction of its face's.
fn share_of_face(polygon: &[Weights]) -> f64 {
    let rest = polygon.get(1..).unwrap_or_default();
    rest.windows(2).map(|pair| determinant(&[polygon[0], pair[0], pair[1]]).abs()).sum()
}

/// The inverse permutation.
fn inverted(corners: [u8; 3]) -> [u8; 3] {
    let mut inverted = [0; 3];
    for (k, &corner) in (0..).zip(&corners) {
        inverted[usize::from(corner)] = k;
    }
    inverted
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIDDLE: Weights = [1.0 / 3.0; 3];

    fn pieces(all: &[Piece]) -> Pieces {
        let mut pieces = Pieces::default();
        all.iter().for_each(|&piece| pieces.push(piece));
        pieces
    }

    #[test]
    fn a_whole_piece_takes_twelve_bytes() {
        assert_eq!(size_of::<Stored>(), 12);
    }

    #[test]
    fn pieces_round_trip_through_storage() {
        let all = [
            Piece::whole(0, 4, [2, 0, 1]),
            Piece::part((1, CORNERS), (3, [CORNERS[1], CORNERS[2], MIDDLE])),
            Piece::whole(2, 1, [0, 2, 1]),
            Piece::part((3, CORNERS), (3, CORNERS)),
        ];
        assert_eq!(pieces(&all).iter().collect::<Vec<_>>(), all);
    }

    #[test]
    fn reversing_inverts_the_corners() {
        let stored = pieces(&[Piece::whole(0, 0, [2, 0, 1])]);
        let uv = [[0.0], [1.0], [2.0]];
        let forward = FacePieces::forward(1, &stored);
        assert_eq!(forward.at_corners(forward.all()[0], uv), [[2.0], [0.0], [1.0]]);
        let reverse = FacePieces::reverse(1, &stored);
        assert_eq!(reverse.at_corners(reverse.all()[0], uv), [[1.0], [2.0], [0.0]]);
    }

    #[test]
    fn parts_with_equal_mappings_have_equal_matrices() {
        // Cut at an arbitrary point, the same on both sides: each third maps as the whole does.
        let cut = [0.211, 0.357, 0.432];
        let parts = [0, 1, 2].map(|k| {
            let corners = [CORNERS[k], CORNERS[(k + 1) % 3], cut];
            Piece::part((0, corners), (0, corners))
        });
        let found = FacePieces::forward(1, &pieces(&parts));
        let uv = [[0.1, 0.9], [0.7, 0.3], [0.33, 0.77]];
        for &piece in found.all() {
            assert_eq!(found.at_corners(piece, uv), uv);
        }
        assert!(found.parts.iter().all(FacePart::maps_corners_exactly));
        assert!(found.is_filled(0));
        assert!(
            (found.all().iter().map(|&piece| found.share(piece)).sum::<f64>() - 1.0).abs() < 1e-12
        );
        let at = |weights| found.at(0, weights).map(|piece| found.share(piece));
        assert_eq!(at([0.5, 0.4, 0.1]), Some(found.share(found.all()[0])));
        assert_eq!(at([0.1, 0.2, 0.7]), Some(found.share(found.all()[1])));
    }

    #[test]
    fn a_face_is_filled_where_its_pieces_leave_slivers() {
        let filled = |parts: &[[Weights; 3]]| {
            let all: Vec<Piece> =
                parts.iter().map(|&to| Piece::part((0, to), (0, CORNERS))).collect();
            FacePieces::forward(1, &pieces(&all)).is_filled(0)
        };
        let [a, b, c] = CORNERS;
        let on = |k: usize, share: f64| {
            let (from, to) = (CORNERS[k], CORNERS[(k + 1) % 3]);
            [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * share)
        };
        assert!(filled(&[CORNERS]));
        assert!(filled(&[[a, c, b]]));
        assert!(filled(&[[a, on(0, 0.995), c]]));
        assert!(!filled(&[[a, on(0, 0.98), c]]));
        // Overlaps count once: parts of 0.6 and 0.5 leave 0.4.
        assert!(!filled(&[[a, on(0, 0.6), c], [a, on(0, 0.5), c]]));
        assert!(filled(&[[a, on(0, 0.6), c], [on(0, 0.3), b, c]]));
        assert!(filled(&[[c, on(0, 0.6), a], [b, on(0, 0.3), c], [a, MIDDLE, b]]));
        // Three of the four triangles of a midpoint subdivision.
        let middles = [0, 1, 2].map(|k| on(k, 0.5));
        let [ab, bc, ca] = middles;
        assert!(!filled(&[[a, ab, ca], [b, bc, ab], [c, ca, bc]]));
        assert!(filled(&[[a, ab, ca], [b, bc, ab], middles, [c, ca, bc]]));
    }

    #[test]
    fn a_whole_piece_hides_those_after_it() {
        let half = [CORNERS[0], CORNERS[1], [0.5, 0.0, 0.5]];
        let flat = [CORNERS[0], CORNERS[0], CORNERS[1]];
        let found = FacePieces::forward(
            3,
            &pieces(&[
                Piece::part((1, half), (7, CORNERS)),
                Piece::part((1, flat), (8, CORNERS)),
                Piece::whole(0, 5, [0, 1, 2]),
                Piece::whole(0, 6, [1, 2, 0]),
            ]),
        );
        assert!(!found.parts[0].maps_corners_exactly());
        let from = |face| found.of_face(face).iter().map(|piece| piece.from).collect::<Vec<_>>();
        assert_eq!([from(0), from(1), from(2)], [vec![5], vec![7], vec![]]);
        assert_eq!([0, 1, 2].map(|face| found.is_filled(face)), [true, false, false]);
        assert!(found.at(1, [0.1, 0.1, 0.8]).is_none());
    }

    #[test]
    fn errors_name_what_is_wrong_with_a_piece() {
        let error = |piece: Piece| piece.check(1, 1).unwrap_err().to_string();
        assert!(error(Piece::whole(1, 0, [0, 1, 2])).starts_with("target face 1 does not exist"));
        assert!(error(Piece::whole(0, 9, [0, 1, 2])).starts_with("source face 9 does not exist"));
        assert!(error(Piece::whole(0, 0, [0, 1, 1])).contains("got [0, 1, 1]"));
        for bad in [[0.5, 0.5, 0.5], [-0.5, 1.0, 0.5], [f64::NAN, 0.5, 0.5]] {
            let corners = [CORNERS[0], CORNERS[1], bad];
            assert!(error(Piece::part((0, corners), (0, CORNERS))).contains("target face must"));
            assert!(error(Piece::part((0, CORNERS), (0, corners))).contains("source face must"));
        }
    }
}
