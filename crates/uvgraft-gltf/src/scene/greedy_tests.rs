//! Files that ask for much are refused before anything is unpacked, and what they share stays shared.

use std::borrow::Cow;
use std::sync::Arc;

use serde_json::json;
use uvgraft_files::input::Input;
use uvgraft_tests::greedy;
use uvgraft_tests::strip::Strip;

use super::whole::whole_of;
use super::*;

#[test]
fn greedy_files_are_refused_by_those_who_would_need_the_memory() {
    for greedy::Greedy { name, file, as_scene, as_mesh, contents: as_contents } in greedy::files() {
        let found = [
            Scene::read(&file).err().map(|error| error.to_string()),
            read_mesh(&file, &MeshChoice::default()).err().map(|error| error.to_string()),
            contents(Input::bytes("greedy.glb", &*file)).err().map(|error| error.to_string()),
        ];
        for (wanted, found) in [as_scene, as_mesh, as_contents].into_iter().zip(found) {
            let is_right = match (wanted, &found) {
                (Some(wanted), Some(found)) => found.contains(wanted),
                (wanted, found) => wanted.is_none() && found.is_none(),
            };
            assert!(is_right, "{name}: wanted {wanted:?}, got {found:?}");
        }
    }
}

#[test]
fn a_budget_allows_less_or_more() {
    let strip = Strip::new();
    let small = Scene::read_within(&strip.glb(), Budget::bytes(1000)).unwrap_err().to_string();
    assert!(small.starts_with("must need at most 0 MiB of memory, got"), "{small}");
    assert!(Scene::read_within(&strip.glb(), Budget::bytes(1 << 20)).is_ok());
    // 3 GiB as drawn, which nothing that is read here needs.
    let mut many = Strip::new();
    let accessors = many.json["accessors"].as_array_mut().unwrap();
    let corners = json!({ "componentType": 5125, "count": 3 * 6_000_000, "type": "SCALAR" });
    accessors.push(corners);
    let indices = accessors.len() - 1;
    let many = many.with("/meshes/0/primitives/0/indices", indices.into());
    assert!(Scene::read(&many.glb()).is_err());
    assert!(Scene::read_within(&many.glb(), Budget::bytes(4 << 30)).is_ok());
}

#[test]
fn primitives_share_what_they_refer_to() {
    let mut strip = Strip::new();
    let primitives = strip.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(primitives[0].clone());
    let scene = Scene::read(&strip.glb()).unwrap();
    let [one, other] = &scene.meshes[0].primitives[..] else { panic!("two primitives") };
    assert!(Arc::ptr_eq(&one.positions, &other.positions));
    assert!(Arc::ptr_eq(&one.uv, &other.uv) && Arc::ptr_eq(&one.triangles, &other.triangles));
    assert!(Arc::ptr_eq(&one.morphs[0].positions, &other.morphs[0].positions));
    let [a, b] = [one, other].map(|primitive| primitive.influences.as_ref().unwrap());
    assert!(Arc::ptr_eq(a, b));
}

