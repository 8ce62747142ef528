//! Pairs between UDIM tiles, as pairs between unit squares.

use super::{Direction, Pair};
use crate::mesh::Placement;
use crate::piece::{Piece, Pieces};
use crate::tile::Tile;
use crate::tile_atlas::TileAtlas;

impl Pair {
    /// The pieces whose faces lie wholly in UDIM tiles of which at least one is not the unit square, in
    /// ascending order of their target face. [`Pair::in_tiles`] makes them accessible to maps.
    pub fn pieces_in_other_tiles(&self) -> impl ExactSizeIterator<Item = Piece> + Clone {
        self.elsewhere.iter()
    }

    /// All pieces with the tile that is read and the tile that is filled.
    pub fn tiles(&self, direction: Direction) -> impl Iterator<Item = (Piece, [Tile; 2])> {
        let square = self.pieces().map(|piece| (piece, [Tile::FIRST; 2]));
        let elsewhere = self.pieces_in_other_tiles().filter_map(move |piece| {
            let source = self.source.tile(piece.source as usize)?;
            let target = self.target.tile(piece.target as usize)?;
            Some(match direction {
                Direction::Forward => (piece, [source, target]),
                Direction::Reverse => (piece, [target, source]),
            })
        });
        square.chain(elsewhere)
    }

    /// The pair between the images of some tiles, joined into an atlas, and one tile that receives a
    /// transfer, which becomes the unit square. Faces in other tiles are not linked. `None` if no piece
    /// is left.
    ///
    /// - `direction`: the one in which the pair will be used; in the other it means nothing.
    /// - `atlas`: of the tiles that are read.
    /// - `to`: the tile that is filled.
    pub fn in_tiles(&self, direction: Direction, atlas: &TileAtlas, to: Tile) -> Option<Self> {
        let mut pieces: Vec<Piece> = self
            .tiles(direction)
            .filter(|(_, [read, filled])| *filled == to && atlas.tiles().contains(read))
            .map(|(piece, _)| piece)
            .collect();
        if pieces.is_empty() {
            return None;
        }
        pieces.sort_by_key(|piece| piece.target);
        let mut sorted = Pieces::with_capacity(pieces.len());
        pieces.into_iter().for_each(|piece| sorted.push(piece));
        let from = self.from(direction).placed(|tile| atlas.place(tile));
        let filled = self.to(direction).placed(|tile| (tile == to).then(|| Placement::of_tile(to)));
        let (source, target) = match direction {
            Direction::Forward => (from, filled),
            Direction::Reverse => (filled, from),
        };
        Some(Self { source, target, pieces: sorted, elsewhere: Pieces::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::size::Size;

    /// Triangles at these places, half as large as a tile.
    fn mesh(places: &[[f32; 2]]) -> Mesh {
        let uv: Vec<[f32; 2]> =
            places.iter().flat_map(|&[u, v]| [[u, v], [u + 0.5, v], [u, v + 0.5]]).collect();
        let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        let faces: Vec<[u32; 3]> =
            (0..places.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    #[test]
    fn pieces_are_kept_by_tile() {
        let source = mesh(&[[0.0, 0.0], [2.25, 0.0], [0.8, 0.0], [0.5, 0.5], [1.0, -1.0]]);
        let target = mesh(&[[0.0, 0.0], [0.25, 0.25], [0.0, 0.5], [1.25, 0.0], [-0.2, 0.0]]);
        let ids: Vec<i64> = (0..15).collect();
        let pair = Pair::by_vertex_map(source, target, &ids).unwrap();
        let targets = |pair: &Pair| pair.pieces().map(|piece| piece.target).collect::<Vec<_>>();
        assert_eq!(targets(&pair), [0]);
        // Faces 2 and 4 cross a border on one side.
        let elsewhere: Vec<u32> = pair.pieces_in_other_tiles().map(|piece| piece.target).collect();
        assert_eq!(elsewhere, [1, 3]);
        let atlas = |numbers: &[&str]| {
            let tiles = numbers.iter().map(|number| number.parse().unwrap()).collect();
            TileAtlas::new(tiles, Size::square(32)).unwrap()
        };
        let tile = |number: &str| number.parse::<Tile>().unwrap();
        let forward =
            |numbers: &[&str], to| pair.in_tiles(Direction::Forward, &atlas(numbers), tile(to));
        let both = forward(&["1003", "1001"], "1001").unwrap();
        assert_eq!(targets(&both), [0, 1]);
        // Two cells of 32 texels with borders of 64: 1003 on the left.
        let uv = both.source().uv_triangle(1)[0];
        assert_eq!(uv, [(64.0 + 0.25 * 32.0) / 320.0, 64.0 / 160.0]);
        assert_eq!(both.target().uv_triangle(1), pair.target().uv_triangle(1));
        assert_eq!(targets(&forward(&["1001"], "1002").unwrap()), [3]);
        assert_eq!(forward(&["1003"], "1002"), None);
        let back = pair.in_tiles(Direction::Reverse, &atlas(&["1001"]), tile("1003")).unwrap();
        assert_eq!(targets(&back), [1]);
        assert_eq!(back.source().uv_triangle(1)[0], [0.25, 0.0]);
        // In its own tile nothing changes.
        let same = forward(&["1001"], "1001").unwrap();
        assert_eq!(same.source().uv_triangle(0), pair.source().uv_triangle(0));
    }
}
