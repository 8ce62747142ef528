//! Two layouts and their corresponding pieces: the input to sampling maps of any size.

mod layouts;
mod mirroring;
mod tiles;

pub use layouts::OtherLayouts;
pub use mirroring::Mirroring;

use crate::mesh::Mesh;
use crate::piece::{FacePieces, Piece, PieceError, Pieces};

/// Two meshes and the parts of their triangles that represent the same surface. Independent of
/// texture sizes, and the same for both directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    source: Mesh,
    target: Mesh,
    /// Between the unit squares of both layouts.
    pieces: Pieces,
    /// Between UDIM tiles of which at least one is not the unit square.
    elsewhere: Pieces,
}

/// One of a pair's two meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// The pair's source, [`Pair::source`].
    Source,
    /// The pair's target, [`Pair::target`].
    Target,
}

crate::choices!(Side {
    Source => "source", "Layout of the source mesh";
    Target => "target", "Layout of the target mesh";
});
#[cfg(feature = "serde")]
crate::serialize_by_name!(Side);

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
pub struct Oriented<'a> {
    /// The mesh that is read.
    pub from: &'a Mesh,
    /// The mesh that is filled.
    pub to: &'a Mesh,
    /// The pieces, grouped by the face that they fill.
    pub pieces: FacePieces,
}

impl<'a> Oriented<'a> {
    /// A mesh paired with itself, face by face.
    pub fn identity(mesh: &'a Mesh) -> Self {
        Self { from: mesh, to: mesh, pieces: FacePieces::identity(mesh.faces().len()) }
    }
}

impl Pair {
    /// Makes a pair of the pieces that a correspondence method found, in ascending order of their
    /// target face; `None` if no texture reaches any of them.
    pub(crate) fn of_found(source: Mesh, target: Mesh, found: Vec<Piece>) -> Option<Self> {
        let mut sorted = Sorted::with_capacity(found.len());
        let reach = reach(&source, &target);
        found.into_iter().for_each(|piece| sorted.push(piece, reach(&piece)));
        let Sorted { pieces, elsewhere, .. } = sorted;
        drop(reach);
        (pieces.len() > 0).then_some(Self { source, target, pieces, elsewhere })
    }

    /// Makes a pair of pieces found by any method.
    ///
    /// - `pieces`: in any order. Where pieces of one triangle overlap, the first of them owns the
    ///   overlap; areas without a piece stay unlinked.
    ///
    /// A texture has no texels outside the unit square, so pieces whose faces extend beyond it, by
    /// more than a thousandth, are left out: [`Mesh::is_outside`]. Those whose faces lie wholly in
    /// other UDIM tiles are kept apart from the others: [`Pair::pieces_in_other_tiles`].
    ///
    /// # Errors
    /// [`PairError`] if a piece does not fit the meshes or is given twice, or if none is left.
    pub fn from_pieces(
        source: Mesh,
        target: Mesh,
        pieces: impl IntoIterator<Item = Piece>,
    ) -> Result<Self, PairError> {
        let [pieces, elsewhere] = checked(&source, &target, pieces)?;
        Ok(Self { source, target, pieces, elsewhere })
    }

    /// As [`Pair::from_pieces`], but keeps pieces outside the unit square: positions far outside
    /// must be correct too, because slivers extrapolate to them. For tests.
    #[doc(hidden)]
    pub fn with_all(source: Mesh, target: Mesh, all: impl IntoIterator<Item = Piece>) -> Self {
        let mut pieces = Pieces::default();
        all.into_iter().for_each(|piece| pieces.push(piece));
        Self { source, target, pieces, elsewhere: Pieces::default() }
    }

    /// The mesh that textures come from in [`Direction::Forward`].
    pub fn source(&self) -> &Mesh {
        &self.source
    }

    /// The mesh that textures go to in [`Direction::Forward`].
    pub fn target(&self) -> &Mesh {
        &self.target
    }

    /// The pieces that correspond in the unit squares of both layouts, in ascending order of their
    /// target face.
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

