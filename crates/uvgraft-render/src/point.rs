//! A point of a face, and its textures there.

use glam::Vec3;

use super::camera::Homogeneous;
use super::geometry::Geometry;
use super::mipmap::Footprint;
use super::projection::Weights;
use super::tangents::Tangent;

/// A point of a face, by its barycentric weights.
#[derive(Clone, Copy)]
pub(crate) struct Point<'a> {
    geometry: &'a Geometry,
    pub face: u32,
    weights: [f32; 3],
    /// What the weights change by across the texture footprint, to the right and downwards.
    steps: [[f32; 3]; 2],
    /// The corners of the face in the first set of texture coordinates, and what those change by
    /// across the footprint.
    uv: [[f32; 2]; 3],
    along: [[f32; 2]; 2],
}

impl<'a> Point<'a> {
    /// The point that is visible at a sample, and the weights around it.
    ///
    /// - `step`: width of the texture footprint, in samples.
    pub fn new(
        geometry: &'a Geometry,
        homogeneous: &[Homogeneous],
        face: u32,
        at: [f64; 2],
        step: f64,
    ) -> Option<(Self, Weights)> {
        let corners =
            geometry.faces[face as usize].vertices.map(|vertex| homogeneous[vertex as usize]);
        let around = Weights::new(corners, at);
        let here = around.at([0.0; 2])?;
        // Beyond the face's horizon the weights belong to a point behind the camera. Exactly on it
        // they are not finite: the footprint then has no extent in that direction.
        let steps = [[step, 0.0], [0.0, step]].map(|offset| {
            let there = around.at(offset).unwrap_or(here);
            [0, 1, 2].map(|k| there[k] - here[k])
        });
        let uv = geometry.corner_uv(face as usize, 0);
        let along = steps.map(|step| mixed_uv(&uv, step));
        Some((Self { geometry, face, weights: here, steps, uv, along }, around))
    }

    /// Another point of the face, with a footprint of the same size.
    pub fn moved(&self, weights: [f32; 3]) -> Self {
        Self { weights, ..*self }
    }

    /// The same point with a footprint of another size.
    pub fn scaled(&self, factor: f32) -> Self {
        let steps = self.steps.map(|step| step.map(|weight| weight * factor));
        Self { steps, along: self.along.map(|along| along.map(|uv| uv * factor)), ..*self }
    }

    fn vertices(&self) -> [usize; 3] {
        self.geometry.faces[self.face as usize].vertices.map(|vertex| vertex as usize)
    }

    pub fn position(&self) -> Vec3 {
        mixed(self.vertices(), &self.geometry.positions, self.weights)
    }

    /// Not of unit length.
    pub fn normal(&self) -> Vec3 {
        mixed(self.vertices(), &self.geometry.normals, self.weights)
    }

    /// The square of what the normal changes by across the footprint.
    pub fn bend(&self) -> f32 {
        let vertices = self.vertices();
        let along = |step| {
            let change = mixed(vertices, &self.geometry.normals, step);
            change.dot(change)
        };
        along(self.steps[0]) + along(self.steps[1])
    }

    pub fn tangent(&self, tangents: &[Tangent]) -> Tangent {
        let [a, b, c] = self.vertices().map(|vertex| tangents[vertex]);
        let weights = self.weights;
        // Handedness is not interpolated: where corners differ, the first one's is used.
        (a.0 * weights[0] + b.0 * weights[1] + c.0 * weights[2], a.1)
    }

    /// The footprint in the texture.
    pub fn footprint(&self, coordinates: usize) -> Footprint {
        if coordinates == 0 {
            let [along_x, along_y] = self.along;
            return Footprint { uv: mixed_uv(&self.uv, self.weights), along_x, along_y };
        }
        let corners = self.geometry.corner_uv(self.face as usize, coordinates);
        let [along_x, along_y] = self.steps.map(|step| mixed_uv(&corners, step));
        Footprint { uv: mixed_uv(&corners, self.weights), along_x, along_y }
    }

    /// A colour multiplied by the vertices' colours.
    pub fn tinted(&self, color: [f32; 4]) -> [f32; 4] {
        if self.geometry.colors.is_empty() {
            return color;
        }
        let corners = self.vertices().map(|vertex| self.geometry.colors[vertex]);
        [0, 1, 2, 3]
            .map(|k| color[k] * (0..3).map(|at| self.weights[at] * corners[at][k]).sum::<f32>())
    }
}

fn mixed_uv([a, b, c]: &[[f32; 2]; 3], weights: [f32; 3]) -> [f32; 2] {
    [0, 1].map(|k| weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k])
}

fn mixed([a, b, c]: [usize; 3], values: &[Vec3], weights: [f32; 3]) -> Vec3 {
    values[a] * weights[0] + values[b] * weights[1] + values[c] * weights[2]
}
