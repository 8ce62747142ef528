//! VRM 1.0: bones and expressions by nodes.

use serde_json::json;
use uvgraft_tests::strip::Strip;

use super::{choose, gltf, reading};

fn person() -> Strip {
    let mut strip = Strip::new();
    let bind = json!({ "node": 2, "index": 0, "weight": 1.0 });
    strip.json["extensionsUsed"] = json!(["VRMC_vrm"]);
    strip.json["extensions"] = json!({ "VRMC_vrm": {
        "specVersion": "1.0",
        "meta": { "name": "strip", "authors": ["nobody"], "licenseUrl": "https://vrm.dev/licenses/1.0/" },
        "humanoid": { "humanBones": { "hips": { "node": 0 }, "head": { "node": 1 } } },
        "expressions": {
            "preset": { "happy": { "morphTargetBinds": [bind], "isBinary": false } },
            "custom": { "own": { "morphTargetBinds": [bind], "isBinary": true } }
        }
    }});
    strip
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<gltf::Changes>(bytes).map_or_else(Vec::new, |changes| changes.file(person()))
}

pub(crate) fn run(bytes: &[u8]) {
    reading::scene(&file(bytes));
}
