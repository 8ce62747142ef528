//! The container: a header, the JSON and the buffer, each a chunk.
//!
//! Source: "glTF 2.0 Specification", chapter 4, "GLB File Format Specification".

use super::GlbError;

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const JSON: &[u8; 4] = b"JSON";
const BIN: &[u8; 4] = b"BIN\0";
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// Puts a file together.
pub(crate) fn pack(json: &[u8], binary: &[u8]) -> Result<Vec<u8>, GlbError> {
    let (json_length, binary_length) =
        (json.len().next_multiple_of(4), binary.len().next_multiple_of(4));
    let length = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json_length + binary_length;
    // Lengths are 32 bits wide, and so are those of the parts then.
    let Ok(total) = u32::try_from(length) else {
        return Err(GlbError::TooLarge { bytes: length as u64 });
    };
    let mut bytes = Vec::with_capacity(length);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&total.to_le_bytes());
    bytes.extend_from_slice(&(json_length as u32).to_le_bytes());
    bytes.extend_from_slice(JSON);
    bytes.extend_from_slice(json);
    bytes.resize(HEADER_BYTES + CHUNK_HEADER_BYTES + json_length, b' ');
    bytes.extend_from_slice(&(binary_length as u32).to_le_bytes());
    bytes.extend_from_slice(BIN);
    bytes.extend_from_slice(binary);
    bytes.resize(length, 0);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_padded_to_four_bytes() {
        let glb = pack(b"{ }", &[9]).unwrap();
        let wanted = b"glTF\x02\0\0\0\x24\0\0\0\x04\0\0\0JSON{ } \x04\0\0\0BIN\0\x09\0\0\0";
        assert_eq!(glb, wanted);
    }
}
