//! EXRs of a kind that uvgraft reads and does not write: luminance, and chroma at half the resolution.

pub(crate) fn attribute(name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
    let length = (value.len() as i32).to_le_bytes();
    [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, value].concat()
}

/// A channel of floats, since of halves the decoder of B44 panics on some, if a mutation names that compression.
fn channel(name: &str, sampling: i32) -> Vec<u8> {
    let numbers = [2, 0, sampling, sampling].map(i32::to_le_bytes);
    [name.as_bytes(), b"\0", numbers.as_flattened()].concat()
}

/// A file of 8 × 4 texels.
///
/// - `compression`: of those whose blocks have one row.
/// - `blocks`: four, from the top to the bottom.
fn exr(compression: u8, blocks: &[&[u8]]) -> Vec<u8> {
    let channels = [channel("BY", 2), channel("RY", 2), channel("Y", 1), vec![0]].concat();
    let window = [0, 0, 7, 3i32].map(i32::to_le_bytes);
    let one = 1f32.to_le_bytes();
    let mut file = [
        b"\x76\x2f\x31\x01\x02\0\0\0".to_vec(),
        attribute("channels", "chlist", &channels),
        attribute("compression", "compression", &[compression]),
        attribute("dataWindow", "box2i", window.as_flattened()),
        attribute("displayWindow", "box2i", window.as_flattened()),
        attribute("lineOrder", "lineOrder", &[0]),
        attribute("pixelAspectRatio", "float", &one),
        attribute("screenWindowCenter", "v2f", &[0; 8]),
        attribute("screenWindowWidth", "float", &one),
        vec![0],
    ]
    .concat();
    let mut offset = file.len() + 8 * blocks.len();
    for block in blocks {
        file.extend((offset as u64).to_le_bytes());
        offset += 8 + block.len();
    }
    for (row, block) in (0i32..).zip(blocks) {
        file.extend([row.to_le_bytes(), (block.len() as i32).to_le_bytes()].as_flattened());
        file.extend(*block);
    }
    file
}

/// Uncompressed, and runs of equal bytes.
pub(crate) fn all() -> Vec<Vec<u8>> {
    let floats: Vec<u8> = (0..16).flat_map(|at| [0, 0, at << 3, 0x3e]).collect();
    vec![
        exr(0, &[&floats, &floats[32..], &floats, &floats[32..]]),
        exr(1, &[&[63, 128], &[31, 128], &[63, 128], &[31, 128]]),
    ]
}
