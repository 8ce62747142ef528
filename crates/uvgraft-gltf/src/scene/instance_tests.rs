//! Nodes that draw their mesh several times.

use serde_json::{Value, json};
use uvgraft_tests::strip::{self, Strip};

use super::whole::whole_of;
use super::wild_tests::meshopt;
use super::*;

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// The node of the strip without its skin, with attributes of instances.
fn with_attributes(mut strip: Strip, attributes: &Value) -> Strip {
    strip.json["nodes"][2].as_object_mut().unwrap().remove("skin");
    skinned(strip, attributes)
}

fn skinned(strip: Strip, attributes: &Value) -> Strip {
    let instancing = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    strip
        .with("/nodes/2/extensions", instancing)
        .with("/extensionsUsed", json!(["EXT_mesh_gpu_instancing"]))
        .with("/extensionsRequired", json!(["EXT_mesh_gpu_instancing"]))
}

/// Three instances of the strip at z = 5: one as it is; one at x = 10, turned by 90° about Z and
/// twice as large; and one that is mirrored.
fn three() -> Strip {
    let mut strip = Strip::new();
    let places = floats(&[0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let places = strip.add(&places, 5126, 3, "VEC3");
    let turns = [[0_i16, 0, 0, 32_767], [0, 0, 23_170, 23_170], [0, 0, 0, 32_767]];
    let turns = strip.add(
        &turns.concat().into_iter().flat_map(i16::to_le_bytes).collect::<Vec<_>>(),
        5122,
        3,
        "VEC4",
    );
    strip.json["accessors"][turns]["normalized"] = true.into();
    let sizes = floats(&[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, -1.0, 1.0, 1.0]);
    let sizes = strip.add(&sizes, 5126, 3, "VEC3");
    let attributes = json!({ "TRANSLATION": places, "ROTATION": turns, "SCALE": sizes });
    with_attributes(strip, &attributes).with("/nodes/2/translation", json!([0, 0, 5]))
}

fn near(found: [f32; 3], wanted: [f32; 3]) -> bool {
    // Rotations are in 16 bits.
    (0..3).all(|k| (found[k] - wanted[k]).abs() < 1e-3)
}

/// The second vertex, which is half a unit to the right of the foot, of each of [`three`].
const SECOND: [[f32; 3]; 3] = [[0.5, 0.0, 5.0], [10.0, 1.0, 5.0], [-0.5, 0.0, 5.0]];

#[test]
fn instances_are_drawn_where_they_are_placed() {
    let scene = Scene::read(&three().glb()).unwrap();
    assert_eq!(scene.triangles(), 12);
    let drawn = scene.pose(&PoseRequest::default()).unwrap();
    assert_eq!(drawn.len(), 3);
    for (piece, wanted) in drawn.iter().zip(SECOND) {
        assert!(near(piece.positions[1], wanted), "{:?} {wanted:?}", piece.positions);
        assert!(near(piece.normals[1], [0.0, 0.0, 1.0]), "{:?}", piece.normals);
    }
    // What is mirrored is turned over, so that its front stays in front.
    let first = [0, 1, 2].map(|piece: usize| drawn[piece].triangles[0]);
    assert_eq!(first, [[0, 1, 3], [0, 1, 3], [0, 3, 1]]);
    let extent = scene.extent("strip", &PoseRequest::default()).unwrap();
    assert_eq!(extent.points.len(), 36);
    assert!(extent.points.iter().any(|&point| near(point, [6.0, 1.0, 5.0])));
}

#[test]
fn rotations_may_be_bytes_and_attributes_missing() {
    let mut strip = Strip::new();
    let turns = [0_i8, 0, 0, 127, 0, 0, 90, 90].map(|value| value as u8);
    let turns = strip.add(&turns, 5120, 2, "VEC4");
    strip.json["accessors"][turns]["normalized"] = true.into();
    let drawn = Scene::read(&with_attributes(strip, &json!({ "ROTATION": turns })).glb()).unwrap();
    let drawn = drawn.pose(&PoseRequest::default()).unwrap();
    assert!(drawn.len() == 2 && near(drawn[1].positions[1], [0.0, 0.5, 0.0]), "{drawn:?}");
    // Attributes of an application count instances, which are all at the node.
    for count in [0, 1, 4] {
        let mut strip = Strip::new();
        let numbers = strip.add(&[7; 16], 5121, count, "SCALAR");
        let scene = Scene::read(&with_attributes(strip, &json!({ "_ID": numbers })).glb()).unwrap();
        assert_eq!(scene.triangles(), 4 * count);
        assert_eq!(scene.pose(&PoseRequest::default()).unwrap().len(), count);
    }
    let plain = Scene::read(&with_attributes(Strip::new(), &json!({})).glb()).unwrap();
    assert_eq!(plain.triangles(), 4);
}

#[test]
fn instances_of_a_skinned_mesh_move_as_posed() {
    let mut strip = Strip::new();
    let places = strip.add(&floats(&[0.0, 0.0, 0.0, 3.0, 0.0, 0.0]), 5126, 2, "VEC3");
    let strip = skinned(strip, &json!({ "TRANSLATION": places }));
    // As seen from the node, whose units are twice as long; its scale does not affect joints.
    let strip = strip.with("/nodes/2/scale", json!([2, 2, 2]));
    let scene = Scene::read(&strip.glb()).unwrap();
    let bent = PoseRequest { clip: Some((0, 1.0)), ..PoseRequest::default() };
    let drawn = scene.pose(&bent).unwrap();
    for (a, b) in drawn[0].positions.iter().zip(&drawn[1].positions) {
        assert!(near(*b, [a[0] + 6.0, a[1], a[2]]), "{a:?} {b:?}");
    }
    assert!(near(drawn[0].positions[5], [-1.0, 1.5, 0.0]));
    let mesh = read_mesh(&strip.glb(), &MeshChoice::default()).unwrap().mesh;
    assert!(near(mesh.positions()[7], [6.5, 0.0, 0.0]), "{:?}", mesh.positions());
}

#[test]
fn meshes_and_reports_have_all_instances() {
    let found = read_mesh(&three().glb(), &MeshChoice::default()).unwrap().mesh;
    assert_eq!((found.positions().len(), found.uv().len(), found.faces().len()), (18, 18, 12));
    for (index, wanted) in SECOND.into_iter().enumerate() {
        assert!(near(found.positions()[6 * index + 1], wanted), "{:?}", found.positions());
    }
    assert_eq!((found.faces()[4], found.uv_faces()[4]), ([6, 7, 9], [6, 7, 9]));
    assert_eq!((found.faces()[8], found.uv_faces()[8]), ([12, 15, 13], [12, 15, 13]));
    assert_eq!((found.uv()[7], found.parts().len()), (found.uv()[1], 1));
    let parts = contents(Input::bytes("a.glb", three().glb())).unwrap().parts;
    let counts = (parts[0].instances, parts[0].vertices, parts[0].triangles);
    assert_eq!((counts, parts.len()), ((3, 18, 12), 1));
    // Without UV coordinates each instance counts.
    let mut bare = three();
    let mesh = bare.json["meshes"][0].clone();
    bare.json["meshes"].as_array_mut().unwrap().push(mesh);
    bare.json["nodes"].as_array_mut().unwrap().push(json!({ "mesh": 1 }));
    let attributes = &mut bare.json["meshes"][0]["primitives"][0]["attributes"];
    attributes.as_object_mut().unwrap().remove("TEXCOORD_0");
    let bare = bare.with("/scenes/0/nodes", json!([0, 2, 3]));
    let found = read_mesh(&bare.glb(), &MeshChoice::default()).unwrap();
    assert_eq!((found.without_uv.polygons, found.mesh.faces().len()), (12, 4));
}

#[test]
fn converted_files_keep_their_instances() {
    let mut strip = meshopt();
    let places = strip.add(&floats(&[0.0, 0.0, 0.0, 0.0, 3.0, 0.0]), 5126, 2, "VEC3");
    let instancing = json!({ "attributes": { "TRANSLATION": places } });
    let strip = strip
        .with("/nodes/2/extensions", json!({ "EXT_mesh_gpu_instancing": instancing }))
        .with("/extensionsUsed", json!(["EXT_meshopt_compression", "EXT_mesh_gpu_instancing"]));
    let whole = whole_of(&strip.glb(), None, Budget::default()).unwrap().into_owned();
    let [before, after] = [strip.glb(), whole.clone()].map(|glb| Scene::read(&glb).unwrap());
    let of = |scene: &Scene| scene.pose(&PoseRequest::default()).unwrap();
    assert!(of(&before).len() == 2 && of(&before) == of(&after));
    let json: Value =
        serde_json::from_slice(Asset::new(&whole, None, Budget::default()).unwrap().json).unwrap();
    assert_eq!(json["extensionsUsed"], json!(["EXT_mesh_gpu_instancing"]));
}

#[test]
fn impossible_instances_are_refused() {
    let with = |count: u64, other: u64| {
        let mut strip = Strip::new();
        let zeros = |count: u64| json!({ "componentType": 5126, "count": count, "type": "VEC3" });
        let accessors = strip.json["accessors"].as_array_mut().unwrap();
        let first = accessors.len();
        accessors.extend([zeros(count), zeros(other)]);
        with_attributes(strip, &json!({ "TRANSLATION": first, "SCALE": first + 1 }))
    };
    assert!(Scene::read(&with(9, 9).glb()).is_ok());
    let many = (1 << 20) + 1;
    let mut twice = with(1 << 20, 1 << 20);
    let primitives = twice.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(primitives[0].clone());
    let cases = [
        (with(2, 3), "must have 2 elements, got 3"),
        (with(many, many), "must have at most 1048576 instances, got 1048577"),
        (with(u64::MAX, 1), "instances"),
        (with_attributes(Strip::new(), &json!({ "SCALE": 99 })), "refers to accessor 99"),
        (with_attributes(Strip::new(), &json!({ "SCALE": strip::UV })), "must have 3 components"),
        (twice, "must have at most 1048576 primitives, of all nodes and instances, got 2097152"),
    ];
    for (strip, wanted) in cases {
        for error in [
            Scene::read(&strip.glb()).map(drop).map_err(|error| error.to_string()),
            read_mesh(&strip.glb(), &MeshChoice::default()).map(drop).map_err(|it| it.to_string()),
        ] {
            let error = error.expect_err(wanted);
            assert!(error.contains(wanted), "wanted {wanted:?}, found {error:?}");
        }
    }
}
