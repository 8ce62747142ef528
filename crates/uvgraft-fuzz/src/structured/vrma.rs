//! VRM animations: nodes and clips without meshes.

use serde_json::json;
use uvgraft_tests::strip::Strip;

use super::{choose, gltf, reading};

fn bow() -> Strip {
    let mut strip = Strip::new();
    let json = strip.json.as_object_mut().expect("an object");
    for name in ["meshes", "skins", "materials", "textures", "samplers", "images"] {
        json.remove(name);
    }
    json["nodes"][2] = json!({ "name": "none" });
    json.insert("extensionsUsed".to_owned(), json!(["VRMC_vrm_animation"]));
    json.insert(
        "extensions".to_owned(),
        json!({ "VRMC_vrm_animation": {
            "specVersion": "1.0",
            "humanoid": { "humanBones": { "hips": { "node": 0 }, "head": { "node": 1 } } },
            "expressions": { "preset": { "happy": { "node": 2 } } }
        }}),
    );
    strip
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<gltf::Changes>(bytes).map_or_else(Vec::new, |changes| changes.file(bow()))
}

pub(crate) fn run(bytes: &[u8]) {
    reading::scene(&file(bytes));
}
