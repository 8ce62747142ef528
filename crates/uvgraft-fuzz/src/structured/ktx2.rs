//! KTX2 images of a scene: sides, levels and streams that unpack to much. Without the feature `ktx2`
//! of `uvgraft-gltf` they are refused at once.

use arbitrary::Arbitrary;
use serde_json::json;
use uvgraft_tests::strip::Strip;

use super::number::{Many, Number, Patch};
use super::{MAX_BYTES, choose, gltf, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    sides: [Many; 2],
    header: Option<(u8, Number)>,
    scheme: u8,
    is_etc1s: bool,
    level: Option<Many>,
    level_offset: Option<(bool, Number)>,
    patch: Option<Patch>,
    changes: Option<gltf::Changes>,
}

/// Bytes of the header and the index of one level.
const HEADER: usize = 104;

/// A Zstandard frame whose blocks each are one byte, many times.
fn zstandard(count: usize) -> Vec<u8> {
    // A window of 8 MiB, no size.
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0, 13 << 3];
    let mut rest = count;
    loop {
        let length = rest.min(1 << 17);
        rest -= length;
        let head = (length as u32) << 3 | 1 << 1 | u32::from(rest == 0);
        frame.extend(&head.to_le_bytes()[..3]);
        frame.push(0);
        if rest == 0 {
            return frame;
        }
    }
}

impl Choices {
    fn image(&self) -> Vec<u8> {
        let [width, height] = self.sides.map(|side| side.0);
        let blocks = width.div_ceil(4).saturating_mul(height.div_ceil(4));
        let count = self.level.map_or(blocks.saturating_mul(16), |many| many.0).min(64 * MAX_BYTES);
        let scheme = u32::from(self.scheme % 4);
        let level = match scheme {
            2 => zstandard(count),
            _ => vec![0; count.min(MAX_BYTES)],
        };
        let global = if self.is_etc1s { vec![0; 64] } else { Vec::new() };
        let model = if self.is_etc1s { 163 } else { 166 };
        // The total size, then a block of 40 bytes whose fifth byte is the model.
        let mut descriptor = vec![44, 0, 0, 0, 0, 0, 0, 0, 2, 0, 40, 0, model, 1, 2, 0];
        descriptor.resize(44, 0);
        let mut file = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
        let words =
            [0, 1, width as u32, height as u32, 0, 0, 1, 1, scheme, HEADER as u32, 44, 0, 0];
        words.iter().for_each(|word| file.extend(word.to_le_bytes()));
        let global_at = HEADER + descriptor.len();
        let level_at = global_at + global.len();
        let longs = [global_at, global.len(), level_at, level.len(), count];
        longs.iter().for_each(|&long| file.extend((long as u64).to_le_bytes()));
        if let Some((which, to)) = self.header {
            to.patch(&mut file, 12 + 4 * (usize::from(which) % 13), 4, false);
        }
        if let Some((is_length, to)) = self.level_offset {
            to.patch(&mut file, if is_length { 88 } else { 80 }, 8, false);
        }
        for part in [descriptor, global, level] {
            file.extend(part);
        }
        self.patch.into_iter().for_each(|patch| patch.apply(&mut file, false));
        file
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    let Some(choices) = choose::<Choices>(bytes) else { return Vec::new() };
    let mut strip = Strip::new();
    let view = strip.view(&choices.image());
    strip.json["images"] = json!([{ "bufferView": view, "mimeType": "image/ktx2" }]);
    strip.json["textures"] = json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    match choices.changes {
        Some(changes) => changes.file(strip),
        None => strip.glb(),
    }
}

pub(crate) fn run(bytes: &[u8]) {
    reading::scene(&file(bytes));
}
