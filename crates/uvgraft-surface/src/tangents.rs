//! Tangent frames: the axes that the three channels of a normal map refer to.
//!
//! Based on Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008), known as MikkTSpace, in
//! the implementation of the crate `bevy_mikktspace`. Blender, Substance, Marmoset, xNormal, Unity
//! and Unreal bake and render with it, and glTF 2.0 requires it for files without tangents.
//!
//! Conventions, all of them common:
//! - `v` grows upwards here, as in OBJ, Blender and OpenGL: MikkTSpace gets `1 − v` of a [`Mesh`].
//!   The tangent then points along `u`, the bitangent towards the top of the image. With `v`
//!   downwards the tangents would be the same and all bitangents reversed.
//! - The bitangent is `sign · cross(normal, tangent)`, with sign 1 where a chart is not mirrored.
//! - Green is the component along the bitangent ("OpenGL", "+Y"). glTF does the same: it stores
//!   `1 − v` and the sign of the upright layout (`w`), and specifies green as up. "DirectX" ("−Y")
//!   files have the same frames with green inverted.
//! - Between corners, normal and tangent are interpolated linearly and not normalised; the
//!   bitangent is computed from the result. Bakers invert exactly that, so decoding must do it too.
//!
//! A [`Mesh`] has no normals. Vertex normals are smooth everywhere, weighted by angle (Thürmer and
//! Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998).

use std::collections::HashMap;
use std::hash::Hash;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DVec3, Vec3};

use crate::directions::{direction, perpendicular};
use crate::mesh::{Mesh, bits_of};
use crate::threads::map_indices;

/// MikkTSpace compares the triangles around a vertex pairwise and recursively. Triangles at
/// vertices with more corners than this get their own frame instead.
const MAX_CORNERS: u32 = 1024;

/// A tangent frame at the corner of a triangle, in the mesh's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentFrame {
    /// Smooth unit vertex normal.
    pub normal: [f32; 3],
    /// Unit tangent along `u`, perpendicular to the normal.
    pub tangent: [f32; 3],
    /// Sign of the bitangent `sign · cross(normal, tangent)`: 1, or −1 where a chart is mirrored.
    /// The same at all corners of a triangle that has area.
    pub sign: f32,
}

/// The tangent frames of all corners of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct TangentFrames {
    faces: Vec<[TangentFrame; 3]>,
}

impl TangentFrames {
    /// Computes normals and tangents of a mesh.
    ///
    /// Every corner gets a frame. If a vertex has no normal, because the triangles around it have
    /// no area or cancel out, its corners take the normals of their triangles, or else +Z. Where
    /// MikkTSpace gives no tangent (triangles without UV area that are not connected to others, or
    /// more than 1024 corners around a vertex), the tangent is the triangle's own direction of `u`;
    /// if that does not exist either, any direction perpendicular to the normal, with the sign 1.
    pub fn new(mesh: &Mesh) -> Self {
        let welded = Welded::new(mesh);
        let normals = corner_normals(mesh, &welded);
        let mut faces = map_indices(mesh.faces().len(), |face| {
            let own = own_tangent(mesh, face);
            normals[face].map(|normal| framed(normal, own))
        });
        Surface::new(mesh, &welded, &mut faces).generate();
        Self { faces }
    }

    /// As [`TangentFrames::new`], with the normals that the mesh is rendered with.
    ///
    /// - `normals`: `[vertices]`, not necessarily normalised. A vertex whose normal is missing,
    ///   zero or not finite keeps its smooth one.
    pub fn with_normals(mesh: &Mesh, normals: &[[f32; 3]]) -> Self {
        let welded = Welded::new(mesh);
        let smooth = corner_normals(mesh, &welded);
        let shown = |vertex: u32| direction(dvec3(*normals.get(vertex as usize)?));
        let mut faces = map_indices(mesh.faces().len(), |face| {
            let own = own_tangent(mesh, face);
            let corners = mesh.faces()[face];
            [0, 1, 2].map(|k| framed(shown(corners[k]).unwrap_or(smooth[face][k]), own))
        });
        Surface::new(mesh, &welded, &mut faces).generate();
        Self { faces }
    }

