//! Bounded quadratic minimisation.

use nalgebra::{DMatrix, DVector};

/// Minimises `xᵀ A x / 2 - bᵀ x` within bounds, for a positive definite `A`.
///
/// Active-set method: unknowns that leave their bounds are fixed there, and released once the
/// gradient pulls them back inside. Fixing all violated bounds at once settles a hundred unknowns
/// within a few rounds. `None` if `A` is not positive definite.
pub(super) fn least(
    matrix: &DMatrix<f64>,
    right: &DVector<f64>,
    bounds: &[[f64; 2]],
) -> Option<DVector<f64>> {
    const ROUNDS: usize = 60;
    let count = right.len();
    let mut x = DVector::zeros(count);
    let mut fixed: Vec<Option<f64>> =
        bounds.iter().map(|&[low, high]| (low == high).then_some(low)).collect();
    for round in 0..ROUNDS {
        let free: Vec<usize> = (0..count).filter(|&at| fixed[at].is_none()).collect();
        for (at, fixed) in fixed.iter().enumerate() {
            x[at] = fixed.unwrap_or(0.0);
        }
        let fixed_part = matrix * &x;
        let inner = DMatrix::from_fn(free.len(), free.len(), |a, b| matrix[(free[a], free[b])]);
        let rest = DVector::from_fn(free.len(), |at, _| right[free[at]] - fixed_part[free[at]]);
        let solved = if free.is_empty() { rest } else { inner.cholesky()?.solve(&rest) };
        for (&at, &value) in free.iter().zip(solved.iter()) {
            x[at] = value;
        }
        let mut settled = true;
        for &at in &free {
            let [low, high] = bounds[at];
            if !(low..=high).contains(&x[at]) {
                x[at] = x[at].clamp(low, high);
                fixed[at] = Some(x[at]);
                settled = false;
            }
        }
        if !settled {
            continue;
        }
        let slope = matrix * &x - right;
        // Later rounds only fix unknowns, so that two of them cannot alternate for ever.
        for at in 0..count {
            let [low, high] = bounds[at];
            let is_pulled = |bound: f64| {
                low < high && if bound == low { slope[at] < 0.0 } else { slope[at] > 0.0 }
            };
            if round < ROUNDS / 2 && fixed[at].is_some_and(is_pulled) {
                fixed[at] = None;
                settled = false;
            }
        }
        if settled {
            break;
        }
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_and_free_unknowns_compensate() {
        // (x + y - 3)² + (x - y - 1)² / 100: without bounds x = 2, y = 1.
        let matrix = DMatrix::from_row_slice(2, 2, &[2.02, 1.98, 1.98, 2.02]);
        let right = DVector::from_row_slice(&[6.02, 5.98]);
        let near = |bounds: [[f64; 2]; 2], wanted: [f64; 2]| {
            let x = least(&matrix, &right, &bounds).unwrap();
            assert!((x[0] - wanted[0]).abs() < 1e-9 && (x[1] - wanted[1]).abs() < 1e-9, "{x}");
        };
        near([[-9.0, 9.0]; 2], [2.0, 1.0]);
        // With x at most 1 the derivative with respect to y is 2.02 y + 1.98 - 5.98.
        near([[-9.0, 1.0], [-9.0, 9.0]], [1.0, 4.0 / 2.02]);
        near([[-9.0, 0.5], [0.0, 0.25]], [0.5, 0.25]);
        near([[0.0, 0.0], [-9.0, 9.0]], [0.0, 5.98 / 2.02]);
        let singular = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        assert_eq!(least(&singular, &right, &[[-9.0, 9.0]; 2]), None);
    }
}
