//! The sampling map: for every texel of a target of one size, where its value comes from.
//!
//! Inside a target triangle the source position is an affine function of the target
//! position, so the map is a list of runs of texels, each of which refers to the affine map
//! ("patch") that applies.

mod beneath;
mod build;
mod coverage;
mod cut;
mod from_positions;
mod gutter;
mod gutter_rows;
mod lost_edges;
mod precedence;
mod rows;
mod texel_set;
mod tiles;

pub(crate) use coverage::{Coverage, LayoutTriangles};
pub use from_positions::PositionsError;
pub(crate) use precedence::Precedence;
pub use precedence::Prefer;
pub(crate) use rows::BLOCK_ROWS;
pub(crate) use texel_set::TexelSet;
pub(crate) use tiles::{TILE, Tiles, tiles};

use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::pair::{Direction, Oriented, Pair};

use crate::color::Encoding;
use crate::texture::{Channels, Size, Texels, Texture};
use gutter::{FRINGE_PX, REACH_PX};
use rows::RowLists;

/// Coordinates beyond this many texels are treated as inexact. Rounding reaches a whole texel for
/// values a thousand million times as large.
pub(crate) const FAR_PX: f64 = 1e6;

/// How a map is built.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct MapOptions {
    /// Width of the gutter around islands, in texels, so that filtering and mip levels do not pick
    /// up the background.
    pub gutter_px: u32,
    /// Which of several overlapping islands of the target owns the texels that they share.
    pub prefer: Prefer,
}

impl MapOptions {
    /// A gutter of `gutter_px` texels, and defaults for everything else.
    pub const fn with_gutter(gutter_px: u32) -> Self {
        Self { gutter_px, prefer: Prefer::First }
    }

    /// The same with another precedence among overlapping islands.
    #[must_use]
    pub const fn prefer(self, prefer: Prefer) -> Self {
        Self { prefer, ..self }
    }
}

impl Default for MapOptions {
    /// A gutter of 16 texels, which lasts down to the fourth mip level.
    fn default() -> Self {
        Self::with_gutter(16)
    }
}

/// For each texel of a target texture, the source position of its value, for one pair,
/// direction and size.
#[derive(Debug, Clone)]
pub struct SamplingMap {
    size: Size,
    direction: Direction,
    runs: RowLists<Run>,
    patches: Vec<Patch>,
    /// Index of the first patch of the gutter; all later patches belong to it too.
    gutter_patches: u32,
    stats: MapStats,
}

/// Consecutive texels of a row that share a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Column of the first texel.
    pub x: u32,
    /// Number of texels; at least 1.
    pub len: u32,
    /// Index into [`SamplingMap::patches`].
    pub patch: u32,
}

/// The affine map for the texels of one piece of a target triangle, or of the gutter
/// along one of its edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Maps a target position in texels to source UV.
    pub src_uv_from_tgt_px: Affine,
    /// Derivative of the source UV by the target position inside the triangle, which determines a
    /// filter's footprint. In the gutter it is that of the triangle too, although the position may
    /// be constant there.
    pub jacobian: [[f64; 2]; 2],
    /// Target face.
    pub face: u32,
    /// Index of the pair's piece, in the order of target faces.
    pub(crate) piece: u32,
    /// Whether the piece is only a part of the face.
    pub(crate) is_part: bool,
}

/// `uv = origin_uv + jacobian · (px − origin_px)`.
///
/// Relative to a corner of its triangle: for a steep triangle far from the texture's origin, an
/// absolute offset would lose digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Affine {
    /// A target position, in texels.
    pub origin_px: [f64; 2],
    /// The source UV there.
    pub origin_uv: [f64; 2],
    /// `jacobian[i][k]`: derivative of source coordinate `i` by target coordinate `k`.
    pub jacobian: [[f64; 2]; 2],
}

/// Texel counts of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MapStats {
    /// Texels owned by a linked triangle.
    pub linked: usize,
    /// Texels filled in the gutter.
    pub gutter: usize,
    /// Texels owned by any triangle of the target.
    pub covered: usize,
    /// Texels that more than one triangle covers.
    pub overlapping: usize,
}

impl MapStats {
    /// Why no texel is linked, where none is.
    pub fn why_nothing_is_linked(&self) -> &'static str {
        if self.covered == 0 {
            "no triangle is as large as a texel, or none has a UV area"
        } else {
            "they have no UV area, or are smaller than a texel"
        }
    }
}

impl Affine {
    /// The affine map from three target points to three source points; `None` if the target
    /// points are collinear.
    fn from_triangles(tgt_px: [[f64; 2]; 3], src_uv: [[f64; 2]; 3]) -> Option<Self> {
        let ([p, q], determinant) = sides(tgt_px);
        let [s, t] = [1, 2].map(|k| [src_uv[k][0] - src_uv[0][0], src_uv[k][1] - src_uv[0][1]]);
        if determinant == 0.0 {
            return None;
        }
        let row = |i: usize| {
            [(s[i] * q[1] - t[i] * p[1]) / determinant, (t[i] * p[0] - s[i] * q[0]) / determinant]
        };
        Some(Self { origin_px: tgt_px[0], origin_uv: src_uv[0], jacobian: [row(0), row(1)] })
    }

