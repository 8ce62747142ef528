//! Two layouts and their corresponding pieces: the input to sampling maps of any size.

use crate::correspond::{LinkError, vertex_map};
use crate::mesh::Mesh;
use crate::piece::{FacePieces, Piece, PieceError, Pieces};

/// Two meshes and the parts of their triangles that represent the same surface. Independent of
/// texture sizes, and the same for both directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    source: Mesh,
    target: Mesh,
    pieces: Pieces,
}

/// The direction of a transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Direction {
    /// From the pair's source to its target.
    #[default]
    Forward,
    /// From the pair's target to its source.
    Reverse,
}

impl Direction {
    /// The opposite direction.
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::Forward => Self::Reverse,
            Self::Reverse => Self::Forward,
        }
    }
}

/// Why pieces do not make a pair.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PairError {
    /// A piece is invalid.
    #[error("piece {piece}: {reason}")]
    Piece {
        /// Index of the piece.
        piece: usize,
        /// The problem.
        #[source]
        reason: PieceError,
    },
    /// No piece is left.
    #[error("no links: none of the {given} pieces lies in the unit square of both layouts")]
    Empty {
        /// How many pieces were given.
        given: usize,
    },
    /// A piece is given twice.
    #[error("duplicate piece of target face {target_face} and source face {source_face}")]
    Repeated {
        /// Its target face.
        target_face: u32,
        /// Its source face.
        source_face: u32,
    },
}

/// A pair seen in one direction.
pub(crate) struct Oriented<'a> {
    pub from: &'a Mesh,
    pub to: &'a Mesh,
    pub pieces: FacePieces,
}

impl<'a> Oriented<'a> {
    /// A mesh paired with itself, face by face.
    pub fn identity(mesh: &'a Mesh) -> Self {
        Self { from: mesh, to: mesh, pieces: FacePieces::identity(mesh.faces().len()) }
    }
}

impl Pair {
    /// Links two meshes whose vertices correspond.
    ///
    /// - `vertex_map`: `[source vertices]`, for each the corresponding target vertex, or -1 for
    ///   none.
    ///
    /// Faces are matched by their vertices, whichever corner they start at and whichever way they
    /// wind. Polygons may be retriangulated where the two meshes chose different diagonals.
    /// Triangles outside the unit square of their layout are not linked: see [`Pair::from_pieces`].
    ///
    /// # Errors
    /// [`LinkError`] for a map of the wrong length or with entries out of range, or if no face
    /// matches.
    pub fn by_vertex_map(
        mut source: Mesh,
        mut target: Mesh,
        vertex_map: &[i64],
    ) -> Result<Self, LinkError> {
        let pieces = vertex_map::pieces(&mut source, &mut target, vertex_map)?;
        Self::of_found(source, target, pieces).ok_or(LinkError::Outside)
    }

    /// Makes a pair of the pieces that a correspondence method found, in ascending order of their
    /// target face; `None` if no texture reaches any of them.
    pub(crate) fn of_found(source: Mesh, target: Mesh, found: Vec<Piece>) -> Option<Self> {
        let mut pieces = Pieces::with_capacity(found.len());
        found.into_iter().filter(reaches(&source, &target)).for_each(|piece| pieces.push(piece));
        (pieces.len() > 0).then_some(Self { source, target, pieces })
    }

    /// Makes a pair of pieces found by any method.
    ///
    /// - `pieces`: in any order. Where pieces of one triangle overlap, the first of them owns the
    ///   overlap; areas without a piece stay unlinked.
    ///
    /// A texture has no texels outside the unit square, so pieces whose faces extend beyond it, by
    /// more than a thousandth, are left out: [`Mesh::is_outside`].
    ///
    /// # Errors
    /// [`PairError`] if a piece does not fit the meshes or is given twice, or if none is left.
    pub fn from_pieces(
        source: Mesh,
        target: Mesh,
        pieces: impl IntoIterator<Item = Piece>,
    ) -> Result<Self, PairError> {
        let pieces = checked(&source, &target, pieces)?;
        Ok(Self { source, target, pieces })
    }

    /// As [`Pair::from_pieces`], but keeps pieces outside the unit square: positions far outside
    /// must be correct too, because slivers extrapolate to them.
    #[cfg(test)]
    pub(crate) fn with_all(
        source: Mesh,
        target: Mesh,
        all: impl IntoIterator<Item = Piece>,
    ) -> Self {
        let mut pieces = Pieces::default();
        all.into_iter().for_each(|piece| pieces.push(piece));
        Self { source, target, pieces }
    }

    /// The mesh that textures come from in [`Direction::Forward`].
    pub fn source(&self) -> &Mesh {
        &self.source
    }

    /// The mesh that textures go to in [`Direction::Forward`].
    pub fn target(&self) -> &Mesh {
        &self.target
    }

