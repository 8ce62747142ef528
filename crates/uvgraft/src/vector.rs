//! Vectors of three 64-bit floats.

pub(crate) type Vector = [f64; 3];

pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + factor · b`.
pub(crate) fn plus(a: Vector, factor: f64, b: Vector) -> Vector {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The direction of a vector; `None` for one that has none, being zero or not finite.
pub(crate) fn direction(a: Vector) -> Option<Vector> {
    // Scaled first: squares of small and large numbers leave the range.
    let largest = a.into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    if !(a.into_iter().all(f64::is_finite) && largest > 0.0) {
        return None;
    }
    let a = a.map(|value| value / largest);
    let length = dot(a, a).sqrt();
    Some(a.map(|value| value / length))
}

/// A direction at right angles to another.
pub(crate) fn perpendicular(direction: Vector) -> Vector {
    let [x, y, z] = direction.map(f64::abs);
    let axis = if x <= y && x <= z {
        [1.0, 0.0, 0.0]
    } else if y <= z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    self::direction(cross(direction, axis)).unwrap_or([1.0, 0.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_length_one_or_are_none() {
        for factor in [1e-310, 1e-200, 1.0, 1e200] {
            let found = direction([3.0 * factor, 0.0, -4.0 * factor]).unwrap();
            assert!((found[0] - 0.6).abs() < 1e-9 && (found[2] + 0.8).abs() < 1e-9, "{found:?}");
        }
        for none in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
            assert_eq!(direction(none), None);
        }
    }

    #[test]
    fn perpendiculars_are_perpendicular() {
        for of in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.6, -0.64, 0.48]] {
            let found = perpendicular(of);
            assert!(dot(found, of).abs() < 1e-15 && (dot(found, found) - 1.0).abs() < 1e-15);
        }
    }
}