    /// The pair as one direction sees it.
    pub fn oriented(&self, direction: Direction) -> Oriented<'_> {
        let (from, to) = (self.from(direction), self.to(direction));
        Oriented { from, to, pieces: self.face_pieces(direction) }
    }

    /// The pieces, grouped by the face that they fill.
    pub fn face_pieces(&self, direction: Direction) -> FacePieces {
        let faces = self.to(direction).faces().len();
        match direction {
            Direction::Forward => FacePieces::forward(faces, &self.pieces),
            Direction::Reverse => FacePieces::reverse(faces, &self.pieces),
        }
    }
}

/// Where textures reach a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    /// In the unit squares of both layouts.
    UnitSquares,
    /// In UDIM tiles.
    Tiles,
    /// Nowhere.
    Nowhere,
}

/// Pieces, sorted by where textures reach them.
struct Sorted {
    pieces: Pieces,
    elsewhere: Pieces,
    /// Whether either is in ascending order of target faces.
    is_ascending: [bool; 2],
    last: [u32; 2],
}

impl Sorted {
    fn with_capacity(pieces: usize) -> Self {
        Self {
            pieces: Pieces::with_capacity(pieces),
            elsewhere: Pieces::default(),
            is_ascending: [true; 2],
            last: [0; 2],
        }
    }

    fn push(&mut self, piece: Piece, reach: Reach) {
        let (pieces, index) = match reach {
            Reach::UnitSquares => (&mut self.pieces, 0),
            Reach::Tiles => (&mut self.elsewhere, 1),
            Reach::Nowhere => return,
        };
        self.is_ascending[index] &= self.last[index] <= piece.target;
        self.last[index] = piece.target;
        pieces.push(piece);
    }
}

/// Validates pieces and sorts them by target face: those in the unit squares and those in other tiles,
/// without those that no texture reaches.
fn checked(
    source: &Mesh,
    target: &Mesh,
    pieces: impl IntoIterator<Item = Piece>,
) -> Result<[Pieces; 2], PairError> {
    let pieces = pieces.into_iter();
    let reach = reach(source, target);
    let mut found = Sorted::with_capacity(pieces.size_hint().0);
    let mut given = 0;
    for (index, piece) in pieces.enumerate() {
        given = index + 1;
        piece
            .check(target.faces().len(), source.faces().len())
            .map_err(|reason| PairError::Piece { piece: index, reason })?;
        found.push(piece, reach(&piece));
    }
    let Sorted { pieces, elsewhere, is_ascending, .. } = found;
    if pieces.len() == 0 {
        return Err(PairError::Empty { given });
    }
    let mut both = [pieces, elsewhere];
    for (pieces, is_ascending) in both.iter_mut().zip(is_ascending) {
        if !is_ascending {
            *pieces = pieces.sorted();
        }
        if let Some([target_face, source_face]) = pieces.repeated() {
            return Err(PairError::Repeated { target_face, source_face });
        }
    }
    Ok(both)
}

/// Where textures reach a piece, by where both of its faces lie.
fn reach(source: &Mesh, target: &Mesh) -> impl Fn(&Piece) -> Reach {
    let has_outside = [source, target].map(|mesh| !mesh.is_all_inside());
    move |piece| {
        let is_outside = |index: usize, mesh: &Mesh, face: u32| {
            has_outside[index] && mesh.is_outside(face as usize)
        };
        if !is_outside(0, source, piece.source) && !is_outside(1, target, piece.target) {
            return Reach::UnitSquares;
        }
        let has_tile = |mesh: &Mesh, face: u32| mesh.tile(face as usize).is_some();
        if has_tile(source, piece.source) && has_tile(target, piece.target) {
            Reach::Tiles
        } else {
            Reach::Nowhere
        }
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
        let whole = Piece::whole(0, 0, [0, 1, 2]);
        let given = |pieces: &[Piece]| {
            Pair::from_pieces(triangle_at(2.0), triangle(), pieces.iter().copied())
        };
        assert_eq!(given(&[whole]), Err(PairError::Empty { given: 1 }));
        assert_eq!(given(&[]), Err(PairError::Empty { given: 0 }));
    }
}
