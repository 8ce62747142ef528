//! The expression in a face's landmarks, as far as it can be distinguished from its shape.
//!
//! A handful of movements explain most of what faces do in photographs: the jaw opens, the corners
//! of the mouth go outwards and up, the upper lip rises, lips protrude, brows rise. Each is a field
//! over the landmarks of the average face. How far each is there is found by regularised least
//! squares; what they don't explain is shape.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use crate::landmarks::regions::{
    LEFT_BROW, LEFT_MOUTH_CORNER, LIPS_INNER, LIPS_OUTER, RIGHT_BROW, RIGHT_MOUTH_CORNER,
};

/// A movement, as displacements of landmarks in distances between the eyes.
type Movement = Vec<DVec3>;

/// How strongly movements are kept small, relative to how well they are seen. Origin not recorded.
const PRIOR: f64 = 0.15;

/// Share of the movements that is taken out. Origin not recorded.
const SHARE: f64 = 0.6;

/// Displacements of landmarks from a head at rest, without what an expression explains.
///
/// - `canonical`: the landmarks of the average face, in centimetres.
/// - `displacements`: x to the person's left, y up, z forwards, in distances between the eyes.
/// - `weights`: how sure each is.
pub(crate) fn removed(canonical: &[DVec3], displacements: &[DVec3], weights: &[f64]) -> Vec<DVec3> {
    let movements = movements(canonical);
    // Shape is smooth: what it may explain is not seen as expression. So both the displacements
    // and the movements are freed of affine changes of the whole face first.
    let basis = Affine::new(canonical, weights);
    let seen = basis.residual(displacements);
    let moves: Vec<Movement> = movements.iter().map(|movement| basis.residual(movement)).collect();
    let count = moves.len();
    let dot = |a: &[DVec3], b: &[DVec3]| -> f64 {
        a.iter().zip(b).zip(weights).map(|((a, b), weight)| a.dot(*b) * weight).sum()
    };
    let matrix = DMatrix::from_fn(count, count, |i, j| {
        dot(&moves[i], &moves[j]) * if i == j { 1.0 + PRIOR } else { 1.0 }
    });
    let right = DVector::from_fn(count, |i, _| dot(&moves[i], &seen));
    let amounts = bounded(&matrix, &right);
    let mut neutral = displacements.to_vec();
    for (movement, amount) in movements.iter().zip(&amounts) {
        for (neutral, by) in neutral.iter_mut().zip(movement) {
            *neutral -= *by * (amount * SHARE);
        }
    }
    close_lips(canonical, &mut neutral);
    neutral
}

/// Lets the lips meet as they do at rest: what is left between them, above half of it comes down
/// and below half of it up, less and less away from the mouth.
fn close_lips(canonical: &[DVec3], displacements: &mut [DVec3]) {
    /// How far around the mouth surfaces give way, in centimetres.
    const AROUND: f64 = 1.1;
    if canonical.len() <= LIPS_INNER.iter().copied().fold(0, usize::max) {
        return;
    }
    // The inner outline goes along the lower lip and back along the upper one.
    let pairs: Vec<(usize, usize)> = (1..10).map(|k| (LIPS_INNER[20 - k], LIPS_INNER[k])).collect();
    let gaps: Vec<(f64, DVec3)> = pairs
        .iter()
        .map(|&(upper, lower)| {
            let x = (canonical[upper].x + canonical[lower].x) / 2.0;
            (x, displacements[upper] - displacements[lower])
        })
        .collect();
    let line = |x: f64| {
        let nearest = pairs.iter().min_by(|a, b| {
            let off = |pair: &(usize, usize)| (canonical[pair.0].x - x).abs();
            off(a).total_cmp(&off(b))
        });
        nearest.map_or(DVec3::ZERO, |&(upper, lower)| (canonical[upper] + canonical[lower]) / 2.0)
    };
    let gap = |x: f64| {
        let weight = |at: f64| (-0.5 * ((at - x) / 0.5).powi(2)).exp();
        let total: f64 = gaps.iter().map(|&(at, _)| weight(at)).sum();
        let sum: DVec3 = gaps.iter().map(|&(at, gap)| gap * weight(at)).sum();
        if total > 1e-6 { sum / total } else { DVec3::ZERO }
    };
    let is_lower = lower_lip(canonical);
    let is_lip = |index: usize| LIPS_INNER.contains(&index) || LIPS_OUTER.contains(&index);
    let corners = [LIPS_INNER[0], LIPS_INNER[10], LIPS_OUTER[0], LIPS_OUTER[10]];
    let moves: Vec<DVec3> = canonical
        .iter()
        .enumerate()
        .map(|(index, &point)| {
            if corners.contains(&index) {
                return DVec3::ZERO;
            }
            let line = line(point.x);
            let below = if is_lip(index) { is_lower[index] } else { point.y < line.y };
            let beside =
                (point.x.abs() - gaps.iter().map(|gap| gap.0).fold(0.0, f64::max)).max(0.0);
            let away =
                if LIPS_INNER.contains(&index) { 0.0 } else { (point.y - line.y).hypot(beside) };
            let share = (-0.5 * (away / AROUND).powi(2)).exp();
            gap(point.x) * if below { 0.5 * share } else { -0.5 * share }
        })
        .collect();
    displacements.iter_mut().zip(moves).for_each(|(at, by)| *at += by);
}

