//! The parts of a pixel that are shaded together.
//!
//! Coverage is known for 4 or 16 samples of a pixel, but colours vary much less: all samples that show
//! one face share a shading, and so do those that show neighbouring faces of one smooth surface.

use std::cmp::Reverse;

use super::geometry::Geometry;
use super::layers::Layers;
use super::samples::{EMPTY, Samples};

/// Faces are shaded together if the cosine between their normals is at least the root of this: 26°.
const ALIKE: f32 = 0.81;

/// Samples of a pixel, one bit each, row by row.
pub(crate) type Mask = u16;

/// Samples of a pixel that show one smooth surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Patch {
    /// The face that most of the samples show.
    pub face: u32,
    pub mask: Mask,
    /// Linear, multiplied by alpha; and alpha.
    pub color: [f32; 4],
}

/// The patches of one pixel, reused from pixel to pixel.
#[derive(Debug, Default)]
pub(crate) struct Patches {
    pub patches: Vec<Patch>,
    members: Vec<Member>,
    /// Empty if one face covers all of the pixel, without layers.
    pub stacks: Vec<Stack>,
}

/// Samples of a pixel that show the same faces, one behind another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stack {
    pub mask: Mask,
    /// One of the samples.
    pub at: (u32, u32),
    /// The opaque face, or [`EMPTY`].
    pub last: u32,
}

/// A face that shows in a pixel.
#[derive(Debug, Clone, Copy)]
struct Member {
    face: u32,
    mask: Mask,
    patch: usize,
}

impl Patches {
    /// Finds the patches of a pixel whose first sample is `(left, top)`.
    ///
    /// - `layers`: if any of the pixel's samples has some.
    pub fn find(
        &mut self,
        geometry: &Geometry,
        opaque: &Samples,
        layers: Option<&Layers>,
        (left, top): (u32, u32),
        samples: u32,
    ) {
        self.patches.clear();
        self.members.clear();
        self.stacks.clear();
        let first = opaque.faces(left, top, 1)[0];
        let mut rows = (top..top + samples).map(|y| opaque.faces(left, y, samples));
        if layers.is_none() && rows.all(|row| row.iter().all(|&face| face == first)) {
            if first != EMPTY {
                let mask = full(samples);
                self.patches.push(Patch { face: first, mask, color: [0.0; 4] });
            }
            return;
        }
        for (row, y) in (top..top + samples).enumerate() {
            for (column, &face) in opaque.faces(left, y, samples).iter().enumerate() {
                let bit = 1 << (row * samples as usize + column);
                let at = (left + column as u32, y);
                let known = self.stacks.iter_mut().find(|stack| {
                    stack.last == face && layers.is_none_or(|layers| layers.same(stack.at, at))
                });
                match known {
                    Some(stack) => stack.mask |= bit,
                    None => self.stacks.push(Stack { mask: bit, at, last: face }),
                }
            }
        }
        for index in 0..self.stacks.len() {
            let Stack { mask, at: (x, y), last } = self.stacks[index];
            self.show(last, mask);
            if let Some(layers) = layers {
                layers.over(x, y).for_each(|face| self.show(face, mask));
            }
        }
        // The largest first, as faces that represent a patch.
        self.members.sort_by_key(|member| Reverse(member.mask.count_ones()));
        for index in 0..self.members.len() {
            let (known, rest) = self.members.split_at_mut(index);
            let member = &mut rest[0];
            let neighbour = known.iter().find(|known| {
                let representative = self.patches[known.patch].face;
                adjoin(geometry, known.face, member.face)
                    && alike(geometry, representative, member.face)
            });
            if let Some(neighbour) = neighbour {
                member.patch = neighbour.patch;
                self.patches[member.patch].mask |= member.mask;
            } else {
                member.patch = self.patches.len();
                let Member { face, mask, .. } = *member;
                self.patches.push(Patch { face, mask, color: [0.0; 4] });
            }
        }
    }

    fn show(&mut self, face: u32, mask: Mask) {
        if face == EMPTY {
            return;
        }
        match self.members.iter_mut().find(|member| member.face == face) {
            Some(member) => member.mask |= mask,
            None => self.members.push(Member { face, mask, patch: 0 }),
        }
    }

