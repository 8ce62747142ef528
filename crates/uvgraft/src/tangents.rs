//! Tangent frames: what the three channels of a normal map are measured along.
//!
//! Based on Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008), known as MikkTSpace, by
//! the crate `bevy_mikktspace`. It is what Blender, Substance, Marmoset, xNormal, Unity and Unreal
//! bake and draw with, and what glTF 2.0 asks for where a file has no tangents of its own.
//!
//! Conventions, all of them the common ones:
//! - `v` grows upwards here, as in OBJ, Blender and OpenGL: MikkTSpace is given `1 − v` of a [`Mesh`].
//!   The tangent then points along `u`, the bitangent to the top of the image. With `v` downwards
//!   the tangents would be the same, and all bitangents opposite.
//! - The bitangent is `sign · cross(normal, tangent)`, sign being 1 where a chart is not mirrored.
//! - Green is the part along the bitangent ("OpenGL", "+Y"). glTF is that too: it stores `1 − v`
//!   and the sign of the upright layout (`w`), and says that green is up.
//!   "DirectX" ("−Y") files have the same frames and green inverted.
//! - Between corners normal and tangent are interpolated linearly and not normalised; the bitangent
//!   is made from what comes out. Bakers invert exactly that, so decoding has to do it as well.
//!
//! Meshes here carry no normals of their own: they are smooth everywhere, weighted by angle
//! (Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998).

use std::collections::HashMap;
use std::hash::Hash;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DVec3, Vec3};

use crate::directions::{direction, perpendicular};
use crate::mesh::Mesh;

/// MikkTSpace compares the triangles at a vertex each with each, by recursion. Triangles at vertices
/// with more corners than this get a frame of their own.
const MOST_CORNERS: u32 = 1024;

/// A tangent frame at the corner of a triangle, in the mesh's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentFrame {
    /// Smooth vertex normal, of length 1.
    pub normal: [f32; 3],
    /// Along `u`, of length 1 and at right angles to the normal.
    pub tangent: [f32; 3],
    /// The bitangent is `sign · cross(normal, tangent)`: 1 or −1 where a chart is mirrored. The same
    /// at all corners of a triangle that has area.
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
    /// Everything has a frame. A corner whose vertex has no normal, because the triangles around it
    /// have no area or cancel out, takes its triangle's, else +Z. Where MikkTSpace gives no tangent
    /// (triangles without area in the layout that no other joins, or more than 1024 corners around
    /// a vertex), it is the triangle's own direction of `u`, and where that does not exist
    /// either, any direction at right angles to the normal with the sign 1.
    pub fn new(mesh: &Mesh) -> Self {
        let welded = Welded::new(mesh);
        let normals = corner_normals(mesh, &welded);
        let mut faces: Vec<[TangentFrame; 3]> = (0..mesh.faces().len())
            .map(|face| {
                let own = own_tangent(mesh, face);
                normals[face].map(|normal| framed(normal, own))
            })
            .collect();
        Surface::new(mesh, &welded, &mut faces).generate();
        Self { faces }
    }

    /// The same with the normals that a mesh is drawn with.
    ///
    /// - `normals`: `[vertices]`, of any length; a vertex whose normal has none, or is not finite, keeps its smooth one.
    pub fn with_normals(mesh: &Mesh, normals: &[[f32; 3]]) -> Self {
        let welded = Welded::new(mesh);
        let smooth = corner_normals(mesh, &welded);
        let shown = |vertex: u32| direction(wide(*normals.get(vertex as usize)?));
        let mut faces: Vec<[TangentFrame; 3]> = (0..mesh.faces().len())
            .map(|face| {
                let own = own_tangent(mesh, face);
                let corners = mesh.faces()[face];
                [0, 1, 2].map(|k| framed(shown(corners[k]).unwrap_or(smooth[face][k]), own))
            })
            .collect();
        Surface::new(mesh, &welded, &mut faces).generate();
        Self { faces }
    }

    /// `[triangles]`, corner by corner as [`Mesh::faces`].
    pub fn faces(&self) -> &[[TangentFrame; 3]] {
        &self.faces
    }
}

/// Vertices at the same place are one, whatever seams of the layout or the file made of them.
struct Welded {
    /// For each corner of each triangle.
    corners: Vec<[u32; 3]>,
    count: usize,
}

