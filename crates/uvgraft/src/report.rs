//! Statistics of a pairing: enough to tell a good one from a wrong one.

use uvgraft_surface::islands::Islands;
use uvgraft_surface::mesh::{Mesh, TileFaces, doubled_area};
use uvgraft_surface::pair::{Direction, Pair};
use uvgraft_surface::piece::{Piece, wide};

use crate::map::{MapOptions, MapStats, SamplingMap};
use crate::texture::{Size, Sizes};

/// Statistics of a pair, at nominal texture sizes.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PairReport {
    /// The layout that textures are taken from.
    pub source: LayoutReport,
    /// The layout that textures are transferred to.
    pub target: LayoutReport,
    /// Pieces: corresponding parts of triangles, mostly whole ones.
    pub links: usize,
    /// Pieces whose two triangles have opposite windings.
    pub opposite_windings: usize,
    /// Pieces that mirror the image: their UV areas have opposite signs, corner by corner.
    pub mirrored: usize,
    /// Target texels per source texel along a line, over the pieces. Above 1 the target has the
    /// higher resolution; `None` if every piece is degenerate.
    pub forward_density: Option<Percentiles>,
    /// Source texels per target texel along a line, over the pieces.
    pub reverse_density: Option<Percentiles>,
}

/// Statistics of one layout of a pair.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct LayoutReport {
    /// Number of positions.
    pub vertices: usize,
    /// Number of UV coordinates.
    pub uv_coordinates: usize,
    /// Number of triangles.
    pub faces: usize,
    /// Number of polygons before triangulation.
    pub polygons: usize,
    /// Number of UV islands.
    pub islands: usize,
    /// Triangles with a counterpart.
    pub linked: usize,
    /// Linked triangles without UV area, which cannot hold any texture.
    pub degenerate: usize,
    /// Linked triangles whose UV orientation differs from that of the larger part of the mesh.
    pub mirrored: usize,
    /// Triangles with UV coordinates outside the unit square, where a texture has no texels; none
    /// of them is linked there.
    pub outside: usize,
    /// The UV tiles by the centroids of triangles; empty if all are in the unit square.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Vec::is_empty"))]
    pub tiles: Vec<TileFaces>,
    /// Triangles that are linked only between UDIM tiles of which at least one is not the unit
    /// square: [`Pair::pieces_in_other_tiles`].
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_zero"))]
    pub linked_in_other_tiles: usize,
    /// Triangles that cross the border of a tile, or lie where there are none; none is linked.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_zero"))]
    pub in_no_tile: usize,
    /// The texture size that the following statistics are for.
    pub size: Size,
    /// Texel counts of a texture that receives a transfer.
    pub texels: MapStats,
}

#[cfg(feature = "serde")]
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Order statistics of a set of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Percentiles {
    /// Minimum.
    pub min: f64,
    /// 5th percentile.
    pub p5: f64,
    /// 50th percentile.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Maximum.
    pub max: f64,
}

impl Percentiles {
    /// Nearest-rank percentiles of the finite numbers in `values`; `None` if there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        values.sort_unstable_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        let at = |share: f64| values[(share * last as f64).round() as usize];
        Some(Self { min: at(0.0), p5: at(0.05), median: at(0.5), p95: at(0.95), max: at(1.0) })
    }
}

impl PairReport {
    /// Computes the statistics of a pair.
    ///
    /// - `sizes`: of textures in the source's and in the target's layout.
    ///
    /// # Panics
    /// If a side of a size is 0 or beyond [`Texture::MAX_SIDE`](crate::Texture::MAX_SIDE).
    pub fn new(pair: &Pair, sizes: Sizes) -> Self {
        let areas: Vec<[f64; 2]> = pair
            .pieces()
            .map(|piece| {
                let [target, source] = piece.uv(pair.target(), pair.source());
                [doubled_area(source), doubled_area(target)]
            })
            .collect();
        let texels = (sizes.to.texels() as f64 / sizes.from.texels() as f64).sqrt();
        // Rounding decides the area of what has less than a thousandth of a texel in either layout: clipped
        // triangles have slivers, and some triangles no area.
        let has_area = |[source, target]: &&[f64; 2]| {
            let halves = [source * sizes.from.texels() as f64, target * sizes.to.texels() as f64];
            halves.iter().all(|doubled| doubled.abs() > 2e-3)
        };
        let dense = || areas.iter().filter(has_area);
        let forward = dense().map(|[source, target]| (target / source).abs().sqrt() * texels);
        let reverse = dense().map(|[source, target]| (source / target).abs().sqrt() / texels);
        Self {
            source: LayoutReport::new(pair, Direction::Reverse, sizes.from),
            target: LayoutReport::new(pair, Direction::Forward, sizes.to),
            links: pair.piece_count(),
            opposite_windings: pair.pieces().filter(Piece::flips).count(),
            mirrored: areas.iter().filter(|[source, target]| source * target < 0.0).count(),
            forward_density: Percentiles::of(forward),
            reverse_density: Percentiles::of(reverse),
        }
    }
}