/// Coordinate descent with amounts of at least 0.
fn bounded(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Vec<f64> {
    const ROUNDS: usize = 200;
    let count = right.len();
    let mut amounts = vec![0.0_f64; count];
    for _ in 0..ROUNDS {
        for i in 0..count {
            if matrix[(i, i)] <= 0.0 {
                continue;
            }
            let others: f64 =
                (0..count).filter(|&j| j != i).map(|j| matrix[(i, j)] * amounts[j]).sum();
            // The exact minimum along one axis, cut off at 0; convex, so rounds of these converge.
            amounts[i] = ((right[i] - others) / matrix[(i, i)]).max(0.0);
        }
    }
    amounts
}

/// Affine displacement fields of a face.
struct Affine {
    /// Orthonormal under the weights: values at the landmarks.
    fields: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

impl Affine {
    fn new(canonical: &[DVec3], weights: &[f64]) -> Self {
        let mut fields: Vec<Vec<f64>> = Vec::new();
        let raw: [Box<dyn Fn(DVec3) -> f64>; 4] =
            [Box::new(|_| 1.0), Box::new(|p| p.x), Box::new(|p| p.y), Box::new(|p| p.z)];
        let dot = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(b).zip(weights).map(|((a, b), weight)| a * b * weight).sum()
        };
        for function in raw {
            let mut field: Vec<f64> = canonical.iter().map(|&point| function(point)).collect();
            for other in &fields {
                let along = dot(&field, other);
                field.iter_mut().zip(other).for_each(|(value, other)| *value -= along * other);
            }
            let norm = dot(&field, &field).sqrt();
            if norm > 1e-9 {
                field.iter_mut().for_each(|value| *value /= norm);
                fields.push(field);
            }
        }
        Self { fields, weights: weights.to_vec() }
    }

    fn residual(&self, displacements: &[DVec3]) -> Vec<DVec3> {
        let mut rest = displacements.to_vec();
        for field in &self.fields {
            let along: DVec3 = displacements
                .iter()
                .zip(field)
                .zip(&self.weights)
                .map(|((by, field), weight)| *by * (field * weight))
                .sum();
            rest.iter_mut().zip(field).for_each(|(rest, field)| *rest -= along * *field);
        }
        rest
    }
}

/// The movements.
fn movements(canonical: &[DVec3]) -> Vec<Movement> {
    let at = |index: usize| canonical.get(index).copied().unwrap_or(DVec3::ZERO);
    let near = |point: DVec3, center: DVec3, radius: f64| {
        (-0.5 * (point.distance(center) / radius).powi(2)).exp()
    };
    let (left, right) = (at(LEFT_MOUTH_CORNER), at(RIGHT_MOUTH_CORNER));
    let middle = (left + right) / 2.0;
    let is_lower = lower_lip(canonical);
    let field = |of: &dyn Fn(usize, DVec3) -> DVec3| -> Movement {
        canonical.iter().enumerate().map(|(index, &point)| of(index, point)).collect()
    };
    // The jaw turns about an axis through its joints, before the ears.
    let hinge = DVec3::new(0.0, middle.y + 4.5, middle.z - 9.0);
    let open = field(&|index, point| {
        let below = ((middle.y - point.y) / 1.5).clamp(0.0, 1.0);
        let share = if is_lower[index] { 1.0 } else { below * below * (3.0 - 2.0 * below) };
        let arm = point - hinge;
        DVec3::new(0.0, -arm.z, arm.y).normalize_or_zero() * (-0.25 * share)
    });
    // A negative turn about the x axis takes the chin down and back.
    let open: Movement = open.into_iter().map(|by| DVec3::new(by.x, -by.y.abs(), by.z)).collect();
    let corner = |center: DVec3| {
        let side = center.x.signum();
        field(&|_, point| {
            DVec3::new(0.55 * side, 0.6, -0.35) * (0.25 * near(point, center, 1.6))
                + DVec3::new(0.1 * side, 0.35, 0.1)
                    * (0.25 * near(point, center + DVec3::new(1.2 * side, 2.0, 0.0), 1.4))
        })
    };
    let upper = field(&|index, point| {
        let is_lip = LIPS_OUTER.contains(&index) || LIPS_INNER.contains(&index);
        let share = if is_lip && is_lower[index] { 0.0 } else { near(point, middle, 1.6) };
        let above = if point.y >= middle.y - 0.5 { 1.0 } else { 0.0 };
        DVec3::new(0.0, 0.15, 0.0) * (share * above)
    });
    let pout = field(&|_, point| {
        DVec3::new(-0.3 * (point.x / 2.5).clamp(-1.0, 1.0), 0.0, 0.3)
            * (0.5 * near(point, middle, 1.4))
    });
    let brows = |indices: [usize; 10]| {
        let center = indices.iter().map(|&index| at(index)).sum::<DVec3>() / 10.0;
        field(&|_, point| DVec3::new(0.0, 0.15, 0.0) * near(point, center, 1.5))
    };
    vec![open, corner(left), corner(right), upper, pout, brows(LEFT_BROW), brows(RIGHT_BROW)]
}

/// Whether a landmark is on the lower lip; the first half of each outline is.
fn lower_lip(canonical: &[DVec3]) -> Vec<bool> {
    let mut is_lower = vec![false; canonical.len()];
    for outline in [LIPS_OUTER, LIPS_INNER] {
        for index in &outline[1..10] {
            if let Some(is_lower) = is_lower.get_mut(*index) {
                *is_lower = true;
            }
        }
    }
    is_lower
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a bulge, with lips that nearly touch along a line and corners 5 cm apart.
    fn face() -> Vec<DVec3> {
        let mut points: Vec<DVec3> = (0..468)
            .map(|index| {
                let (column, row) = (index % 22, index / 22);
                let (x, y) = (column as f64 * 0.65 - 6.8, row as f64 * 0.7 - 9.0);
                DVec3::new(x, y, 5.0 - 0.05 * (x * x + 0.5 * y * y))
            })
            .collect();
        for (outline, height) in [(LIPS_OUTER, 0.9), (LIPS_INNER, 0.05)] {
            for (k, index) in outline.into_iter().enumerate() {
                let along = (k % 10) as f64 / 10.0 * std::f64::consts::PI;
                let side = if k < 10 { -1.0 } else { 1.0 };
                let (x, y) = (2.5 * along.cos() * side, side * height * along.sin() - 4.0);
                points[index] = DVec3::new(x, y, 5.0 - 0.05 * (x * x + 0.5 * y * y));
            }
        }
        points
    }

    #[test]
    fn an_open_mouth_is_closed_and_a_wide_face_stays_wide() {
        let canonical = face();
        let open = &movements(&canonical)[0];
        let wide: Vec<DVec3> =
            canonical.iter().map(|point| DVec3::new(0.02 * point.x, 0.0, 0.0)).collect();
        let seen: Vec<DVec3> = wide.iter().zip(open).map(|(wide, open)| *wide + *open).collect();
        let weights = vec![1.0; canonical.len()];
        let neutral = removed(&canonical, &seen, &weights);
        for k in 1..10 {
            let (upper, lower) = (neutral[LIPS_INNER[20 - k]], neutral[LIPS_INNER[k]]);
            assert!((upper.y - lower.y).abs() < 0.02, "{k}: {upper} {lower}");
        }
        let rest = removed(&canonical, &wide, &weights);
        for (rest, wide) in rest.iter().zip(&wide) {
            assert!(rest.distance(*wide) < 0.02, "{rest} {wide}");
        }
    }
}
