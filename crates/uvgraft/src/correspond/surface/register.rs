//! Non-rigid registration: the target's points are moved onto the source's surface.
//!
//! Based on B. Amberg, S. Romdhani and T. Vetter, "Optimal Step Nonrigid ICP Algorithms for Surface
//! Registration", 2007: closest points with compatible normals, and a stiffness that decreases in
//! steps. Instead of an affine transform, each point has a displacement, so there is one unknown a
//! point and coordinate; smoothness is bending energy, see [`equations`](super::equations).

use glam::DVec3;

use super::equations::{Anchor, Equations, Stiffness};
use super::shape::Shape;
use super::tree::{Nearest, Tree};
use crate::threads::map_indices;

/// Stiffness of each stage, as shares of the unit, which is about the height of a head.
const STAGES: [Stiffness; 6] = [
    Stiffness { bending: 0.08, membrane: 0.0 },
    Stiffness { bending: 0.05, membrane: 0.0 },
    Stiffness { bending: 0.03, membrane: 0.003 },
    Stiffness { bending: 0.02, membrane: 0.003 },
    Stiffness { bending: 0.012, membrane: 0.005 },
    Stiffness { bending: 0.008, membrane: 0.005 },
];

/// Steps of each stage, at most.
const STEPS: usize = 4;

/// Points farther away than this share of the unit are no partners.
const REACH: f64 = 0.08;

/// Least cosine between the normals of a point and of its partner.
const COMPATIBLE: f64 = 0.3;

/// The surface to reach.
#[derive(Debug)]
pub(super) struct Goal {
    pub shape: Shape,
    pub face_normals: Vec<DVec3>,
    /// As [`Shape::open_sides`].
    pub open_sides: Vec<bool>,
    pub tree: Tree,
}

impl Goal {
    pub fn new(shape: Shape) -> Self {
        Self {
            face_normals: shape.face_normals(),
            open_sides: shape.open_sides(),
            tree: shape.tree(),
            shape,
        }
    }

    /// The closest point whose normal is compatible.
    pub fn partner(&self, point: DVec3, normal: DVec3, reach: f64, least: f64) -> Option<Nearest> {
        self.tree.nearest(point, reach, |triangle| {
            self.face_normals[triangle as usize].dot(normal) > least
        })
    }

    /// Whether a point of a triangle is on an open edge: the surface ends there, so a closest point
    /// that falls on it is no partner.
    pub fn is_at_border(&self, nearest: &Nearest) -> bool {
        const ZERO: f64 = 1e-9;
        (0..3).any(|k| {
            nearest.weights[(k + 2) % 3] < ZERO
                && self.open_sides[3 * nearest.triangle as usize + k]
        })
    }
}

/// Registers a shape.
///
/// - `rest`: aligned with the goal, in a unit of about a head's height.
/// - `anchors`: landmarks, which lead the first stages and fade out.
///
/// Returns the moved points.
pub(super) fn register(rest: &Shape, goal: &Goal, anchors: &[Anchor]) -> Vec<DVec3> {
    /// Weight of a landmark, in points of mean mass.
    const ANCHOR: f64 = 10.0;
    const SETTLED: f64 = 1e-4;
    let equations = Equations::new(rest);
    let mean_mass = equations.masses().iter().sum::<f64>() / equations.masses().len().max(1) as f64;
    let mut moved = rest.clone();
    let mut displacements = vec![DVec3::ZERO; rest.points.len()];
    for (stage, stiffness) in STAGES.into_iter().enumerate() {
        let Some(factors) = equations.factorise(stiffness) else { break };
        let fading = ANCHOR * mean_mass * (1.0 - stage as f64 / STAGES.len() as f64);
        for _ in 0..STEPS {
            let (weights, targets) = partners(rest, &moved, goal, equations.masses());
            let next = factors.solve(&weights, &targets, anchors, fading, &displacements);
            let change = next.iter().zip(&displacements).map(|(a, b)| a.distance(*b));
            let change = change.fold(0.0, f64::max);
            displacements = next;
            for (point, (rest, displacement)) in
                moved.points.iter_mut().zip(rest.points.iter().zip(&displacements))
            {
                *point = *rest + *displacement;
            }
            if change < SETTLED {
                break;
            }
        }
    }
    moved.points
}

/// Each point's weight, and the displacement that takes it to its partner.
fn partners(rest: &Shape, moved: &Shape, goal: &Goal, masses: &[f64]) -> (Vec<f64>, Vec<DVec3>) {
    let normals = moved.normals();
    map_indices(rest.points.len(), |index| {
        let partner = goal.partner(moved.points[index], normals[index], REACH, COMPATIBLE);
        match partner {
            Some(nearest) if !goal.is_at_border(&nearest) => {
                (masses[index], nearest.point - rest.points[index])
            }
            _ => (0.0, DVec3::ZERO),
        }
    })
    .into_iter()
    .unzip()
}