impl LayoutReport {
    /// For the layout that textures are transferred to in `direction`.
    fn new(pair: &Pair, direction: Direction, size: Size) -> Self {
        let mesh = pair.to(direction);
        let areas: Vec<f64> = (0..mesh.faces().len())
            .map(|face| doubled_area(wide(mesh.uv_triangle(face))))
            .collect();
        let total: f64 = areas.iter().sum();
        let pieces = pair.face_pieces(direction);
        let linked_areas = || {
            let faces = areas.iter().enumerate();
            faces.filter(|(face, _)| !pieces.of_face(*face).is_empty()).map(|(_, area)| *area)
        };
        let is_linked = |face: &u32| !pieces.of_face(*face as usize).is_empty();
        let mut elsewhere: Vec<u32> = pair
            .pieces_in_other_tiles()
            .map(|piece| match direction {
                Direction::Forward => piece.target,
                Direction::Reverse => piece.source,
            })
            .filter(|face| !is_linked(face))
            .collect();
        elsewhere.sort_unstable();
        elsewhere.dedup();
        Self {
            vertices: mesh.positions().len(),
            uv_coordinates: mesh.uv().len(),
            faces: mesh.faces().len(),
            polygons: mesh.polygon_count(),
            islands: Islands::new(mesh).count(),
            linked: linked_areas().count(),
            degenerate: linked_areas().filter(|&area| area == 0.0).count(),
            mirrored: linked_areas().filter(|&area| area * total < 0.0).count(),
            outside: (0..mesh.faces().len()).filter(|&face| mesh.is_outside(face)).count(),
            tiles: other_tiles(mesh),
            linked_in_other_tiles: elsewhere.len(),
            in_no_tile: (0..mesh.faces().len()).filter(|&face| mesh.tile(face).is_none()).count(),
            size,
            texels: SamplingMap::new(pair, direction, size, &MapOptions::default()).stats(),
        }
    }
}

/// The tiles of a mesh, unless the unit square is the only one.
fn other_tiles(mesh: &Mesh) -> Vec<TileFaces> {
    let has_outside = (0..mesh.faces().len()).any(|face| mesh.is_outside(face));
    if has_outside { mesh.tiles() } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_count_faces_and_texels() {
        // Target: a face that is mirrored and twice as dense, one without area, one without
        // counterpart.
        let positions: Vec<[f32; 3]> = (0..9).map(|vertex| [vertex as f32, 0.0, 0.0]).collect();
        let faces = [[0, 1, 2], [3, 4, 5], [6, 7, 8]];
        let at = |x: f32, y: f32, side: f32| [[x, y], [x + side, y], [x, y + side]];
        let source_uv = [at(0.0, 0.0, 0.25), at(0.5, 0.0, 0.25), at(0.0, 0.5, 0.25)].concat();
        let target_uv = [
            vec![[0.5, 0.0], [0.5, 0.5], [1.0, 0.0]],
            vec![[0.1, 0.1], [0.2, 0.2], [0.3, 0.3]],
            at(0.0, 0.6, 0.5).to_vec(),
        ]
        .concat();
        let mesh = |uv| Mesh::from_triangles(positions.clone(), uv, &faces, &faces).unwrap();
        let vertex_map = [0, 1, 2, 3, 4, 5, -1, -1, -1];
        let pair = Pair::by_vertex_map(mesh(source_uv), mesh(target_uv), &vertex_map).unwrap();
        let report = PairReport::new(&pair, Sizes { from: Size::square(64), to: Size::square(64) });
        assert_eq!((report.links, report.mirrored, report.opposite_windings), (2, 1, 0));
        assert_eq!(
            (report.source.faces, report.source.linked, report.source.degenerate),
            (3, 2, 0)
        );
        assert_eq!((report.target.degenerate, report.target.islands), (1, 3));
        assert_eq!(report.target.outside, 1);
        assert_eq!(report.forward_density.unwrap().max, 2.0);
        assert_eq!(report.reverse_density.unwrap().min, 0.5);
        // Half of a 32-texel square; the centres on the diagonal all go to one side.
        assert!((480..=544).contains(&report.target.texels.linked));
    }

    #[test]
    fn percentiles_by_nearest_rank() {
        let of = Percentiles::of((0..=100).map(f64::from).chain([f64::NAN])).unwrap();
        assert_eq!([of.min, of.p5, of.median, of.p95, of.max], [0.0, 5.0, 50.0, 95.0, 100.0]);
        assert_eq!(Percentiles::of([f64::INFINITY]), None);
    }
}
