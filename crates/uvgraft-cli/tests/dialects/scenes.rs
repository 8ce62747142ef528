//! GLB and glTF of engines, exporters and optimisers.

use serde_json::{Value, json};
use uvgraft_tests::strip::Strip;

use super::meshes::{COMMAND, Sheet, difference};
use super::{Case, Expected, Near, Refused, Same, Warned, case, check};
use crate::bench::Bench;

const FLOAT: u32 = 5126;

fn bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn indices() -> Vec<u32> {
    Sheet::new().split().2.into_flattened()
}

/// Coordinates with the origin at the top left, as glTF has them.
fn coordinates() -> Vec<[f32; 2]> {
    Sheet::new().split().1.into_iter().map(|[u, v]| [u, 1.0 - v]).collect()
}

fn positions() -> Vec<[f32; 3]> {
    Sheet::new().split().0
}

/// A file with one node, one mesh and no accessors.
fn empty() -> Strip {
    let json = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "sheet", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": {} }] }],
        "accessors": [],
        "bufferViews": [],
        "buffers": [{ "byteLength": 0 }]
    });
    Strip { json, binary: Vec::new() }
}

/// With one attribute or the indices of the first primitive set to an accessor.
fn set(mut file: Strip, key: &str, accessor: usize) -> Strip {
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    match key {
        "indices" => primitive["indices"] = accessor.into(),
        _ => primitive["attributes"][key] = accessor.into(),
    }
    file
}

/// Adds an array and uses it.
fn with_array(mut file: Strip, key: &str, data: &[u8], component: u32, shape: &str) -> Strip {
    let width = match component {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        _ => 4,
    } * match shape {
        "VEC2" => 2,
        "VEC3" => 3,
        _ => 1,
    };
    let accessor = file.add(data, component, data.len() / width, shape);
    set(file, key, accessor)
}

fn with_positions(file: Strip, positions: &[[f32; 3]]) -> Strip {
    with_array(file, "POSITION", &bytes(positions.as_flattened()), FLOAT, "VEC3")
}

fn with_uv(file: Strip, key: &str, uv: &[[f32; 2]]) -> Strip {
    with_array(file, key, &bytes(uv.as_flattened()), FLOAT, "VEC2")
}

fn with_indices(file: Strip, indices: &[u32]) -> Strip {
    let data: Vec<u8> = indices.iter().flat_map(|&it| (it as u16).to_le_bytes()).collect();
    with_array(file, "indices", &data, 5123, "SCALAR")
}

/// The plain file.
fn plain() -> Strip {
    let file = with_uv(with_positions(empty(), &positions()), "TEXCOORD_0", &coordinates());
    with_indices(file, &indices())
}

