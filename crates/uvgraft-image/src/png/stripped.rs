//! A PNG's picture alone.

/// What decodes the picture, gives its colours, shows it at its size, or animates it.
const KEPT: [&[u8; 4]; 18] = [
    b"IHDR", b"PLTE", b"IDAT", b"tRNS", b"cHRM", b"cICP", b"cLLI", b"gAMA", b"iCCP", b"mDCV",
    b"sBIT", b"sRGB", b"bKGD", b"pHYs", b"acTL", b"fcTL", b"fdAT", b"IEND",
];

/// See [`without_metadata`](crate::without_metadata).
///
/// - `exif`: a block to write instead of the file's.
pub(super) fn stripped(bytes: &[u8], exif: Option<&[u8]>) -> Option<Vec<u8>> {
    let (signature, mut rest) = bytes.split_at_checked(8)?;
    let mut out = signature.to_vec();
    loop {
        let length = u32::from_be_bytes(*rest.first_chunk()?) as usize;
        // Length, kind, content and checksum.
        let (chunk, after) = rest.split_at_checked(length.checked_add(12)?)?;
        let kind = chunk[4..].first_chunk()?;
        if KEPT.contains(&kind) {
            out.extend(chunk);
        }
        match kind {
            b"IHDR" => out.extend(exif.into_iter().flat_map(exif_chunk)),
            b"IEND" => return Some(out),
            _ => {}
        }
        rest = after;
    }
}

fn exif_chunk(exif: &[u8]) -> Vec<u8> {
    let mut chunk = (exif.len() as u32).to_be_bytes().to_vec();
    chunk.extend(b"eXIf");
    chunk.extend(exif);
    let checksum = crc32fast::hash(&chunk[4..]);
    chunk.extend(checksum.to_be_bytes());
    chunk
}
