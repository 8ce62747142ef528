//! Directions: vectors of length 1.

use glam::DVec3;

/// The normalised vector; `None` if it is zero or not finite.
///
/// [`DVec3::try_normalize`] fails for very short and very long vectors.
pub fn direction(vector: DVec3) -> Option<DVec3> {
    // Scale first: the squares of very small and very large components under- or overflow.
    let largest = vector.abs().max_element();
    if !(vector.is_finite() && largest > 0.0) {
        return None;
    }
    let scaled = vector / largest;
    Some(scaled / scaled.length())
}

/// A unit vector perpendicular to `to`.
pub fn perpendicular(to: DVec3) -> DVec3 {
    let axis = DVec3::AXES[to.abs().min_position()];
    direction(to.cross(axis)).unwrap_or(DVec3::X)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_length_one_or_are_none() {
        for factor in [1e-310, 1e-200, 1.0, 1e200] {
            let found = direction(DVec3::new(3.0, 0.0, -4.0) * factor).unwrap();
            assert!(found.abs_diff_eq(DVec3::new(0.6, 0.0, -0.8), 1e-9), "{found}");
        }
        for none in [DVec3::ZERO, DVec3::X.with_x(f64::NAN), DVec3::X.with_y(f64::INFINITY)] {
            assert_eq!(direction(none), None);
        }
    }

    #[test]
    fn perpendiculars_are_perpendicular() {
        for of in [DVec3::X, DVec3::Y, DVec3::NEG_Z, DVec3::new(0.6, -0.64, 0.48)] {
            let found = perpendicular(of);
            assert!(found.dot(of).abs() < 1e-15 && (found.dot(found) - 1.0).abs() < 1e-15);
        }
    }
}