impl Welded {
    fn new(mesh: &Mesh) -> Self {
        let mut numbers = Numbers::default();
        let vertices: Vec<u32> =
            mesh.positions().iter().map(|&position| numbers.number(bits(position))).collect();
        let corners =
            mesh.faces().iter().map(|face| face.map(|vertex| vertices[vertex as usize])).collect();
        Self { corners, count: numbers.0.len() }
    }

    fn is_collapsed(&self, face: usize) -> bool {
        let [a, b, c] = self.corners[face];
        a == b || b == c || c == a
    }
}

/// Numbers in the order of first appearance.
struct Numbers<K>(HashMap<K, u32>);

impl<K> Default for Numbers<K> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<K: Hash + Eq> Numbers<K> {
    fn number(&mut self, key: K) -> u32 {
        let next = self.0.len() as u32;
        *self.0.entry(key).or_insert(next)
    }
}

/// Equal for equal numbers; adding 0.0 makes one zero of the two.
fn bits<const N: usize>(values: [f32; N]) -> [u32; N] {
    values.map(|value| (value + 0.0).to_bits())
}

fn wide(vector: [f32; 3]) -> DVec3 {
    Vec3::from(vector).as_dvec3()
}

/// The three positions of a triangle.
pub(crate) fn corner_positions(mesh: &Mesh, face: usize) -> [DVec3; 3] {
    mesh.faces()[face].map(|vertex| wide(mesh.positions()[vertex as usize]))
}

fn corner_normals(mesh: &Mesh, welded: &Welded) -> Vec<[DVec3; 3]> {
    let mut sums = vec![DVec3::ZERO; welded.count];
    let mut own = Vec::with_capacity(mesh.faces().len());
    for (face, vertices) in welded.corners.iter().enumerate() {
        let corners = corner_positions(mesh, face);
        let [p, q] = [1, 2].map(|k| corners[k] - corners[0]);
        let normal = direction(p.cross(q));
        own.push(normal);
        let Some(normal) = normal else { continue };
        for k in 0..3 {
            let [p, q] = [1, 2].map(|step| corners[(k + step) % 3] - corners[k]);
            let angle = p.cross(q).length().atan2(p.dot(q));
            sums[vertices[k] as usize] += normal * angle;
        }
    }
    let smooth: Vec<Option<DVec3>> = sums
        .into_iter()
        // What cancels out leaves rounding.
        .map(|sum| direction(sum).filter(|_| sum.length_squared() > 1e-12))
        .collect();
    welded
        .corners
        .iter()
        .zip(own)
        .map(|(vertices, own)| {
            vertices.map(|vertex| smooth[vertex as usize].or(own).unwrap_or(DVec3::Z))
        })
        .collect()
}

/// In which direction `u` grows on a triangle, and whether its chart is mirrored; `None` if `u` does
/// not grow in any.
fn own_tangent(mesh: &Mesh, face: usize) -> Option<(DVec3, f32)> {
    let corners = corner_positions(mesh, face);
    let [p, q] = [1, 2].map(|k| corners[k] - corners[0]);
    let uv = mesh.uv_triangle(face).map(|[u, v]| [f64::from(u), -f64::from(v)]);
    let [s, t] = [1, 2].map(|k| [uv[k][0] - uv[0][0], uv[k][1] - uv[0][1]]);
    let area = s[0] * t[1] - s[1] * t[0];
    let sign = if area < 0.0 { -1.0 } else { 1.0 };
    // The gradient of `u` turned into the position's derivative, but for a positive factor.
    let along: DVec3 = [p * (t[1] * sign), q * (-s[1] * sign)].iter().sum();
    Some((direction(along)?, sign as f32))
}

fn framed(normal: DVec3, own: Option<(DVec3, f32)>) -> TangentFrame {
    let projected = own.and_then(|(along, sign)| {
        let across = along - normal * along.dot(normal);
        // Of what runs along the normal rounding is left.
        let across = direction(across).filter(|_| across.length_squared() > 1e-12)?;
        Some((across, sign))
    });
    let (tangent, sign) = projected.unwrap_or_else(|| (perpendicular(normal), 1.0));
    let single = |vector: DVec3| vector.as_vec3().to_array();
    TangentFrame { normal: single(normal), tangent: single(tangent), sign }
}

