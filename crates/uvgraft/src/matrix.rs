//! A transfer as an explicit sparse matrix, row by row.
//!
//! The entries are those of [`reference()`](crate::resample::reference::resample): the product of
//! the filter's weights on both axes, averaged over a texel's samples. Taps beyond the source
//! belong to its edge texels, and taps outside its islands to the texels that padding copies.

use std::ops::Range;

use uvgraft_surface::threads::map_indices_with;

use crate::filter::{Filter, MAX_TAPS};
use crate::operator::Operator;
use crate::pad::Padding;
use crate::resample::position::{containing, fraction, near_texture, split};
use crate::texture::Size;

/// The entries of `H`, made on demand; from [`Operator::matrix`].
///
/// `H` has a row for each texel of the target and a column for each texel of the source, both
/// row-major.
#[derive(Debug)]
pub struct OperatorMatrix<'a> {
    operator: &'a Operator,
    padded: PaddedTexels,
}

/// Rows of a matrix in compressed form, as in SciPy's CSR.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MatrixRows {
    /// For each row, the end of its entries; those of the next row begin there.
    pub ends: Vec<usize>,
    /// The column of each entry, ascending within a row, each at most once.
    pub columns: Vec<u32>,
    /// The value of each entry; never 0.
    pub values: Vec<f32>,
}

impl Operator {
    /// The entries of `H`.
    ///
    /// Finds which texel stands in for each texel outside the source's islands, in up to 4 bytes
    /// per source texel.
    pub fn matrix(&self) -> OperatorMatrix<'_> {
        let padded = PaddedTexels::new(self.resampler().padding());
        OperatorMatrix { operator: self, padded }
    }

    /// A source as `H` reads it: where filters reach outside its islands, texels take the value of
    /// the nearest texel inside.
    ///
    /// # Panics
    /// As [`Operator::apply`].
    pub fn padded(&self, channels: usize, source: &[f32]) -> Vec<f32> {
        let texels = self.source_size().texels();
        assert!((1..=4).contains(&channels), "channels must be 1 to 4, got {channels}");
        assert_eq!(source.len(), texels * channels, "{channels} channels");
        let mut source = source.to_vec();
        let padding = self.resampler().padding();
        match channels {
            1 => padding.fill::<1>(&mut source),
            2 => padding.fill::<2>(&mut source),
            3 => padding.fill::<3>(&mut source),
            _ => padding.fill::<4>(&mut source),
        }
        source
    }
}

impl OperatorMatrix<'_> {
    /// The matrix rows of all texels in some rows of the target.
    ///
    /// # Panics
    /// If the target does not have these rows.
    pub fn rows(&self, rows: Range<u32>) -> MatrixRows {
        assert!(rows.end <= self.operator.target_size().height, "{rows:?}");
        let made = map_indices_with(rows.len(), Vec::new, |terms, index| {
            self.row(rows.start + index as u32, terms)
        });
        let mut all = MatrixRows::default();
        for row in made {
            let before = all.columns.len();
            all.ends.extend(row.ends.into_iter().map(|end| before + end));
            all.columns.extend(row.columns);
            all.values.extend(row.values);
        }
        all
    }

    /// - `terms`: a buffer.
    fn row(&self, row: u32, terms: &mut Vec<(u32, f64)>) -> MatrixRows {
        let resampler = self.operator.resampler();
        let (map, paths) = (resampler.map(), resampler.paths());
        let mut made = MatrixRows::default();
        for &run in map.row(row) {
            made.ends.resize(run.x as usize, made.columns.len());
            let walk = paths.walk(row, run);
            let [columns, rows] = walk.samples();
            let share = 1.0 / f64::from(columns * rows);
            for k in 0..run.len {
                terms.clear();
                for b in 0..rows {
                    for a in 0..columns {
                        self.add(walk.sample(k, a, b), share, terms);
                    }
                }
                made.push(terms);
            }
        }
        made.ends.resize(map.size().width as usize, made.columns.len());
        made
    }

    /// Adds the terms of one sample.
    fn add(&self, position: [i64; 2], share: f64, terms: &mut Vec<(u32, f64)>) {
        let (source, filter) = (self.operator.source_size(), self.operator.resampler().filter());
        let x = taps(position[0], source.width, filter);
        let y = taps(position[1], source.height, filter);
        for &(y, weight_y) in &y[..filter.taps()] {
            for &(x, weight_x) in &x[..filter.taps()] {
                let weight = f64::from(weight_x) * f64::from(weight_y) * share;
                terms.push((self.padded.inside(y * source.width + x), weight));
            }
        }
    }
}

