//! The joint regressor: each joint as an affine combination of vertices near it.
//!
//! MakeHuman's joints are centres of cubes, which the targets move as their authors saw fit, so no
//! combination of vertices reproduces them for all shapes. These weights are exact for the template
//! and within centimetres elsewhere; the model has exact joints besides.

use glam::Vec3;
use nalgebra::{Cholesky, DMatrix, DVector};
use uvgraft::threads;

use crate::t_pose::Points;

/// Vertices that determine a joint, in each of the eight octants around it: inside a body, the
/// nearest ones would all lie on one side.
const VERTICES: usize = 16;
/// Squared weight of the regularisation, in square metres: the smallest weights among those that
/// fit equally well.
const RIDGE: f64 = 1e-5;
/// Weight of the template, in which joints must be exact.
const TEMPLATE: f64 = 30.0;
/// Weight of moving everything by a metre, after which joints must be exact too.
const SHIFT: f64 = 30.0;

/// Weights of each joint's vertices, which sum to 1.
///
/// - `template`: at rest.
/// - `components`: offsets of the shape space's components.
/// - `is_fit`: which vertices may be used.
pub(crate) fn fit(
    template: &Points,
    components: &[Points],
    is_fit: impl Fn(usize) -> bool + Sync,
) -> Vec<Vec<(u32, f32)>> {
    threads::map_indices(template.joints.len(), |joint| {
        let place = Vec3::from(template.joints[joint]);
        let distance = |&vertex: &usize| place.distance_squared(template.vertices[vertex].into());
        let octant = |vertex: usize| {
            let offset = Vec3::from(template.vertices[vertex]) - place;
            offset.to_array().map(|value| value > 0.0)
        };
        let mut all: Vec<usize> = (0..template.vertices.len()).filter(|&at| is_fit(at)).collect();
        all.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
        let mut near = Vec::with_capacity(8 * VERTICES);
        for signs in 0..8 {
            let signs = [0, 1, 2].map(|axis| signs >> axis & 1 == 1);
            let there = all.iter().copied().filter(|&vertex| octant(vertex) == signs);
            near.extend(there.take(VERTICES));
        }
        let weights = solve(template, components, joint, &near);
        (near.iter().zip(weights)).map(|(&at, weight)| (at as u32, weight as f32)).collect()
    })
}

/// Least squares over the coordinates of all samples, by normal equations.
fn solve(template: &Points, components: &[Points], joint: usize, near: &[usize]) -> Vec<f64> {
    let count = near.len();
    let mut matrix = DMatrix::<f64>::zeros(count, count);
    let mut right = DVector::<f64>::zeros(count);
    let mut add = |row: &[f64], wanted: f64| {
        for (at, &one) in row.iter().enumerate() {
            right[at] += one * wanted;
            for (other, &two) in row.iter().enumerate() {
                matrix[(other, at)] += one * two;
            }
        }
    };
    // Relative to the joint, so that the template asks for a centre.
    let place = template.joints[joint];
    for axis in 0..3 {
        let row: Vec<f64> = near
            .iter()
            .map(|&at| TEMPLATE * (f64::from(template.vertices[at][axis]) - f64::from(place[axis])))
            .collect();
        add(&row, 0.0);
    }
    for points in components {
        for axis in 0..3 {
            let row: Vec<f64> =
                near.iter().map(|&at| f64::from(points.vertices[at][axis])).collect();
            add(&row, f64::from(points.joints[joint][axis]));
        }
    }
    add(&vec![SHIFT; count], SHIFT);
    for at in 0..count {
        matrix[(at, at)] += RIDGE;
        right[at] += RIDGE / count as f64;
    }
    let mut weights: Vec<f64> = match Cholesky::new(matrix) {
        Some(factor) => factor.solve(&right).iter().copied().collect(),
        None => vec![1.0 / count as f64; count],
    };
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_follows_the_vertices_that_move_it() {
        // The joint is the mean of the first two of four vertices in every sample.
        let sample = |seed: u32| {
            let value = |at: u32| ((at * 37 + seed * 101) % 19) as f32 * 0.01 - 0.09;
            let vertices: Vec<[f32; 3]> =
                (0..4).map(|v| [0, 1, 2].map(|axis| value(3 * v + axis + seed))).collect();
            let joint = [0, 1, 2].map(|axis| f32::midpoint(vertices[0][axis], vertices[1][axis]));
            Points { vertices, joints: vec![joint] }
        };
        let components: Vec<Points> = (1..9).map(sample).collect();
        let found = fit(&sample(0), &components, |vertex| vertex != 3);
        assert_eq!(found[0].len(), 3);
        let weight = |vertex| found[0].iter().find(|(at, _)| *at == vertex).unwrap().1;
        assert!((weight(0) - 0.5).abs() < 0.01 && (weight(1) - 0.5).abs() < 0.01, "{found:?}");
        assert!((found[0].iter().map(|(_, weight)| weight).sum::<f32>() - 1.0).abs() < 1e-6);
    }
}
