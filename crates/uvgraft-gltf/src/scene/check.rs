//! Validation helpers shared by all readers of file contents.

use super::asset::Bytes;
use super::error::SceneError;

/// Errors if `found` exceeds a limit of the reader.
pub(super) fn too_many(what: &'static str, found: u64, max: u64) -> Result<(), SceneError> {
    if found > max { Err(SceneError::TooMany { what, found, max }) } else { Ok(()) }
}

/// An entry of one of the file's lists; errors if the index is out of range.
///
/// - `place`: the referring object, for messages.
pub(super) fn find<'a, T>(
    list: &'a [T],
    index: u32,
    what: &str,
    place: &str,
) -> Result<&'a T, SceneError> {
    list.get(index as usize).ok_or_else(|| {
        let reason = format!("refers to {what} {index}, but the file has {}", list.len());
        SceneError::content(place, reason)
    })
}

/// A checked range of a buffer.
pub(super) fn slice<'a>(
    buffers: &'a [Bytes<'_>],
    (buffer, offset, length): (u32, u64, u64),
    place: &str,
) -> Result<&'a [u8], SceneError> {
    let bytes = find(buffers, buffer, "buffer", place)?;
    let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
    let end = end.ok_or_else(|| {
        let found = bytes.len();
        let reason = format!(
            "{length} bytes at offset {offset} exceed buffer {buffer}, which has {found} bytes"
        );
        SceneError::content(place, reason)
    })?;
    Ok(&bytes[offset as usize..end as usize])
}
