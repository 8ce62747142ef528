//! Small glTF files that ask for much memory: by nodes that show the same mesh, arrays without data, images of
//! one colour, and whatever else multiplies.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use serde_json::{Value, json};

use crate::strip::{self, Strip};

/// A file, and who refuses it for which reason. All others read it in little memory.
#[derive(Debug)]
pub struct Greedy {
    /// What is much.
    pub name: &'static str,
    /// The file, as GLB.
    pub file: Vec<u8>,
    /// Why scenes are refused, to render and to view.
    pub as_scene: Option<&'static str>,
    /// Why meshes are refused.
    pub as_mesh: Option<&'static str>,
    /// Why its contents are refused.
    pub contents: Option<&'static str>,
}

/// An array of zeros, which has no data.
fn zeros(strip: &mut Strip, component: u32, count: u64, shape: &str) -> usize {
    let accessors = strip.json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "componentType": component, "count": count, "type": shape }));
    accessors.len() - 1
}

fn repeated(value: &Value, count: usize) -> Value {
    Value::Array(vec![value.clone(); count])
}

/// A scene of nodes that show the first mesh.
fn nodes(strip: Strip, node: &Value, count: usize) -> Strip {
    let all: Vec<usize> = (0..count).collect();
    strip
        .with("/nodes", repeated(node, count))
        .with("/scenes/0/nodes", json!(all))
        .with("/animations", json!([]))
        .with("/skins", json!([{ "joints": [0, 1] }]))
}

/// As many triangles without data as a primitive has by `vertices` and `corners`.
fn empty_primitive(strip: &mut Strip, vertices: u64, corners: u64) -> Value {
    let positions = zeros(strip, 5126, vertices, "VEC3");
    let uv = zeros(strip, 5126, vertices, "VEC2");
    let indices = zeros(strip, 5125, corners, "SCALAR");
    json!({ "attributes": { "POSITION": positions, "TEXCOORD_0": uv }, "indices": indices })
}

fn binds() -> Strip {
    let binds = repeated(&json!({ "mesh": 0, "index": 0, "weight": 100 }), 1_500);
    nodes(Strip::new(), &json!({ "mesh": 0 }), 1_500).with(
        "/extensions",
        json!({ "VRM": { "blendShapeMaster": { "blendShapeGroups": [{ "name": "smile", "binds": binds }] } } }),
    )
}

fn triangle_strip() -> Strip {
    let mut strip = Strip::new();
    let mut primitive = empty_primitive(&mut strip, 3, 1 << 27);
    primitive["mode"] = 5.into();
    strip.with("/meshes/0/primitives", json!([primitive]))
}

fn unshown_meshes() -> Strip {
    let mut strip = Strip::new();
    for _ in 0..5 {
        let primitive = empty_primitive(&mut strip, 1 << 24, 3);
        let meshes = strip.json["meshes"].as_array_mut().unwrap();
        meshes.push(json!({ "primitives": [primitive] }));
    }
    strip
}

fn nodes_of_a_mesh() -> Strip {
    let mut strip = Strip::new();
    let primitive = empty_primitive(&mut strip, 1_500, 9_000);
    let strip = strip.with("/meshes/0/primitives", json!([primitive]));
    nodes(strip, &json!({ "mesh": 0 }), 10_000)
}

fn instances() -> Strip {
    let mut strip = Strip::new();
    let primitive = empty_primitive(&mut strip, 3, 48);
    let moves = zeros(&mut strip, 5126, 1 << 18, "VEC3");
    let strip = strip.with("/meshes/0/primitives", json!([primitive]));
    let instancing =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": moves } } });
    strip.with("/nodes/2/extensions", instancing).with("/nodes/2/skin", Value::Null)
}

