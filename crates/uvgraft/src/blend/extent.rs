//! How large a selection is, for those who choose lengths: the distance of its innermost point from
//! its boundary, how far what surrounds it reaches, and its area.

use super::selection::{BlendDomain, Selection};

impl Selection {
    /// The distance of its innermost point from its boundary along the surface, in the target mesh's
    /// unit: a feather of this length is opaque at that point alone, and nothing is left after
    /// shrinking by it. `None` without a boundary, as of a whole eyeball. Parts without one do not
    /// count.
    pub fn depth(&self) -> Option<f64> {
        let domain = self.domain();
        innermost(&self.touched(), domain, &domain.signed_distances(self, f64::INFINITY))
    }

    /// The distance of the farthest point of `whole` that is outside: growing by it covers `whole`.
    /// `None` if nothing of it is outside, or only parts that no path leads to.
    pub fn reach(&self, whole: &Self) -> Option<f64> {
        let domain = self.domain();
        let outside: Vec<f64> = domain
            .signed_distances(self, f64::INFINITY)
            .into_iter()
            .map(|distance| -distance)
            .collect();
        innermost(&whole.touched(), domain, &outside).filter(|&reach| reach > 0.0)
    }

    /// The area of its parts that have a boundary, in the square of the target mesh's unit.
    pub fn bounded_area(&self) -> f64 {
        let domain = self.domain();
        let distances = domain.signed_distances(self, f64::INFINITY);
        let level = domain.level(self);
        let triangles = (0..).zip(domain.surface().triangles()).zip(self.touched());
        triangles
            .filter(|((_, corners), touched)| {
                *touched && corners.iter().any(|&point| distances[point as usize].is_finite())
            })
            .map(|((face, corners), _)| {
                let share = share_above(corners.map(|point| level[point as usize]));
                share * domain.surface().area(face)
            })
            .sum()
    }

    fn touched(&self) -> Vec<bool> {
        self.domain().touched(self)
    }
}

/// The largest finite distance at a corner of the triangles in `faces`, at least 0; `None` without any.
pub(super) fn innermost(faces: &[bool], domain: &BlendDomain, distances: &[f64]) -> Option<f64> {
    let corners = domain.surface().triangles().iter().zip(faces).filter(|(_, is_in)| **is_in);
    let distances = corners.flat_map(|(corners, _)| corners.map(|point| distances[point as usize]));
    distances
        .filter(|distance| distance.is_finite())
        .map(|distance| distance.max(0.0))
        .reduce(f64::max)
}

/// The share of a triangle's area where a value that is linear in between is positive.
fn share_above(levels: [f64; 3]) -> f64 {
    let above = levels.iter().filter(|&&level| level > 0.0).count();
    // The corner that is alone on its side.
    let alone = levels.iter().position(|&level| (level > 0.0) == (above == 1)).unwrap_or(0);
    let [level, next, other] = [0, 1, 2].map(|k| levels[(alone + k) % 3]);
    let along =
        |to: f64| if level.is_finite() && to.is_finite() { level / (level - to) } else { 0.5 };
    match above {
        // Regions of whole triangles are 0 at all corners of those in corners of the boundary.
        0 if levels.contains(&f64::NEG_INFINITY) => 0.0,
        0 | 3 => 1.0,
        1 if next >= 0.0 && other >= 0.0 => 1.0,
        2 if level >= 0.0 => 1.0,
        1 => along(next) * along(other),
        _ => 1.0 - along(next) * along(other),
    }
}