/// The texels that a filter reads on one axis, and their weights; only the first are used.
fn taps(position: i64, count: u32, filter: Filter) -> [(u32, f32); MAX_TAPS] {
    let near = near_texture(position, count);
    let clamped = |texel: i32| texel.clamp(0, count as i32 - 1) as u32;
    if filter == Filter::Nearest {
        return [(clamped(containing(near)), 1.0); MAX_TAPS];
    }
    let (texel, bits) = split(near);
    let weights = filter.weights(fraction(bits));
    let before = filter.taps() as i32 / 2 - 1;
    std::array::from_fn(|k| (clamped(texel - before + k as i32), weights[k]))
}

impl MatrixRows {
    /// Adds a row: sorts terms by column, and adds up those of one column.
    fn push(&mut self, terms: &mut [(u32, f64)]) {
        if !terms.is_sorted_by_key(|term| term.0) {
            terms.sort_unstable_by_key(|term| term.0);
        }
        for terms in terms.chunk_by(|a, b| a.0 == b.0) {
            let value = terms.iter().map(|term| term.1).sum::<f64>() as f32;
            if value != 0.0 {
                self.columns.push(terms[0].0);
                self.values.push(value);
            }
        }
        self.ends.push(self.columns.len());
    }
}

/// For each padded texel of a source, the texel whose value it takes.
#[derive(Debug)]
struct PaddedTexels {
    /// Texels in pieces of [`PIECE`]; `None` where none is padded.
    pieces: Vec<Option<Box<[u32; PIECE]>>>,
}

const PIECE: usize = 1024;
const NOT_PADDED: u32 = u32::MAX;

impl PaddedTexels {
    fn new(padding: &Padding) -> Self {
        let Size { width, height } = padding.size();
        let count = (width as usize * height as usize).div_ceil(PIECE);
        let mut pieces: Vec<Option<Box<[u32; PIECE]>>> = (0..count).map(|_| None).collect();
        padding.for_each_copy(|outside, inside| {
            let piece =
                pieces[outside / PIECE].get_or_insert_with(|| Box::new([NOT_PADDED; PIECE]));
            piece[outside % PIECE] = inside as u32;
        });
        Self { pieces }
    }

