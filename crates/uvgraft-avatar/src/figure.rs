//! The example figure: a head, and a body that contains the same head under other vertex numbers
//! and another layout.

use std::collections::HashMap;
use std::ops::Range;

use uvgraft::{Corner, Mesh};

use crate::head_shape::{EYE, EYE_LEVEL};
use crate::layout::{Layout, corners};
use crate::noise::hash;
use crate::surface::{Kind, Part, Polygon, Side, Surface};
use crate::vector::vec3;
use crate::{arms, clothes, features, hair, head};

/// A synthetic person: two meshes and how they correspond.
///
/// Positions are in metres, Y up, facing +Z, in an A-pose with the ground at 0. Both meshes name
/// their parts ([`Mesh::parts`]): groups like `face` or `arm left`, materials like `skin`.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Face, cranium, neck, ears, hair and two eyeballs, in the layout of a face texture.
    pub head: Mesh,
    /// The whole figure in another layout, in which both eyes share one disc. It contains every
    /// polygon of `head`, some with their corners rotated.
    pub body: Mesh,
    /// For each head vertex, the body vertex that it is.
    pub vertex_map: Vec<u32>,
    pub(crate) head_parts: Vec<PartFaces>,
    pub(crate) body_parts: Vec<PartFaces>,
}

/// A part's triangles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PartFaces {
    pub part: Part,
    pub faces: Range<usize>,
}

impl Default for Figure {
    fn default() -> Self {
        Self::new()
    }
}

impl Figure {
    /// Builds the figure; the same one every time.
    pub fn new() -> Self {
        let (head, rim) = head_surface();
        let body = body_surface(&head, &rim);
        let head_vertices = head.positions.len();
        let body_number = renumbering(head_vertices, body.positions.len());

        let (head_mesh, head_parts) = mesh(&head, Layout::Head, None);
        let (body_mesh, body_parts) = mesh(&body, Layout::Body, Some(&body_number));
        let vertex_map = body_number[..head_vertices].to_vec();
        Self { head: head_mesh, body: body_mesh, vertex_map, head_parts, body_parts }
    }
}

/// The head in world space, and the rim at the base of its neck.
fn head_surface() -> (Surface, Vec<u32>) {
    let (mut surface, rim) = head::skin_surface();
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
        *position = *position + vec3(0.0, EYE_LEVEL, 0.0);
    }
    (surface, rim)
}

/// The body around a copy of the head, whose vertices come first here.
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

/// Shuffled numbers of the body's vertices: those below the neck first, then the head's.
fn renumbering(head_vertices: usize, vertices: usize) -> Vec<u32> {
    let mut order: Vec<usize> = (0..vertices).collect();
    order.sort_by_key(|&vertex| (vertex < head_vertices, hash(vertex as i32, 0, 0, 1)));
    let mut number = vec![0; vertices];
    for (new, &old) in order.iter().enumerate() {
        number[old] = new as u32;
    }
    number
}

/// The mesh of a surface in a layout, its polygons sorted by part. With new vertex numbers, some
/// polygons also start at another corner.
fn mesh(surface: &Surface, layout: Layout, number: Option<&[u32]>) -> (Mesh, Vec<PartFaces>) {
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
    let mut parts: Vec<uvgraft::Part> = Vec::new();
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
            parts.push(described(polygon.part, start..start));
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

fn described(part: Part, polygons: Range<u32>) -> uvgraft::Part {
    let (object, group, material) = match part.kind {
        Kind::Face => ("head", "face".to_owned(), "skin"),
        Kind::Eye => ("head", "eye".to_owned(), "eye"),
        Kind::Ear => ("head", "ear".to_owned(), "skin"),
        Kind::Hair => ("head", "hair".to_owned(), "hair"),
        Kind::Chest => ("body", "chest".to_owned(), "skin"),
        Kind::Shirt => ("body", "shirt".to_owned(), "cloth"),
        Kind::Sleeve => ("body", "sleeve".to_owned(), "cloth"),
        Kind::Arm => ("body", "arm".to_owned(), "skin"),
        Kind::Finger(number) => ("body", format!("finger {number}"), "skin"),
        Kind::Leg => ("body", "leg".to_owned(), "cloth"),
        Kind::Shoe => ("body", "shoe".to_owned(), "leather"),
    };
    let side = match part.side {
        Side::Both => "",
        Side::Left => " left",
        Side::Right => " right",
    };
    let (object, material) = (object.to_owned(), material.to_owned());
    uvgraft::Part { object, group: group + side, material, polygons }
}
