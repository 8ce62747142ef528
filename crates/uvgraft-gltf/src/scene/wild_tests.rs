//! Files as other programs write them: compressed, VRM 0.x, various materials.

use std::borrow::Cow;

use serde_json::{Value, json};
pub(super) use uvgraft_tests::strip::draco;
use uvgraft_tests::strip::{self, Strip};

use super::whole::whole_of;
use super::*;

/// Compresses indices as a sequence and weights as attributes, by hand: every byte uncompressed.
pub(super) fn meshopt() -> Strip {
    let mut strip = Strip::new();
    let mut sequence = vec![0xd1];
    let mut last = 0;
    for index in [0_i32, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4] {
        let step = index - last;
        sequence.push(((step << 1 ^ step >> 31) << 1) as u8);
        last = index;
    }
    sequence.extend([0; 4]);
    let weights: Vec<[u8; 4]> =
        (0..6_u8).map(|vertex| [255 - vertex / 2 * 127, vertex / 2 * 127, 0, 0]).collect();
    let mut attributes = vec![0xa0];
    for k in 0..4 {
        attributes.push(3);
        let mut last = 0_u8;
        for weights in weights.iter().chain(std::iter::repeat_n(&weights[5], 10)) {
            let step = weights[k].wrapping_sub(last) as i8;
            attributes.push((step << 1 ^ step >> 7) as u8);
            last = weights[k];
        }
    }
    attributes.extend([0; 32]);
    let views = [
        (strip::INDICES, sequence, 2, 12, "INDICES"),
        (strip::WEIGHTS, attributes, 4, 6, "ATTRIBUTES"),
    ];
    for (accessor, bytes, stride, count, mode) in views {
        let packed = strip.view(&bytes);
        let packed = strip.json["bufferViews"][packed].clone();
        let view = strip.json["accessors"][accessor]["bufferView"].as_u64().unwrap();
        strip.json["bufferViews"][view as usize] = json!({
            "buffer": 1, "byteOffset": 0, "byteLength": stride * count,
            "extensions": { "EXT_meshopt_compression": {
                "buffer": 0, "byteOffset": packed["byteOffset"], "byteLength": bytes.len(),
                "byteStride": stride, "count": count, "mode": mode
            } }
        });
    }
    strip.json["accessors"][strip::WEIGHTS]["componentType"] = 5121.into();
    strip.json["accessors"][strip::WEIGHTS]["normalized"] = true.into();
    strip.json["buffers"].as_array_mut().unwrap().push(json!({
        "byteLength": 48, "extensions": { "EXT_meshopt_compression": { "fallback": true } }
    }));
    strip.with("/extensionsRequired", json!(["EXT_meshopt_compression"]))
}

/// All corners of the strip's triangles while it bends, in an order independent of the encoder.
fn bent(scene: &Scene) -> Vec<[i32; 3]> {
    let drawn =
        scene.pose(&PoseRequest { clip: Some((0, 1.0)), ..PoseRequest::default() }).unwrap();
    let corners = drawn[0].triangles.iter().flatten().map(|&v| drawn[0].positions[v as usize]);
    // In hundredths: Draco keeps 14 bits of positions, and weights have 8 bits.
    let mut rounded: Vec<_> = corners.map(|p| p.map(|x| (x * 100.0).round() as i32)).collect();
    rounded.sort_unstable();
    rounded
}

#[test]
fn compressed_files_equal_plain_ones() {
    let plain = bent(&Scene::read(&Strip::new().glb()).unwrap());
    for strip in [draco(), meshopt()] {
        let glb = strip.glb();
        let near = |scene: &Scene| {
            for (found, wanted) in bent(scene).iter().zip(&plain) {
                assert!((0..3).all(|k| (found[k] - wanted[k]).abs() <= 1), "{found:?} {wanted:?}");
            }
        };
        near(&Scene::read(&glb).unwrap());
        // As embedded in a page: uncompressed, readable by the crate `gltf` and by ourselves.
        let whole = whole_of(&glb, None, Budget::default()).unwrap();
        let scene = Scene::read(&whole).unwrap();
        assert_eq!(scene.triangles(), 4);
        near(&scene);
        let document = gltf::Gltf::from_slice_without_validation(&whole).unwrap();
        assert_eq!((document.extensions_required().count(), document.buffers().count()), (0, 1));
    }
    // A self-contained file is returned unchanged.
    let glb = Strip::new().glb();
    assert!(matches!(whole_of(&glb, None, Budget::default()), Ok(Cow::Borrowed(_))));
}