/// The plain file with its positions moved so that a node with these properties brings them back.
fn under(node: Value, unmoved: impl Fn([f32; 3]) -> [f32; 3], mirrored: bool) -> Strip {
    let moved: Vec<_> = positions().into_iter().map(unmoved).collect();
    let mut order = indices();
    if mirrored {
        order.as_chunks_mut::<3>().0.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    let file = with_indices(
        with_uv(with_positions(empty(), &moved), "TEXCOORD_0", &coordinates()),
        &order,
    );
    let mut node = node;
    node["mesh"] = 0.into();
    file.with("/nodes/0", node)
}

/// Cases that differ by how arrays are stored.
fn storage() -> Vec<Case> {
    let glb = |name, file: Strip, expected| case(name, "mesh.glb", file.glb(), expected);
    let no_indices = {
        let at = |k: u32| k as usize;
        let positions: Vec<_> = indices().into_iter().map(|k| positions()[at(k)]).collect();
        let uv: Vec<_> = indices().into_iter().map(|k| coordinates()[at(k)]).collect();
        with_uv(with_positions(empty(), &positions), "TEXCOORD_0", &uv)
    };
    let wide: Vec<u8> = indices().into_iter().flat_map(u32::to_le_bytes).collect();
    let narrow: Vec<u8> = indices().into_iter().map(|index| index as u8).collect();
    let mut interleaved = empty();
    let rows: Vec<f32> = positions()
        .iter()
        .zip(coordinates())
        .flat_map(|(p, uv)| [p[0], p[1], p[2], uv[0], uv[1], 9.0])
        .collect();
    let position = interleaved.add(&bytes(&rows), FLOAT, positions().len(), "VEC3");
    interleaved.json["bufferViews"][0]["byteStride"] = 24.into();
    let mut uv = interleaved.json["accessors"][position].clone();
    uv["byteOffset"] = 12.into();
    uv["type"] = "VEC2".into();
    interleaved.json["accessors"].as_array_mut().into_iter().for_each(|all| all.push(uv.clone()));
    let interleaved =
        with_indices(set(set(interleaved, "POSITION", 0), "TEXCOORD_0", 1), &indices());
    let mut sparse = plain();
    let (at, values) = (
        sparse.view(&[3, 0, 7, 0]),
        sparse.view(&bytes(&[positions()[3], positions()[7]].concat())),
    );
    for vertex in [3, 7] {
        sparse = sparse.with_bytes(0, vertex * 12, 7.5_f32.to_le_bytes());
    }
    sparse.json["accessors"][0]["sparse"] = json!({
        "count": 2, "indices": { "bufferView": at, "componentType": 5123 }, "values": { "bufferView": values }
    });
    let shorts: Vec<u8> = coordinates()
        .as_flattened()
        .iter()
        .flat_map(|v| ((v * 65_535.0).round() as u16).to_le_bytes())
        .collect();
    let small: Vec<u8> =
        coordinates().as_flattened().iter().map(|v| (v * 255.0).round() as u8).collect();
    let normalised = |data: &[u8], component| {
        let mut file = with_array(plain(), "TEXCOORD_0", data, component, "VEC2");
        let last = file.json["accessors"].as_array().map_or(0, Vec::len) - 1;
        file.json["accessors"][last]["normalized"] = true.into();
        file
    };
    let two_sets = with_uv(plain(), "TEXCOORD_1", &coordinates());
    let lightmap: Vec<_> = coordinates().into_iter().map(|[u, v]| [v * 0.5, u * 0.5]).collect();
    let two_sets = with_uv(two_sets, "TEXCOORD_0", &lightmap);
    vec![
        glb("plain", plain(), Same),
        glb("indices of 8 bits", with_array(plain(), "indices", &narrow, 5121, "SCALAR"), Same),
        glb("indices of 32 bits", with_array(plain(), "indices", &wide, 5125, "SCALAR"), Same),
        glb("no indices", no_indices, Same),
        glb("interleaved", interleaved, Same),
        glb("sparse", sparse, Same),
        // Half a step of the integers.
        glb("normalised shorts", normalised(&shorts, 5123), Near(0.51 / 65_535.0)),
        glb("normalised bytes", normalised(&small, 5121), Near(0.51 / 255.0)),
        case("second UV set", "mesh.glb#1", two_sets.glb(), Same),
        glb(
            "index out of range",
            with_indices(plain(), &[0, 1, 99]),
            Refused("must be less than 15, got 99"),
        ),
        glb("NaN", plain().with_bytes(0, 0, f32::NAN.to_le_bytes()), Refused("must be finite")),
        glb(
            "no coordinates",
            with_indices(with_positions(empty(), &positions()), &indices()),
            Refused("has no UV coordinates"),
        ),
    ]
}

/// Cases that differ by how triangles, materials and nodes bring about the same sheet.
fn structure() -> Vec<Case> {
    let glb = |name, file: Strip, expected| case(name, "mesh.glb", file.glb(), expected);
    let mode = |order: &[u32], mode: u32| {
        with_indices(plain(), order).with("/meshes/0/primitives/0/mode", json!(mode))
    };
    // Strips of the two columns on the left and of the one on the right, bridged by triangles
    // without area; a strip's second triangle is the quad's other half, cut along its other diagonal,
    // so each quad is a fan of its own instead.
    let mut fans = plain();
    let primitive = fans.json["meshes"][0]["primitives"][0].clone();
    let mut primitives = Vec::new();
    for quad in Sheet::new().quads {
        let data: Vec<u8> = quad.iter().flat_map(|&(_, uv)| (uv as u16).to_le_bytes()).collect();
        let mut fan = primitive.clone();
        fan["indices"] = fans.add(&data, 5123, 4, "SCALAR").into();
        fan["mode"] = 6.into();
        primitives.push(fan);
    }
    fans.json["meshes"][0]["primitives"] = primitives.into();
    let strips = {
        let [_, b, c, d] = [0, 1, 6, 5];
        // Quad 0 alone, whose strip b c a d has the triangles b c a and c d a.
        let mut file = mode(&[b, c, 0, d], 5);
        let rest = with_indices(file.clone(), &indices()[6..]);
        let mut second = rest.json["meshes"][0]["primitives"][0].clone();
        second["mode"] = 4.into();
        let first = file.json["meshes"][0]["primitives"][0].clone();
        file = rest;
        file.with("/meshes/0/primitives", json!([first, second]))
    };
    let scaled: Vec<u8> =
        positions().as_flattened().iter().flat_map(|v| ((v * 64.0) as i16).to_le_bytes()).collect();
    let mut quantised = with_array(plain(), "POSITION", &scaled, 5122, "VEC3");
    quantised.json["nodes"][0]["scale"] = json!([1.0 / 64.0, 1.0 / 64.0, 1.0 / 64.0]);
    quantised.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    quantised.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let untransformed: Vec<_> =
        coordinates().into_iter().map(|[u, v]| [(u - 0.25) * 2.0, (v + 0.5) * 4.0]).collect();
    let mut transformed = with_uv(plain(), "TEXCOORD_0", &untransformed);
    let image = transformed.view(&uvgraft_tests::strip::texture());
    transformed.json["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
    transformed.json["textures"] = json!([{ "source": 0 }]);
    let transform =
        json!({ "KHR_texture_transform": { "offset": [0.25, -0.5], "scale": [0.5, 0.25] } });
    transformed.json["materials"] = json!([{ "pbrMetallicRoughness": {
        "baseColorTexture": { "index": 0, "extensions": transform }
    } }]);
    transformed.json["meshes"][0]["primitives"][0]["material"] = 0.into();
    let mut nested =
        under(json!({ "translation": [0, 0, 1] }), |[x, y, z]| [x - 1.0, y, z - 1.0], false);
    nested.json["nodes"] =
        json!([nested.json["nodes"][0], { "children": [0], "translation": [1, 0, 0] }]);
    nested.json["scenes"] = json!([{ "nodes": [1] }]);
    let mut halves = plain();
    let first = with_indices(halves.clone(), &indices()[..18]);
    let half = with_indices(first.clone(), &indices()[18..]);
    let [a, b] = [&first, &half].map(|file| file.json["meshes"][0]["primitives"][0].clone());
    halves.json = half.json;
    halves.binary = half.binary;
    halves.json["meshes"] = json!([{ "primitives": [a] }, { "primitives": [b] }]);
    halves.json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 1 }]);
    halves.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    let mut hidden = plain();
    hidden.json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "translation": [5, 0, 0] }]);
    let mut bare = plain();
    let mut hair = bare.json["meshes"][0].clone();
    hair["primitives"][0]["attributes"] = json!({ "POSITION": 0 });
    bare.json["meshes"] = json!([bare.json["meshes"][0], hair]);
    bare.json["nodes"] = json!([{ "mesh": 0 }, { "name": "hair", "mesh": 1 }]);
    bare.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    let mut instance = under(json!({}), |[x, y, z]| [x - 1.0, y - 2.0, z + 0.5], false);
    let place = instance.add(&bytes(&[1.0, 2.0, -0.5]), FLOAT, 1, "VEC3");
    let instancing = json!({ "attributes": { "TRANSLATION": place } });
    let instance = instance
        .with("/nodes/0/extensions", json!({ "EXT_mesh_gpu_instancing": instancing }))
        .with("/extensionsRequired", json!(["EXT_mesh_gpu_instancing"]));
    vec![
        glb("an instance", instance, Same),
        glb("fans", fans, Same),
        glb("a strip", strips, Same),
        glb("quantised", quantised, Same),
        glb("texture transform", transformed, Same),
        glb(
            "translation and scale",
            under(
                json!({ "translation": [1, 2, -0.5], "scale": [2, 4, 0.5] }),
                |[x, y, z]| [(x - 1.0) / 2.0, (y - 2.0) / 4.0, (z + 0.5) * 2.0],
                false,
            ),
            Same,
        ),
        glb(
            "rotation",
            under(json!({ "rotation": [0.0, 0.0, 1.0, 0.0] }), |[x, y, z]| [-x, -y, z], false),
            Same,
        ),
        glb(
            "matrix",
            under(
                json!({ "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }),
                |[x, y, z]| [y, -x, z],
                false,
            ),
            Same,
        ),
        glb(
            "negative scale",
            under(json!({ "scale": [-1, 1, 1] }), |[x, y, z]| [-x, y, z], true),
            Same,
        ),
        glb("nested nodes", nested, Same),
        glb("several nodes", halves, Same),
        glb("nodes outside the scene", hidden, Same),
        glb(
            "a part without coordinates",
            bare,
            Warned("12 of 24 polygons have no UV coordinates and are left out: \"hair\""),
        ),
        glb("points", mode(&indices(), 0), Refused("must have triangles")),
        glb(
            "an unknown extension",
            plain().with("/extensionsRequired", json!(["EXT_mesh_of_fog"])),
            Refused("unsupported extension EXT_mesh_of_fog"),
        ),
        glb(
            "an older version",
            plain().with("/asset/version", "1.0".into()),
            Refused("version must be 2.0"),
        ),
    ]
}

/// A GLB with other JSON bytes.
fn glb_of(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let word = |value: usize| (value as u32).to_le_bytes();
    [
        b"glTF\x02\0\0\0",
        &word(length)[..],
        &word(json.len()),
        b"JSON",
        json,
        &word(binary.len()),
        b"BIN\0",
        binary,
    ]
    .concat()
}

/// Cases that differ by the container, and by how other files are named.
fn containers() -> Vec<Case> {
    let file = plain();
    let text = file.json.to_string();
    let padded = |before: &str, pad: u8| {
        let mut json = [before.as_bytes(), text.as_bytes()].concat();
        json.resize(json.len().next_multiple_of(4) + 4, pad);
        glb_of(&json, &file.binary)
    };
    let apart = |name, uri: &str, stored: &'static str, expected: Expected| {
        let json = plain().with("/buffers/0/uri", uri.into()).json.to_string();
        Case { name, files: vec![("apart.gltf", json.into()), (stored, plain().binary)], expected }
    };
    let glb = |name, content: Vec<u8>, expected| case(name, "mesh.glb", content, expected);
    let whole = file.glb();
    vec![
        glb("blanks behind the JSON", padded("", b' '), Same),
        glb("NUL behind the JSON", padded("", 0), Same),
        glb("byte order mark in the JSON", padded("\u{feff}", b' '), Same),
        glb("bytes behind the file", [&whole[..], b"\0\0\0\0rest"].concat(), Same),
        glb("cut", whole[..whole.len() - 40].to_vec(), Refused("truncated")),
        glb("no binary chunk", glb_of(text.as_bytes(), b""), Refused("must have")),
        apart("an external buffer", "sheet.bin", "sheet.bin", Same),
        apart("a name with a dot", "./sheet.bin", "sheet.bin", Same),
        apart("escapes", "the%20sheet.bin", "the sheet.bin", Same),
        apart("escapes in the name of the file", "50%25%20off.bin", "50%25%20off.bin", Same),
        apart("blanks", "the sheet.bin", "the sheet.bin", Same),
        apart("a backslash", "parts\\sheet.bin", "parts/sheet.bin", Same),
        apart(
            "a URL",
            "https://example.org/sheet.bin",
            "sheet.bin",
            Refused("got a URL: download it"),
        ),
        apart(
            "another folder",
            "..\\sheet.bin",
            "sheet.bin",
            Refused("must be in the model's folder or below"),
        ),
        apart(
            "a drive",
            "C:\\sheet.bin",
            "sheet.bin",
            Refused("must be in the model's folder or below"),
        ),
        apart("a missing file", "none.bin", "sheet.bin", Refused("none.bin: No such file")),
    ]
}

#[test]
fn glb_and_gltf_files() {
    let bench = Bench::new();
    bench.make_folder("parts");
    for cases in [storage(), structure(), containers()] {
        check(&bench, cases, COMMAND, difference);
    }
}
