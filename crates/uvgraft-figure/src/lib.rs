//! A synthetic example figure: a head, and a body that contains the same head with different vertex
//! indices and another UV layout.

#![forbid(unsafe_code)]

mod arms;
mod bake;
mod body_shape;
mod clothes;
mod complexion;
mod curve;
mod expressions;
mod face;
mod features;
mod hair;
mod head;
mod head_shape;
mod layout;
pub mod motion;
mod rigging;
mod sdf;
mod surface;
mod symmetry;
mod wardrobe;

use std::collections::HashMap;
use std::ops::Range;

use glam::vec3;
use uvgraft::{Corner, Mesh};
use uvgraft_avatar::paint::noise::hash;

use self::head_shape::{EYE, EYE_LEVEL};
use self::layout::{UvLayout, corners};
use self::surface::{BodyPart, PartKind, Polygon, Side, Surface};
pub use face::paint_head;
pub use wardrobe::{paint_body, paint_body_in_tone};

/// A synthetic person: two meshes and their correspondence.
///
/// Positions are in metres, Y up, facing +Z, in an A-pose with the ground at 0. Both meshes name
/// their parts ([`Mesh::parts`]): groups such as `face` or `arm left`, materials such as `skin`.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Face, cranium, neck, ears, hair and two eyeballs, in the UV layout of a face texture.
    pub head: Mesh,
    /// The whole figure in another UV layout, in which both eyes share one disc. It contains every
    /// polygon of `head`, some starting at another corner.
    pub body: Mesh,
    /// For each head vertex, the index of the same vertex in the body.
    pub vertex_map: Vec<u32>,
    pub(crate) head_parts: Vec<PartFaces>,
    pub(crate) body_parts: Vec<PartFaces>,
    /// Body vertices inside the outline of the lips, with their coordinate; see
    /// [`head::HeadSkin::lips`].
    pub(crate) lips: Vec<(u32, f32)>,
}

/// The triangles of a part.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PartFaces {
    pub part: BodyPart,
    pub faces: Range<usize>,
}

impl Default for Figure {
    fn default() -> Self {
        Self::new()
    }
}

impl Figure {
    /// Builds the figure; the result is deterministic.
    pub fn new() -> Self {
        let head = head_surface();
        let body = body_surface(&head.surface, &head.rim);
        let lips = head.lips;
        let head = head.surface;
        let head_vertices = head.positions.len();
        let body_index = renumbering(head_vertices, body.positions.len());

        let (head_mesh, head_parts) = mesh(&head, UvLayout::Head, None);
        let (body_mesh, body_parts) = mesh(&body, UvLayout::Body, Some(&body_index));
        let vertex_map = body_index[..head_vertices].to_vec();
        let lips =
            lips.iter().map(|&(vertex, along)| (vertex_map[vertex as usize], along)).collect();
        Self { head: head_mesh, body: body_mesh, vertex_map, head_parts, body_parts, lips }
    }
}

/// The head in world space.
fn head_surface() -> head::HeadSkin {
    let mut skin = head::skin();
    let surface = &mut skin.surface;
    let left_eye = features::eye();
    let mut right_eye = left_eye.clone();
    for position in &mut right_eye.positions {
        position.x -= 2.0 * EYE.x;
    }
    for polygon in &mut right_eye.polygons {
        polygon.part.side = Side::Right;
    }
    let left_ear = features::ear();
    let right_ear = left_ear.mirrored();
    for piece in [left_eye, right_eye, left_ear, right_ear, hair::shell()] {
        surface.append(piece);
    }
    for position in &mut surface.positions {
        *position += vec3(0.0, EYE_LEVEL, 0.0);
    }
    skin
}

/// The body around a copy of the head, whose vertices come first.
fn body_surface(head: &Surface, rim: &[u32]) -> Surface {
    let mut surface = head.clone();
    clothes::chest(&mut surface, rim);
    clothes::torso(&mut surface);
    let mut left = Surface::default();
    clothes::left_sleeve(&mut left);
    arms::left(&mut left);
    clothes::left_leg(&mut left);
    clothes::left_shoe(&mut left);
    let right = left.mirrored();
    surface.append(left);
    surface.append(right);
    surface
}

/// A shuffled vertex order for the body: the new index of each vertex, those below the neck first.
fn renumbering(head_vertices: usize, vertices: usize) -> Vec<u32> {
    let mut order: Vec<usize> = (0..vertices).collect();
    order.sort_by_key(|&vertex| (vertex < head_vertices, hash(vertex as i32, 0, 0, 1)));
    let mut number = vec![0; vertices];
    for (new, &old) in order.iter().enumerate() {
        number[old] = new as u32;
    }
    number
}