    /// The source UV at a target position.
    pub fn at(&self, px: [f64; 2]) -> [f64; 2] {
        let offset = [px[0] - self.origin_px[0], px[1] - self.origin_px[1]];
        [0, 1].map(|i| {
            self.origin_uv[i] + self.jacobian[i][0] * offset[0] + self.jacobian[i][1] * offset[1]
        })
    }

    /// The constant map with the value at one position.
    fn constant(&self, px: [f64; 2]) -> Self {
        Self { origin_px: px, origin_uv: self.at(px), jacobian: [[0.0; 2]; 2] }
    }

    /// Evaluates the map at the orthogonal projection of a position onto the line through `from` in
    /// the direction `along`, moved by `shift`.
    fn projected(
        &self,
        from: [f64; 2],
        along: [f64; 2],
        inverse_squared_length: f64,
        shift: [f64; 2],
    ) -> Self {
        let jacobian = self.jacobian.map(|row| {
            let along_line = (row[0] * along[0] + row[1] * along[1]) * inverse_squared_length;
            along.map(|component| along_line * component)
        });
        let origin_uv = self.at([from[0] + shift[0], from[1] + shift[1]]);
        Self { origin_px: from, origin_uv, jacobian }
    }
}

/// Two sides of a triangle, and their determinant.
fn sides(tgt_px: [[f64; 2]; 3]) -> ([[f64; 2]; 2], f64) {
    let [p, q] = [1, 2].map(|k| [tgt_px[k][0] - tgt_px[0][0], tgt_px[k][1] - tgt_px[0][1]]);
    ([p, q], p[0] * q[1] - p[1] * q[0])
}

/// Whether [`Affine::from_triangles`] has a map for a target triangle.
fn has_area(tgt_px: [[f64; 2]; 3]) -> bool {
    sides(tgt_px).1 != 0.0
}

impl SamplingMap {
    /// Builds the map of one direction for a target texture of `size`.
    ///
    /// # Panics
    /// If a side of `size` is 0 or beyond [`Texture::MAX_SIDE`].
    pub fn new(pair: &Pair, direction: Direction, size: Size, options: &MapOptions) -> Self {
        let oriented = pair.oriented(direction);
        let precedence = || Precedence::of(&oriented, options.prefer);
        build::build(&oriented, direction, size, options.gutter_px, precedence)
    }

    /// The map of a layout to itself, over all triangles of the mesh.
    ///
    /// # Panics
    /// As [`SamplingMap::new`].
    pub fn of_layout(mesh: &Mesh, size: Size, options: &MapOptions) -> Self {
        let oriented = Oriented::identity(mesh);
        let precedence = || Precedence::of(&oriented, options.prefer);
        build::build(&oriented, Direction::Forward, size, options.gutter_px, precedence)
    }

    /// The target size.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The direction in which the pair is used.
    pub fn direction(&self) -> Direction {
        self.direction
    }

    /// The runs of a row, from left to right, disjoint.
    pub fn row(&self, row: u32) -> &[Run] {
        self.runs.row(row)
    }

    /// The affine maps that runs refer to.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// The patches inside target triangles, one for each piece.
    pub(crate) fn linked_patches(&self) -> &[Patch] {
        &self.patches[..self.gutter_patches as usize]
    }

    /// The patches of the gutter along boundary edges; their Jacobians are those of
    /// the triangles there.
    pub(crate) fn border_patches(&self) -> &[Patch] {
        &self.patches[self.gutter_patches as usize..]
    }

    /// Distance beyond an island's edge up to which source positions are extrapolated, in target
    /// texels.
    pub(crate) fn reach_px(&self) -> f64 {
        if self.stats.overlapping > 0 { FRINGE_PX } else { REACH_PX }
    }

    /// Whether a run lies outside the islands.
    pub fn is_gutter(&self, run: Run) -> bool {
        run.patch >= self.gutter_patches
    }

    /// Texel counts.
    pub fn stats(&self) -> MapStats {
        self.stats
    }

