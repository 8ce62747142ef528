//! glTF: skins, morph targets, animations, images, sparse accessors, instances and meshoptimizer's
//! streams.

use arbitrary::Arbitrary;
use serde_json::json;
use uvgraft_tests::strip::{BULGE, Strip};

use super::{choose, gltf, reading};
use crate::seeds;

#[derive(Debug, Arbitrary)]
struct Choices {
    is_compressed: bool,
    is_sparse: bool,
    changes: gltf::Changes,
}

/// The strip with a morph target of one vertex.
fn sparse() -> Strip {
    let mut strip = Strip::new();
    let indices = strip.view(&2_u16.to_le_bytes());
    let values = strip.view(&[0; 12]);
    strip.with(
        &format!("/accessors/{BULGE}"),
        json!({
            "componentType": 5126, "type": "VEC3", "count": 6,
            "sparse": {
                "count": 1,
                "indices": { "bufferView": indices, "componentType": 5123 },
                "values": { "bufferView": values }
            }
        }),
    )
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    let Some(Choices { is_compressed, is_sparse, changes }) = choose(bytes) else {
        return Vec::new();
    };
    changes.file(match (is_compressed, is_sparse) {
        (true, _) => seeds::instances(),
        (false, true) => sparse(),
        (false, false) => Strip::new(),
    })
}

pub(crate) fn run(bytes: &[u8]) {
    reading::scene(&file(bytes));
}
