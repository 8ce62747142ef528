//! Orders of axes.

/// Reorders values from Fortran order, in which the first axis is contiguous, to C order.
pub(crate) fn last_axis_fastest<T: Copy>(values: &[T], shape: &[usize]) -> Vec<T> {
    let mut step = 1;
    let mut axes: Vec<(usize, usize, usize)> = Vec::with_capacity(shape.len());
    for &length in shape {
        axes.push((0, length, step));
        step *= length;
    }
    let mut at = 0;
    let mut next = || {
        let value = values[at];
        for (place, length, step) in axes.iter_mut().rev() {
            *place += 1;
            at += *step;
            if *place < *length {
                break;
            }
            *place = 0;
            at -= *step * *length;
        }
        value
    };
    (0..values.len()).map(|_| next()).collect()
}

/// Reorders values from C order to Fortran order; the inverse of [`last_axis_fastest`].
pub(crate) fn first_axis_fastest<T: Copy>(values: &[T], shape: &[usize]) -> Vec<T> {
    // Fortran order is C order with the axes reversed.
    let reversed: Vec<usize> = shape.iter().rev().copied().collect();
    last_axis_fastest(values, &reversed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_of_axes() {
        let written = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(last_axis_fastest(&written, &[2, 3]), [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
        assert_eq!(last_axis_fastest(&written, &[6]), written);
        let shape = [2, 3, 5];
        let values: Vec<usize> = (0..30).collect();
        let fortran = first_axis_fastest(&values, &shape);
        assert_eq!(fortran[..3], [0, 15, 5]);
        assert_eq!(last_axis_fastest(&fortran, &shape), values);
        assert_eq!(last_axis_fastest::<f32>(&[], &[0, 3]), [0.0; 0]);
    }
}