#[test]
fn data_of_fallback_buffers_may_be_missing() {
    let plain = bent(&Scene::read(&meshopt().glb()).unwrap());
    let unmarked = meshopt().with("/buffers/1", json!({ "byteLength": 48 }));
    let elsewhere = meshopt().with("/buffers/1/uri", json!("fallback.bin"));
    let renamed = |strip: &Strip| {
        let text = strip.json.to_string().replace("EXT_meshopt", "KHR_meshopt");
        Strip { json: serde_json::from_str(&text).unwrap(), binary: strip.binary.clone() }
    };
    for strip in [&unmarked, &elsewhere, &renamed(&meshopt()), &renamed(&unmarked)] {
        let glb = strip.glb();
        assert_eq!(bent(&Scene::read(&glb).unwrap()), plain);
        assert_eq!(
            bent(&Scene::read(&whole_of(&glb, None, Budget::default()).unwrap()).unwrap()),
            plain
        );
    }
    // What is not compressed needs its data, and so do compressed streams.
    let view = unmarked.json["accessors"][strip::BULGE]["bufferView"].to_string();
    let needed = unmarked.clone().with(&format!("/bufferViews/{view}/buffer"), json!(1));
    let view = unmarked.json["accessors"][strip::INDICES]["bufferView"].to_string();
    let at = format!("/bufferViews/{view}/extensions/EXT_meshopt_compression/buffer");
    for strip in [needed, unmarked.with(&at, json!(1))] {
        let error = Scene::read(&strip.glb()).unwrap_err().to_string();
        assert_eq!(error, "buffer 1: must have a URI or a binary chunk");
    }
}

#[test]
fn inconsistent_compressed_parts_are_rejected() {
    let meshopt = |pointer: &str, value: Value| {
        let strip = meshopt();
        let view = &strip.json["accessors"][strip::WEIGHTS]["bufferView"].to_string();
        let at = format!("/bufferViews/{view}/extensions/EXT_meshopt_compression/{pointer}");
        strip.with(&at, value)
    };
    let compressed = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let cases = [
        (meshopt("count", json!(u64::MAX)), "decompressed bytes"),
        (meshopt("count", json!(1 << 27)), "truncated"),
        (meshopt("count", json!(1_u64 << 40)), "decompressed bytes"),
        (meshopt("byteLength", json!(40)), "truncated"),
        (meshopt("byteLength", json!(1 << 30)), "exceed buffer 0"),
        (meshopt("byteOffset", json!(u64::MAX)), "exceed buffer"),
        (meshopt("buffer", json!(7)), "refers to buffer 7"),
        (meshopt("byteStride", json!(6)), "multiple of 4"),
        (meshopt("mode", json!("SOUP")), "SOUP"),
        (meshopt("filter", json!("QUATERNION")), "QUATERNION must be 8"),
        (draco().with(&format!("{compressed}/bufferView"), json!(99)), "refers to buffer view 99"),
        (draco().with(&format!("{compressed}/bufferView"), json!(4)), "Draco stream"),
        (draco().with(&format!("{compressed}/attributes/POSITION"), json!(9)), "no attribute 9"),
        (draco().with("/accessors/0/count", json!(7)), "must have 7 elements, got 6"),
        (
            draco().with("/meshes/0/primitives/0/mode", json!(5)),
            "mode must be 4 (triangles) with Draco compression, got 5",
        ),
    ];
    for (strip, wanted) in cases {
        let error = Scene::read(&strip.glb()).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "wanted {wanted:?}, found {error:?}");
    }
}

#[test]
fn flipped_bytes_of_compressed_parts_never_panic() {
    for strip in [draco(), meshopt()] {
        let glb = strip.glb();
        let start = glb.len() - 300;
        for at in start..glb.len() {
            for flip in [0x01, 0x10, 0x80, 0xff] {
                let mut bytes = glb.clone();
                bytes[at] ^= flip;
                if let Ok(scene) = Scene::read(&bytes) {
                    let _ = scene.pose(&PoseRequest::default());
                }
                let _ = whole_of(&bytes, None, Budget::default());
            }
        }
    }
}

/// The strip as VRM 0.x, with bones and blend shape groups.
fn vrm0() -> Strip {
    Strip::new().with(
        "/extensions",
        json!({ "VRM": {
            "humanoid": { "humanBones": [
                { "bone": "hips", "node": 0 }, { "bone": "head", "node": 1 },
                { "bone": "leftThumbProximal", "node": 1 }, { "bone": "jaw", "node": -1 }
            ] },
            "blendShapeMaster": { "blendShapeGroups": [
                { "name": "Joy", "presetName": "joy", "binds": [{ "mesh": 0, "index": 0, "weight": 50 }] },
                { "name": "A", "presetName": "A", "isBinary": true,
                    "binds": [{ "mesh": 0, "index": 0, "weight": 100 }] },
                { "name": "Wink", "presetName": "unknown", "binds": [] },
                { "name": "Blink_L", "presetName": "blink_l", "binds": [] }
            ] }
        } }),
    )
}