/// The mesh of a surface in a UV layout, its polygons sorted by part. With new vertex indices, some
/// polygons also start at another corner.
///
/// Texture vertices are shared by exact equality of their coordinates within a chart.
fn mesh(surface: &Surface, layout: UvLayout, number: Option<&[u32]>) -> (Mesh, Vec<PartFaces>) {
    const METRES: f32 = 0.01;
    let mut positions = vec![[0.0; 3]; surface.positions.len()];
    for (index, &position) in surface.positions.iter().enumerate() {
        let new = number.map_or(index, |number| number[index] as usize);
        positions[new] = (position * METRES).into();
    }
    let mut sorted: Vec<&Polygon> = surface.polygons.iter().collect();
    sorted.sort_by_key(|polygon| polygon.part);

    let mut uv = Vec::new();
    let mut uv_numbers: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
    let (mut all_corners, mut sizes) = (Vec::new(), Vec::new());
    let mut parts: Vec<uvgraft::MeshPart> = Vec::new();
    let mut part_faces: Vec<PartFaces> = Vec::new();
    let mut faces = 0;
    for (index, polygon) in sorted.into_iter().enumerate() {
        let (chart, polygon_uv) = corners(layout, polygon);
        let count = polygon.knots.len();
        let first = if number.is_some() { hash(index as i32, 0, 0, 2) as usize % count } else { 0 };
        for k in (0..count).map(|k| (first + k) % count) {
            let vertex = polygon.knots[k].vertex;
            let vertex = number.map_or(vertex, |number| number[vertex as usize]);
            let corner_uv = polygon_uv[k];
            let uv = *uv_numbers.entry((chart, corner_uv.map(f32::to_bits))).or_insert_with(|| {
                uv.push(corner_uv);
                uv.len() as u32 - 1
            });
            all_corners.push(Corner { vertex, uv });
        }
        sizes.push(count as u32);
        if part_faces.last().is_none_or(|last| last.part != polygon.part) {
            let start = index as u32;
            parts.push(mesh_part(polygon.part, start..start));
            part_faces.push(PartFaces { part: polygon.part, faces: faces..faces });
        }
        faces += count - 2;
        if let (Some(part), Some(range)) = (parts.last_mut(), part_faces.last_mut()) {
            part.polygons.end = index as u32 + 1;
            range.faces.end = faces;
        }
    }
    let mesh = Mesh::from_polygons(positions, uv, &all_corners, &sizes)
        .expect("the figure's own polygons are sound")
        .with_parts(parts);
    (mesh, part_faces)
}

