//! Reading and posing valid files, and rejecting invalid ones.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use uvgraft_tests::strip::{self, Strip};

use super::*;

fn read(strip: &Strip) -> Scene {
    Scene::read(&strip.glb()).unwrap()
}

fn positions(scene: &Scene, posing: &PoseRequest) -> Vec<[f32; 3]> {
    scene.pose(posing).unwrap()[0].positions.clone()
}

fn assert_near(found: &[[f32; 3]], wanted: &[[f32; 3]]) {
    assert_eq!(found.len(), wanted.len());
    for (a, b) in found.iter().zip(wanted) {
        // Rounding error of sums of a few products of numbers up to 2 in single precision.
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-6), "{found:?} instead of {wanted:?}");
    }
}

const REST: [[f32; 3]; 6] = [
    [-0.5, 0.0, 0.0],
    [0.5, 0.0, 0.0],
    [-0.5, 1.0, 0.0],
    [0.5, 1.0, 0.0],
    [-0.5, 2.0, 0.0],
    [0.5, 2.0, 0.0],
];

/// Joint 1 rotated by 90° about Z around (0, 1, 0): the top moves to the left, the middle is the
/// mean of its original position and of (0, 0.5, 0) or (0, 1.5, 0).
const BENT: [[f32; 3]; 6] = [
    [-0.5, 0.0, 0.0],
    [0.5, 0.0, 0.0],
    [-0.25, 0.75, 0.0],
    [0.25, 1.25, 0.0],
    [-1.0, 0.5, 0.0],
    [-1.0, 1.5, 0.0],
];

#[test]
fn a_strip_is_read_and_bends_as_computed_by_hand() {
    let scene = read(&Strip::new());
    assert_eq!((scene.triangles(), scene.clips().len()), (4, 1));
    assert_eq!((scene.clips()[0].name.as_str(), scene.clips()[0].seconds), ("bend", 1.0));
    assert_eq!(scene.expressions(), ["bulge"]);
    assert_eq!(scene.textures()[0].size(), uvgraft::Size::square(2));
    assert_near(&positions(&scene, &PoseRequest::default()), &REST);
    let at = |seconds| PoseRequest { clip: Some((0, seconds)), ..PoseRequest::default() };
    assert_near(&positions(&scene, &at(0.0)), &REST);
    assert_near(&positions(&scene, &at(1.0)), &BENT);
    // At half the time, the angle is halved.
    let half = positions(&scene, &at(0.5));
    let side = std::f32::consts::FRAC_1_SQRT_2;
    assert_near(&half[5..], &[[0.5 * side - side, 1.0 + 0.5 * side + side, 0.0]]);
    let turned = PoseRequest {
        rotations: vec![("head".into(), [0.0, 0.0, 90.0])],
        ..PoseRequest::default()
    };
    assert_near(&positions(&scene, &turned), &BENT);
    // The rotation is applied on top of the clip.
    let both = PoseRequest { rotations: vec![("head".into(), [0.0, 0.0, -90.0])], ..at(1.0) };
    assert_near(&positions(&scene, &both), &REST);
}

#[test]
fn morphs_move_before_joints_do() {
    let scene = read(&Strip::new());
    let bulge = |weight| vec![("Bulge".to_owned(), weight)];
    let found = positions(&scene, &PoseRequest { weights: bulge(0.5), ..PoseRequest::default() });
    assert_eq!((found[2], found[0]), ([-0.5, 1.0, 0.25], [-0.5, 0.0, 0.0]));
    // A rotation by 90° about X maps Z to -Y for the half that follows the joint.
    let posing = PoseRequest {
        weights: bulge(1.0),
        rotations: vec![("head".into(), [90.0, 0.0, 0.0])],
        ..PoseRequest::default()
    };
    assert_near(&positions(&scene, &posing)[2..3], &[[-0.5, 0.75, 0.25]]);
}

#[test]
fn normals_turn_with_the_surface() {
    let scene = read(&Strip::new());
    for (rotation, wanted) in [([0.0; 3], [0.0, 0.0, 1.0]), ([0.0, 90.0, 0.0], [1.0, 0.0, 0.0])] {
        let rotations = vec![("foot".into(), rotation)];
        let drawn = scene.pose(&PoseRequest { rotations, ..PoseRequest::default() }).unwrap();
        assert_near(&drawn[0].normals, &[wanted; 6]);
    }
}