#[test]
fn vrm_0_is_turned_around_and_gets_the_names_of_vrm_1() {
    let scene = Scene::read(&vrm0().glb()).unwrap();
    let bones: Vec<&str> = scene.bones().collect();
    assert_eq!(bones, ["head", "hips", "leftThumbMetacarpal"]);
    assert_eq!(scene.expressions(), ["aa", "blinkLeft", "happy", "Wink", "bulge"]);
    let posed = |name: &str, weight| {
        let weights = vec![(name.to_owned(), weight)];
        scene.pose(&PoseRequest { weights, ..PoseRequest::default() }).unwrap()[0].positions.clone()
    };
    // A rotation by 180° about Y: what bulged towards +Z bulges towards -Z, left is right.
    let happy = posed("happy", 1.0);
    assert!((happy[2][0] - 0.5).abs() < 1e-6 && (happy[2][2] + 0.25).abs() < 1e-6, "{happy:?}");
    assert!((posed("aa", 0.6)[2][2] + 0.5).abs() < 1e-6 && posed("aa", 0.4)[2][2].abs() < 1e-6);
    // Rotations are about the axes of the visible world.
    let rotations = vec![("head".to_owned(), [0.0, 0.0, 90.0])];
    let turned = scene.pose(&PoseRequest { rotations, ..PoseRequest::default() }).unwrap();
    let top = turned[0].positions[4];
    assert!((top[0] + 1.0).abs() < 1e-6 && (top[1] - 1.5).abs() < 1e-6, "{top:?}");
    for (pointer, value, wanted) in [
        ("/extensions/VRM/humanoid/humanBones/0/node", json!(9), "node 9"),
        ("/extensions/VRM/blendShapeMaster/blendShapeGroups/0/binds/0/mesh", json!(3), "mesh 3"),
        ("/extensions/VRM/blendShapeMaster/blendShapeGroups/0/binds/0/index", json!(1), "target 1"),
    ] {
        let error = Scene::read(&vrm0().with(pointer, value).glb()).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "{error}");
    }
}

#[test]
fn textures_have_their_own_coordinates() {
    let moved =
        json!({ "index": 0, "extensions": { "KHR_texture_transform": { "offset": [0.5, 0] } } });
    let strip = Strip::new()
        .with("/materials/0/emissiveTexture", moved)
        .with("/materials/0/emissiveFactor", json!([1, 0.5, 0]))
        .with("/materials/0/occlusionTexture", json!({ "index": 0, "strength": 0.25 }))
        .with("/materials/0/normalTexture", json!({ "index": 0, "texCoord": 3, "scale": 2 }))
        .with(
            "/materials/0/extensions",
            json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 4 } }),
        );
    let scene = Scene::read(&strip.glb()).unwrap();
    let material = &scene.materials()[0];
    assert_eq!(material.emissive, [4.0, 2.0, 0.0]);
    let (normal, occlusion) = (material.normal.unwrap(), material.occlusion.unwrap());
    assert_eq!((normal.scale, occlusion.scale), (2.0, 0.25));
    let numbers = [
        material.texture.unwrap().coordinates,
        material.emissive_texture.unwrap().coordinates,
        normal.texture.coordinates,
        occlusion.texture.coordinates,
    ];
    assert_eq!(numbers, [0, 1, 2, 0]);
    let drawn = &scene.pose(&PoseRequest::default()).unwrap()[0];
    assert_eq!(drawn.more_uv.len(), 2);
    assert_eq!(
        (drawn.uv[1], drawn.more_uv[0][1], drawn.more_uv[1][1]),
        ([1.0; 2], [1.5, 1.0], [0.0; 2])
    );
}

