//! Non-rigid registration: the target's points are moved onto the source's surface.
//!
//! Based on B. Amberg, S. Romdhani and T. Vetter, "Optimal Step Nonrigid ICP Algorithms for Surface
//! Registration", 2007: closest points with compatible normals, and a stiffness that decreases in
//! steps. Instead of an affine transform, each point has a displacement, so there is one unknown a
//! point and coordinate; smoothness is bending energy, see [`equations`](super::equations).

use std::sync::Arc;

use glam::DVec3;

use super::equations::{Anchor, Equations, Stiffness};
use super::kinds::TriangleKind;
use super::shape::Shape;
use crate::sparse::Filled;
use crate::threads::map_indices;
use crate::triangle_tree::{Effort, Nearest, TriangleTree};

/// Stiffness of each stage, as shares of the unit, which is about the height of a head. The values'
/// origin is not recorded.
const STAGES: [Stiffness; 6] = [
    Stiffness { bending: 0.08, membrane: 0.0 },
    Stiffness { bending: 0.05, membrane: 0.0 },
    Stiffness { bending: 0.03, membrane: 0.003 },
    Stiffness { bending: 0.02, membrane: 0.003 },
    Stiffness { bending: 0.012, membrane: 0.005 },
    Stiffness { bending: 0.008, membrane: 0.005 },
];

/// Steps after the last stage, at most, in which points of triangles that were turned over are let
/// go.
const REPAIRS: usize = 8;

/// Steps of each stage, at most.
const STEPS: usize = 4;

/// Points farther away than this share of the unit are no partners. Origin not recorded.
const REACH: f64 = 0.08;

/// Least cosine between the normals of a point and of its partner: 72.5°. Origin not recorded.
const COMPATIBLE: f64 = 0.3;

/// The surface to reach.
#[derive(Debug)]
pub(super) struct Goal {
    pub shape: Shape,
    pub face_normals: Vec<DVec3>,
    /// As [`Shape::open_sides`].
    pub open_sides: Vec<bool>,
    pub tree: TriangleTree,
    pub kinds: Vec<TriangleKind>,
}

impl Goal {
    /// - `effort`: of searches in it, together with others.
    pub fn new(shape: Shape, effort: &Arc<Effort>) -> Self {
        Self {
            face_normals: shape.face_normals(),
            open_sides: shape.open_sides(),
            tree: shape.tree(effort),
            kinds: vec![TriangleKind::ANY; shape.triangles.len()],
            shape,
        }
    }