    /// The texel whose value a texel has.
    fn inside(&self, texel: u32) -> u32 {
        match &self.pieces[texel as usize / PIECE] {
            Some(piece) if piece[texel as usize % PIECE] != NOT_PADDED => {
                piece[texel as usize % PIECE]
            }
            _ => texel,
        }
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::Pair;
    use uvgraft_surface::piece::Piece;

    use super::*;
    use crate::graft::Graft;
    use crate::texture::Sizes;

    /// Triangles scattered over both layouts, some minified.
    fn pair() -> Pair {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut mesh = || {
            let uv: Vec<[f32; 2]> = (0..16)
                .flat_map(|_| {
                    let at = [rng.f32(), rng.f32()];
                    let side = rng.f32() * rng.f32() * 0.7;
                    [(); 3].map(|()| {
                        at.map(|value| (value + (rng.f32() - 0.5) * side).clamp(0.0, 1.0))
                    })
                })
                .collect();
            let faces: Vec<[u32; 3]> =
                (0..16).map(|face| [0, 1, 2].map(|k| face * 3 + k)).collect();
            Mesh::from_triangles(vec![[0.0; 3]; 48], uv, &faces, &faces).unwrap()
        };
        let itself = (0..16).map(|face| Piece::whole(face, face, [0, 1, 2]));
        Pair::from_pieces(mesh(), mesh(), itself).unwrap()
    }

    #[test]
    fn the_matrix_is_the_operator() {
        let pair = std::sync::Arc::new(pair());
        let mut rng = fastrand::Rng::with_seed(9);
        for (from, to) in [
            (Size::new(150, 131), Size::new(97, 60)),
            (Size::new(40, 90), Size::new(170, 160)),
            (Size::new(3, 2), Size::new(40, 50)),
        ] {
            for filter in Filter::ALL {
                let graft = Graft::builder(std::sync::Arc::clone(&pair), Sizes { from, to });
                let operator = graft.filter(filter).gutter_px(2).build().unwrap().operator();
                let source: Vec<f32> = (0..from.texels()).map(|_| rng.f32()).collect();
                let wanted = operator.apply(1, &source);
                let matrix = operator.matrix();
                // In bands that are not multiples of anything.
                let bands = [0..7, 7..8, 8..to.height];
                let mut found = Vec::new();
                for band in bands {
                    let rows = matrix.rows(band.clone());
                    assert_eq!(rows.ends.len(), band.len() * to.width as usize);
                    let mut start = 0;
                    for &end in &rows.ends {
                        let columns = &rows.columns[start..end];
                        assert!(columns.windows(2).all(|pair| pair[0] < pair[1]));
                        let terms = columns.iter().zip(&rows.values[start..end]);
                        let sum = terms.map(|(&column, &value)| value * source[column as usize]);
                        found.push(sum.sum::<f32>());
                        if start < end {
                            let sum: f32 = rows.values[start..end].iter().sum();
                            assert!((sum - 1.0).abs() < 1e-5, "{filter}: {sum}");
                        }
                        start = end;
                    }
                }
                assert_eq!(found.len(), wanted.len());
                let mut reached = 0;
                for (found, wanted) in found.iter().zip(&wanted) {
                    assert!((found - wanted).abs() < 2e-5, "{filter}: {found} {wanted}");
                    reached += usize::from(*wanted != 0.0);
                }
                assert!(reached * 20 > to.texels(), "{reached}");
                // The padded source gives the same, and padding it again changes nothing.
                let padded = operator.padded(1, &source);
                assert_eq!(operator.apply(1, &padded), wanted);
                assert!(from.width < 4 || padded != source);
            }
        }
    }

    #[test]
    fn entries_by_hand() {
        // The right half of a source of 4x2 texels fills a target of 2x2.
        let uv = |left: f32| vec![[left, 0.0], [1.0, 0.0], [1.0, 1.0], [left, 1.0]];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let mesh =
            |left| Mesh::from_triangles(vec![[0.0; 3]; 4], uv(left), &faces, &faces).unwrap();
        let pair = Pair::by_vertex_map(mesh(0.5), mesh(0.0), &[0, 1, 2, 3]).unwrap();
        let sizes = Sizes { from: Size::new(4, 2), to: Size::new(4, 2) };
        let graft = Graft::builder(pair, sizes).filter(Filter::Bilinear).build().unwrap();
        let rows = graft.operator().matrix().rows(0..1);
        // Positions 2.25, 2.75, 3.25, 3.75: the first reads texel 1, outside, as texel 2; the
        // last reads beyond the edge.
        assert_eq!(rows.ends, [1, 3, 5, 6]);
        assert_eq!(rows.columns, [2, 2, 3, 2, 3, 3]);
        assert_eq!(rows.values, [1.0, 0.75, 0.25, 0.25, 0.75, 1.0]);
    }
}
