//! Replaces compressed parts of a file by plain ones: each becomes a new buffer, and the document
//! is updated to refer to it. Later stages see plain buffer views only.

mod draco;
mod meshopt;

use super::asset::Bytes;
use super::budget::MAX_BYTES;
use super::check::{slice, too_many};
use super::document::{BufferView, Document};
use super::error::SceneError;

/// Buffers of a file, followed by those from decompression.
type Buffers<'a> = Vec<Bytes<'a>>;

/// Decompresses the parts compressed by `EXT_meshopt_compression`, `KHR_meshopt_compression` and
/// `KHR_draco_mesh_compression`.
///
/// # Errors
/// [`SceneError`] for damaged streams, or if more than a gigabyte is decompressed in total.
pub(super) fn unpack(document: &mut Document, buffers: &mut Buffers<'_>) -> Result<(), SceneError> {
    let mut total = 0;
    for index in 0..document.buffer_views.len() {
        let Some(compressed) = document.buffer_views[index].extensions.meshopt.take() else {
            continue;
        };
        let place = format!("buffer view {index}");
        total = decoded(total, compressed.decoded_length())?;
        let stored = (compressed.buffer, compressed.byte_offset, compressed.byte_length);
        let bytes = slice(buffers, stored, &place)?;
        let plain =
            compressed.decode(bytes).map_err(|reason| SceneError::content(place, reason))?;
        let is_attribute = compressed.mode == "ATTRIBUTES";
        document.buffer_views[index] = BufferView {
            byte_stride: is_attribute.then_some(compressed.byte_stride),
            ..appended(buffers, plain)
        };
    }
    draco::unpack(document, buffers, total)
}

/// Adds decoded bytes to the total, within the limit.
fn decoded(total: u64, more: u64) -> Result<u64, SceneError> {
    let total = total.saturating_add(more);
    too_many("decompressed bytes", total, MAX_BYTES)?;
    Ok(total)
}

/// Appends a buffer; returns a view of all of it.
fn appended(buffers: &mut Buffers<'_>, bytes: Vec<u8>) -> BufferView {
    let view = BufferView {
        buffer: buffers.len() as u32,
        byte_length: bytes.len() as u64,
        ..BufferView::default()
    };
    buffers.push(bytes.into());
    view
}
