//! Decompresses primitives: their indices and attributes become new buffers.
//!
//! # Source
//! Khronos, "KHR_draco_mesh_compression"; Google, "Draco Bitstream Specification", which the crate
//! `draco-core` decodes.

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};

use super::{Buffers, appended, decoded};
use crate::scene::budget::{MAX_BYTES, MAX_VERTICES};
use crate::scene::check::{find, slice};
use crate::scene::document::{Document, Draco};
use crate::scene::error::SceneError;

/// - `total`: bytes decompressed so far.
pub(super) fn unpack(
    document: &mut Document,
    buffers: &mut Buffers<'_>,
    mut total: u64,
) -> Result<(), SceneError> {
    for mesh in 0..document.meshes.len() {
        for number in 0..document.meshes[mesh].primitives.len() {
            let primitive = &mut document.meshes[mesh].primitives[number];
            let Some(draco) = primitive.extensions.draco.take() else { continue };
            let place = format!("mesh {mesh}, primitive {number}");
            let mode = primitive.mode.unwrap_or(4);
            if mode != 4 {
                let reason =
                    format!("mode must be 4 (triangles) with Draco compression, got {mode}");
                return Err(SceneError::content(place, reason));
            }
            let attributes = primitive.attributes.clone();
            let indices = primitive.indices;
            let faces = document.triangles(&document.meshes[mesh].primitives[number]).1;
            let decompressed = decode(document, buffers, &draco, (faces, total), &place)?;
            if let Some(indices) = indices {
                let bytes = decompressed.faces().iter().flatten();
                let bytes = bytes.flat_map(|point| point.0.to_le_bytes()).collect();
                // Always 32-bit: seams may have added vertices.
                let accessor = Stored { accessor: indices, component: Some(UNSIGNED_INT), bytes };
                total = accessor.put(document, buffers, 3 * decompressed.num_faces(), total)?;
            }
            for (name, &id) in &draco.attributes {
                let Some(&accessor) = attributes.get(name) else { continue };
                let bytes = values(document, &decompressed, accessor, id, &place)?;
                let stored = Stored { accessor, component: None, bytes };
                total = stored.put(document, buffers, decompressed.num_points(), total)?;
            }
        }
    }
    Ok(())
}

const UNSIGNED_INT: u32 = 5125;

/// - `faces`: as many as the accessors have, whose numbers were added up.
fn decode(
    document: &Document,
    buffers: &Buffers<'_>,
    draco: &Draco,
    (faces, total): (u64, u64),
    place: &str,
) -> Result<Mesh, SceneError> {
    let view = find(&document.buffer_views, draco.buffer_view, "buffer view", place)?;
    let bytes = slice(buffers, (view.buffer, view.byte_offset, view.byte_length), place)?;
    let limits = DecodeLimits::default()
        .with_max_points(MAX_VERTICES)
        .with_max_faces(faces)
        .with_max_decoded_bytes(MAX_BYTES - total);
    let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
    let mut mesh = Mesh::new();
    let decoded = MeshDecoder::new().decode(&mut buffer, &mut mesh);
    decoded
        .map_err(|error| SceneError::content(place, format!("Draco stream: {error}")))
        .map(|()| mesh)
}

/// An attribute's values, in the component type of its accessor.
fn values(
    document: &Document,
    mesh: &Mesh,
    accessor: u32,
    id: u32,
    place: &str,
) -> Result<Vec<u8>, SceneError> {
    let accessor = find(&document.accessors, accessor, "accessor", place)?;
    let attribute = mesh
        .attribute_by_unique_id(id)
        .ok_or_else(|| SceneError::content(place, format!("Draco stream has no attribute {id}")))?;
    let width = usize::from(attribute.num_components());
    let numbers = attribute.read_f32s(mesh.num_points(), width);
    let mut bytes = Vec::with_capacity(4 * numbers.len());
    for number in numbers {
        match accessor.component_type {
            5120 => bytes.extend((number as i8).to_le_bytes()),
            5121 => bytes.push(number as u8),
            5122 => bytes.extend((number as i16).to_le_bytes()),
            5123 => bytes.extend((number as u16).to_le_bytes()),
            UNSIGNED_INT => bytes.extend((number as u32).to_le_bytes()),
            _ => bytes.extend(number.to_le_bytes()),
        }
    }
    Ok(bytes)
}

/// New contents of an accessor.
struct Stored {
    accessor: u32,
    /// The new component type, if it changes.
    component: Option<u32>,
    bytes: Vec<u8>,
}

impl Stored {
    /// Stores the bytes in a new buffer and updates the accessor; returns the new total of
    /// decompressed bytes.
    fn put(
        self,
        document: &mut Document,
        buffers: &mut Buffers<'_>,
        count: usize,
        total: u64,
    ) -> Result<u64, SceneError> {
        let place = format!("accessor {}", self.accessor);
        find(&document.accessors, self.accessor, "accessor", &place)?;
        let accessor = &mut document.accessors[self.accessor as usize];
        if accessor.count != count as u64 {
            let wanted = accessor.count;
            let reason = format!("Draco stream must have {wanted} elements, got {count}");
            return Err(SceneError::content(place, reason));
        }
        let total = decoded(total, self.bytes.len() as u64)?;
        accessor.buffer_view = Some(document.buffer_views.len() as u32);
        accessor.byte_offset = 0;
        accessor.sparse = None;
        accessor.component_type = self.component.unwrap_or(accessor.component_type);
        document.buffer_views.push(appended(buffers, self.bytes));
        Ok(total)
    }
}
