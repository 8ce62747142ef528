//! A small hand-built avatar for tests: a strip that is 1 wide and 2 high, with a joint at its foot
//! and one half-way up.
//!
//! Vertices 0 to 5 lie at heights 0, 0, 1, 1, 2, 2, left (x = -0.5) then right. The foot follows
//! joint 0, the top joint 1, and the vertices half-way up both equally. The morph target `bulge`
//! moves these by 0.5 along Z. The clip `bend` rotates joint 1 by 90° about Z in one second. The
//! texture has four texels: red and green in the upper row, blue and white in the lower one.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// A texture of 2 × 2 texels as PNG, whose zlib stream is one stored block.
pub fn texture() -> Vec<u8> {
    let rows: [u8; 14] = [0, 255, 0, 0, 0, 255, 0, 0, 0, 0, 255, 255, 255, 255];
    let mut zlib = vec![0x78, 1, 1, 14, 0, !14, 0xff];
    zlib.extend(rows);
    let (mut a, mut b) = (1_u32, 0_u32);
    for byte in rows {
        a = (a + u32::from(byte)) % 65_521;
        b = (b + a) % 65_521;
    }
    zlib.extend((b << 16 | a).to_be_bytes());
    png(2, 2, &zlib)
}

/// An 8-bit RGB PNG with any size in its header.
pub fn png(width: u32, height: u32, zlib: &[u8]) -> Vec<u8> {
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], data: &[u8]| {
        let body = [&name[..], data].concat();
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(&body);
        file.extend(crc(&body).to_be_bytes());
    };
    let sides = [width.to_be_bytes(), height.to_be_bytes()].concat();
    chunk(b"IHDR", &[&sides[..], &[8, 2, 0, 0, 0]].concat());
    chunk(b"IDAT", zlib);
    chunk(b"IEND", &[]);
    file
}

fn crc(bytes: &[u8]) -> u32 {
    let mut crc = !0_u32;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    !crc
}

/// A file under construction: its JSON and its binary chunk.
#[derive(Debug, Clone)]
pub struct Strip {
    /// The JSON chunk.
    pub json: Value,
    /// The binary chunk.
    pub binary: Vec<u8>,
}

/// Accessor of the positions.
pub const POSITIONS: usize = 0;
/// Accessor of the texture coordinates.
pub const UV: usize = 1;
/// Accessor of the joints.
pub const JOINTS: usize = 2;
/// Accessor of the weights.
pub const WEIGHTS: usize = 3;
/// Accessor of the triangles' indices.
pub const INDICES: usize = 4;
/// Accessor of the morph target's offsets.
pub const BULGE: usize = 5;
/// Accessor of the inverse bind matrices.
pub const INVERSE_BIND: usize = 6;
/// Accessor of the clip's times.
pub const TIMES: usize = 7;
/// Accessor of the clip's rotations.
pub const TURNS: usize = 8;

impl Default for Strip {
    fn default() -> Self {
        Self::new()
    }
}

