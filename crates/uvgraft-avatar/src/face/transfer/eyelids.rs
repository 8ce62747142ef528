//! Lids that slide over the eyeballs.
//!
//! Gradients of a deformation say nothing about how far a lid is from an eyeball of another size, and
//! little about the narrow strips behind its margin. The anatomy does: the outside of a lid keeps its distance
//! from the eyeball, and its inside stays behind the margin, which turns about the eyeball's centre.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3, Vec3};
use uvgraft::Mesh;
use uvgraft::statistics::median;

use super::super::features::Face;
use super::super::surface::Spot;
use super::parts::Parts;
use crate::normals::vertex_normals;
use crate::ray::intersect;

/// Range of the distance of skin from an eyeball's centre, in radii: that of the lids' margins.
const CLEARANCE: [f64; 2] = [1.02, 1.15];
/// Skin that is farther away at rest is not that of a lid, in radii.
const REACH: f64 = 2.0;
/// How far margins may leave the eyeball, as a share of their distance from the centre; and how much farther
/// the skin beside them, for the square of its distance from them in radii.
const LIFT: f64 = 0.02;
const LOOSER: f64 = 2.0;
/// How far the inside of a lid may come forward of its place behind the outside, and towards the opening,
/// as shares of the least distance of skin from the eyeball's centre.
const FORWARD: f64 = 0.01;
const INTO_OPENING: f64 = 0.005;
/// Distance of the skin before a point of the eyeball, as a multiple of that point's distance.
const BEFORE: f32 = 1.01;
/// Where the skin is nearer to its margin's radius than this share, it is not behind it.
const BEHIND: f64 = 0.97;
/// Cosine between the normal and the direction from the eyeball, below which skin does not face outwards.
const OUTWARDS: f64 = 0.5;

/// The lids of one eye.
pub(super) struct Eyelids<'a> {
    rest: &'a [[f32; 3]],
    center: DVec3,
    /// Least distance from the centre, where skin is not nearer at rest.
    clearance: f64,
    /// The eyeball's vertices, with those of other shells around the same centre.
    ball: Vec<u32>,
    /// The middle of the opening, from the centre.
    opening: DVec3,
    /// Vertices of the outside.
    outside: Vec<u32>,
    /// How far each may leave the eyeball, as a share of its distance from the centre.
    lifts: Vec<f64>,
    /// Triangles of the outside into which the eyeball does not reach at rest.
    triangles: Vec<[u32; 3]>,
    /// Vertices of the inside, each with one of the outside that it lies behind.
    inside: Vec<(u32, u32)>,
}

impl<'a> Eyelids<'a> {
    /// The lids of the eyes that have an eyeball.
    pub fn find(mesh: &'a Mesh, face: &Face, parts: &Parts) -> Vec<Self> {
        let normals = vertex_normals(mesh.positions(), mesh.faces());
        let eyes = face.eyes.iter().filter_map(|eye| {
            let openings = eye.lids.iter().flat_map(|lid| [&lid.upper, &lid.lower]);
            Self::of(mesh, &normals, &openings.collect::<Vec<&Spot>>(), parts)
        });
        eyes.collect()
    }