fn mesh_part(part: BodyPart, polygons: Range<u32>) -> uvgraft::MeshPart {
    let (object, group, material) = match part.kind {
        PartKind::Face => ("head", "face".to_owned(), "skin"),
        PartKind::Eye => ("head", "eye".to_owned(), "eye"),
        PartKind::Ear => ("head", "ear".to_owned(), "skin"),
        PartKind::Hair => ("head", "hair".to_owned(), "hair"),
        PartKind::Chest => ("body", "chest".to_owned(), "skin"),
        PartKind::Shirt => ("body", "shirt".to_owned(), "cloth"),
        PartKind::Sleeve => ("body", "sleeve".to_owned(), "cloth"),
        PartKind::Arm => ("body", "arm".to_owned(), "skin"),
        PartKind::Finger(number) => ("body", format!("finger {number}"), "skin"),
        PartKind::Leg => ("body", "leg".to_owned(), "cloth"),
        PartKind::Shoe => ("body", "shoe".to_owned(), "leather"),
    };
    let side = match part.side {
        Side::Both => "",
        Side::Left => " left",
        Side::Right => " right",
    };
    let (object, material) = (object.to_owned(), material.to_owned());
    uvgraft::MeshPart { object, group: group + side, material, image: None, polygons }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use glam::Vec3;
    use uvgraft::Size;
    use uvgraft::raster::ScanTriangle;

    use super::*;

    /// The vertices in their cyclic order, starting with the smallest.
    fn canonical(mut vertices: Vec<u32>) -> Vec<u32> {
        let first = (0..vertices.len()).min_by_key(|&k| vertices[k]).unwrap();
        vertices.rotate_left(first);
        vertices
    }

    fn polygon(mesh: &Mesh, polygon: usize) -> Vec<u32> {
        mesh.polygon_corners(polygon).iter().map(|corner| corner.vertex).collect()
    }

    #[test]
    fn is_the_same_every_time() {
        assert_eq!(Figure::new(), Figure::new());
    }

    #[test]
    fn the_body_contains_every_polygon_of_the_head() {
        let figure = Figure::new();
        let mut seen = vec![false; figure.body.positions().len()];
        for (vertex, &in_body) in figure.vertex_map.iter().enumerate() {
            assert!(!std::mem::replace(&mut seen[in_body as usize], true), "vertex {vertex}");
            assert_eq!(figure.head.positions()[vertex], figure.body.positions()[in_body as usize]);
        }
        let bodies: HashMap<Vec<u32>, usize> = (0..figure.body.polygon_count())
            .map(|index| (canonical(polygon(&figure.body, index)), index))
            .collect();
        let mut rotated = 0;
        for index in 0..figure.head.polygon_count() {
            let mapped: Vec<u32> = polygon(&figure.head, index)
                .iter()
                .map(|&vertex| figure.vertex_map[vertex as usize])
                .collect();
            let found = bodies[&canonical(mapped.clone())];
            rotated += usize::from(polygon(&figure.body, found) != mapped);
        }
        assert!(rotated > figure.head.polygon_count() / 3);
        let moved = figure.vertex_map.iter().enumerate().filter(|(a, b)| *a != **b as usize);
        assert!(moved.count() > figure.vertex_map.len() / 2);
    }

    #[test]
    fn every_triangle_of_the_head_finds_its_counterpart() {
        let figure = Figure::new();
        let map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
        let pair = uvgraft::Pair::by_vertex_map(figure.head, figure.body, &map).unwrap();
        assert_eq!(pair.piece_count(), pair.source().faces().len());
    }

    #[test]
    fn winding_is_consistent() {
        let figure = Figure::new();
        for mesh in [&figure.head, &figure.body] {
            let mut edges = HashMap::new();
            for face in mesh.faces() {
                for k in 0..3 {
                    *edges.entry((face[k], face[(k + 1) % 3])).or_insert(0) += 1;
                }
            }
            let parts = if mesh == &figure.head { &figure.head_parts } else { &figure.body_parts };
            for part in parts {
                let faces: Vec<[Vec3; 3]> = mesh.faces()[part.faces.clone()]
                    .iter()
                    .map(|face| face.map(|vertex| mesh.positions()[vertex as usize].into()))
                    .collect();
                let count = 3.0 * faces.len() as f32;
                let middle = faces.iter().flatten().fold(Vec3::default(), |sum, &p| sum + p);
                let middle = middle * (1.0 / count);
                let volume: f32 = faces
                    .iter()
                    .map(|[a, b, c]| (*a - middle).dot((*b - middle).cross(*c - middle)))
                    .sum();
                assert!(volume > 0.0, "{:?} is inside out", part.part);
            }
            assert!(
                edges.values().all(|&count| count == 1),
                "an edge is used twice in one direction"
            );
        }
    }

    #[test]
    fn charts_have_area_and_lie_inside() {
        let figure = Figure::new();
        for (name, mesh) in [("head", &figure.head), ("body", &figure.body)] {
            assert!(mesh.uv().iter().flatten().all(|value| (0.0..=1.0).contains(value)));
            for face in 0..mesh.faces().len() {
                let [a, b, c] = mesh.uv_triangle(face);
                let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                assert!(area.abs() > 1e-9, "{name} face {face} has area {area}");
            }
        }
    }

    /// The owner of every texel, and the gap between charts.
    #[test]
    fn charts_overlap_at_the_eyes_only_and_keep_apart() {
        const SIDE: u32 = 1024;
        const GAP: i32 = 8;
        let figure = Figure::new();
        for (name, mesh, parts) in
            [("head", &figure.head, &figure.head_parts), ("body", &figure.body, &figure.body_parts)]
        {
            let size = Size::square(SIDE);
            let mut owner: Vec<Option<BodyPart>> = vec![None; size.texels()];
            let mut shared = 0;
            for part in parts {
                for face in part.faces.clone() {
                    let corners = mesh
                        .uv_triangle(face)
                        .map(|uv| uv.map(|value| f64::from(value) * f64::from(SIDE)));
                    let Some(scan) = ScanTriangle::new(corners, size) else { continue };
                    for row in scan.rows() {
                        for column in scan.span(row) {
                            let texel = &mut owner[(row * SIDE + column) as usize];
                            match *texel {
                                Some(other) if other.kind == PartKind::Eye => shared += 1,
                                Some(other) => {
                                    panic!(
                                        "{name}: {:?} over {other:?} at {column}, {row}",
                                        part.part
                                    )
                                }
                                None => *texel = Some(part.part),
                            }
                        }
                    }
                }
            }
            let side = SIDE as i32;
            for y in 0..side {
                for x in 0..side {
                    let Some(part) = owner[(y * side + x) as usize] else { continue };
                    for (dx, dy) in [(GAP - 1, 0), (0, GAP - 1)] {
                        let (x, y) = (x + dx, y + dy);
                        if x < side && y < side {
                            let other = owner[(y * side + x) as usize];
                            assert!(
                                other.is_none_or(|other| other == part),
                                "{name}: {part:?} and {other:?} are close at {x}, {y}"
                            );
                        }
                    }
                }
            }
            assert_eq!(shared > 0, name == "body", "{name}: {shared} shared texels");
        }
    }
}