    /// `[triangles]`, corner by corner as [`Mesh::faces`].
    pub fn faces(&self) -> &[[TangentFrame; 3]] {
        &self.faces
    }
}

/// Vertices merged by position, whether UV seams or the file format split them.
struct Welded {
    /// Welded vertex of each corner of each triangle.
    corners: Vec<[u32; 3]>,
    count: usize,
}

impl Welded {
    fn new(mesh: &Mesh) -> Self {
        let mut ids = Ids::default();
        let vertices: Vec<u32> =
            mesh.positions().iter().map(|&position| ids.id(bits_of(position))).collect();
        let corners =
            mesh.faces().iter().map(|face| face.map(|vertex| vertices[vertex as usize])).collect();
        Self { corners, count: ids.0.len() }
    }

    fn is_collapsed(&self, face: usize) -> bool {
        let [a, b, c] = self.corners[face];
        a == b || b == c || c == a
    }
}

/// Assigns consecutive indices in order of first appearance.
struct Ids<K>(HashMap<K, u32>);

impl<K> Default for Ids<K> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<K: Hash + Eq> Ids<K> {
    fn id(&mut self, key: K) -> u32 {
        let next = self.0.len() as u32;
        *self.0.entry(key).or_insert(next)
    }
}

fn dvec3(vector: [f32; 3]) -> DVec3 {
    Vec3::from(vector).as_dvec3()
}

/// The positions of a triangle's corners.
pub fn corner_positions(mesh: &Mesh, face: usize) -> [DVec3; 3] {
    mesh.faces()[face].map(|vertex| dvec3(mesh.positions()[vertex as usize]))
}

/// Smooth normals of all corners: the sum of the unit normals around a welded vertex, each weighted
/// by the triangle's angle there, so that the triangulation of flat areas does not matter. Corners
/// without one take the normal of their triangle, or else +Z.
fn corner_normals(mesh: &Mesh, welded: &Welded) -> Vec<[DVec3; 3]> {
    // The unit normal of each triangle, and its angles.
    let own: Vec<Option<(DVec3, [f64; 3])>> = map_indices(mesh.faces().len(), |face| {
        let corners = corner_positions(mesh, face);
        let [p, q] = [1, 2].map(|k| corners[k] - corners[0]);
        let normal = direction(p.cross(q))?;
        let angles = [0, 1, 2].map(|k| {
            let [p, q] = [1, 2].map(|step| corners[(k + step) % 3] - corners[k]);
            p.cross(q).length().atan2(p.dot(q))
        });
        Some((normal, angles))
    });
    // In the order of the triangles, so that sums do not depend on threads.
    let mut sums = vec![DVec3::ZERO; welded.count];
    for (vertices, own) in welded.corners.iter().zip(&own) {
        let Some((normal, angles)) = own else { continue };
        for (&vertex, &angle) in vertices.iter().zip(angles) {
            sums[vertex as usize] += *normal * angle;
        }
    }
    let smooth = map_indices(sums.len(), |vertex| {
        // The remainder of normals that cancel out is rounding error.
        direction(sums[vertex]).filter(|_| sums[vertex].length_squared() > 1e-12)
    });
    map_indices(own.len(), |face| {
        let own = own[face].map(|(normal, _)| normal);
        welded.corners[face].map(|vertex| smooth[vertex as usize].or(own).unwrap_or(DVec3::Z))
    })
}

/// The direction of growing `u` on a triangle, and −1 if its chart is mirrored, else 1; `None` if
/// `u` is constant or the triangle degenerate.
fn own_tangent(mesh: &Mesh, face: usize) -> Option<(DVec3, f32)> {
    let corners = corner_positions(mesh, face);
    let [p, q] = [1, 2].map(|k| corners[k] - corners[0]);
    let uv = mesh.uv_triangle(face).map(|[u, v]| [f64::from(u), -f64::from(v)]);
    let [s, t] = [1, 2].map(|k| [uv[k][0] - uv[0][0], uv[k][1] - uv[0][1]]);
    let area = s[0] * t[1] - s[1] * t[0];
    let sign = if area < 0.0 { -1.0 } else { 1.0 };
    // `∂p/∂u` of the triangle, up to a positive factor.
    let along: DVec3 = [p * (t[1] * sign), q * (-s[1] * sign)].iter().sum();
    Some((direction(along)?, sign as f32))
}

