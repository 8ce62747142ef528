//! Changes of glTF files that keep them consistent: what a generator of JSON alone hardly finds.

use arbitrary::Arbitrary;
use serde_json::{Value, json};
use uvgraft_tests::strip::{Strip, png};

use super::number::{Many, Number, Patch};
use super::{MAX_BYTES, json};

/// What is changed in a file.
#[derive(Debug, Arbitrary)]
pub(super) struct Changes {
    first: Change,
    further: [Option<Change>; 2],
    is_text: Option<bool>,
    binary: Option<Patch>,
}

#[derive(Debug, Arbitrary)]
enum Change {
    /// Any value of the JSON.
    Json(json::Change),
    /// The number of elements of all accessors that have as many as one.
    Elements { accessor: u8, count: Many, is_stored: bool },
    /// The count of an accessor without data, which are zeros.
    Zeros { accessor: u8, count: Number },
    /// The nodes that show a mesh.
    Nodes { mesh: u8, count: Many },
    /// The instances of a node.
    Instances { node: u8, count: Many },
    /// Nodes in a chain.
    Chain { length: Many },
    /// The primitives of a mesh that share all arrays.
    Primitives { mesh: u8, count: Many },
    /// The morph targets of a mesh, and their names.
    Targets { mesh: u8, count: Many },
    /// The size of an image whose file is small.
    Image { width: Many, height: Many, is_whole: bool },
    /// The images, each with a texture and a material.
    Materials { count: Many },
    /// The channels of an animation.
    Channels { count: Many },
    /// The joints of a skin.
    Joints { count: Many },
}

impl Changes {
    pub fn file(&self, mut strip: Strip) -> Vec<u8> {
        let mut changes: Vec<&Change> =
            [&self.first].into_iter().chain(self.further.iter().flatten()).collect();
        // What any value may become comes last, since the others count on what is there.
        changes.sort_by_key(|change| matches!(change, Change::Json(_)));
        changes.into_iter().for_each(|change| change.apply(&mut strip));
        self.binary.into_iter().for_each(|patch| patch.apply(&mut strip.binary, false));
        let text = json::text(&strip.json);
        if self.is_text == Some(true) {
            return text.into();
        }
        // Lengths of chunks are those of what they have.
        uvgraft_gltf::container::Glb::write(text.as_bytes(), &strip.binary).expect("below 4 GiB")
    }
}

impl Change {
    fn apply(&self, strip: &mut Strip) {
        match *self {
            Self::Json(ref change) => change.apply(&mut strip.json),
            Self::Elements { accessor, count, is_stored } => {
                elements(strip, accessor.into(), count, is_stored);
            }
            Self::Zeros { accessor, count } => {
                let Some(accessor) = nth(strip, "/accessors", accessor.into()) else {
                    return;
                };
                accessor.as_object_mut().into_iter().for_each(|it| drop(it.remove("bufferView")));
                accessor["count"] =
                    count.instead_of(accessor["count"].as_u64().unwrap_or(0)).into();
            }
            Self::Nodes { mesh, count } => {
                let node = json!({ "mesh": mesh % 2, "name": "another" });
                for _ in 0..count.of(40) {
                    let index = push(strip, "/nodes", node.clone());
                    push(strip, "/scenes/0/nodes", index.into());
                }
            }
            Self::Instances { node, count } => {
                let accessor = json!({ "componentType": 5126, "type": "VEC3", "count": count.0 });
                let accessor = push(strip, "/accessors", accessor);
                let Some(node) = nth(strip, "/nodes", node.into()) else { return };
                node["mesh"] = 0.into();
                node["extensions"]["EXT_mesh_gpu_instancing"] =
                    json!({ "attributes": { "TRANSLATION": accessor } });
            }
            Self::Chain { length } => {
                let first = strip.json["nodes"].as_array().map_or(0, Vec::len);
                for at in first..first + length.of(40) {
                    push(strip, "/nodes", json!({ "children": [at + 1], "mesh": 0 }));
                }
                push(strip, "/nodes", json!({ "name": "last" }));
                push(strip, "/scenes/0/nodes", first.into());
            }
            Self::Primitives { mesh, count } => {
                let Some(mesh) = nth(strip, "/meshes", mesh.into()) else { return };
                json::repeat(&mut mesh["primitives"], 0, count);
            }
            Self::Targets { mesh, count } => {
                let Some(mesh) = nth(strip, "/meshes", mesh.into()) else { return };
                json::repeat(&mut mesh["primitives"][0]["targets"], 0, count);
                json::repeat(&mut mesh["extras"]["targetNames"], 0, count);
            }
            Self::Image { width, height, is_whole } => image(strip, [width.0, height.0], is_whole),
            Self::Materials { count } => {
                for _ in 0..count.of(200) {
                    let first = strip.json["images"][0].clone();
                    let image = push(strip, "/images", first);
                    let texture = push(strip, "/textures", json!({ "source": image }));
                    let color = json!({ "baseColorTexture": { "index": texture } });
                    let material = json!({ "pbrMetallicRoughness": color });
                    push(strip, "/materials", material);
                }
            }
            Self::Channels { count } => {
                let Some(clip) = nth(strip, "/animations", 0) else { return };
                json::repeat(&mut clip["channels"], 0, count);
            }
            Self::Joints { count } => {
                let Some(skin) = nth(strip, "/skins", 0) else { return };
                skin.as_object_mut()
                    .into_iter()
                    .for_each(|it| drop(it.remove("inverseBindMatrices")));
                json::repeat(&mut skin["joints"], 0, count);
            }
        }
    }
}

