//! What a head wears: hair, glasses, hats and clothes that are components of their own, over the skin.

use crate::anatomy::{Anatomy, Area, Ball, HeadFrame};
use crate::disjoint::DisjointSets;
use crate::mesh::Mesh;
use crate::triangle_tree::Effort;

use glam::DVec3;

use super::register::Goal;
use super::shape::Shape;

/// For each triangle, whether it is worn: part of a component that lies over the skin of the head. Ears
/// and eyeballs are not.
pub(super) fn worn(mesh: &Mesh, shape: &Shape, anatomy: &Anatomy, balls: &[Ball]) -> Vec<bool> {
    let mut is_worn = vec![false; shape.triangles.len()];
    let is_skin = |triangle: usize| anatomy.skin()[mesh.faces()[triangle][0] as usize];
    let mut is_other: Vec<bool> = (0..is_worn.len()).map(|triangle| !is_skin(triangle)).collect();
    let eyes = balls.iter().filter(|ball| is_eye(ball, anatomy.frame()));
    eyes.flat_map(|ball| &ball.faces).for_each(|&face| is_other[face as usize] = false);
    if !is_other.contains(&true) {
        return is_worn;
    }
    let skin: Vec<usize> = (0..is_worn.len()).filter(|&triangle| is_skin(triangle)).collect();
    let below = Below::new(shape, &skin);
    for component in components(shape, &is_other) {
        if !is_ear(mesh, &component, anatomy) && below.is_below(shape, &component) {
            component.into_iter().for_each(|triangle| is_worn[triangle] = true);
        }
    }
    is_worn
}

/// Whether a component is an ear, and no strand of hair beside it.
fn is_ear(mesh: &Mesh, component: &[usize], anatomy: &Anatomy) -> bool {
    /// Strands have up to about 40 triangles, and modelled ears a few hundred.
    const LEAST: usize = 60;
    let weights = anatomy.area(Area::Ears);
    let is_there = |&&triangle: &&usize| {
        mesh.faces()[triangle].iter().any(|&vertex| weights[vertex as usize] > 0.5)
    };
    let there = component.iter().filter(is_there).count();
    component.len() >= LEAST && 2 * there > component.len()
}

/// Whether a ball is an eyeball: caps of hair, buns and earrings are balls as well.
fn is_eye(ball: &Ball, frame: &HeadFrame) -> bool {
    /// In distances between the eyes, whose radius is about a fifth of it, at most a third.
    const NEAR: f64 = 0.35;
    const LARGEST: f64 = 0.45;
    let at = DVec3::from(frame.local(ball.center.to_array()));
    let is_near = |side: f64| at.distance(DVec3::X * side) < NEAR;
    ball.radius < LARGEST * frame.unit && (is_near(0.5) || is_near(-0.5))
}

/// How many connected components a shape has.
pub(super) fn component_count(shape: &Shape) -> usize {
    components(shape, &vec![true; shape.triangles.len()]).len()
}

/// The chosen triangles by component.
fn components(shape: &Shape, chosen: &[bool]) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(shape.points.len() as u32);
    let triangles = || (0..chosen.len()).filter(|&triangle| chosen[triangle]);
    for [a, b, c] in triangles().map(|triangle| shape.triangles[triangle]) {
        sets.join(a, b);
        sets.join(a, c);
    }
    let mut number = vec![usize::MAX; shape.points.len()];
    let mut components: Vec<Vec<usize>> = Vec::new();
    for triangle in triangles() {
        let number = &mut number[sets.root(shape.triangles[triangle][0]) as usize];
        if *number == usize::MAX {
            *number = components.len();
            components.push(Vec::new());
        }
        components[*number].push(triangle);
    }
    components
}

/// The skin, as what lies over it is seen from.
struct Below {
    goal: Goal,
}

impl Below {
    fn new(shape: &Shape, skin: &[usize]) -> Self {
        let triangles = skin.iter().map(|&triangle| shape.triangles[triangle]).collect();
        let effort = Effort::unlimited();
        Self { goal: Goal::new(Shape { points: shape.points.clone(), triangles }, &effort) }
    }

    /// Whether the skin is below some triangles: its closest point is not on an open edge, and faces
    /// them.
    fn is_below(&self, shape: &Shape, triangles: &[usize]) -> bool {
        const SAMPLES: usize = 200;
        /// Part of a strand of hair may lie below the skin, or beyond its end. Parts that continue the
        /// skin lie beyond its end altogether.
        const LEAST: f64 = 0.25;
        /// Cosine between the skin's normal and the direction to what lies over it: 60°.
        const OVER: f64 = 0.5;
        let samples: Vec<&usize> =
            triangles.iter().step_by(triangles.len().div_ceil(SAMPLES)).collect();
        let is_over = |&&&triangle: &&&usize| {
            let center = shape.corners(triangle).into_iter().sum::<DVec3>() / 3.0;
            let Some(nearest) = self.goal.tree.nearest(center, f64::INFINITY, |_| true) else {
                return false;
            };
            let up = (center - nearest.point).normalize_or_zero();
            let normal = self.goal.face_normals[nearest.triangle as usize];
            !self.goal.is_at_border(&nearest) && normal.dot(up) > OVER
        };
        samples.iter().filter(is_over).count() as f64 > LEAST * samples.len() as f64
    }
}
