//! A transfer as a linear operator: `H` maps source texels to target texels, `Hᵀ` is its transpose.
//!
//! Padding, filtering and averaging are all linear in the source values, so a transfer is
//! `target = H · source` on the texels that its map reaches. With the transpose, a texture can be
//! solved for instead of sampled, and gradients can be propagated through a transfer.

use std::sync::Arc;

use crate::resample::adjoint::Schedule;
use crate::resampler::Resampler;
use crate::texture::Size;

/// Matrix-free `H` and `Hᵀ` of a transfer; from [`Graft::operator`].
///
/// Values are `[height * width * channels]` floats, row-major, with 1 to 4 interleaved channels.
/// Channels are independent of each other. Alpha is treated like any other channel, so colours have
/// to be premultiplied. Where islands overlap, the island that owns a texel is read; averaging
/// overlaps is not part of the matrix.
///
/// [`Graft::operator`]: crate::Graft::operator
#[derive(Debug, Clone)]
pub struct Operator {
    resampler: Arc<Resampler>,
    schedule: Arc<Schedule>,
}

impl Operator {
    pub(crate) fn new(resampler: Arc<Resampler>) -> Self {
        let schedule = Schedule::new(resampler.map(), resampler.source_size(), resampler.filter());
        Self { resampler, schedule: Arc::new(schedule) }
    }

    pub(crate) fn resampler(&self) -> &Resampler {
        &self.resampler
    }

    /// The size of the source textures.
    pub fn source_size(&self) -> Size {
        self.resampler.source_size()
    }

    /// The size of the target textures.
    pub fn target_size(&self) -> Size {
        self.resampler.map().size()
    }

    /// `H · source`. Texels that the map does not reach are 0.
    ///
    /// # Panics
    /// If `channels` is not 1 to 4, or the length of `source` does not match the source size.
    pub fn apply(&self, channels: usize, source: &[f32]) -> Vec<f32> {
        let mut source = source.to_vec();
        let mut target = vec![0.0; self.target_size().texels() * channels];
        match channels {
            1 => self.resampler.fill_floats::<1>(&mut source, &mut target),
            2 => self.resampler.fill_floats::<2>(&mut source, &mut target),
            3 => self.resampler.fill_floats::<3>(&mut source, &mut target),
            4 => self.resampler.fill_floats::<4>(&mut source, &mut target),
            _ => panic!("channels must be 1 to 4, got {channels}"),
        }
        target
    }

    /// `Hᵀ · target`. Source texels that nothing reads are 0, and so are those outside the islands,
    /// since `H` reads the nearest texel inside in their place.
    ///
    /// # Panics
    /// If `channels` is not 1 to 4, or the length of `target` does not match the target size.
    pub fn apply_transposed(&self, channels: usize, target: &[f32]) -> Vec<f32> {
        let mut source = vec![0.0; self.source_size().texels() * channels];
        match channels {
            1 => self.add_transposed_to::<1>(target, &mut source),
            2 => self.add_transposed_to::<2>(target, &mut source),
            3 => self.add_transposed_to::<3>(target, &mut source),
            4 => self.add_transposed_to::<4>(target, &mut source),
            _ => panic!("channels must be 1 to 4, got {channels}"),
        }
        source
    }

    /// Adds `Hᵀ · target` to `source`, which must be 0 outside the islands.
    pub(crate) fn add_transposed_to<const C: usize>(&self, target: &[f32], source: &mut [f32]) {
        let size = self.target_size();
        assert_eq!(target.len(), size.texels() * C, "{size} with {C} channels");
        self.schedule.gather::<C>(self.resampler.map(), target, source);
        self.resampler.padding().fill_transposed::<C>(source);
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};
    use uvgraft_surface::piece::Piece;

    use super::*;
    use crate::filter::Filter;
    use crate::map::MapOptions;
    use crate::resampler::{MapInputs, Overlap};

    fn operator(pair: &Pair, source: Size, target_size: Size, filter: Filter) -> Operator {
        let map = MapOptions::with_gutter(2);
        let inputs = MapInputs { pair, direction: Direction::Forward, target_size, map };
        let maps = inputs.maps(Overlap::First);
        Operator::new(Arc::new(Resampler::new(&inputs, maps, source, filter)))
    }

    /// Triangles scattered over both layouts, some minified, some beyond the edge of the texture.
    fn pair() -> Pair {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut mesh = || {
            let uv: Vec<[f32; 2]> = (0..24)
                .flat_map(|_| {
                    let at = [rng.f32(), rng.f32()];
                    let side = rng.f32() * rng.f32() * 0.7;
                    [(); 3].map(|()| at.map(|value| value + (rng.f32() - 0.5) * side))
                })
                .collect();
            let faces: Vec<[u32; 3]> =
                (0..24).map(|face| [0, 1, 2].map(|k| face * 3 + k)).collect();
            Mesh::from_triangles(vec![[0.0; 3]; 72], uv, &faces, &faces).unwrap()
        };
        Pair::with_all(mesh(), mesh(), (0..24).map(|face| Piece::whole(face, face, [0, 1, 2])))
    }

    fn dot(a: &[f32], b: &[f32]) -> f64 {
        a.iter().zip(b).map(|(&a, &b)| f64::from(a) * f64::from(b)).sum()
    }

    #[test]
    fn the_transpose_is_the_adjoint() {
        let pair = pair();
        let mut rng = fastrand::Rng::with_seed(9);
        for (source, target) in [
            (Size::new(150, 131), Size::new(97, 120)),
            (Size::new(40, 90), Size::new(170, 160)),
            (Size::new(3, 2), Size::new(40, 50)),
        ] {
            for filter in Filter::ALL {
                let operator = operator(&pair, source, target, filter);
                for channels in 1..=4 {
                    let mut values = |count| (0..count).map(|_| rng.f32()).collect::<Vec<f32>>();
                    let x = values(source.texels() * channels);
                    let y = values(target.texels() * channels);
                    let (there, back) = (
                        dot(&operator.apply(channels, &x), &y),
                        dot(&x, &operator.apply_transposed(channels, &y)),
                    );
                    let error = (there - back).abs() / there.abs();
                    assert!(there > 1.0 && error < 1e-6, "{filter} {channels}: {there} {back}");
                }
            }
        }
    }

    #[test]
    fn columns_of_the_matrix_are_rows_of_its_transpose() {
        let pair = pair();
        let (source, target) = (Size::new(14, 11), Size::new(12, 13));
        for filter in Filter::ALL {
            let operator = operator(&pair, source, target, filter);
            let unit = |count: usize, at: usize| {
                let mut values = vec![0.0; count];
                values[at] = 1.0;
                values
            };
            let columns: Vec<Vec<f32>> = (0..source.texels())
                .map(|at| operator.apply(1, &unit(source.texels(), at)))
                .collect();
            for at in 0..target.texels() {
                let row = operator.apply_transposed(1, &unit(target.texels(), at));
                for (column, value) in columns.iter().zip(row) {
                    let error = (column[at] - value).abs();
                    assert!(error < 1e-6, "{filter}: {} and {value}", column[at]);
                }
            }
        }
    }
}