    fn of(mesh: &'a Mesh, normals: &[Vec3], margins: &[&Spot], parts: &Parts) -> Option<Self> {
        let rest = mesh.positions();
        let places: Vec<DVec3> = margins.iter().map(|spot| spot.of(rest).as_dvec3()).collect();
        let middle = places.iter().sum::<DVec3>() / places.len() as f64;
        let near = |radius: f64, center: DVec3| center.distance(middle) < REACH * radius;
        let eye = parts.eyes.iter().filter(|eye| near(eye.radius, eye.center));
        let eye = eye.max_by(|a, b| a.radius.total_cmp(&b.radius))?;
        let (center, radius) = (eye.center, eye.radius);
        let shells = parts.eyes.iter().filter(|shell| shell.center == center);
        let mut ball: Vec<u32> = shells.flat_map(|shell| shell.vertices.iter().copied()).collect();
        ball.sort_unstable();
        let opening = middle - center;
        let margins: Vec<DVec3> = places.into_iter().map(|place| place - center).collect();
        let [least, most] = CLEARANCE.map(|share| share * radius);
        let clearance = median(margins.iter().map(|margin| margin.length()))?.clamp(least, most);

        let (mut outside, mut lifts, mut inside) = (Vec::new(), Vec::new(), Vec::new());
        for (vertex, place) in (0..).zip(rest) {
            let from = Vec3::from(*place).as_dvec3() - center;
            if from.length() > REACH * radius || ball.binary_search(&vertex).is_ok() {
                continue;
            }
            let cosine = |direction: DVec3| {
                normals[vertex as usize].as_dvec3().dot(direction.normalize_or_zero())
            };
            // Skin in a corner of the eye may face sideways, but it also faces forward.
            let cosine = cosine(from).max(cosine(opening));
            let by_distance =
                |a: &&DVec3, b: &&DVec3| a.distance(from).total_cmp(&b.distance(from));
            let nearest = margins.iter().min_by(by_distance)?;
            let is_behind = from.length() < BEHIND * nearest.length();
            if cosine > OUTWARDS || (cosine > 0.0 && !is_behind) {
                let apart = nearest.distance(from) / radius;
                lifts.push(LIFT + LOOSER * apart * apart);
                outside.push(vertex);
            } else if is_behind {
                inside.push(vertex);
            }
        }
        let inside = behind(mesh, &inside, &outside);
        let is_outside = |vertex: &u32| outside.binary_search(vertex).is_ok();
        let is_clear = |vertex: &u32| {
            let place = Vec3::from(rest[*vertex as usize]).as_dvec3();
            is_outside(vertex) && place.distance(center) > radius
        };
        let triangles = mesh.faces().iter().filter(|corners| corners.iter().all(is_clear));
        let triangles = triangles.copied().collect();
        let mut new =
            Self { rest, center, clearance, ball, opening, outside, lifts, triangles, inside };
        let reached = new.reached(&vec![[0.0; 3]; rest.len()], 0.0);
        let mut at_rest = reached.iter().map(Option::is_some);
        new.triangles.retain(|_| !at_rest.next().unwrap_or(false));
        Some(new)
    }

    fn at_rest(&self, vertex: u32) -> DVec3 {
        Vec3::from(self.rest[vertex as usize]).as_dvec3() - self.center
    }

    /// A vertex from the centre.
    ///
    /// - `weight`: of its offset.
    fn moved(&self, vertex: u32, offsets: &[[f32; 3]], weight: f32) -> DVec3 {
        let offset = Vec3::from(offsets[vertex as usize]);
        let at = Vec3::from(self.rest[vertex as usize]) + weight * offset;
        at.as_dvec3() - self.center
    }

    fn place(&self, vertex: u32, from_center: DVec3, offsets: &mut [[f32; 3]]) {
        let rest = Vec3::from(self.rest[vertex as usize]).as_dvec3();
        offsets[vertex as usize] = (from_center + self.center - rest).as_vec3().to_array();
    }

    /// Keeps the vertices of the outside out of the eyeball, where they do not lie in it at rest, and margins
    /// on it.
    pub fn clear(&self, offsets: &mut [[f32; 3]]) {
        for (&vertex, lift) in self.outside.iter().zip(&self.lifts) {
            if offsets[vertex as usize] == [0.0; 3] {
                continue;
            }
            let (near, moved) = (self.at_rest(vertex).length(), self.moved(vertex, offsets, 1.0));
            let least = near.min(self.clearance);
            let most = near.max(self.clearance) * (1.0 + lift);
            let far = moved.length();
            if far > 0.0 && !(least..=most).contains(&far) {
                self.place(vertex, moved * (far.clamp(least, most) / far), offsets);
            }
        }
    }

    /// Puts the outside before the eyeball, also between its vertices, where the cornea bulges and on the
    /// straight way from rest, and lets the inside follow the margins.
    pub fn settle(&self, offsets: &mut [[f32; 3]]) {
        const ROUNDS: usize = 3;
        /// Weights of the expression: a straight way is nearest to the eyeball in its middle.
        const WAY: [f32; 3] = [0.5, 0.75, 1.0];
        self.clear(offsets);
        for _ in 0..ROUNDS {
            let mut lifts = vec![0.0_f64; self.outside.len()];
            for weight in WAY {
                let reached = self.reached(offsets, weight);
                for (corners, factor) in self.triangles.iter().zip(reached) {
                    let Some(factor) = factor else { continue };
                    for vertex in corners {
                        let Ok(at) = self.outside.binary_search(vertex) else { continue };
                        let far = self.moved(*vertex, offsets, weight).length();
                        let lift = f64::from(factor - 1.0) * far / f64::from(weight);
                        lifts[at] = lifts[at].max(lift);
                    }
                }
            }
            if lifts.iter().all(|&lift| lift == 0.0) {
                break;
            }
            for (&vertex, lift) in self.outside.iter().zip(lifts) {
                if lift > 0.0 {
                    let moved = self.moved(vertex, offsets, 1.0);
                    self.place(vertex, moved + moved.normalize_or_zero() * lift, offsets);
                }
            }
        }
        self.follow(offsets);
    }

