//! A transfer as a matrix: `H` takes the source's texels to the target's, `Hᵀ` the other way.
//!
//! Padding, filtering and averaging are all linear in the source's values, so a transfer is
//! `target = H · source` on the texels that its map reaches. With its transpose at hand a texture
//! can be solved for rather than sampled, and gradients can flow through a transfer.

use crate::resample::adjoint::Schedule;
use crate::texture::Size;
use crate::transfer::Transfer;

/// `H` and `Hᵀ` of a [`Transfer`], applied without being written out.
///
/// Values are `[height * width * channels]` floats, row-major, channels interleaved, 1 to 4 of them.
/// Each channel is on its own: opacity is one like others, so colours have to be multiplied by it
/// before.
#[derive(Debug, Clone)]
pub struct Operator<'a> {
    transfer: &'a Transfer,
    schedule: Schedule,
}

impl<'a> Operator<'a> {
    /// The matrix of a transfer.
    pub fn new(transfer: &'a Transfer) -> Self {
        let (map, options) = (transfer.map(), transfer.options());
        let schedule = Schedule::new(map, transfer.source_size(), options.filter);
        Self { transfer, schedule }
    }

    /// The transfer that this is the matrix of.
    pub fn transfer(&self) -> &'a Transfer {
        self.transfer
    }

    /// The size of the textures that `H` reads.
    pub fn source_size(&self) -> Size {
        self.transfer.source_size()
    }

    /// The size of the textures that `H` makes.
    pub fn target_size(&self) -> Size {
        self.transfer.map().size()
    }

    /// `H · source`. Texels that the map does not reach are 0.
    ///
    /// # Panics
    /// If `channels` is not 1 to 4, or `source` has another length than its size says.
    pub fn apply(&self, channels: usize, source: &[f32]) -> Vec<f32> {
        let mut source = source.to_vec();
        let mut target = vec![0.0; self.target_size().texels() * channels];
        match channels {
            1 => self.transfer.fill_floats::<1>(&mut source, &mut target),
            2 => self.transfer.fill_floats::<2>(&mut source, &mut target),
            3 => self.transfer.fill_floats::<3>(&mut source, &mut target),
            4 => self.transfer.fill_floats::<4>(&mut source, &mut target),
            _ => panic!("a texel has 1 to 4 channels, not {channels}"),
        }
        target
    }

    /// `Hᵀ · target`. Source texels that nothing reads are 0, and so are those beside the islands:
    /// `H` reads the nearest texel inside in their place.
    ///
    /// # Panics
    /// If `channels` is not 1 to 4, or `target` has another length than its size says.
    pub fn apply_transposed(&self, channels: usize, target: &[f32]) -> Vec<f32> {
        let mut source = vec![0.0; self.source_size().texels() * channels];
        match channels {
            1 => self.add_transposed_to::<1>(target, &mut source),
            2 => self.add_transposed_to::<2>(target, &mut source),
            3 => self.add_transposed_to::<3>(target, &mut source),
            4 => self.add_transposed_to::<4>(target, &mut source),
            _ => panic!("a texel has 1 to 4 channels, not {channels}"),
        }
        source
    }

    /// Adds `Hᵀ · target` to `source`, which is 0 beside the islands.
    pub(crate) fn add_transposed_to<const C: usize>(&self, target: &[f32], source: &mut [f32]) {
        let size = self.target_size();
        assert_eq!(target.len(), size.texels() * C, "{size} with {C} channels");
        self.schedule.gather::<C>(self.transfer.map(), target, source);
        self.transfer.padding().give_back::<C>(source);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Filter;
    use crate::map::MapOptions;
    use crate::mesh::Mesh;
    use crate::pair::{Direction, Pair};
    use crate::transfer::TransferOptions;

    /// Triangles strewn over both layouts, some shrunk, some beyond the border.
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
        Pair::by_vertex_map(mesh(), mesh(), &(0..72).collect::<Vec<i64>>()).unwrap()
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
                let map = MapOptions::with_gutter(2);
                let options = TransferOptions { filter, map, ..TransferOptions::default() };
                let transfer = Transfer::new(&pair, Direction::Forward, source, target, &options);
                let operator = Operator::new(&transfer);
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
            let options = TransferOptions { filter, ..TransferOptions::default() };
            let transfer = Transfer::new(&pair, Direction::Forward, source, target, &options);
            let operator = Operator::new(&transfer);
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