#[test]
fn rotations_are_independent_of_bone_axes() {
    // The joint's axes are rotated by 90° about X, and its bind matrix undoes that.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let mut strip = Strip::new().with("/nodes/1/rotation", json!([half, 0, 0, half]));
    let inverse: [[f32; 4]; 8] = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 1.0],
    ];
    let bytes = inverse.concat().into_iter().flat_map(f32::to_le_bytes).collect::<Vec<_>>();
    let accessor = strip.add(&bytes, 5126, 2, "MAT4");
    let scene = read(&strip.with("/skins/0/inverseBindMatrices", accessor.into()));
    assert_near(&positions(&scene, &PoseRequest::default()), &REST);
    let rotations = vec![("head".into(), [0.0, 0.0, 90.0])];
    assert_near(&positions(&scene, &PoseRequest { rotations, ..PoseRequest::default() }), &BENT);
}

#[test]
fn unskinned_meshes_follow_their_node() {
    let mut strip = Strip::new()
        .with("/nodes/2/matrix", json!([-2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1]));
    strip.json["nodes"][2].as_object_mut().unwrap().remove("skin");
    let drawn = read(&strip).pose(&PoseRequest::default()).unwrap();
    assert_near(&drawn[0].positions[..1], &[[4.0, 4.0, 5.0]]);
    // Mirrored, so the winding is reversed to keep front faces in front.
    assert_eq!(drawn[0].triangles[0], [0, 3, 1]);
    assert_near(&drawn[0].normals[..1], &[[0.0, 0.0, 1.0]]);
}

#[test]
fn sparse_arrays_without_others_are_zero_elsewhere() {
    let mut strip = Strip::new();
    let indices = strip.view(&[5, 0, 0, 0]);
    let values = strip.view(&[0.25_f32, 0.5, 1.0].map(f32::to_le_bytes).concat());
    let accessor = &mut strip.json["accessors"][strip::POSITIONS];
    accessor.as_object_mut().unwrap().remove("bufferView");
    accessor["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values }
    });
    let found = positions(&read(&strip), &PoseRequest::default());
    assert_eq!((found[0], found[5]), ([0.0; 3], [0.25, 0.5, 1.0]));
}

#[test]
fn transforms_of_textures_may_name_another_set() {
    let mut strip = Strip::new();
    let second = strip.add(&[0, 0x80, 0xff, 0xff].repeat(6), 5123, 6, "VEC2");
    strip.json["accessors"][second]["normalized"] = true.into();
    strip.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = second.into();
    let transform = json!({ "KHR_texture_transform": { "texCoord": 1, "offset": [0.25, 0] } });
    let texture = json!({ "index": 0, "texCoord": 0, "extensions": transform });
    let strip = strip.with("/materials/0/pbrMetallicRoughness/baseColorTexture", texture);
    let drawn = read(&strip).pose(&PoseRequest::default()).unwrap();
    let mesh = read_mesh(&strip.glb(), &MeshChoice::default()).unwrap().mesh;
    for uv in [drawn[0].uv[3], mesh.uv()[3]] {
        assert!((uv[0] - (0.25 + 32_768.0 / 65_535.0)).abs() < 1e-6 && uv[1] == 1.0, "{uv:?}");
    }
}

#[test]
fn quantised_and_sparse_arrays_are_decoded() {
    let mut strip = Strip::new().with("/extensionsRequired", json!(["KHR_mesh_quantization"]));
    let bytes = [0_i8, 127, -127, -128].map(|value| value as u8).repeat(6);
    let weights = strip.add(&bytes, 5120, 6, "VEC4");
    strip.json["accessors"][weights]["normalized"] = true.into();
    let indices = strip.view(&[4, 0, 0, 0]);
    let values = strip.view(&[0, 0, 0x80, 0x3f].repeat(3));
    strip.json["accessors"][strip::POSITIONS]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values }
    });
    let glb = strip.glb();
    let container = Asset::new(&glb, None, Budget::default()).unwrap();
    let buffers = container.buffers().unwrap();
    let mut accessors = Accessors::new(&container.document, &buffers);
    let found = accessors.floats::<4>(weights as u32, Some(6)).unwrap();
    assert_eq!(found[5], [0.0, 1.0, -1.0, -1.0]);
    let scene = Scene::read(&glb).unwrap();
    let found = positions(&scene, &PoseRequest::default());
    assert_eq!((found[4], found[3]), ([1.0; 3], REST[3]));
}