fn images() -> Strip {
    let mut strip = Strip::new();
    // Only the header is ever read.
    let (mut images, mut materials, mut primitives) = (vec![], vec![], vec![]);
    for index in 0..4 {
        let view = strip.view(&strip::png(8192, 8192, &[]));
        images.push(json!({ "bufferView": view, "mimeType": "image/png" }));
        materials
            .push(json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": index } } }));
        let mut primitive = strip.json["meshes"][0]["primitives"][0].clone();
        primitive["material"] = index.into();
        primitives.push(primitive);
    }
    let textures: Vec<Value> = (0..4).map(|source| json!({ "source": source })).collect();
    strip
        .with("/images", json!(images))
        .with("/textures", json!(textures))
        .with("/materials", json!(materials))
        .with("/meshes/0/primitives", json!(primitives))
}

fn bind_matrices() -> Strip {
    let mut strip = Strip::new();
    let matrices = zeros(&mut strip, 5126, 1 << 26, "MAT4");
    strip.with("/skins/0/inverseBindMatrices", json!(matrices))
}

fn channels() -> Strip {
    let mut strip = Strip::new();
    let mut channels = Vec::new();
    let mut samplers = Vec::new();
    for sampler in 0..100 {
        let (input, output) =
            (zeros(&mut strip, 5126, 1 << 21, "SCALAR"), zeros(&mut strip, 5126, 1 << 21, "VEC3"));
        samplers.push(json!({ "input": input, "output": output }));
        channels
            .push(json!({ "sampler": sampler, "target": { "node": 0, "path": "translation" } }));
    }
    strip.with("/animations", json!([{ "samplers": samplers, "channels": channels }]))
}

fn joint_sets() -> Strip {
    let mut strip = Strip::new();
    let mut primitive = empty_primitive(&mut strip, 1 << 16, 3);
    let joints = zeros(&mut strip, 5123, 1 << 16, "VEC4");
    for set in 0..1_000 {
        primitive["attributes"][format!("JOINTS_{set}")] = joints.into();
        primitive["attributes"][format!("WEIGHTS_{set}")] = joints.into();
    }
    strip.with("/meshes/0/primitives", json!([primitive]))
}

fn mesh_name() -> Strip {
    let name = "long".repeat(50_000);
    nodes(Strip::new(), &json!({ "mesh": 0 }), 1_000).with("/meshes/0/name", json!(name))
}

fn material_name() -> Strip {
    let uses = (0..2_000).map(|k| (format!("{k}Texture"), json!({ "index": 0 })));
    let uses: serde_json::Map<String, Value> = uses.collect();
    Strip::new()
        .with("/materials/0/name", json!("long".repeat(50_000)))
        .with("/materials/0/extras", Value::Object(uses))
}

fn morph_targets() -> Strip {
    let mut strip = Strip::new();
    let mut primitive = empty_primitive(&mut strip, 1 << 18, 3);
    // Those of a file may share their data.
    let view = strip.view(&vec![0x3f; 12 << 18]);
    let accessor =
        json!({ "bufferView": view, "componentType": 5126, "count": 1 << 18, "type": "VEC3" });
    let accessors = strip.json["accessors"].as_array_mut().unwrap();
    let first = accessors.len();
    accessors.extend(vec![accessor; 1_500]);
    let targets = (first..first + 1_500).map(|index| json!({ "POSITION": index }));
    primitive["targets"] = targets.collect();
    strip.with("/meshes/0/primitives", json!([primitive]))
}

fn objects() -> Strip {
    Strip::new().with("/materials", repeated(&json!({}), 900_000))
}

/// All of them.
pub fn files() -> Vec<Greedy> {
    type Refused = Option<&'static str>;
    let file = |name, strip: Strip, as_scene: Refused, as_mesh: Refused, contents: Refused| {
        Greedy { name, file: strip.glb(), as_scene, as_mesh, contents }
    };
    let memory = Some("MiB of memory");
    let of_expressions = Some("morph targets of expressions");
    let [triangles, vertices] = [Some("triangles, of all"), Some("vertices, of all")];
    vec![
        file("binds of blend shapes", binds(), of_expressions, None, of_expressions),
        file("a triangle strip", triangle_strip(), triangles, triangles, None),
        file("meshes that nothing shows", unshown_meshes(), vertices, None, None),
        file("nodes of a mesh", nodes_of_a_mesh(), memory, memory, None),
        file("instances", instances(), memory, memory, None),
        file("images", images(), memory, None, None),
        file("bind matrices", bind_matrices(), memory, memory, memory),
        file("channels", channels(), memory, None, memory),
        file("sets of joints", joint_sets(), memory, memory, None),
        file("names of a mesh", mesh_name(), None, None, Some("bytes of names")),
        file("names of a material", material_name(), None, None, Some("bytes of names")),
        file("morph targets", morph_targets(), memory, None, None),
        file("objects", objects(), memory, memory, memory),
    ]
}