    /// For each triangle, the factor that puts it before the eyeball, if that reaches through it.
    ///
    /// - `weight`: of the offsets.
    fn reached(&self, offsets: &[[f32; 3]], weight: f32) -> Vec<Option<f32>> {
        /// A triangle farther behind the eyeball's surface is the far side of something.
        const DEEPEST: f32 = 0.7;
        let place = |vertex: u32| self.moved(vertex, offsets, weight).as_vec3();
        let ball: Vec<Vec3> = self.ball.iter().map(|&vertex| place(vertex)).collect();
        let reach = |corners: &[u32; 3]| {
            let corners = corners.map(place);
            let middle = corners.iter().sum::<Vec3>() / 3.0;
            let size = corners.iter().map(|at| at.distance(middle)).fold(0.0, f32::max);
            let mut most = None;
            for &point in &ball {
                if point.dot(middle) <= 0.0 || point.distance_squared(middle) > 4.0 * size * size {
                    continue;
                }
                let Some(hit) = intersect(Vec3::ZERO, point, &corners) else { continue };
                if (DEEPEST..BEFORE).contains(&hit.distance) {
                    most = Some((BEFORE / hit.distance).max(most.unwrap_or(1.0)));
                }
            }
            most
        };
        self.triangles.iter().map(reach).collect()
    }

    /// Keeps the inside behind the outside, which turns about the eyeball's centre.
    fn follow(&self, offsets: &mut [[f32; 3]]) {
        for &(vertex, margin) in &self.inside {
            let (before, after) = (self.at_rest(margin), self.moved(margin, offsets, 1.0));
            let turn = DQuat::from_rotation_arc(
                before.normalize_or(DVec3::Z),
                after.normalize_or(DVec3::Z),
            );
            let place = turn * self.at_rest(vertex) * (after.length() / before.length());
            let tangent = turn * (self.opening - before).reject_from(before);
            let mut moved = self.moved(vertex, offsets, 1.0);
            for (direction, most) in [(tangent, INTO_OPENING), (place, FORWARD)] {
                let direction = direction.normalize_or_zero();
                moved -=
                    direction * ((moved - place).dot(direction) - most * self.clearance).max(0.0);
            }
            self.place(vertex, moved, offsets);
        }
    }
}

/// For vertices of the inside that edges connect to the outside, a vertex of the outside: that of a neighbour,
/// the nearest of several.
fn behind(mesh: &Mesh, inside: &[u32], outside: &[u32]) -> Vec<(u32, u32)> {
    let place = |vertex: u32| Vec3::from(mesh.positions()[vertex as usize]);
    let mut margins: Vec<Option<u32>> = vec![None; mesh.positions().len()];
    outside.iter().for_each(|&vertex| margins[vertex as usize] = Some(vertex));
    let is_inside = |vertex: &u32| inside.binary_search(vertex).is_ok();
    let faces: Vec<&[u32; 3]> =
        mesh.faces().iter().filter(|corners| corners.iter().any(is_inside)).collect();
    loop {
        let mut found: BTreeMap<u32, u32> = BTreeMap::new();
        for corners in &faces {
            for &vertex in corners.iter().filter(|&vertex| is_inside(vertex)) {
                if margins[vertex as usize].is_some() {
                    continue;
                }
                let near = corners.iter().filter_map(|&other| margins[other as usize]);
                for margin in near {
                    let best = found.entry(vertex).or_insert(margin);
                    let apart = |margin: u32| place(margin).distance_squared(place(vertex));
                    if apart(margin) < apart(*best) {
                        *best = margin;
                    }
                }
            }
        }
        if found.is_empty() {
            break;
        }
        found.into_iter().for_each(|(vertex, margin)| margins[vertex as usize] = Some(margin));
    }
    inside.iter().filter_map(|&vertex| Some((vertex, margins[vertex as usize]?))).collect()
}