#[test]
fn buffers_and_images_may_be_embedded_or_external() {
    let strip = Strip::new();
    let uri =
        |bytes: &[u8]| format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes));
    let inline = Strip::new()
        .with("/buffers/0/uri", uri(&strip.binary).into())
        .with("/images/0", json!({ "uri": uri(&strip::texture()) }));
    let scene = Scene::read(inline.json.to_string().as_bytes()).unwrap();
    assert_near(&positions(&scene, &PoseRequest::default()), &REST);

    let folder = std::env::temp_dir().join(format!("uvgraft-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("the strip.bin"), &strip.binary).unwrap();
    let beside = Strip::new().with("/buffers/0/uri", "the%20strip.bin".into());
    std::fs::write(folder.join("me.gltf"), beside.json.to_string()).unwrap();
    let scene = Scene::load(folder.join("me.gltf")).unwrap();
    assert_near(&positions(&scene, &PoseRequest::default()), &REST);
    let alone = Scene::read(beside.json.to_string().as_bytes()).unwrap_err().to_string();
    assert!(alone.contains("external file"), "{alone}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn vrm_names_bones_and_faces() {
    let strip = Strip::new().with(
        "/extensions",
        json!({ "VRMC_vrm": {
            "specVersion": "1.0",
            "humanoid": { "humanBones": { "hips": { "node": 0 }, "head": { "node": 1 } } },
            "expressions": {
                "preset": {
                    "happy": { "morphTargetBinds": [{ "node": 2, "index": 0, "weight": 0.5 }] },
                    "blink": { "isBinary": true,
                        "morphTargetBinds": [{ "node": 2, "index": 0, "weight": 1.0 }] }
                }
            }
        }}),
    );
    let scene = read(&strip);
    assert_eq!(scene.bones().collect::<Vec<_>>(), ["head", "hips"]);
    assert_eq!(scene.expressions(), ["blink", "happy", "bulge"]);
    let bone = |bone| scene.bone(bone, &PoseRequest::default()).unwrap();
    assert_eq!((bone("head"), bone("jaw")), (Some([0.0, 1.0, 0.0]), None));
    let depth = |name: &str, weight: f32| {
        let weights = vec![(name.to_owned(), weight)];
        positions(&scene, &PoseRequest { weights, ..PoseRequest::default() })[2][2]
    };
    assert_eq!((depth("happy", 0.8), depth("blink", 0.4), depth("blink", 0.6)), (0.2, 0.0, 0.5));
}

#[test]
fn named_poses_are_independent_of_the_rest_pose() {
    // Hands and elbows are below along Y, or ahead along Z.
    for (elbow, hand) in [([0.3, -0.3, 0.0], [0.3, -0.6, 0.0]), ([0.0, 0.0, 0.5], [0.0, 0.5, 0.5])]
    {
        let bones = |side: f32, first: usize| {
            let name = if side > 0.0 { "left" } else { "right" };
            [
                json!({ "name": format!("{name}UpperArm"), "children": [first + 1],
                    "translation": [0.2 * side, 1.4, 0] }),
                json!({ "name": format!("{name}LowerArm"), "children": [first + 2],
                    "translation": [elbow[0] * side, elbow[1], elbow[2]] }),
                json!({ "name": format!("{name}Hand"),
                    "translation": [(hand[0] - elbow[0]) * side, hand[1] - elbow[1], hand[2] - elbow[2]] }),
            ]
        };
        let mut strip = Strip::new().with("/scenes/0/nodes", json!([0, 2, 3, 6]));
        let nodes = strip.json["nodes"].as_array_mut().unwrap();
        nodes.extend(bones(1.0, 3));
        nodes.extend(bones(-1.0, 6));
        let scene = read(&strip);
        let length = |v: [f32; 3]| v.iter().map(|x| x * x).sum::<f32>().sqrt();
        let upper = length(elbow);
        let lower = length([0, 1, 2].map(|k| hand[k] - elbow[k]));
        let posing = PoseRequest { stance: NamedPose::TPose, ..PoseRequest::default() };
        for (bone, side) in [("left", 1.0), ("right", -1.0)] {
            let found = scene.bone(&format!("{bone}Hand"), &posing).unwrap().unwrap();
            assert_near(&[found], &[[side * (0.2 + upper + lower), 1.4, 0.0]]);
        }
    }
    let posing = PoseRequest { stance: NamedPose::Wave, ..PoseRequest::default() };
    let error = read(&Strip::new()).pose(&posing).unwrap_err();
    assert!(error.to_string().contains("leftUpperArm"), "{error}");
}

#[test]
fn unknown_names_list_the_available_ones() {
    let scene = read(&Strip::new());
    let refused = |posing: PoseRequest| scene.pose(&posing).unwrap_err().to_string();
    let none = PoseRequest::default();
    for (posing, wanted) in [
        (PoseRequest { clip: Some((1, 0.0)), ..none.clone() }, "no clip \"1\""),
        (PoseRequest { clip: Some((0, f32::NAN)), ..none.clone() }, "finite"),
        (PoseRequest { weights: vec![("smile".into(), 1.0)], ..none.clone() }, "bulge"),
        (PoseRequest { weights: vec![("bulge".into(), f32::NAN)], ..none.clone() }, "finite"),
        (PoseRequest { rotations: vec![("tail".into(), [0.0; 3])], ..none.clone() }, "head"),
        (PoseRequest { rotations: vec![("head".into(), [f32::INFINITY; 3])], ..none }, "finite"),
    ] {
        let found = refused(posing);
        assert!(found.contains(wanted), "{found}");
    }
}

#[test]
fn truncated_files_are_rejected() {
    let glb = Strip::new().glb();
    for length in (0..glb.len()).step_by(16).chain([glb.len() - 1]) {
        let error = Scene::read(&glb[..length]).expect_err("cut off");
        let wanted = if length < 4 { "not a glTF file" } else { "truncated" };
        assert!(error.to_string().contains(wanted), "{length}: {error}");
    }
}

#[test]
fn flipped_bytes_never_panic() {
    // It must not panic, whatever the result.
    let glb = Strip::new().glb();
    for at in 0..glb.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = glb.clone();
            bytes[at] ^= flip;
            if let Ok(scene) = Scene::read(&bytes) {
                let clip = (!scene.clips().is_empty()).then_some((0, 0.3));
                let weights = vec![("bulge".to_owned(), 0.5)];
                let _ = scene.pose(&PoseRequest { clip, weights, ..PoseRequest::default() });
            }
        }
    }
}