#[test]
fn specular_glossiness_is_read_and_rewritten() {
    let gloss = json!({ "KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.25, 1, 0.75], "diffuseTexture": { "index": 0 },
        "specularFactor": [0.1, 0.2, 0.3], "glossinessFactor": 0.5,
        "specularGlossinessTexture": { "index": 0 }
    } });
    let strip = Strip::new()
        .with("/materials/0/extensions", gloss)
        .with("/extensionsUsed", json!(["KHR_materials_pbrSpecularGlossiness"]));
    let glb = strip.glb();
    let scene = Scene::read(&glb).unwrap();
    let material = &scene.materials()[0];
    let read = material.gloss.unwrap();
    assert_eq!((material.color, read.glossiness), ([0.5, 0.25, 1.0, 0.75], 0.5));
    assert_eq!((read.specular, scene.textures().len()), ([0.1, 0.2, 0.3], 1));

    let whole = whole_of(&glb, None, Budget::default()).unwrap();
    let document = gltf::Gltf::from_slice_without_validation(&whole).unwrap();
    let pbr = document.materials().next().unwrap().pbr_metallic_roughness().base_color_factor();
    assert_eq!((pbr, document.images().count()), ([0.5, 0.25, 1.0, 0.75], 2));
    let gltf::image::Source::View { view, .. } = document.images().nth(1).unwrap().source() else {
        panic!("an image in the file")
    };
    let png = &document.blob.as_ref().unwrap()[view.offset()..][..view.length()];
    let rough = images::decode(png, 1).unwrap();
    // The texture is opaque, so half of the full glossiness remains everywhere: 255 - 127.5.
    assert_eq!([0, 1, 2].map(|k| (rough.get(0, 0, k) * 255.0).round()), [0.0, 128.0, 0.0]);
    let json: Value =
        serde_json::from_slice(Asset::new(&whole, None, Budget::default()).unwrap().json).unwrap();
    let used = json["extensionsUsed"].to_string();
    assert!(!used.contains("Glossiness") && used.contains("KHR_materials_specular"), "{used}");
    let specular = &json["materials"][0]["extensions"]["KHR_materials_specular"];
    assert_eq!(specular["specularColorFactor"][2].as_f64().map(|x| (x * 10.0).round()), Some(3.0));
}

#[test]
fn external_parts_are_embedded() {
    let strip = Strip::new();
    let folder = std::env::temp_dir().join(format!("uvgraft-whole-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("parts")).unwrap();
    std::fs::write(folder.join("parts/strip.bin"), &strip.binary).unwrap();
    std::fs::write(folder.join("parts/skin.png"), strip::texture()).unwrap();
    let strip = strip
        .with("/buffers/0/uri", "parts/strip.bin".into())
        .with("/images/0", json!({ "uri": "parts/skin.png", "name": "skin" }));
    let path = folder.join("me.gltf");
    std::fs::write(&path, strip.json.to_string()).unwrap();
    let glb = whole(&path).unwrap();
    let beside = strip.with("/images/0/uri", "../skin.png".into());
    std::fs::write(&path, beside.json.to_string()).unwrap();
    let refused = whole(&path).unwrap_err().to_string();
    assert_eq!(whole(Input::bytes("me.glb", &*glb)).unwrap(), glb);
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(
        refused.contains("me.gltf") && refused.contains("must be in the model's folder or below"),
        "{refused}"
    );
    let scene = Scene::read(&glb).unwrap();
    assert_eq!(scene.textures()[0].size(), uvgraft::Size::square(2));
    let document = gltf::Gltf::from_slice_without_validation(&glb).unwrap();
    assert_eq!(document.images().next().unwrap().name(), Some("skin"));
}

#[test]
fn cameras_can_frame_a_bone() {
    let scene = Scene::read(&Strip::new().glb()).unwrap();
    let around = |name: &str| scene.extent(name, &PoseRequest::default());
    let head = around("head").unwrap();
    assert_eq!(head.joint, [0.0, 1.0, 0.0]);
    // The middle belongs half to each, which is not a majority.
    assert!(head.points.len() == 3 && head.points.iter().all(|p| p[1] == 2.0), "{head:?}");
    // The foot is not a body part here, so all its descendants belong to it.
    assert_eq!(around("foot").unwrap().points.len(), 12);
    assert!(around("tail").unwrap_err().to_string().contains("no bone \"tail\""));
    let posed = PoseRequest {
        rotations: vec![("foot".into(), [0.0, 0.0, 90.0])],
        ..PoseRequest::default()
    };
    let turned = scene.extent("head", &posed).unwrap().points[0];
    assert!((turned[0] + 2.0).abs() < 1e-6, "{turned:?}");
    // In a humanoid, the hips do not include the head.
    let scene = Scene::read(&vrm0().glb()).unwrap();
    let hips = scene.extent("hips", &PoseRequest::default()).unwrap();
    assert!(hips.points.iter().all(|p| p[1] == 0.0) && !hips.points.is_empty(), "{hips:?}");
}