impl Strip {
    /// The strip described in the module documentation.
    pub fn new() -> Self {
        let mut strip = Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [0, 2] }],
                "nodes": [
                    { "name": "foot", "children": [1] },
                    { "name": "head", "translation": [0, 1, 0] },
                    { "name": "strip", "mesh": 0, "skin": 0 }
                ],
                "meshes": [{
                    "primitives": [{
                        "attributes": {
                            "POSITION": POSITIONS,
                            "TEXCOORD_0": UV,
                            "JOINTS_0": JOINTS,
                            "WEIGHTS_0": WEIGHTS
                        },
                        "indices": INDICES,
                        "material": 0,
                        "targets": [{ "POSITION": BULGE }]
                    }],
                    "extras": { "targetNames": ["bulge"] }
                }],
                "skins": [{ "joints": [0, 1], "inverseBindMatrices": INVERSE_BIND }],
                "animations": [{
                    "name": "bend",
                    "samplers": [{ "input": TIMES, "output": TURNS }],
                    "channels": [{ "sampler": 0, "target": { "node": 1, "path": "rotation" } }]
                }],
                "materials": [{
                    "name": "cloth",
                    "doubleSided": true,
                    "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }
                }],
                "textures": [{ "source": 0, "sampler": 0 }],
                "samplers": [{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33071 }],
                "accessors": [],
                "bufferViews": [],
                "buffers": [{ "byteLength": 0 }]
            }),
            binary: Vec::new(),
        };
        let floats = |values: &[f32]| -> Vec<u8> {
            values.iter().flat_map(|value| value.to_le_bytes()).collect()
        };
        let heights = [0.0, 0.0, 1.0, 1.0, 2.0, 2.0];
        let places: Vec<f32> =
            (0..6).flat_map(|v| [v as f32 % 2.0 - 0.5, heights[v], 0.0]).collect();
        let uv: Vec<f32> = (0..6).flat_map(|v| [v as f32 % 2.0, 1.0 - heights[v] / 2.0]).collect();
        let weights: Vec<f32> = (0..6)
            .flat_map(|v| {
                let top = heights[v] / 2.0;
                [1.0 - top, top, 0.0, 0.0]
            })
            .collect();
        let bulge: Vec<f32> =
            (0..6).flat_map(|v| [0.0, 0.0, if heights[v] == 1.0 { 0.5 } else { 0.0 }]).collect();
        let mut inverse = [0.0; 32];
        for matrix in 0..2 {
            for k in 0..4 {
                inverse[16 * matrix + 5 * k] = 1.0;
            }
        }
        inverse[16 + 13] = -1.0;
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let indices = [0_u16, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4];
        strip.add(&floats(&places), 5126, 6, "VEC3");
        strip.add(&floats(&uv), 5126, 6, "VEC2");
        strip.add(&[0, 1, 0, 0].repeat(6), 5121, 6, "VEC4");
        strip.add(&floats(&weights), 5126, 6, "VEC4");
        strip.add(&indices.map(u16::to_le_bytes).concat(), 5123, 12, "SCALAR");
        strip.add(&floats(&bulge), 5126, 6, "VEC3");
        strip.add(&floats(&inverse), 5126, 2, "MAT4");
        strip.add(&floats(&[0.0, 1.0]), 5126, 2, "SCALAR");
        strip.add(&floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]), 5126, 2, "VEC4");
        let view = strip.view(&texture());
        strip.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
        strip
    }

    /// Adds bytes and an accessor for them.
    pub fn add(&mut self, bytes: &[u8], component: u32, count: usize, shape: &str) -> usize {
        let view = self.view(bytes);
        let accessor = json!({
            "bufferView": view, "componentType": component, "count": count, "type": shape
        });
        push(&mut self.json["accessors"], accessor)
    }

    /// Adds bytes and a buffer view of them.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.json["buffers"][0]["byteLength"] = self.binary.len().into();
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        push(&mut self.json["bufferViews"], view)
    }

    /// The same with one JSON value replaced.
    pub fn with(mut self, pointer: &str, value: Value) -> Self {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match self.json.pointer_mut(parent).unwrap() {
            Value::Object(object) => drop(object.insert(key.to_owned(), value)),
            Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
            other => panic!("{pointer}: {other}"),
        }
        self
    }

    /// The same with four bytes of an accessor's data replaced.
    pub fn with_bytes(mut self, accessor: usize, offset: usize, bytes: [u8; 4]) -> Self {
        let view = self.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        let start = self.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
        self.binary[start + offset..][..4].copy_from_slice(&bytes);
        self
    }

    /// The whole file.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend((28 + json.len() as u32 + self.binary.len() as u32).to_le_bytes());
        for (name, chunk) in [(b"JSON", &json), (b"BIN\0", &self.binary)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(name);
            file.extend(chunk);
        }
        file
    }
}

fn push(list: &mut Value, value: Value) -> usize {
    let list = list.as_array_mut().unwrap();
    list.push(value);
    list.len() - 1
}

/// The strip's positions, UV coordinates, joints, weights and indices, compressed by Google's
/// encoder (1.5.7, with gltf-transform's defaults).
const DRACO: &str = "RFJBQ08CAgEBAAAABgQDBAAAAu8G/wER/wEz/wEz/wEzBP8AAAAAAAEAAAIAAAEACQMAAAIBAwkCAAECAQQCBAACAQEECQQA\
    AwIBAQEADwMBIC8BIAMA+I8AwP8PAPz//j8A8P8DAAAABAAAAAD/PwAAAAAAvwAAAAAAAAAAAAAAQA4BAQEADQMBIK0KI1UV\
    AyuobgDw/wHw/wIAAAAAAP8PAAAAAAAAAAAAAAAAgD8MAQEBAQECVT2tAgMvno4AAAAAAQAAAAEBAQANA60qJ1UVA+c6iv//\
    /wAAAP/v/wAAAAACAAAAAP8PAAAAAAAAAAAAAAAAAAAAAAAAAACAPww=";

/// The strip with its primitive compressed by Draco, without the morph target.
pub fn draco() -> Strip {
    let mut strip = Strip::new();
    let view = strip.view(&STANDARD.decode(DRACO).unwrap());
    for accessor in [POSITIONS, UV, JOINTS, WEIGHTS, INDICES] {
        strip.json["accessors"][accessor].as_object_mut().unwrap().remove("bufferView");
    }
    let ids = json!({ "POSITION": 0, "TEXCOORD_0": 1, "JOINTS_0": 2, "WEIGHTS_0": 3 });
    strip
        .with("/meshes/0/primitives/0/targets", json!([]))
        .with("/extensionsRequired", json!(["KHR_draco_mesh_compression"]))
        .with(
            "/meshes/0/primitives/0/extensions",
            json!({ "KHR_draco_mesh_compression": { "bufferView": view, "attributes": ids } }),
        )
}
