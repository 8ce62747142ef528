//! The GLB container: a header, a chunk of JSON and a chunk of binary data.
//!
//! # Source
//! Khronos Group, "glTF 2.0 Specification", section 4, "GLB File Format Specification".

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const JSON: &[u8; 4] = b"JSON";
const BIN: &[u8; 4] = b"BIN\0";
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The chunks of a GLB file. Their contents are not inspected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Glb<'a> {
    /// The first chunk of JSON.
    pub json: &'a [u8],
    /// The first binary chunk.
    pub binary: Option<&'a [u8]>,
    /// The file length from the header, at most the number of bytes given.
    pub length: usize,
}

/// Why bytes were refused as a GLB file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ContainerError {
    /// Not a GLB file.
    #[error("not a GLB file: it must start with \"glTF\", got \"{}\"", found.escape_ascii())]
    Magic {
        /// The first four bytes, or fewer.
        found: Vec<u8>,
    },
    /// Unsupported container version.
    #[error("the GLB version must be 2, got {found}")]
    Version {
        /// The version in the header.
        found: u32,
    },
    /// The file is shorter than its headers announce.
    #[error("truncated file: {what} ends at byte {end}, but the file has {actual} bytes")]
    Truncated {
        /// The truncated part.
        what: &'static str,
        /// Offset of its end, in bytes.
        end: u64,
        /// Actual length in bytes.
        actual: u64,
    },
    /// The file has no JSON chunk.
    #[error("the GLB has no JSON chunk")]
    NoJson,
}

/// A file whose length exceeds the 32-bit length field of the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a GLB file must be at most 4 GiB, got {bytes} bytes")]
pub struct TooLarge {
    /// The length it would have.
    pub bytes: u64,
}

/// Whether the bytes start with the GLB magic.
pub fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

impl<'a> Glb<'a> {
    /// Finds the chunks of a file. Bytes beyond the length in the header are ignored.
    ///
    /// # Errors
    /// [`ContainerError`] unless it is a complete GLB file of version 2 with a JSON chunk.
    pub fn read(bytes: &'a [u8]) -> Result<Self, ContainerError> {
        if !is_glb(bytes) {
            return Err(ContainerError::Magic { found: bytes[..bytes.len().min(4)].to_vec() });
        }
        let actual = bytes.len() as u64;
        let cut_short = |what, end| ContainerError::Truncated { what, end, actual };
        let header = || cut_short("the GLB header", HEADER_BYTES as u64);
        let found = word(bytes, 4).ok_or_else(header)?;
        if found != VERSION {
            return Err(ContainerError::Version { found });
        }
        let length = word(bytes, 8).ok_or_else(header)?;
        let file = bytes.get(..length as usize);
        let file = file.ok_or_else(|| cut_short("the GLB", length.into()))?;
        let (mut json, mut binary) = (None, None);
        let mut at = HEADER_BYTES;
        while let (Some(length), Some(kind)) = (word(file, at), word(file, at + 4)) {
            let start = at + CHUNK_HEADER_BYTES;
            let end = (start as u64).saturating_add(length.into());
            let chunk = usize::try_from(end).ok().and_then(|end| file.get(start..end));
            let chunk = chunk.ok_or_else(|| cut_short("a chunk of the GLB", end))?;
            match &kind.to_le_bytes() {
                JSON if json.is_none() => json = Some(chunk),
                BIN if binary.is_none() => binary = Some(chunk),
                _ => {}
            }
            at = end as usize;
        }
        let json = json.ok_or(ContainerError::NoJson)?;
        Ok(Self { json, binary, length: length as usize })
    }

    /// Assembles a file; chunks are padded to multiples of four bytes.
    ///
    /// # Errors
    /// [`TooLarge`] from 4 GiB on.
    pub fn write(json: &[u8], binary: &[u8]) -> Result<Vec<u8>, TooLarge> {
        let (json_length, binary_length) =
            (json.len().next_multiple_of(4), binary.len().next_multiple_of(4));
        let length = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json_length + binary_length;
        // Lengths are 32-bit; if the file's length fits, so do those of its chunks.
        let Ok(total) = u32::try_from(length) else {
            return Err(TooLarge { bytes: length as u64 });
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
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..).and_then(<[u8]>::first_chunk);
    four.map(|four| u32::from_le_bytes(*four))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_padded_to_four_bytes_and_read_back() {
        let glb = Glb::write(b"{ }", &[9]).unwrap();
        let wanted = b"glTF\x02\0\0\0\x24\0\0\0\x04\0\0\0JSON{ } \x04\0\0\0BIN\0\x09\0\0\0";
        assert_eq!(glb, wanted);
        let read = Glb { json: b"{ } ", binary: Some(&[9, 0, 0, 0]), length: 36 };
        assert_eq!(Glb::read(&glb), Ok(read));
        // Trailing bytes and chunks of other types are skipped.
        let longer = [&glb[..], b"more"].concat();
        assert_eq!(Glb::read(&longer), Ok(read));
        let mut other = glb.clone();
        other[32..36].copy_from_slice(b"ELSE");
        assert_eq!(Glb::read(&other).map(|read| read.json), Ok(&b"{ } "[..]));
    }

    #[test]
    fn invalid_files_are_rejected() {
        let refused = |bytes: &[u8]| Glb::read(bytes).unwrap_err().to_string();
        assert!(refused(b"\x89PNG").ends_with(r#"got "\x89PNG""#), "{}", refused(b"\x89PNG"));
        assert!(refused(b"").ends_with(r#"got """#));
        assert!(
            refused(b"glTF").contains("the GLB header ends at byte 12, but the file has 4 bytes")
        );
        assert_eq!(refused(b"glTF\x01\0\0\0"), "the GLB version must be 2, got 1");
        let glb = Glb::write(b"{}", &[]).unwrap();
        assert!(refused(&glb[..20]).contains("the GLB ends at byte 32, but the file has 20 bytes"));
        let mut chunk = glb.clone();
        chunk[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(refused(&chunk).contains("a chunk of the GLB ends at byte 4294967315"));
        assert_eq!(refused(b"glTF\x02\0\0\0\x0c\0\0\0"), "the GLB has no JSON chunk");
        let mut kind = glb;
        kind[16..20].copy_from_slice(b"ELSE");
        assert_eq!(refused(&kind), "the GLB has no JSON chunk");
    }
}
