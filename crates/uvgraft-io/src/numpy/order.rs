//! Orders of axes.

/// Reorders values from Fortran order, in which the first axis is contiguous, to C order.
pub(crate) fn last_axis_fastest<T: Copy>(values: &[T], shape: &[usize]) -> Vec<T> {
    let steps: Vec<usize> = (0..shape.len()).map(|axis| shape[..axis].iter().product()).collect();
    places(shape, &steps).take(values.len()).map(|at| values[at]).collect()
}

/// The places of values in C order, over and over.
///
/// - `steps`: how far the next value along each axis is.
pub(crate) fn places(shape: &[usize], steps: &[usize]) -> impl Iterator<Item = usize> {
    let axes = shape.iter().zip(steps);
    let mut axes: Vec<_> = axes.map(|(&length, &step)| (0, length, step)).collect();
    let mut next = 0;
    std::iter::repeat_with(move || {
        let at = next;
        for (place, length, step) in axes.iter_mut().rev() {
            *place += 1;
            next += *step;
            if *place < *length {
                break;
            }
            *place = 0;
            next -= *step * *length;
        }
        at
    })
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