#[test]
fn invalid_references_and_numbers_are_located() {
    let nan = f32::NAN.to_le_bytes();
    let bomb = {
        let mut strip = Strip::new();
        let view = strip.view(&strip::png(32_000, 32_000, &[]));
        strip.with("/images/0/bufferView", view.into())
    };
    let ktx2 = {
        let mut strip = Strip::new();
        let view = strip.view(b"\xabKTX 20\xbb\r\n\x1a\n");
        let strip = strip.with("/images/0/bufferView", view.into());
        strip
            .with("/textures/0", json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } }))
    };
    let accessor = |index: usize, key: &str| format!("/accessors/{index}/{key}");
    let strip = Strip::new;
    let cases = [
        (strip().with("/nodes/1/children", json!([0])), "node 0: must not be its own ancestor"),
        (strip().with("/nodes/0/children", json!([0])), "node 0: must not be its own ancestor"),
        (strip().with("/nodes/2/children", json!([1])), "already has the parent"),
        (strip().with("/nodes/0/children", json!([9])), "refers to node 9, but the file has 3"),
        (strip().with("/scenes/0/nodes", json!([7])), "scene 0"),
        (strip().with("/scene", json!(3)), "refers to scene 3"),
        (strip().with("/nodes/2/mesh", json!(1)), "node 2: refers to mesh 1"),
        (strip().with("/nodes/2/skin", json!(1)), "node 2: refers to skin 1"),
        (strip().with("/nodes/0/translation", json!([1e39, 0, 0])), "node 0"),
        (strip().with("/skins/0/joints", json!([0])), "uses joint 1, but skin 0 has 1"),
        (strip().with("/skins/0/joints", json!([0, 5])), "skin 0: refers to node 5"),
        (
            strip().with("/skins/0/joints", json!([0, 1, 2])),
            "must have 3 matrices, one for each joint, got 2",
        ),
        (strip().with_bytes(strip::JOINTS, 0, [7, 1, 0, 0]), "uses joint 7"),
        (strip().with_bytes(strip::INDICES, 0, [6, 0, 0, 0]), "index 0 must be less than 6, got 6"),
        (strip().with_bytes(strip::POSITIONS, 12, nan), "accessor 0: element 1"),
        (strip().with_bytes(strip::UV, 0, nan), "accessor 1: element 0"),
        (strip().with_bytes(strip::WEIGHTS, 0, nan), "accessor 3"),
        (strip().with_bytes(strip::INVERSE_BIND, 0, nan), "accessor 6"),
        (strip().with_bytes(strip::TIMES, 0, 5_f32.to_le_bytes()), "times must increase"),
        (strip().with(&accessor(0, "count"), json!(7)), "7 elements of 12 bytes"),
        (strip().with(&accessor(0, "count"), json!(u64::MAX)), "must have at most"),
        (strip().with(&accessor(0, "byteOffset"), json!(u64::MAX)), "exceed buffer view"),
        (strip().with(&accessor(0, "componentType"), json!(5124)), "5126, got 5124"),
        (strip().with(&accessor(0, "type"), json!("VEC2")), "must have 3 components"),
        (strip().with(&accessor(0, "type"), json!("MAT9")), "MAT9"),
        (strip().with(&accessor(0, "bufferView"), json!(99)), "refers to buffer view 99"),
        (strip().with(&accessor(4, "componentType"), json!(5120)), "unsigned integers"),
        (strip().with("/bufferViews/0/byteLength", json!(1_u64 << 40)), "buffer view 0"),
        (strip().with("/bufferViews/0/byteOffset", json!(u64::MAX)), "buffer view 0"),
        (strip().with("/bufferViews/0/buffer", json!(1)), "refers to buffer 1"),
        (strip().with("/bufferViews/0/byteStride", json!(4)), "got 4"),
        (strip().with("/buffers/0/byteLength", json!(1 << 30)), "buffer 0: must have"),
        (strip().with("/buffers/0/uri", json!("../x.bin")), "external file"),
        (strip().with("/buffers/0/uri", json!("data:;base64,?")), "data URI"),
        (
            strip().with("/materials/0/alphaMode", json!("ADD")),
            "alpha mode must be OPAQUE, MASK or BLEND, got \"ADD\"",
        ),
        (strip().with("/textures/0/source", json!(4)), "refers to image 4"),
        (strip().with("/images/0/bufferView", json!(0)), "image 0: not a supported image"),
        (strip().with("/animations/0/samplers/0/input", json!(0)), "accessor 0"),
        (strip().with("/animations/0/channels/0/sampler", json!(4)), "sampler 4"),
        (strip().with("/animations/0/channels/0/target/node", json!(4)), "node 4"),
        (strip().with("/meshes/0/primitives/0/mode", json!(9)), "mode must be 0 to 6, got 9"),
        (strip().with("/meshes/0/primitives/0/material", json!(3)), "material 3"),
        (strip().with("/asset/version", json!("1.0")), "version must be 2.0, got \"1.0\""),
        (strip().with("/extensionsRequired", json!(["EXT_mesh_of_fog"])), "EXT_mesh_of_fog"),
        // With the decoder, the image itself is checked.
        (ktx2, if cfg!(feature = "ktx2") { "image 0" } else { "KHR_texture_basisu" }),
        (bomb, "texels of images"),
    ];
    for (strip, wanted) in cases {
        let error = Scene::read(&strip.glb()).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "wanted {wanted:?}, found {error:?}");
    }
}
