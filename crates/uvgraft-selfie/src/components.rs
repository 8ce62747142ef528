//! The connected parts of a head: its skin, and what lies loose in it, such as eyeballs and teeth.

use std::collections::HashMap;

use glam::DVec3;
use uvgraft::{Anatomy, Landmark, Mesh};
use uvgraft_avatar::eyes::eyeball::pieces;

/// An eyeball.
#[derive(Debug, Clone, PartialEq)]
pub struct Eyeball {
    /// Its centre in the mesh's space.
    pub center: DVec3,
    /// In the mesh's unit.
    pub radius: f64,
    /// Its vertices.
    pub vertices: Vec<u32>,
}

/// The connected parts of a mesh. Vertices at the same position are connected.
#[derive(Debug, Clone)]
pub struct Components {
    /// The component of each vertex.
    pub of_vertex: Vec<u32>,
    /// The vertices of each component that has triangles.
    pub vertices: Vec<Vec<u32>>,
    /// The component with the tip of the nose.
    pub skin: u32,
    /// Components that are eyeballs, the left one first; none if there are not two.
    pub eyeballs: Vec<Eyeball>,
}

impl Components {
    /// Finds the connected parts of a mesh with a head.
    pub fn new(mesh: &Mesh, anatomy: &Anatomy) -> Self {
        let labels = pieces(mesh);
        let mut numbers = HashMap::new();
        let mut of_vertex = Vec::with_capacity(mesh.positions().len());
        let mut vertices: Vec<Vec<u32>> = Vec::new();
        for (vertex, label) in (0..).zip(labels) {
            let next = numbers.len() as u32;
            let number = *numbers.entry(label).or_insert(next);
            if number as usize == vertices.len() {
                vertices.push(Vec::new());
            }
            vertices[number as usize].push(vertex);
            of_vertex.push(number);
        }
        let mut found = Self { of_vertex, vertices, skin: 0, eyeballs: Vec::new() };
        found.skin = found.nearest(mesh, anatomy, Landmark::NoseTip);
        found.eyeballs = found.eyeballs(mesh, anatomy);
        found
    }

    /// Whether a triangle belongs to an eyeball.
    pub fn is_eye(&self, mesh: &Mesh, face: u32) -> bool {
        let part = |vertex: u32| self.of_vertex[vertex as usize];
        let own = part(mesh.faces()[face as usize][0]);
        self.eyeballs.iter().any(|ball| ball.vertices.first().is_some_and(|&at| part(at) == own))
    }

    fn nearest(&self, mesh: &Mesh, anatomy: &Anatomy, landmark: Landmark) -> u32 {
        let Some(at) = anatomy.point(landmark).map(DVec3::from) else { return 0 };
        let used = mesh.faces().as_flattened().iter();
        let distance = |vertex: u32| position(mesh, vertex).distance_squared(at);
        used.copied()
            .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
            .map_or(0, |vertex| self.of_vertex[vertex as usize])
    }

    /// Components all of whose vertices are at about one distance from the centre of an eye.
    fn eyeballs(&self, mesh: &Mesh, anatomy: &Anatomy) -> Vec<Eyeball> {
        /// Largest radius, in distances between the eyes: a fifth is usual.
        const LARGEST: f64 = 0.35;
        let unit = anatomy.frame().unit;
        let of_eye = |landmark: Landmark| {
            let near = DVec3::from(anatomy.point(landmark)?);
            let candidates =
                self.vertices.iter().enumerate().filter(|(number, vertices)| {
                    *number as u32 != self.skin && vertices.len() >= 12
                });
            let balls = candidates.filter_map(|(_, vertices)| {
                let center = vertices.iter().map(|&at| position(mesh, at)).sum::<DVec3>()
                    / vertices.len() as f64;
                // The mean of a cap is off its centre; the landmark is not.
                let center = if center.distance(near) < 0.1 * unit { center } else { near };
                let distances = vertices.iter().map(|&at| position(mesh, at).distance(center));
                let radius = distances.fold(0.0, f64::max);
                let is_near =
                    vertices.iter().all(|&at| position(mesh, at).distance(near) < LARGEST * unit);
                is_near.then(|| Eyeball { center, radius, vertices: vertices.clone() })
            });
            balls.max_by_key(|ball| ball.vertices.len())
        };
        let both = [Landmark::LeftEye, Landmark::RightEye].into_iter().filter_map(of_eye);
        let both: Vec<Eyeball> = both.collect();
        if both.len() == 2 { both } else { Vec::new() }
    }
}

fn position(mesh: &Mesh, vertex: u32) -> DVec3 {
    glam::Vec3::from(mesh.positions()[vertex as usize]).as_dvec3()
}