    /// The closest point whose normal is compatible.
    ///
    /// - `least`: cosine between the normals.
    pub fn partner(
        &self,
        kind: TriangleKind,
        point: DVec3,
        normal: DVec3,
        reach: f64,
        least: f64,
    ) -> Option<Nearest> {
        self.tree.nearest(point, reach, |triangle| {
            self.face_normals[triangle as usize].dot(normal) > least
                && kind.may_meet(self.kinds[triangle as usize])
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

/// Landmarks, which lead the first stages and fade out.
#[derive(Debug, Clone)]
pub(super) struct Anchors {
    pub places: Vec<Anchor>,
    /// How many stages they lead, at least 1.
    pub stages: usize,
}

impl Anchors {
    /// Landmarks that were given: they are right.
    pub const GIVEN: usize = STAGES.len();
    /// Landmarks that were found in the shape: their errors, of some millimetres, must not stay.
    pub const FOUND: usize = 2;
}

/// Registers a shape.
///
/// - `rest`: aligned with the goal, in a unit of about a head's height.
/// - `kinds`: of its triangles.
/// - `anchors`: landmarks.
///
/// Returns the moved points.
///
/// # Errors
/// [`Filled`] for a shape whose triangles are connected like no surface.
pub(super) fn register(
    rest: &Shape,
    kinds: &[TriangleKind],
    goal: &Goal,
    anchors: &Anchors,
) -> Result<Vec<DVec3>, Filled> {
    /// Weight of a landmark, in points of mean mass.
    const ANCHOR: f64 = 10.0;
    const SETTLED: f64 = 1e-4;
    let equations = Equations::new(rest);
    let mean_mass = equations.masses().iter().sum::<f64>() / equations.masses().len().max(1) as f64;
    let kinds = of_points(rest, kinds);
    let mut moved = rest.clone();
    let mut displacements = vec![DVec3::ZERO; rest.points.len()];
    // Points of triangles that were turned over: their partners are on another fold of the
    // surface, so they follow their neighbours.
    let mut misled = vec![false; rest.points.len()];
    for (stage, stiffness) in STAGES.into_iter().enumerate() {
        let Some(factors) = equations.factorise(stiffness)? else { break };
        let fading = ANCHOR * mean_mass * (1.0 - stage as f64 / anchors.stages as f64).max(0.0);
        let is_last = stage + 1 == STAGES.len();
        for step in 0..STEPS + if is_last { REPAIRS } else { 0 } {
            let (mut weights, targets) = partners(rest, &moved, &kinds, goal, equations.masses());
            if step >= STEPS && !mark_turned_over(rest, &moved, &mut misled) {
                break;
            }
            for (weight, _) in weights.iter_mut().zip(&misled).filter(|(_, misled)| **misled) {
                *weight = 0.0;
            }
            let next = factors.solve(&weights, &targets, &anchors.places, fading, &displacements);
            let change = next.iter().zip(&displacements).map(|(a, b)| a.distance(*b));
            let change = change.fold(0.0, f64::max);
            displacements = next;
            for (point, (rest, displacement)) in
                moved.points.iter_mut().zip(rest.points.iter().zip(&displacements))
            {
                *point = *rest + *displacement;
            }
            if change < SETTLED && !is_last {
                break;
            }
        }
    }
    untangle(rest, &mut moved);
    Ok(moved.points)
}

/// Lets the points of triangles that are still turned over move as their neighbours do on average.
/// Where all points move alike, nothing is turned over.
fn untangle(rest: &Shape, moved: &mut Shape) {
    /// How often the corners of turned triangles get one displacement, where that changes little
    /// relative to their length: slivers are turned over by the least of shears.
    const TOGETHER: usize = 16;
    const LITTLE: f64 = 0.1;
    /// How many rings of triangles give way at most, and the rounds of averaging for each.
    const RINGS: usize = 4;
    const ROUNDS: usize = 8;
    for _ in 0..TOGETHER {
        let turned = turned_over(rest, moved);
        if turned.is_empty() {
            return;
        }
        for points in turned.into_iter().map(|triangle| rest.triangles[triangle]) {
            let points = points.map(|point| point as usize);
            let displacements = points.map(|point| moved.points[point] - rest.points[point]);
            let mean = displacements.into_iter().sum::<DVec3>() / 3.0;
            let change =
                displacements.map(|one| one.distance(mean)).into_iter().fold(0.0, f64::max);
            let [a, b, c] = points.map(|point| rest.points[point]);
            if change <= LITTLE * a.distance(b).max(b.distance(c)).max(c.distance(a)) {
                points.iter().for_each(|&point| moved.points[point] = rest.points[point] + mean);
            }
        }
    }
    for rings in 0..RINGS {
        let turned = turned_over(rest, moved);
        if turned.is_empty() {
            break;
        }
        let mut gives_way = vec![false; rest.points.len()];
        let corners = turned.iter().flat_map(|&triangle| rest.triangles[triangle]);
        corners.for_each(|point| gives_way[point as usize] = true);
        for _ in 0..rings {
            let inner = gives_way.clone();
            let is_next = |points: &&[u32; 3]| points.iter().any(|&point| inner[point as usize]);
            let next = rest.triangles.iter().filter(is_next).flatten();
            next.for_each(|&point| gives_way[point as usize] = true);
        }
        for _ in 0..ROUNDS {
            average(rest, moved, &gives_way);
        }
    }
}

/// Gives chosen points the mean displacement of their neighbours.
fn average(rest: &Shape, moved: &mut Shape, chosen: &[bool]) {
    let mut sums = vec![(DVec3::ZERO, 0.0); rest.points.len()];
    // Inner edges are in two triangles and count twice, which changes means at open edges alone.
    for points in &rest.triangles {
        for k in 0..3 {
            let [one, other] = [points[k], points[(k + 1) % 3]].map(|point| point as usize);
            for (at, neighbour) in [(one, other), (other, one)] {
                sums[at].0 += moved.points[neighbour] - rest.points[neighbour];
                sums[at].1 += 1.0;
            }
        }
    }
    for (index, (sum, count)) in sums.into_iter().enumerate().filter(|(index, _)| chosen[*index]) {
        moved.points[index] = rest.points[index] + sum / count;
    }
}

/// The triangles that were turned over.
pub(super) fn turned_over(rest: &Shape, moved: &Shape) -> Vec<usize> {
    let is_turned =
        |&triangle: &usize| rest.area_vector(triangle).dot(moved.area_vector(triangle)) < 0.0;
    (0..rest.triangles.len()).filter(is_turned).collect()
}

/// Marks the points of triangles that were turned over, and their neighbours where they are marked
/// already; returns whether any triangle is.
fn mark_turned_over(rest: &Shape, moved: &Shape, marks: &mut [bool]) -> bool {
    let turned = turned_over(rest, moved);
    let mut still = vec![false; marks.len()];
    for points in turned.iter().map(|&triangle| rest.triangles[triangle]) {
        let was_marked = points.iter().all(|&point| marks[point as usize]);
        for point in points {
            marks[point as usize] = true;
            still[point as usize] |= was_marked;
        }
    }
    for points in &rest.triangles {
        if points.iter().any(|&point| still[point as usize]) {
            points.iter().for_each(|&point| marks[point as usize] = true);
        }
    }
    !turned.is_empty()
}

/// The kind of each point.
fn of_points(shape: &Shape, kinds: &[TriangleKind]) -> Vec<TriangleKind> {
    let mut of_points = vec![None::<TriangleKind>; shape.points.len()];
    for (points, &kind) in shape.triangles.iter().zip(kinds) {
        for &point in points {
            let of_point = &mut of_points[point as usize];
            *of_point = Some(of_point.map_or(kind, |known| known.joined(kind)));
        }
    }
    of_points.into_iter().map(|kind| kind.unwrap_or(TriangleKind::ANY)).collect()
}

/// Each point's weight, and the displacement that takes it to its partner.
fn partners(
    rest: &Shape,
    moved: &Shape,
    kinds: &[TriangleKind],
    goal: &Goal,
    masses: &[f64],
) -> (Vec<f64>, Vec<DVec3>) {
    let normals = moved.normals();
    map_indices(rest.points.len(), |index| {
        let (point, normal) = (moved.points[index], normals[index]);
        let partner = goal.partner(kinds[index], point, normal, REACH, COMPATIBLE);
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
