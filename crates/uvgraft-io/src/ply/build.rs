//! Builds a mesh from the rows of a PLY file.

use std::collections::HashMap;

use uvgraft::mesh::{Corner, Mesh, MeshPart};

use super::PlyError;
use super::header::{Element, Header};
use super::values::{Row, Values};
use crate::arrays::listed;
use crate::textured::{TexturedMesh, WithoutUv};

const VERTEX: &str = "vertex";
const FACE: &str = "face";
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];
const UV_NAMES: [[&str; 2]; 4] =
    [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
/// Maximum memory of all parts with their names.
const MAX_PART_BYTES: usize = 1 << 28;

pub(super) fn mesh(header: &Header, body: &[u8]) -> Result<TexturedMesh, PlyError> {
    let (vertex_columns, face_columns) = columns(header)?;
    let mut values = Values::new(header, body);
    let (mut vertices, mut faces) = (Vertices::default(), Faces::default());
    for element in &header.elements {
        let rows = values.rows(element)?;
        match &*element.name {
            VERTEX => vertices.read(element, rows, &vertex_columns, &mut values)?,
            FACE => faces.read(element, rows, &face_columns, &mut values)?,
            _ => skip(element, rows, &mut values)?,
        }
    }
    values.finish()?;
    let without_uv = faces.leave_out_bare(&header.textures);
    let (uv, corners) = if faces.uv.is_empty() {
        if vertex_columns.uv.is_none() {
            return Err(PlyError::NoTextureCoordinates);
        }
        let corner = |&vertex: &u32| Corner { vertex, uv: vertex };
        (vertices.uv, faces.corners.iter().map(corner).collect())
    } else {
        faces.welded()
    };
    let parts = faces.parts(&header.textures)?;
    let mesh = Mesh::from_polygons(vertices.positions, uv, &corners, &faces.sizes)?;
    Ok(TexturedMesh { mesh: mesh.with_parts(parts), without_uv })
}

struct VertexColumns {
    position: [usize; 3],
    uv: Option<[usize; 2]>,
}

struct FaceColumns {
    corners: usize,
    uv: Option<usize>,
    texture: Option<usize>,
}

/// Finds the columns of a mesh, before any row is read.
fn columns(header: &Header) -> Result<(VertexColumns, FaceColumns), PlyError> {
    let named = |name: &str| header.elements.iter().find(|element| element.name == name);
    let elements = || {
        let names = header.elements.iter().map(|element| element.name.clone());
        listed(&names.collect::<Vec<_>>())
    };
    let missing = |wanted, found| PlyError::Missing { wanted, found };
    let vertex = named(VERTEX).ok_or_else(|| missing("an element `vertex`", elements()))?;
    let face = named(FACE).ok_or_else(|| missing("an element `face` with polygons", elements()))?;
    let scalar =
        |name: &str| vertex.find(&[name]).filter(|&index| vertex.properties[index].list.is_none());
    let list =
        |names: &[&str]| face.find(names).filter(|&index| face.properties[index].list.is_some());
    let properties = |element: &Element| {
        let names = element.properties.iter().map(|property| property.name.clone());
        listed(&names.collect::<Vec<_>>())
    };
    let (Some(x), Some(y), Some(z)) = (scalar("x"), scalar("y"), scalar("z")) else {
        return Err(missing("the vertex properties `x`, `y` and `z`", properties(vertex)));
    };
    let corners =
        list(&CORNERS).filter(|&index| face.properties[index].scalar.is_integer()).ok_or_else(
            || missing("the list of integers `vertex_indices` in its faces", properties(face)),
        )?;
    let mut pairs = UV_NAMES.iter().filter_map(|[u, v]| Some([scalar(u)?, scalar(v)?]));
    let vertices = VertexColumns { position: [x, y, z], uv: pairs.next() };
    let texture = face.find(&["texnumber"]);
    let faces = FaceColumns { corners, uv: list(&["texcoord"]), texture };
    if vertices.uv.is_none() && faces.uv.is_none() {
        return Err(PlyError::NoTextureCoordinates);
    }
    Ok((vertices, faces))
}

fn skip(element: &Element, rows: usize, values: &mut Values<'_>) -> Result<(), PlyError> {
    let mut unused = Vec::new();
    for row in 0..rows as u64 {
        for property in &element.properties {
            values.property(property, Row { element, row }, &mut unused)?;
        }
    }
    Ok(())
}

#[derive(Default)]
struct Vertices {
    positions: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
}

impl Vertices {
    fn read(
        &mut self,
        element: &Element,
        rows: usize,
        columns: &VertexColumns,
        values: &mut Values<'_>,
    ) -> Result<(), PlyError> {
        self.positions.reserve_exact(rows);
        self.uv.reserve_exact(if columns.uv.is_some() { rows } else { 0 });
        let mut numbers = vec![0.0; element.properties.len()];
        let mut read = Vec::new();
        for row in 0..rows as u64 {
            let place = Row { element, row };
            for (number, property) in numbers.iter_mut().zip(&element.properties) {
                if property.list.is_some() {
                    values.property(property, place, &mut read)?;
                } else {
                    *number = values.number(property.scalar, place)?;
                }
            }
            self.positions.push(columns.position.map(|column| numbers[column] as f32));
            self.uv.extend(columns.uv.map(|uv| flipped(uv.map(|column| numbers[column]))));
        }
        Ok(())
    }
}

/// With the origin at the top left.
fn flipped([u, v]: [f64; 2]) -> [f32; 2] {
    [u as f32, (1.0 - v) as f32]
}

#[derive(Default)]
struct Faces {
    corners: Vec<u32>,
    sizes: Vec<u32>,
    /// A texture coordinate for each corner of the faces that have any.
    uv: Vec<[f32; 2]>,
    /// Whether each face has texture coordinates.
    is_textured: Vec<bool>,
    /// The number of each face's texture, if the file has them.
    textures: Vec<i64>,
}

impl Faces {
    fn read(
        &mut self,
        element: &Element,
        rows: usize,
        columns: &FaceColumns,
        values: &mut Values<'_>,
    ) -> Result<(), PlyError> {
        self.sizes.reserve_exact(rows);
        let (mut corners, mut uv, mut other) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..rows as u64 {
            let place = Row { element, row };
            for (column, property) in element.properties.iter().enumerate() {
                let into = if column == columns.corners {
                    &mut corners
                } else if Some(column) == columns.uv {
                    &mut uv
                } else {
                    &mut other
                };
                values.property(property, place, into)?;
                if Some(column) == columns.texture {
                    self.textures.extend(other.first().map(|&number| number as i64));
                }
            }
            self.face(&corners, &uv, place)?;
        }
        Ok(())
    }

    /// Adds a polygon. Faces without a texture are written with empty lists.
    fn face(&mut self, corners: &[f64], uv: &[f64], place: Row<'_>) -> Result<(), PlyError> {
        for &corner in corners {
            if !(0.0..=f64::from(u32::MAX)).contains(&corner) {
                return Err(place.error(format!("vertex index must be at least 0, got {corner}")));
            }
            self.corners.push(corner as u32);
        }
        self.sizes.push(u32::try_from(corners.len()).unwrap_or(u32::MAX));
        let wanted = 2 * corners.len();
        if ![0, wanted].contains(&uv.len()) {
            let found = uv.len();
            return Err(place.error(format!(
                "`texcoord` must have {wanted} numbers, two for each corner, got {found}"
            )));
        }
        self.is_textured.push(!uv.is_empty());
        self.uv.extend(uv.as_chunks::<2>().0.iter().map(|&uv| flipped(uv)));
        Ok(())
    }

    /// Removes the faces without texture coordinates, where others have them.
    fn leave_out_bare(&mut self, names: &[String]) -> WithoutUv {
        let mut without = WithoutUv::default();
        if self.uv.is_empty() || self.is_textured.iter().all(|&is_textured| is_textured) {
            return without;
        }
        let (mut corners, mut start) = (Vec::with_capacity(self.uv.len()), 0);
        for (face, &size) in self.sizes.iter().enumerate() {
            let end = start + size as usize;
            if self.is_textured[face] {
                corners.extend_from_slice(&self.corners[start..end]);
            } else {
                let texture = self.textures.get(face).copied().unwrap_or(0);
                let is_named = !(names.is_empty() && self.textures.is_empty());
                let name = if is_named { texture_name(texture, names) } else { String::new() };
                without.add(["", "", &name], 1);
            }
            start = end;
        }
        self.corners = corners;
        let mut is_textured = self.is_textured.iter();
        self.sizes.retain(|_| is_textured.next() == Some(&true));
        let mut is_textured = self.is_textured.iter();
        self.textures.retain(|_| is_textured.next() == Some(&true));
        without
    }

    /// The texture coordinates of the corners, those of one vertex and value stored once.
    fn welded(&mut self) -> (Vec<[f32; 2]>, Vec<Corner>) {
        let mut known = HashMap::new();
        let mut uv = Vec::new();
        let corners = self.corners.iter().zip(&self.uv).map(|(&vertex, &value)| {
            let index = *known.entry((vertex, value.map(f32::to_bits))).or_insert_with(|| {
                uv.push(value);
                uv.len() - 1
            });
            Corner { vertex, uv: u32::try_from(index).unwrap_or(u32::MAX) }
        });
        let corners = corners.collect();
        (uv, corners)
    }

    /// Consecutive polygons of one texture, where the file distinguishes or names textures.
    fn parts(&self, names: &[String]) -> Result<Vec<MeshPart>, PlyError> {
        let mut parts: Vec<MeshPart> = Vec::new();
        let (mut last, mut bytes) = (None, 0);
        for polygon in 0..self.sizes.len() {
            let texture = self.textures.get(polygon).copied().unwrap_or(0);
            let end = u32::try_from(polygon + 1).unwrap_or(u32::MAX);
            if let (true, Some(part)) = (last == Some(texture), parts.last_mut()) {
                part.polygons.end = end;
                continue;
            }
            last = Some(texture);
            let material = texture_name(texture, names);
            bytes += size_of::<MeshPart>() + 2 * material.len();
            if bytes > MAX_PART_BYTES {
                return Err(PlyError::TextureChanges { max: MAX_PART_BYTES });
            }
            let image = Some(material.clone());
            let polygons = end - 1..end;
            parts.push(MeshPart { material, image, polygons, ..MeshPart::default() });
        }
        Ok(if names.is_empty() && parts.len() < 2 { Vec::new() } else { parts })
    }
}

/// The name of a texture, or its number where the file does not name it.
fn texture_name(texture: i64, names: &[String]) -> String {
    let name = usize::try_from(texture).ok().and_then(|texture| names.get(texture));
    name.cloned().unwrap_or_else(|| format!("texture {texture}"))
}
