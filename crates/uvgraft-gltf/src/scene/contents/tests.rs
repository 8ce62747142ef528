use serde_json::json;
use uvgraft_tests::strip::{self, Strip};

use super::*;

fn of(strip: &Strip) -> Contents {
    read_in(&strip.glb(), None).unwrap()
}

#[test]
fn a_file_is_described() {
    let found = of(&Strip::new());
    let part = PartContents {
        node: "strip".to_owned(),
        mesh: String::new(),
        material: "cloth".to_owned(),
        vertices: 6,
        triangles: 4,
        instances: 1,
        uv_sets: vec![0],
        morph_targets: 1,
        is_skinned: true,
    };
    assert_eq!(found.parts, [part]);
    assert_eq!((found.joints, found.vrm, found.expressions.len()), (2, None, 0));
    assert_eq!(found.morph_targets, ["bulge"]);
    let clip = ClipContents { name: "bend".to_owned(), seconds: 1.0, channels_without_keys: 0 };
    assert_eq!(found.clips, [clip]);
    let [image] = &found.images[..] else { panic!("{:?}", found.images) };
    assert_eq!((image.format, image.size), (Some("PNG"), Some([2, 2])));
    let color =
        ImageUse { role: "baseColorTexture".to_owned(), material: Some("cloth".to_owned()) };
    assert_eq!(image.uses, [color]);
}

#[test]
fn strips_of_triangles_are_counted() {
    for (mode, triangles) in [(4, 2), (5, 4), (6, 4)] {
        let mut strip = Strip::new().with("/meshes/0/primitives/0/mode", json!(mode));
        strip.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
        assert_eq!(of(&strip).parts[0].triangles, triangles, "{mode}");
    }
    let lines = Strip::new().with("/meshes/0/primitives/0/mode", json!(1));
    assert_eq!(of(&lines).parts, []);
}

#[test]
fn images_of_extensions_and_damaged_ones_are_listed() {
    let mut strip = Strip::new();
    let broken = strip.view(b"not an image");
    let mut ktx2 = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    ktx2.extend([0, 1, 64, 32].map(u32::to_le_bytes).concat());
    ktx2.resize(80, 0);
    let ktx2 = strip.view(&ktx2);
    strip.json["images"].as_array_mut().unwrap().extend([
        json!({ "name": "broken", "bufferView": broken, "mimeType": "image/png" }),
        json!({ "bufferView": ktx2, "mimeType": "image/ktx2" }),
        json!({ "uri": "none.png" }),
    ]);
    strip.json["textures"].as_array_mut().unwrap().extend([
        json!({ "source": 1 }),
        json!({ "extensions": { "KHR_texture_basisu": { "source": 2 } } }),
    ]);
    let strip = strip
        .with(
            "/materials/0/extensions",
            json!({ "VRMC_materials_mtoon": { "matcapTexture": { "index": 1 } } }),
        )
        .with("/materials/0/pbrMetallicRoughness/metallicRoughnessTexture", json!({ "index": 2 }))
        .with("/extensions", json!({ "VRMC_vrm": { "meta": { "thumbnailImage": 0 } } }));
    let found = of(&strip);
    let roles: Vec<Vec<&str>> = found
        .images
        .iter()
        .map(|image| image.uses.iter().map(|it| it.role.as_str()).collect())
        .collect();
    let wanted = [
        vec!["baseColorTexture", "thumbnailImage"],
        vec!["matcapTexture"],
        vec!["metallicRoughnessTexture"],
        vec![],
    ];
    assert_eq!(roles, wanted);
    let [_, broken, ktx2, missing] = &found.images[..] else { panic!("{:?}", found.images) };
    assert!(broken.problem.is_some() && broken.bytes == Some(12) && broken.size.is_none());
    assert_eq!((ktx2.format, ktx2.size), (Some("KTX2"), Some([64, 32])));
    assert!(missing.name == "none.png" && missing.problem.is_some() && missing.bytes.is_none());
    assert_eq!(found.vrm, Some("1.0"));
}

#[test]
fn damaged_files_are_refused() {
    let refused = |strip: Strip| read_in(&strip.glb(), None).unwrap_err().to_string();
    let far = Strip::new().with("/meshes/0/primitives/0/attributes/POSITION", json!(99));
    assert!(refused(far).contains("refers to accessor 99"));
    let far = Strip::new().with("/nodes/2/mesh", json!(9));
    assert!(refused(far).contains("refers to mesh 9"));
    let late = Strip::new().with_bytes(strip::TIMES, 0, f32::NAN.to_le_bytes());
    assert!(refused(late).contains("finite"));
}
