//! The header of KTX2 files.
//!
//! # Source
//! Khronos Group, "KTX File Format Specification", version 2.0, and `KHR_texture_basisu`.

use uvgraft::Size;

use super::embed_error::EmbedError;

/// The file identifier of KTX2.
pub(crate) const KTX2_IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// The image size from the header; errors if `KHR_texture_basisu` does not allow the file.
pub(super) fn size(bytes: &[u8]) -> Result<Size, EmbedError> {
    let wrong = |problem| Err(EmbedError::Ktx2 { problem });
    let word = |index: usize| {
        let at = KTX2_IDENTIFIER.len() + 4 * index;
        bytes.get(at..at + 4)?.first_chunk().map(|&word| u32::from_le_bytes(word))
    };
    // vkFormat, typeSize, width, height, depth, layers, faces, levels.
    let words: Option<Vec<u32>> = (0..8).map(word).collect();
    let Some(&[format, _, width, height, depth, layers, faces, _]) = words.as_deref() else {
        return wrong("is truncated");
    };
    if format != 0 {
        return wrong("must be in a Basis Universal format (ETC1S or UASTC)");
    }
    if depth != 0 || layers != 0 || faces != 1 {
        return wrong("must be a single 2D image");
    }
    if width == 0 || height == 0 || !width.is_multiple_of(4) || !height.is_multiple_of(4) {
        return wrong("must have sides that are multiples of 4");
    }
    Ok(Size::new(width, height))
}
