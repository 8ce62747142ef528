//! The canonical face, from the metadata that accompany the landmark network.
//!
//! A protobuf message with the mesh in field 1: five floats for each vertex (position in
//! centimetres, uv) in its field 3, vertex indices in its field 4.
//!
//! # Source
//! `geometry_pipeline_metadata.proto` and `mesh_3d.proto` of MediaPipe; the wire format of Protocol
//! Buffers.

use super::FaceNetworksError;

/// Number of landmarks.
pub const LANDMARKS: usize = 468;

/// Number of triangles of the canonical face.
pub const TRIANGLES: usize = 898;

/// The average face whose vertices are the landmarks.
#[derive(Debug, Clone, PartialEq)]
pub struct CanonicalMesh {
    /// [`LANDMARKS`] positions in centimetres: x towards the face's left, y up, z forwards.
    pub positions: Vec<[f32; 3]>,
    /// [`LANDMARKS`] texture coordinates in `0.0..=1.0`, with the origin at the top left.
    pub uvs: Vec<[f32; 2]>,
    /// [`TRIANGLES`] triangles of vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// One field of a message.
struct Field<'b> {
    number: u64,
    value: Value<'b>,
}

enum Value<'b> {
    Integer(u64),
    Word([u8; 4]),
    Bytes(&'b [u8]),
    Other,
}

/// Reads the canonical face.
///
/// # Errors
/// [`FaceNetworksError::Geometry`]
pub(super) fn parse(bytes: &[u8]) -> Result<CanonicalMesh, FaceNetworksError> {
    mesh(bytes).ok_or(FaceNetworksError::Geometry)
}

fn mesh(bytes: &[u8]) -> Option<CanonicalMesh> {
    let mut rest = bytes;
    let mesh = loop {
        if let Field { number: 1, value: Value::Bytes(mesh) } = field(&mut rest)? {
            break mesh;
        }
    };
    let (mut floats, mut indices) = (Vec::new(), Vec::new());
    let mut rest = mesh;
    while !rest.is_empty() {
        match field(&mut rest)? {
            Field { number: 3, value: Value::Word(word) } => floats.push(f32::from_le_bytes(word)),
            Field { number: 4, value: Value::Integer(index) } => {
                indices.push(u32::try_from(index).ok().filter(|&i| (i as usize) < LANDMARKS)?);
            }
            _ => {}
        }
    }
    let (vertices, []) = floats.as_chunks::<5>() else { return None };
    let (triangles, []) = indices.as_chunks::<3>() else { return None };
    let is_right = vertices.len() == LANDMARKS
        && triangles.len() == TRIANGLES
        && floats.iter().all(|value| value.is_finite());
    is_right.then(|| CanonicalMesh {
        positions: vertices.iter().map(|&[x, y, z, ..]| [x, y, z]).collect(),
        // V has its origin at the bottom in the file.
        uvs: vertices.iter().map(|&[.., u, v]| [u, 1.0 - v]).collect(),
        triangles: triangles.to_vec(),
    })
}

/// Takes the next field from the front; `None` if there is none or it is cut short.
fn field<'b>(rest: &mut &'b [u8]) -> Option<Field<'b>> {
    let tag = varint(rest)?;
    let value = match tag & 7 {
        0 => Value::Integer(varint(rest)?),
        1 => {
            take(rest, 8)?;
            Value::Other
        }
        2 => {
            let length = usize::try_from(varint(rest)?).ok()?;
            Value::Bytes(take(rest, length)?)
        }
        5 => Value::Word(*take(rest, 4)?.first_chunk()?),
        _ => return None,
    };
    Some(Field { number: tag >> 3, value })
}

fn take<'b>(rest: &mut &'b [u8], length: usize) -> Option<&'b [u8]> {
    let (front, back) = rest.split_at_checked(length)?;
    *rest = back;
    Some(front)
}

/// Seven bits a byte, the lowest first; the top bit says that more follow.
fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let byte = take(rest, 1)?[0];
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn put_varint(bytes: &mut Vec<u8>, mut value: u64) {
        while value >= 0x80 {
            bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        bytes.push(value as u8);
    }

    /// A message with a mesh of so many vertices and triangles, between other fields.
    fn message(vertices: usize, triangles: usize) -> Vec<u8> {
        let mut mesh = vec![0x08, 0x01, 0x10, 0x00];
        for value in 0..vertices * 5 {
            mesh.push(0x1d);
            mesh.extend((value as f32).to_le_bytes());
        }
        for index in 0..triangles * 3 {
            mesh.push(0x20);
            put_varint(&mut mesh, (index % LANDMARKS) as u64);
        }
        let mut bytes = vec![0x12, 0x02, 0x08, 0x07, 0x18, 0x02, 0x0a];
        put_varint(&mut bytes, mesh.len() as u64);
        bytes.extend(mesh);
        bytes
    }

    #[test]
    fn reads_a_mesh_and_refuses_any_other() {
        let bytes = message(LANDMARKS, TRIANGLES);
        let mesh = parse(&bytes).unwrap();
        assert_eq!(mesh.positions[1], [5.0, 6.0, 7.0]);
        assert_eq!(mesh.uvs[1], [8.0, -8.0]);
        assert_eq!(mesh.triangles[1], [3, 4, 5]);
        assert!(parse(&message(LANDMARKS - 1, TRIANGLES)).is_err());
        assert!(parse(&message(LANDMARKS, TRIANGLES + 1)).is_err());
        for end in 0..bytes.len() {
            assert!(parse(&bytes[..end]).is_err(), "cut at {end}");
        }
        assert!(parse(&[0xff; 40]).is_err());
    }
}