    /// The colour of the patch that a face belongs to, in a pixel with more than one face.
    pub fn color_of(&self, face: u32) -> Option<[f32; 4]> {
        let member = self.members.iter().find(|member| member.face == face)?;
        Some(self.patches[member.patch].color)
    }
}

/// All samples of a pixel.
pub(crate) const fn full(samples: u32) -> Mask {
    ((1_u32 << (samples * samples)) - 1) as Mask
}

/// Whether two faces of one surface share a corner, with its texture coordinates. They then meet, and
/// neither is in front of the other.
fn adjoin(geometry: &Geometry, a: u32, b: u32) -> bool {
    let (a, b) = (geometry.faces[a as usize], geometry.faces[b as usize]);
    let share = |k: usize| (0..3).any(|l| a.vertices[k] == b.vertices[l] && a.uv[k] == b.uv[l]);
    a.surface == b.surface && (0..3).any(share)
}

/// Whether the normals of two faces are alike.
fn alike(geometry: &Geometry, a: u32, b: u32) -> bool {
    let (a, b) = (geometry.normal_of(a as usize), geometry.normal_of(b as usize));
    let cosine = a.dot(b);
    cosine > 0.0 && cosine * cosine >= ALIKE * a.dot(a) * b.dot(b)
}

/// Places in a patch at which its textures are sampled: the centroid of its samples in each quarter
/// of the pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Tap {
    /// In samples, from the centroid of the patch.
    pub offset: [f64; 2],
    /// Its share of the patch.
    pub share: f32,
}