fn framed(normal: DVec3, own: Option<(DVec3, f32)>) -> TangentFrame {
    let projected = own.and_then(|(along, sign)| {
        let across = along - normal * along.dot(normal);
        // The remainder of a tangent parallel to the normal is rounding error.
        let across = direction(across).filter(|_| across.length_squared() > 1e-12)?;
        Some((across, sign))
    });
    let (tangent, sign) = projected.unwrap_or_else(|| (perpendicular(normal), 1.0));
    let single = |vector: DVec3| vector.as_vec3().to_array();
    TangentFrame { normal: single(normal), tangent: single(tangent), sign }
}

/// Adapter for MikkTSpace; `frames` already hold the normals.
struct Surface<'a> {
    mesh: &'a Mesh,
    /// Scales positions to about 1, so that their squares and products stay within the range of
    /// `f32`. A power of two, hence exact. Tangents do not depend on scale.
    scale: f32,
    frames: &'a mut [[TangentFrame; 3]],
    /// The triangles given to MikkTSpace.
    sound: Vec<u32>,
    /// Triangles with coincident vertices, which copy frames from the others.
    collapsed: Vec<u32>,
}

impl<'a> Surface<'a> {
    fn new(mesh: &'a Mesh, welded: &Welded, frames: &'a mut [[TangentFrame; 3]]) -> Self {
        let mut uses = vec![0; welded.count];
        for &vertex in welded.corners.as_flattened() {
            uses[vertex as usize] += 1;
        }
        let is_crowded =
            |face: usize| welded.corners[face].iter().any(|&v| uses[v as usize] > MAX_CORNERS);
        let faces = (0..mesh.faces().len()).filter(|&face| !is_crowded(face));
        // MikkTSpace searches the whole mesh for each corner of a collapsed triangle.
        let (collapsed, sound): (Vec<usize>, Vec<usize>) =
            faces.partition(|&face| welded.is_collapsed(face));
        let narrow = |faces: Vec<usize>| faces.into_iter().map(|face| face as u32).collect();
        let largest = mesh.positions().as_flattened().iter().map(|value| value.abs());
        let largest = f64::from(largest.fold(0.0, f32::max));
        let scale = 2.0f32.powi(-largest.log2().clamp(-126.0, 126.0).ceil() as i32);
        Self { mesh, scale, frames, sound: narrow(sound), collapsed: narrow(collapsed) }
    }

    fn generate(&mut self) {
        // The error type has no variants yet. Should it ever fail, triangles keep their own frames.
        if generate_tangents(self).is_ok() {
            self.fill_collapsed();
        }
    }

    /// Corners of collapsed triangles copy the frame of the first other triangle with the same
    /// position and UV coordinate, as MikkTSpace does.
    fn fill_collapsed(&mut self) {
        if self.collapsed.is_empty() {
            return;
        }
        let mut found = HashMap::new();
        for &face in &self.sound {
            for corner in 0..3 {
                let key = self.key(face, corner);
                found.entry(key).or_insert((face, corner));
            }
        }
        for index in 0..self.collapsed.len() {
            let face = self.collapsed[index];
            for corner in 0..3 {
                if let Some(&(from, at)) = found.get(&self.key(face, corner)) {
                    self.frames[face as usize][corner] = self.frames[from as usize][at];
                }
            }
        }
    }

    fn key(&self, face: u32, corner: usize) -> ([u32; 3], [u32; 2]) {
        let vertex = self.mesh.faces()[face as usize][corner];
        let uv = self.mesh.uv_faces()[face as usize][corner];
        (bits_of(self.mesh.positions()[vertex as usize]), bits_of(self.mesh.uv()[uv as usize]))
    }
}