#[test]
fn images_in_one_place_are_one() {
    let mut strip = Strip::new();
    let image = strip.json["images"][0].clone();
    strip.json["images"] = json!([image, image]);
    strip.json["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    let strip = strip.with("/materials/0/emissiveTexture", json!({ "index": 1 }));
    let scene = Scene::read(&strip.glb()).unwrap();
    assert_eq!(scene.textures().len(), 1);
    let [color, glow] = [scene.materials()[0].texture, scene.materials()[0].emissive_texture];
    assert_eq!((color.unwrap().index, glow.unwrap().index), (0, 0));
}

/// The strip, to be converted since it has a material of an older kind.
fn to_convert() -> Strip {
    Strip::new().with("/extensionsUsed", json!(["KHR_materials_pbrSpecularGlossiness"]))
}

#[test]
fn conversion_copies_ranges_once_and_no_more_than_a_file_may_have() {
    let convert =
        |strip: &Strip| whole_of(&strip.glb(), None, Budget::default()).map(Cow::into_owned);
    let plain = convert(&to_convert()).unwrap();
    let with_views = |count: usize, shift: usize| {
        let mut strip = to_convert();
        strip.view(&vec![7; 1 << 20]);
        let views = strip.json["bufferViews"].as_array_mut().unwrap();
        let large = views.pop().unwrap();
        for index in 0..count {
            let mut view = large.clone();
            view["byteLength"] = ((1 << 20) - shift * index).into();
            views.push(view);
        }
        strip
    };
    let same = convert(&with_views(1000, 0)).unwrap();
    assert!(same.len() < plain.len() + (2 << 20), "{} bytes", same.len());
    let refused = convert(&with_views(3000, 4)).unwrap_err().to_string();
    assert!(refused.contains("MiB of memory"), "{refused}");
}

#[test]
fn materials_of_one_roughness_share_its_texture() {
    let gloss = json!({ "KHR_materials_pbrSpecularGlossiness": {
        "glossinessFactor": 0.5, "specularGlossinessTexture": { "index": 0 }
    } });
    let material = json!({ "extensions": gloss });
    let strip = to_convert().with("/materials", json!([material, material, material]));
    let whole = whole_of(&strip.glb(), None, Budget::default()).unwrap().into_owned();
    let json: serde_json::Value =
        serde_json::from_slice(Asset::new(&whole, None, Budget::default()).unwrap().json).unwrap();
    // The one of the file, and the one that is made.
    assert_eq!(json["images"].as_array().map(Vec::len), Some(2));
}

#[test]
fn targets_without_data_move_nothing() {
    let mut strip = Strip::new();
    let accessors = strip.json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "componentType": 5126, "count": 6, "type": "VEC3" }));
    let none = accessors.len() - 1;
    let targets = vec![json!({ "POSITION": none }); 100];
    let scene = Scene::read(&strip.with("/meshes/0/primitives/0/targets", targets.into()).glb());
    assert!(scene.unwrap().meshes[0].primitives[0].morphs.iter().all(|it| it.positions.is_empty()));
}

#[test]
fn lists_in_messages_are_short() {
    let names: Vec<String> = (0..200).map(|k| format!("target {k} {}", "x".repeat(1000))).collect();
    let strip = Strip::new().with("/meshes/0/extras/targetNames", json!(names));
    let scene = Scene::read(&strip.glb()).unwrap();
    assert_eq!(scene.expressions().len(), 200);
    let weights = vec![("smile".to_owned(), 1.0)];
    let error = scene.pose(&PoseRequest { weights, ..PoseRequest::default() }).unwrap_err();
    let error = error.to_string();
    assert!(error.ends_with("and 190 more") && error.len() < 1000, "{error}");
}

/// Reports list a triangle in every block of rows of the layout that it touches.
#[test]
fn copies_that_fill_the_layout_count_by_their_height() {
    let copies = |count: u32, height: f32| {
        let mut strip = Strip::new();
        let uv: Vec<u8> =
            [[0.0, 0.0], [1.0, 0.0], [0.0, height], [1.0, height], [0.0, 0.0], [1.0, 0.0]]
                .as_flattened()
                .iter()
                .flat_map(|value: &f32| value.to_le_bytes())
                .collect();
        let uv = strip.add(&uv, 5126, 6, "VEC2");
        let places = json!({ "componentType": 5126, "count": count, "type": "VEC3" });
        let accessors = strip.json["accessors"].as_array_mut().unwrap();
        accessors.push(places);
        let places = accessors.len() - 1;
        strip.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uv.into();
        let node = strip.json["nodes"].as_array_mut().unwrap();
        let node = node.iter_mut().find(|node| !node["mesh"].is_null()).unwrap();
        node["extensions"] =
            json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
        node["skin"] = serde_json::Value::Null;
        read_mesh(&strip.glb(), &MeshChoice::default()).map(|read| read.mesh.faces().len())
    };
    let refused = copies(1 << 17, 1.0).unwrap_err().to_string();
    assert!(refused.contains("memory"), "{refused}");
    assert!(copies(1 << 17, 0.01).is_ok() && copies(1 << 10, 1.0).is_ok());
}