/// A mesh as MikkTSpace reads it, with frames that hold normals already.
struct Surface<'a> {
    mesh: &'a Mesh,
    /// A power of two, so that nothing is lost: brings positions to about 1, whose squares and products
    /// stay within what 32 bits hold. Tangents do not depend on sizes.
    scale: f32,
    frames: &'a mut [[TangentFrame; 3]],
    /// The triangles that take part.
    sound: Vec<u32>,
    /// The others that take over what their vertices have elsewhere.
    collapsed: Vec<u32>,
}

impl<'a> Surface<'a> {
    fn new(mesh: &'a Mesh, welded: &Welded, frames: &'a mut [[TangentFrame; 3]]) -> Self {
        let mut uses = vec![0; welded.count];
        for &vertex in welded.corners.as_flattened() {
            uses[vertex as usize] += 1;
        }
        let is_crowded =
            |face: usize| welded.corners[face].iter().any(|&v| uses[v as usize] > MOST_CORNERS);
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
        // Its error has no values yet; if it ever fails, frames stay what each triangle has by itself.
        if generate_tangents(self).is_ok() {
            self.fill_collapsed();
        }
    }

    /// Corners of collapsed triangles take the frame that the same vertex has at the same coordinate
    /// in the first triangle that is none, as MikkTSpace has it.
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
        (bits(self.mesh.positions()[vertex as usize]), bits(self.mesh.uv()[uv as usize]))
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
        // Only differences count, and those of `−v` are exact.
        [u + 0.0, 0.0 - v]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let Some(space) = space else { return };
        let tangent = space.tangent();
        let frame = &mut self.frames[self.sound[face] as usize][corner];
        let [t, n] = [tangent, frame.normal].map(wide);
        // It leaves zeros where directions cancel out, or what is left of them by rounding.
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

    /// The quad lies upright before the viewer, so that its bitangent has to point up in it when
    /// the image is upright: `v` is 0 at the top.
    #[test]
    fn a_quad_by_hand() {
        let (right, front) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let upright = quad([[0.1, 0.9], [0.5, 0.9], [0.5, 0.2], [0.1, 0.2]]);
        assert_frames(&upright, front, right, 1.0);
        // Left and right swapped in the image: `u` grows to the left, up stays up, and the product of
        // normal and tangent points down.
        let mirrored = quad([[0.5, 0.9], [0.1, 0.9], [0.1, 0.2], [0.5, 0.2]]);
        assert_frames(&mirrored, front, [-1.0, 0.0, 0.0], -1.0);
        // Upside down by mirroring: the bitangent is down.
        let flipped = quad([[0.1, 0.2], [0.5, 0.2], [0.5, 0.9], [0.1, 0.9]]);
        assert_frames(&flipped, front, right, -1.0);
        // Turned by a quarter: what is to the right in the image is up in space, and what is up in
        // the image to the left, or where it is mirrored too, to the right.
        let turned = quad([[0.1, 0.2], [0.1, 0.6], [0.8, 0.6], [0.8, 0.2]]);
        assert_frames(&turned, front, [0.0, 1.0, 0.0], 1.0);
        let turned = quad([[0.1, 0.6], [0.1, 0.2], [0.8, 0.2], [0.8, 0.6]]);
        assert_frames(&turned, front, [0.0, 1.0, 0.0], -1.0);
    }

    #[test]
    fn normals_are_weighted_by_angle_over_welded_vertices() {
        // A corner of a box: three sides, one of them of two triangles, none sharing an index.
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
    fn tangents_are_at_right_angles_to_the_normals_that_are_shown() {
        let uv = vec![[0.1, 0.9], [0.5, 0.9], [0.5, 0.2], [0.1, 0.2]];
        let mesh = Mesh::from_triangles(QUAD.into(), uv, &FACES, &FACES).unwrap();
        // Leaning to the right by 3 in 5; one has no direction, and one is missing.
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
            let [n, t] = [frame.normal, frame.tangent].map(wide);
            assert!((n.length_squared() - 1.0).abs() < 1e-5, "{frame:?}");
            assert!((t.length_squared() - 1.0).abs() < 1e-3, "{frame:?}");
            assert!(n.dot(t).abs() < 1e-3, "{frame:?}");
            assert!(frame.sign.abs() == 1.0, "{frame:?}");
        }
    }

    #[test]
    fn everything_has_a_frame() {
        let mut rng = fastrand::Rng::with_seed(3);
        // Triangles of few distinct points and coordinates: collapsed, doubled, folded ones.
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
    fn a_fan_of_many_triangles_is_no_trouble() {
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