/// An element of a list of the file; an index beyond its end counts from the start again.
fn nth<'s>(strip: &'s mut Strip, list: &str, index: usize) -> Option<&'s mut Value> {
    let list = strip.json.pointer_mut(list)?.as_array_mut().filter(|list| !list.is_empty())?;
    let index = index % list.len();
    list.get_mut(index)
}

/// Adds an element to a list of the file; returns its index.
fn push(strip: &mut Strip, list: &str, element: Value) -> usize {
    if strip.json.pointer(list).is_none() {
        strip.json[list.trim_start_matches('/')] = json!([]);
    }
    let list = strip.json.pointer_mut(list).and_then(Value::as_array_mut);
    list.map_or(0, |list| {
        list.push(element);
        list.len() - 1
    })
}

/// Bytes of an element of an accessor.
fn element_bytes(accessor: &Value) -> usize {
    let component = match accessor["componentType"].as_u64() {
        Some(5120 | 5121) => 1,
        Some(5122 | 5123) => 2,
        _ => 4,
    };
    let count = match accessor["type"].as_str() {
        Some("SCALAR") => 1,
        Some("VEC2") => 2,
        Some("VEC3") => 3,
        Some("MAT4") => 16,
        _ => 4,
    };
    component * count
}

/// Changes the counts of all accessors that have as many elements as one; vertices stay whole.
fn elements(strip: &mut Strip, accessor: usize, count: Many, is_stored: bool) {
    let Some(accessor) = nth(strip, "/accessors", accessor) else { return };
    let was = accessor["count"].clone();
    let all = strip.json["accessors"].as_array().map_or(0, Vec::len);
    let mut room = MAX_BYTES;
    for index in 0..all {
        let accessor = &mut strip.json["accessors"][index];
        if accessor["count"] != was {
            continue;
        }
        accessor["count"] = count.0.into();
        let bytes = element_bytes(accessor) * count.0;
        if !is_stored {
            accessor.as_object_mut().into_iter().for_each(|it| drop(it.remove("bufferView")));
        } else if let Some(left) = room.checked_sub(bytes) {
            room = left;
            let view = strip.view(&vec![0; bytes]);
            strip.json["accessors"][index]["bufferView"] = view.into();
        }
    }
}

/// Makes the first image one of any size and of a single colour, or the beginning of one.
fn image(strip: &mut Strip, [width, height]: [usize; 2], is_whole: bool) {
    let rows = if is_whole { height.saturating_mul(1 + 3 * width) } else { 100 };
    let zlib = super::png::zlib(&vec![0; rows.min(8 * MAX_BYTES)]);
    let view = strip.view(&png(width as u32, height as u32, &zlib));
    if let Some(image) = nth(strip, "/images", 0) {
        *image = json!({ "bufferView": view, "mimeType": "image/png" });
    }
}
