//! Draco's streams in a scene: counts of faces, points and attributes, and their values.

use arbitrary::Arbitrary;
use serde_json::json;
use uvgraft_tests::strip::{self, INDICES, JOINTS, POSITIONS, Strip, UV, WEIGHTS};

use super::number::{Many, Number, Patch};
use super::{choose, gltf, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    is_edgebreaker: bool,
    faces: Many,
    points: Many,
    stated: Option<(bool, Number)>,
    attributes: Option<Many>,
    patch: Option<Patch>,
    further: Option<Patch>,
    changes: Option<gltf::Changes>,
}

/// A number of seven bits a byte.
fn varint(mut number: u64, out: &mut Vec<u8>) {
    while number > 0x7f {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

impl Choices {
    /// A mesh as a sequence of indices and values, which are zeros.
    fn stream(&self, faces: usize, points: usize) -> Vec<u8> {
        let mut stream = b"DRACO\x02\x02\x01\0\0\0".to_vec();
        let mut counts = [faces as u64, points as u64];
        if let Some((which, to)) = self.stated {
            counts[usize::from(which)] = to.instead_of(counts[usize::from(which)]);
        }
        counts.iter().for_each(|&count| varint(count, &mut stream));
        // Indices are not compressed.
        stream.push(1);
        let width = match points {
            0..256 => 1,
            256..65_536 => 2,
            _ => 1,
        };
        stream.resize(stream.len() + 3 * faces * width, 0);
        // One decoder of attributes, which has places as three floats, and maybe more.
        let count = 1 + self.attributes.map_or(0, |many| many.of(6));
        stream.push(1);
        varint(count as u64, &mut stream);
        for id in 0..count {
            stream.extend([0, 9, 3, 0]);
            varint(id as u64, &mut stream);
        }
        // Their values are stored as they are.
        stream.resize(stream.len() + count, 0);
        stream.resize(stream.len() + 12 * points, 0);
        stream
    }

    fn strip(&self) -> Strip {
        if self.is_edgebreaker {
            let mut strip = strip::draco();
            let view =
                strip.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
                    ["bufferView"]
                    .as_u64()
                    .expect("a view") as usize;
            let view = &strip.json["bufferViews"][view];
            let [start, length] = ["byteOffset", "byteLength"]
                .map(|name| view[name].as_u64().expect("a number") as usize);
            for patch in self.patch.into_iter().chain(self.further) {
                patch.apply(&mut strip.binary[start..start + length], false);
            }
            return strip;
        }
        let (faces, points) = (self.faces.of(3), self.points.of(12));
        let mut stream = self.stream(faces, points);
        self.patch.into_iter().for_each(|patch| patch.apply(&mut stream, false));
        let mut strip = Strip::new();
        let view = strip.view(&stream);
        for accessor in [POSITIONS, UV, JOINTS, WEIGHTS, INDICES] {
            let accessor = strip.json["accessors"][accessor].as_object_mut().expect("an object");
            accessor.remove("bufferView");
        }
        for accessor in [POSITIONS, UV, JOINTS, WEIGHTS] {
            strip.json["accessors"][accessor]["count"] = points.into();
        }
        strip.json["accessors"][INDICES]["count"] = (3 * faces).into();
        strip
            .with("/meshes/0/primitives/0/targets", json!([]))
            .with("/extensionsRequired", json!(["KHR_draco_mesh_compression"]))
            .with(
                "/meshes/0/primitives/0/extensions",
                json!({ "KHR_draco_mesh_compression": {
                    "bufferView": view, "attributes": { "POSITION": 0 }
                }}),
            )
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    let Some(choices) = choose::<Choices>(bytes) else { return Vec::new() };
    let strip = choices.strip();
    match choices.changes {
        Some(changes) => changes.file(strip),
        None => strip.glb(),
    }
}

pub(crate) fn run(bytes: &[u8]) {
    reading::scene(&file(bytes));
}