impl Geometry for Surface<'_> {
    fn num_faces(&self) -> usize {
        self.sound.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        let vertex = self.mesh.faces()[self.sound[face] as usize][corner];
        self.mesh.positions()[vertex as usize].map(|value| value * self.scale + 0.0)
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.frames[self.sound[face] as usize][corner].normal.map(|value| value + 0.0)
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.mesh.uv_faces()[self.sound[face] as usize][corner];
        let [u, v] = self.mesh.uv()[uv as usize];
        // Only differences matter, and with `−v` they are exact.
        [u + 0.0, 0.0 - v]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let Some(space) = space else { return };
        let tangent = space.tangent();
        let frame = &mut self.frames[self.sound[face] as usize][corner];
        let [t, n] = [tangent, frame.normal].map(dvec3);
        // Where directions cancel out, MikkTSpace returns zero or rounding error.
        if (t.length_squared() - 1.0).abs() < 1e-3 && t.dot(n).abs() < 1e-3 {
            frame.tangent = tangent;
            frame.sign = if space.is_orientation_preserving() { 1.0 } else { -1.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: [[f32; 3]; 4] =
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]];
    const FACES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    fn quad(uv: [[f32; 2]; 4]) -> TangentFrames {
        TangentFrames::new(&Mesh::from_triangles(QUAD.into(), uv.into(), &FACES, &FACES).unwrap())
    }

    fn assert_frames(frames: &TangentFrames, normal: [f32; 3], tangent: [f32; 3], sign: f32) {
        for frame in frames.faces().as_flattened() {
            let close = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
            let is_wanted =
                close(frame.normal, normal) && close(frame.tangent, tangent) && frame.sign == sign;
            assert!(is_wanted, "{frame:?}");
        }
    }

    /// The quad stands upright before the viewer, so its bitangent must point up when the image is
    /// upright: `v` is 0 at the top.
    #[test]
    fn a_quad_by_hand() {
        let (right, front) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let upright = quad([[0.1, 0.9], [0.5, 0.9], [0.5, 0.2], [0.1, 0.2]]);
        assert_frames(&upright, front, right, 1.0);
        // Image flipped horizontally: `u` grows to the left, up stays up, and the cross product of
        // normal and tangent points down.
        let mirrored = quad([[0.5, 0.9], [0.1, 0.9], [0.1, 0.2], [0.5, 0.2]]);
        assert_frames(&mirrored, front, [-1.0, 0.0, 0.0], -1.0);
        // Image flipped vertically: the bitangent points down.
        let flipped = quad([[0.1, 0.2], [0.5, 0.2], [0.5, 0.9], [0.1, 0.9]]);
        assert_frames(&flipped, front, right, -1.0);
        // Rotated by a quarter turn: right in the image is up in space, and up in the image is
        // left, or right where it is mirrored too.
        let turned = quad([[0.1, 0.2], [0.1, 0.6], [0.8, 0.6], [0.8, 0.2]]);
        assert_frames(&turned, front, [0.0, 1.0, 0.0], 1.0);
        let turned = quad([[0.1, 0.6], [0.1, 0.2], [0.8, 0.2], [0.8, 0.6]]);
        assert_frames(&turned, front, [0.0, 1.0, 0.0], -1.0);
    }

    #[test]
    fn normals_are_weighted_by_angle_over_welded_vertices() {
        // A corner of a box: three sides, one of two triangles, with no shared indices.
        let positions: Vec<[f32; 3]> = [
            [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
            [[0, 0, 0], [1, 1, 0], [0, 1, 0]],
            [[0, 0, 0], [0, 1, 0], [0, 0, -1]],
            [[0, 0, 0], [0, 0, -1], [1, 0, 0]],
        ]
        .iter()
        .flatten()
        .map(|position| position.map(|value| value as f32 * -0.5))
        .collect();
        let uv = positions.iter().map(|&[x, y, _]| [x, y]).collect();
        let faces: Vec<[u32; 3]> = (0..4).map(|face| [0, 1, 2].map(|k| face * 3 + k)).collect();
        let mesh = Mesh::from_triangles(positions, uv, &faces, &faces).unwrap();
        let share = 1.0 / 3.0f32.sqrt();
        for face in TangentFrames::new(&mesh).faces() {
            let wanted = [-share, -share, share];
            for k in 0..3 {
                assert!((face[0].normal[k] - wanted[k]).abs() < 1e-6, "{:?}", face[0]);
            }
        }
    }

    #[test]
    fn tangents_are_perpendicular_to_given_normals() {
        let uv = vec![[0.1, 0.9], [0.5, 0.9], [0.5, 0.2], [0.1, 0.2]];
        let mesh = Mesh::from_triangles(QUAD.into(), uv, &FACES, &FACES).unwrap();
        // Tilted to the right, 3 in 5; one normal is not finite, and one is missing.
        let lean = [0.6, 0.0, 0.8];
        let frames = TangentFrames::with_normals(&mesh, &[lean, lean, [f32::NAN; 3]]);
        let [a, b, c] = frames.faces()[0];
        assert_eq!((a.normal, b.normal, c.normal), (lean, lean, [0.0, 0.0, 1.0]));
        let wanted = [0.8, 0.0, -0.6];
        assert!((0..3).all(|k| (a.tangent[k] - wanted[k]).abs() < 1e-6), "{a:?}");
        assert_eq!(TangentFrames::with_normals(&mesh, &[]), TangentFrames::new(&mesh));
    }

    fn assert_sound(mesh: &Mesh) {
        for frame in TangentFrames::new(mesh).faces().as_flattened() {
            let [n, t] = [frame.normal, frame.tangent].map(dvec3);
            assert!((n.length_squared() - 1.0).abs() < 1e-5, "{frame:?}");
            assert!((t.length_squared() - 1.0).abs() < 1e-3, "{frame:?}");
            assert!(n.dot(t).abs() < 1e-3, "{frame:?}");
            assert!(frame.sign.abs() == 1.0, "{frame:?}");
        }
    }

    #[test]
    fn everything_has_a_frame() {
        let mut rng = fastrand::Rng::with_seed(3);
        // Triangles of few distinct positions and coordinates: collapsed, duplicate and folded
        // ones.
        for round in 0..3000 {
            let size = [1.0, 1e-20, 1e-38, 1e-44, 1e19, 1e38][round % 6];
            let (points, steps) = (rng.u32(1..12), rng.u32(1..5));
            let step = |rng: &mut fastrand::Rng| rng.u32(..steps) as f32 - 1.0;
            let positions = (0..points).map(|_| [(); 3].map(|()| step(&mut rng) * size)).collect();
            let uv = (0..points).map(|_| [(); 2].map(|()| step(&mut rng) * 0.3)).collect();
            let mut faces =
                || (0..40).map(|_| [(); 3].map(|()| rng.u32(..points))).collect::<Vec<_>>();
            let (faces, uv_faces) = (faces(), faces());
            assert_sound(&Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap());
        }
    }

    #[test]
    fn sizes_do_not_matter() {
        let quad = |size: f32| {
            let positions = QUAD.map(|at| at.map(|value| value * size)).into();
            let uv = [[0.1, 0.9], [0.5, 0.8], [0.6, 0.2], [0.1, 0.2]].into();
            TangentFrames::new(&Mesh::from_triangles(positions, uv, &FACES, &FACES).unwrap())
        };
        let wanted = quad(1.0);
        for exponent in [-120, -60, 60, 120] {
            assert_eq!(quad(2.0f32.powi(exponent)), wanted);
        }
    }

    #[test]
    fn fans_of_many_triangles_are_handled() {
        let count = 200_000;
        let rim = |k: u32| f64::from(k) / f64::from(count) * std::f64::consts::TAU;
        let uv: Vec<[f32; 2]> = std::iter::once([0.0; 2])
            .chain((0..count).map(|k| [rim(k).cos() as f32, rim(k).sin() as f32]))
            .collect();
        let positions = uv.iter().map(|&[u, v]| [u, -v, 0.0]).collect();
        let faces: Vec<[u32; 3]> = (0..count).map(|k| [0, 1 + (k + 1) % count, 1 + k]).collect();
        let mesh = Mesh::from_triangles(positions, uv, &faces, &faces).unwrap();
        assert_sound(&mesh);
        assert_eq!(TangentFrames::new(&mesh).faces()[7][0].sign, 1.0);
    }
}