/// The centroid of a patch, in samples from the corner of the pixel, and up to four taps.
pub(crate) fn taps(mask: Mask, samples: u32) -> ([f64; 2], [Tap; 4], usize) {
    let half = f64::from(samples) * 0.5;
    if mask == full(samples) {
        let at = |x: f64, y: f64| Tap { offset: [x * half, y * half], share: 0.25 };
        return ([half; 2], [at(-0.5, -0.5), at(0.5, -0.5), at(-0.5, 0.5), at(0.5, 0.5)], 4);
    }
    let (mut taps, mut used) = ([Tap::default(); 4], 0);
    let mut centre = [0.0; 2];
    let total = f64::from(mask.count_ones());
    for quarter in 0..4 {
        let (left, top) = (quarter % 2 * (samples / 2), quarter / 2 * (samples / 2));
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for (x, y) in
            (0..samples * samples / 4).map(|k| (left + k % (samples / 2), top + k / (samples / 2)))
        {
            if mask >> (y * samples + x) & 1 == 1 {
                sum = [sum[0] + f64::from(x) + 0.5, sum[1] + f64::from(y) + 0.5];
                count += 1.0;
            }
        }
        if count > 0.0 {
            centre = [centre[0] + sum[0] / total, centre[1] + sum[1] / total];
            let share = (count / total) as f32;
            taps[used] = Tap { offset: sum.map(|sum| sum / count), share };
            used += 1;
        }
    }
    for tap in &mut taps[..used] {
        tap.offset = [tap.offset[0] - centre[0], tap.offset[1] - centre[1]];
    }
    (centre, taps, used)
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, vec3};
    use uvgraft::Size;

    use super::*;
    use crate::camera::Camera;
    use crate::depth::{Drawing, Whole};
    use crate::geometry::Face;
    use crate::projection::project;

    /// Two triangles that meet along `x = 0`, with their outer corners `rise` higher, 20 away.
    fn roof(rise: f32) -> Geometry {
        let faces = [[0, 1, 2], [1, 0, 3]];
        Geometry {
            positions: vec![
                vec3(0.0, -90.0, 0.0),
                vec3(0.0, 90.0, 0.0),
                vec3(-20.0, 0.0, rise),
                vec3(20.0, 0.0, rise),
            ],
            faces: faces.map(|vertices| Face { vertices, uv: vertices, surface: 0 }).to_vec(),
            ..Geometry::default()
        }
    }

    /// Masks of the patches in a pixel whose first column of samples shows face 0, from face to face.
    fn found(geometry: &Geometry, layered: bool) -> Vec<(u32, Mask)> {
        let size = Size::square(4);
        let camera = Camera::looking(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), 1.0, size);
        let homogeneous = camera.all_homogeneous(&geometry.positions);
        let drawing = |is_drawn: bool| {
            Drawing::new(project(&camera, geometry, &homogeneous, size, |_| is_drawn), size)
        };
        let (mut opaque, mut layers, mut patches) =
            (Samples::default(), Layers::default(), Patches::default());
        opaque.draw(&drawing(!layered), 0, f32::NEG_INFINITY, &Whole);
        layers.draw(&drawing(layered), 0, f32::NEG_INFINITY, &opaque);
        patches.find(geometry, &opaque, layered.then_some(&layers), (0, 0), 4);
        // What is said of faces is what is said of their patches.
        for (k, patch) in patches.patches.iter_mut().enumerate() {
            patch.color = [k as f32; 4];
        }
        for patch in &patches.patches {
            if patches.patches.len() > 1 {
                assert_eq!(patches.color_of(patch.face), Some(patch.color));
            }
        }
        let stacked = patches.stacks.iter().fold(0, |all, stack| all | stack.mask);
        assert_eq!(stacked, 0xffff);
        let mut found: Vec<_> = patches.patches.iter().map(|p| (p.face, p.mask)).collect();
        found.sort_unstable();
        found
    }

    #[test]
    fn faces_of_one_smooth_surface_make_one_patch() {
        let (left, right, all) = (0x1111, 0xeeee, 0xffff);
        for layered in [false, true] {
            // The larger part represents the patch. Slopes of 4 : 20 are 22.6° apart, of 5 : 20 28°.
            for rise in [0.0, 4.0, -4.0] {
                assert_eq!(found(&roof(rise), layered), [(1, all)], "{rise}");
            }
            for rise in [5.0, -5.0, 40.0] {
                assert_eq!(found(&roof(rise), layered), [(0, left), (1, right)], "{rise}");
            }
            let apart = |change: fn(&mut Geometry)| {
                let mut geometry = roof(0.0);
                geometry.positions.extend([0, 1].map(|k| geometry.positions[k]));
                change(&mut geometry);
                assert_eq!(found(&geometry, layered), [(0, left), (1, right)]);
            };
            // Another surface, a seam in the texture, corners at the same place that are not shared.
            apart(|geometry| geometry.faces[1].surface = 1);
            apart(|geometry| geometry.faces[1].uv = [5, 4, 3]);
            apart(|geometry| geometry.faces[1].vertices = [5, 4, 3]);
        }
    }

    #[test]
    fn samples_with_the_same_faces_make_one_stack() {
        // A square in front of another one, both translucent, over the right half only.
        let corners =
            |x: f32, z: f32| [[x, -9.0], [x + 99.0, -9.0], [x, 99.0]].map(|[x, y]| vec3(x, y, z));
        let positions: Vec<Vec3> = [corners(-9.0, 0.0), corners(0.0, 1.0)].concat();
        let faces = [[0, 1, 2], [3, 4, 5]];
        let faces = faces.map(|vertices| Face { vertices, uv: vertices, surface: 0 }).to_vec();
        let geometry = Geometry { positions, faces, ..Geometry::default() };
        let size = Size::square(4);
        let camera = Camera::looking(vec3(0.0, 0.0, 1.0), Vec3::default(), 1.0, size);
        let homogeneous = camera.all_homogeneous(&geometry.positions);
        let drawing = |is_drawn: bool| {
            Drawing::new(project(&camera, &geometry, &homogeneous, size, |_| is_drawn), size)
        };
        let (mut opaque, mut layers) = (Samples::default(), Layers::default());
        opaque.draw(&drawing(false), 0, f32::NEG_INFINITY, &Whole);
        layers.draw(&drawing(true), 0, f32::NEG_INFINITY, &opaque);
        let mut patches = Patches::default();
        patches.find(&geometry, &opaque, Some(&layers), (0, 0), 4);
        let over = |stack: &Stack| layers.over(stack.at.0, stack.at.1).collect::<Vec<_>>();
        let stacks: Vec<_> = patches.stacks.iter().map(|stack| (stack.mask, over(stack))).collect();
        assert_eq!(stacks, [(0x3333, vec![0]), (0xcccc, vec![0, 1])]);
        assert!(patches.stacks.iter().all(|stack| stack.last == EMPTY));
    }
}
