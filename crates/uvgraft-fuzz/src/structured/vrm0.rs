//! VRM 0.x: blend shapes by meshes, which move the morph targets of all nodes that show them.

use arbitrary::Arbitrary;
use serde_json::json;
use uvgraft_tests::strip::Strip;

use super::number::Many;
use super::{choose, gltf, json, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    binds: Option<Many>,
    changes: gltf::Changes,
}

fn person() -> Strip {
    let mut strip = Strip::new();
    strip.json["extensionsUsed"] = json!(["VRM"]);
    strip.json["extensions"] = json!({ "VRM": {
        "meta": { "title": "strip", "author": "nobody" },
        "humanoid": { "humanBones": [{ "bone": "hips", "node": 0 }, { "bone": "head", "node": 1 }] },
        "blendShapeMaster": { "blendShapeGroups": [{
            "name": "Joy", "presetName": "joy", "isBinary": false,
            "binds": [{ "mesh": 0, "index": 0, "weight": 100.0 }]
        }] }
    }});
    strip
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    let Some(Choices { binds, changes }) = choose(bytes) else { return Vec::new() };
    let mut strip = person();
    if let Some(times) = binds {
        let groups = &mut strip.json["extensions"]["VRM"]["blendShapeMaster"]["blendShapeGroups"];
        json::repeat(&mut groups[0]["binds"], 0, times);
    }
    changes.file(strip)
}

pub(crate) fn run(bytes: &[u8]) {
    reading::scene(&file(bytes));
}