    /// An 8-bit grey mask: white where a linked triangle owns the texel, black elsewhere, the
    /// gutter included.
    pub fn mask(&self) -> Texture {
        let width = self.size.width as usize;
        let mut values = vec![0; self.size.texels()];
        for (row, values) in (0..).zip(values.chunks_mut(width)) {
            for run in self.row(row).iter().filter(|run| !self.is_gutter(**run)) {
                values[run.x as usize..(run.x + run.len) as usize].fill(255);
            }
        }
        Texture::new(self.size, Channels::Grey, Encoding::Data, Texels::U8(values))
            .expect("a map's size is that of a texture")
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::piece::Piece;

    use super::*;

    /// Triangles at random positions, overlapping, some with corners far outside the texture.
    fn scattered(rng: &mut fastrand::Rng, far: f32) -> Mesh {
        let mut uv: Vec<[f32; 2]> = (0..36)
            .flat_map(|_| {
                let at = [rng.f32(), rng.f32()];
                let side = rng.f32();
                [(); 3].map(|()| at.map(|value| value + (rng.f32() - 0.5) * side))
            })
            .collect();
        for corner in &mut uv {
            if rng.u8(..) < 20 {
                *corner = corner.map(|value| (value - 0.5) * far);
            }
        }
        let faces: Vec<[u32; 3]> = (0..36).map(|face| [0, 1, 2].map(|k| face * 3 + k)).collect();
        let positions = uv.iter().map(|_| [rng.f32() - 0.5, 0.0, 0.0]).collect();
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    #[test]
    fn runs_are_sorted_and_disjoint_on_any_mesh() {
        let mut rng = fastrand::Rng::with_seed(5);
        for far in [1.0, 30.0, 1e4, 1e6, 1e12, 1e30] {
            for _ in 0..12 {
                let (source, target) = (scattered(&mut rng, far), scattered(&mut rng, far));
                let itself = (0..36).map(|face| Piece::whole(face, face, [0, 1, 2]));
                let pair = Pair::with_all(source, target, itself);
                let size = Size::new(rng.u32(1..90), rng.u32(1..90));
                let prefer = [Prefer::First, Prefer::Left, Prefer::Right][rng.usize(0..3)];
                let options = MapOptions { gutter_px: rng.u32(0..20), prefer };
                let map = SamplingMap::new(&pair, Direction::Forward, size, &options);
                let beneath = map.beneath(&pair, &options);
                for (map, row) in [Some(&map), beneath.as_ref()]
                    .into_iter()
                    .flatten()
                    .flat_map(|map| (0..size.height).map(move |row| (map, row)))
                {
                    let runs = map.row(row);
                    assert!(runs.iter().all(|run| run.len > 0 && run.x + run.len <= size.width));
                    assert!(runs.windows(2).all(|pair| pair[0].x + pair[0].len <= pair[1].x));
                }
            }
        }
    }

    #[test]
    fn an_affine_map_takes_corners_to_corners() {
        let tgt_px = [[10.0, 20.0], [14.0, 21.0], [11.0, 30.0]];
        let src_uv = [[0.1, 0.2], [0.5, 0.1], [0.3, 0.9]];
        let affine = Affine::from_triangles(tgt_px, src_uv).unwrap();
        for (px, uv) in tgt_px.into_iter().zip(src_uv) {
            let found = affine.at(px);
            assert!((found[0] - uv[0]).hypot(found[1] - uv[1]) < 1e-14, "{found:?}");
        }
        assert_eq!(affine.constant(tgt_px[1]).at([99.0, -5.0]), affine.at(tgt_px[1]));
        assert_eq!(Affine::from_triangles([[0.0; 2], [1.0; 2], [3.0; 2]], src_uv), None);
    }

    /// Source positions, those of the gutter included, are the same whether a triangle is one piece
    /// or several pieces that meet on its edges.
    #[test]
    fn joints_on_edges_do_not_show_in_the_gutter() {
        let uv = vec![[0.25, 0.25], [0.75, 0.25], [0.3, 0.6]];
        let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        let mesh = Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap();
        let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        // There are texel centres next to the midpoint of the first edge.
        let (p, q) = ([0.5, 0.5, 0.0], [0.0, 0.3, 0.7]);
        let parts = [[a, p, c], [p, q, c], [p, b, q]];
        let map = |pieces: Vec<Piece>| {
            let pair = Pair::from_pieces(mesh.clone(), mesh.clone(), pieces).unwrap();
            let size = Size::new(33, 64);
            SamplingMap::new(&pair, Direction::Forward, size, &MapOptions::with_gutter(9))
        };
        let whole = map(vec![Piece::whole(0, 0, [0, 1, 2])]);
        let cut = map(parts.map(|part| Piece::part((0, part), (0, part))).to_vec());
        assert_eq!(cut.stats(), whole.stats());
        let texels = |map: &SamplingMap, row: u32| -> Vec<(u32, bool, [f64; 2])> {
            let runs = map.row(row).iter();
            runs.flat_map(|run| (run.x..run.x + run.len).map(move |x| (x, *run)))
                .map(|(x, run)| {
                    let affine = &map.patches()[run.patch as usize].src_uv_from_tgt_px;
                    let at = affine.at([f64::from(x) + 0.5, f64::from(row) + 0.5]);
                    (x, map.is_gutter(run), at)
                })
                .collect()
        };
        for row in 0..64 {
            assert_eq!(texels(&cut, row), texels(&whole, row), "row {row}");
        }
    }
}