    /// The pieces that correspond, in ascending order of their target face.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = Piece> + Clone {
        self.pieces.iter()
    }

    /// How many pieces there are.
    pub fn piece_count(&self) -> usize {
        self.pieces.len()
    }

    /// The mesh whose layout a texture comes from.
    pub fn from(&self, direction: Direction) -> &Mesh {
        match direction {
            Direction::Forward => &self.source,
            Direction::Reverse => &self.target,
        }
    }

    /// The mesh whose layout a texture goes to.
    pub fn to(&self, direction: Direction) -> &Mesh {
        match direction {
            Direction::Forward => &self.target,
            Direction::Reverse => &self.source,
        }
    }

    pub(crate) fn oriented(&self, direction: Direction) -> Oriented<'_> {
        let (from, to) = (self.from(direction), self.to(direction));
        Oriented { from, to, pieces: self.face_pieces(direction) }
    }

    /// The pieces, grouped by the face that they fill.
    pub(crate) fn face_pieces(&self, direction: Direction) -> FacePieces {
        let faces = self.to(direction).faces().len();
        match direction {
            Direction::Forward => FacePieces::forward(faces, &self.pieces),
            Direction::Reverse => FacePieces::reverse(faces, &self.pieces),
        }
    }
}

/// Validates pieces and sorts them by target face, leaving out those that no texture reaches.
fn checked(
    source: &Mesh,
    target: &Mesh,
    pieces: impl IntoIterator<Item = Piece>,
) -> Result<Pieces, PairError> {
    let pieces = pieces.into_iter();
    let reaches = reaches(source, target);
    let mut checked = Pieces::with_capacity(pieces.size_hint().0);
    let mut last = 0;
    let mut is_sorted = true;
    let mut given = 0;
    for (index, piece) in pieces.enumerate() {
        given = index + 1;
        piece
            .check(target.faces().len(), source.faces().len())
            .map_err(|reason| PairError::Piece { piece: index, reason })?;
        is_sorted &= last <= piece.target;
        last = piece.target;
        if reaches(&piece) {
            checked.push(piece);
        }
    }
    if checked.len() == 0 {
        return Err(PairError::Empty { given });
    }
    if !is_sorted {
        checked = checked.sorted();
    }
    match checked.repeated() {
        None => Ok(checked),
        Some([target_face, source_face]) => Err(PairError::Repeated { target_face, source_face }),
    }
}

/// A test for pieces: whether both faces lie where a texture has texels.
fn reaches(source: &Mesh, target: &Mesh) -> impl Fn(&Piece) -> bool {
    let has_outside = [source, target].map(|mesh| !mesh.is_all_inside());
    move |piece| {
        let is_outside = |index: usize, mesh: &Mesh, face: u32| {
            has_outside[index] && mesh.is_outside(face as usize)
        };
        !is_outside(0, source, piece.source) && !is_outside(1, target, piece.target)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Mesh {
        triangle_at(0.0)
    }

    fn triangle_at(u: f32) -> Mesh {
        let uv = vec![[u, 0.0], [u + 1.0, 0.0], [u, 1.0]];
        let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap()
    }

    #[test]
    fn invalid_pieces_are_refused() {
        let build =
            |pieces: &[Piece]| Pair::from_pieces(triangle(), triangle(), pieces.iter().copied());
        let sound = Piece::whole(0, 0, [2, 1, 0]);
        assert_eq!(build(&[sound]).unwrap().pieces().collect::<Vec<_>>(), [sound]);
        let bad = Piece::whole(0, 1, [0, 1, 2]);
        assert!(matches!(build(&[sound, bad]), Err(PairError::Piece { piece: 1, .. })));
        let twice = Err(PairError::Repeated { target_face: 0, source_face: 0 });
        assert_eq!(build(&[sound, sound]), twice);
    }

    #[test]
    fn faces_outside_the_unit_square_are_not_linked() {
        let ids = [0, 1, 2];
        assert_eq!(
            Pair::by_vertex_map(triangle_at(2.0), triangle(), &ids),
            Err(LinkError::Outside)
        );
        assert_eq!(
            Pair::by_vertex_map(triangle(), triangle_at(-0.01), &ids),
            Err(LinkError::Outside)
        );
        // Within the tolerance for rounding.
        assert!(Pair::by_vertex_map(triangle_at(0.0005), triangle(), &ids).is_ok());
        let whole = Piece::whole(0, 0, [0, 1, 2]);
        let given = |pieces: &[Piece]| {
            Pair::from_pieces(triangle_at(2.0), triangle(), pieces.iter().copied())
        };
        assert_eq!(given(&[whole]), Err(PairError::Empty { given: 1 }));
        assert_eq!(given(&[]), Err(PairError::Empty { given: 0 }));
    }
}
