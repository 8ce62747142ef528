//! Principal components of the macro targets: a few dozen stand for hundreds of targets.

use nalgebra::{DMatrix, SymmetricEigen};
use uvgraft::threads;

/// Number of components.
pub(crate) const COUNT: usize = 80;

/// Components are multiples of this, in metres, so that they compress well: 2⁻¹² m.
const STEP_M: f32 = 1.0 / 4096.0;

/// Every which coordinate takes part in the analysis. Neighbours hardly differ.
const STRIDE: usize = 3;

/// Components, and the coefficients by which they make up each target.
pub(crate) struct Components {
    /// `[components][coordinates]`.
    pub(crate) rows: Vec<Vec<f32>>,
    /// `[targets][components]`, with absolute values of at most 1.
    pub(crate) coefficients: Vec<Vec<f32>>,
}

impl Components {
    /// Finds the components that explain most of the targets' coordinates in all.
    ///
    /// - `targets`: `[targets][coordinates]`, in metres.
    /// - `count`: number of components; there are no more than targets.
    pub(crate) fn new(targets: &[Vec<f32>], count: usize) -> Self {
        let vectors = leading(targets, count);
        let width = targets.first().map_or(0, Vec::len);
        let rows = threads::map_indices(vectors.len(), |component| {
            let mut row = vec![0.0_f64; width];
            for (target, &share) in targets.iter().zip(&vectors[component]) {
                row.iter_mut().zip(target).for_each(|(sum, &x)| *sum += share * f64::from(x));
            }
            let most =
                vectors[component].iter().fold(0.0, |most: f64, share| most.max(share.abs()));
            row.into_iter().map(|value| rounded((most * value) as f32)).collect()
        });
        let most: Vec<f64> = vectors
            .iter()
            .map(|vector| {
                vector.iter().fold(f64::MIN_POSITIVE, |most, share| most.max(share.abs()))
            })
            .collect();
        let share = |target: usize| {
            vectors.iter().zip(&most).map(|(vector, most)| (vector[target] / most) as f32).collect()
        };
        Self { rows, coefficients: (0..targets.len()).map(share).collect() }
    }
}

/// To the nearest multiple of [`STEP_M`].
pub(crate) fn rounded(value: f32) -> f32 {
    // Adding zero turns -0 into 0, which compresses better.
    (value / STEP_M).round() * STEP_M + 0.0
}

/// The leading eigenvectors of the targets' Gram matrix, `[vectors][targets]`.
fn leading(targets: &[Vec<f32>], count: usize) -> Vec<Vec<f64>> {
    let size = targets.len();
    let some: Vec<Vec<f32>> =
        targets.iter().map(|target| target.iter().step_by(STRIDE).copied().collect()).collect();
    let rows: Vec<Vec<f64>> = threads::map_indices(size, |row| {
        (0..=row).map(|column| dot(&some[row], &some[column])).collect()
    });
    let gram = DMatrix::from_fn(size, size, |row, column| rows[row.max(column)][row.min(column)]);
    let eigen = SymmetricEigen::new(gram);
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let vector = |at: usize| {
        let vector: Vec<f64> = eigen.eigenvectors.column(at).iter().copied().collect();
        // The sign is arbitrary: the largest share is positive.
        let largest =
            vector.iter().fold(0.0, |most: f64, &x| if x.abs() > most.abs() { x } else { most });
        vector.into_iter().map(|share| share * largest.signum()).collect()
    };
    order.into_iter().take(count.min(size)).map(vector).collect()
}

/// A dot product, in eight sums that the compiler can keep in one register.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    const BLOCK: usize = 1024;
    let blocks = a.chunks(BLOCK).zip(b.chunks(BLOCK)).map(|(a, b)| {
        let mut sums = [0.0_f32; 8];
        for (a, b) in a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0) {
            for lane in 0..8 {
                sums[lane] += a[lane] * b[lane];
            }
        }
        let rest = a.as_chunks::<8>().1.iter().zip(b.as_chunks::<8>().1);
        let rest: f32 = rest.map(|(a, b)| a * b).sum();
        f64::from(sums.iter().sum::<f32>() + rest)
    });
    blocks.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_reproduce_targets_of_their_rank() {
        // Five targets that combine two shapes.
        let shape = |seed: usize| -> Vec<f32> {
            (0..3000).map(|at| ((at * seed) % 101) as f32 / 101.0 - 0.5).collect()
        };
        let [one, two] = [shape(7), shape(31)];
        let shares = [[1.0, 0.0], [0.0, 1.0], [0.5, -0.25], [-1.0, 0.3], [0.2, 0.2]];
        let targets: Vec<Vec<f32>> = shares
            .iter()
            .map(|share| one.iter().zip(&two).map(|(a, b)| share[0] * a + share[1] * b).collect())
            .collect();
        let found = Components::new(&targets, 2);
        assert_eq!((found.rows.len(), found.coefficients.len()), (2, 5));
        for (target, coefficients) in targets.iter().zip(&found.coefficients) {
            assert!(coefficients.iter().all(|share| share.abs() <= 1.0));
            for (at, &wanted) in target.iter().enumerate() {
                let sum: f32 =
                    coefficients.iter().zip(&found.rows).map(|(c, row)| c * row[at]).sum();
                assert!((sum - wanted).abs() < 1.1 * STEP_M, "{sum} {wanted}");
            }
        }
    }
}
