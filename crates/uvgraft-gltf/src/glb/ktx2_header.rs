//! The header of KTX2 files, for whatever reads one.
//!
//! # Source
//! Khronos Group, "KTX File Format Specification", version 2.0, and `KHR_texture_basisu`.

use uvgraft::Size;

use super::embed_error::EmbedError;

/// The file identifier of KTX2.
pub(crate) const KTX2_IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// What a file says about itself, unchecked.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(not(feature = "ktx2"), expect(dead_code, reason = "only decoding needs all of it"))]
pub(crate) struct Ktx2Header {
    /// `VkFormat`; 0 for formats of Basis Universal.
    pub format: u32,
    /// Width, height and depth.
    pub sides: [u32; 3],
    pub layers: u32,
    pub faces: u32,
    pub levels: u32,
    pub supercompression: u32,
    /// Offset and length of the data format descriptor.
    pub descriptor: [u64; 2],
    /// Offset and length of the supercompression's global data.
    pub global: [u64; 2],
}

impl Ktx2Header {
    /// `None` if a file is another, or truncated within the header.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let (words, _) = bytes.strip_prefix(&KTX2_IDENTIFIER)?.as_chunks::<4>();
        let words = words.first_chunk::<17>()?.map(u32::from_le_bytes);
        let long = |at: usize| u64::from(words[at]) | u64::from(words[at + 1]) << 32;
        // Words 1, 11 and 12 are the size of components, and where keys and values are.
        Some(Self {
            format: words[0],
            sides: [words[2], words[3], words[4]],
            layers: words[5],
            faces: words[6],
            levels: words[7],
            supercompression: words[8],
            descriptor: [words[9], words[10]].map(u64::from),
            global: [long(13), long(15)],
        })
    }
}

/// The image size from the header; errors if `KHR_texture_basisu` does not allow the file.
pub(super) fn size(bytes: &[u8]) -> Result<Size, EmbedError> {
    let wrong = |problem| Err(EmbedError::Ktx2 { problem });
    let Some(header) = Ktx2Header::read(bytes) else { return wrong("is truncated") };
    let [width, height, depth] = header.sides;
    if header.format != 0 {
        return wrong("must be in a Basis Universal format (ETC1S or UASTC)");
    }
    if depth != 0 || header.layers != 0 || header.faces != 1 {
        return wrong("must be a single 2D image");
    }
    if width == 0 || height == 0 || !width.is_multiple_of(4) || !height.is_multiple_of(4) {
        return wrong("must have sides that are multiples of 4");
    }
    Ok(Size::new(width, height))
}
