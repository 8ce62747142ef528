use serde_json::{Value, json};
use uvgraft_tests::strip::{self, Strip};

use super::super::wild_tests::{draco, meshopt};
use uvgraft::Mesh;

use super::*;
use crate::glb::{AvatarMaterial, EmbeddedImage, Export, write};

fn read(strip: &Strip, choice: &MeshChoice) -> Result<Mesh, String> {
    let found = read_mesh(&strip.glb(), choice).map_err(|error| error.to_string())?;
    assert_eq!(found.without_uv.polygons, 0);
    Ok(found.mesh)
}

fn whole(strip: &Strip) -> Mesh {
    read(strip, &MeshChoice::default()).unwrap()
}

fn named(name: &str) -> MeshChoice {
    MeshChoice { name: Some(name.to_owned()), uv_set: None }
}

fn set(uv_set: u32) -> MeshChoice {
    MeshChoice { uv_set: Some(uv_set), name: None }
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

const STRIP_FACES: [[u32; 3]; 4] = [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]];

#[test]
fn a_strip_is_as_its_file_has_it() {
    let mesh = whole(&Strip::new());
    assert_eq!(mesh.faces(), STRIP_FACES);
    assert_eq!(mesh.uv_faces(), STRIP_FACES);
    assert_eq!(mesh.positions()[3], [0.5, 1.0, 0.0]);
    // Not flipped: the foot is at the bottom of the texture.
    assert_eq!((mesh.uv()[0], mesh.uv()[5]), ([0.0, 1.0], [1.0, 0.0]));
    let part = &mesh.parts()[0];
    let names = [&*part.object, &*part.group, &*part.material];
    assert_eq!((names, part.polygons.clone()), (["strip", "", "cloth"], 0..4));
}

#[test]
fn skinned_meshes_follow_joints_and_others_their_node() {
    let moved = Strip::new().with("/nodes/2/translation", json!([5, 0, 0]));
    assert_eq!(whole(&moved).positions()[0], [-0.5, 0.0, 0.0]);
    let bent = Strip::new().with("/nodes/1/translation", json!([0, 1, 2]));
    let mesh = whole(&bent);
    assert_eq!([0, 2, 4].map(|vertex| mesh.positions()[vertex][2]), [0.0, 1.0, 2.0]);
    let bulging = Strip::new().with("/nodes/2/weights", json!([1.0]));
    assert_eq!(whole(&bulging).positions()[2], [-0.5, 1.0, 0.5]);

    let mut loose = moved.with("/nodes/2/scale", json!([-2, 1, 1]));
    loose.json["nodes"][2].as_object_mut().unwrap().remove("skin");
    let mesh = whole(&loose);
    assert_eq!(mesh.positions()[0], [6.0, 0.0, 0.0]);
    // Mirrored: the winding is reversed, in the layout as on the surface.
    assert_eq!((mesh.faces()[0], mesh.uv_faces()[0]), ([0, 3, 1], [0, 3, 1]));
}

/// The strip's upper half as a second primitive with its own material; a second node `prop` shows
/// a mesh `box` of the same primitives.
fn two_nodes() -> Strip {
    let mut strip = Strip::new();
    let upper = [2_u16, 3, 5, 2, 5, 4].map(u16::to_le_bytes).concat();
    let upper = strip.add(&upper, 5123, 6, "SCALAR");
    let second = strip.add(&floats(&[0.25; 12]), 5126, 6, "VEC2");
    strip.json["accessors"][strip::INDICES]["count"] = 6.into();
    let first = &mut strip.json["meshes"][0]["primitives"][0];
    first["attributes"]["TEXCOORD_1"] = second.into();
    let mut other = first.clone();
    other["indices"] = upper.into();
    other["material"] = 1.into();
    let both = json!([first.clone(), other]);
    let cloth = strip.json["materials"][0].clone();
    strip.json["materials"] = json!([cloth, { "name": "skin" }]);
    strip.json["meshes"] = json!([{ "name": "sheet", "primitives": both.clone() }, { "name": "box", "primitives": both }]);
    let nodes = strip.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({ "name": "prop", "mesh": 1, "translation": [0, 0, 7] }));
    nodes.push(json!({ "name": "things", "children": [3] }));
    strip.with("/scenes/0/nodes", json!([0, 2, 4]))
}

#[test]
fn primitives_share_vertices_and_nodes_do_not() {
    let mesh = whole(&two_nodes());
    assert_eq!((mesh.positions().len(), mesh.uv().len()), (12, 12));
    assert_eq!(mesh.faces()[..4], STRIP_FACES);
    assert_eq!(mesh.faces()[7], [8, 11, 10]);
    assert_eq!(mesh.positions()[6], [-0.5, 0.0, 7.0]);
    let parts: Vec<[&str; 3]> =
        mesh.parts().iter().map(|part| [&*part.object, &*part.group, &*part.material]).collect();
    assert_eq!(
        parts,
        [
            ["strip", "sheet", "cloth"],
            ["strip", "sheet", "skin"],
            ["prop", "box", "cloth"],
            ["prop", "box", "skin"]
        ]
    );
    assert_eq!(mesh.parts()[2].polygons, 4..6);
    // Other coordinates at the same positions.
    let mut apart = two_nodes();
    let other = apart.add(&floats(&[0.75; 12]), 5126, 6, "VEC2");
    let apart = apart.with("/meshes/0/primitives/1/attributes/TEXCOORD_0", other.into());
    let mesh = whole(&apart);
    assert_eq!((mesh.positions().len(), mesh.uv().len()), (12, 18));
    assert_eq!((mesh.faces()[2], mesh.uv_faces()[2]), ([2, 3, 5], [8, 9, 11]));
}

#[test]
fn parts_are_chosen_by_name() {
    let strip = two_nodes();
    let count = |name: &str| {
        let mesh = read(&strip, &named(name)).unwrap();
        (mesh.positions().len(), mesh.faces().len())
    };
    assert_eq!(count("prop"), (6, 4));
    assert_eq!(count("things"), (6, 4));
    assert_eq!(count("sheet"), (6, 4));
    assert_eq!(count("skin"), (12, 4));
    // A joint without a mesh, and a name that does not exist.
    for name in ["head", "hat", ""] {
        let error = read(&strip, &named(name)).unwrap_err();
        assert_eq!(
            error,
            format!(
                "no node, mesh or material with triangles is named {name:?}; must be one of strip, \
                 prop, sheet, box, cloth, skin"
            )
        );
    }
    // Nodes come before materials.
    let renamed = strip.clone().with("/nodes/3/name", json!("skin"));
    assert_eq!(read(&renamed, &named("skin")).unwrap().positions()[0][2], 7.0);
    let long = "x".repeat(1000);
    let strip = strip.with("/materials/1/name", json!(long));
    let error = read(&strip, &named("hat")).unwrap_err();
    assert!(error.len() < 300 && error.contains("xxx…"), "{error}");
}

#[test]
fn any_uv_set_is_read() {
    let strip = two_nodes();
    let mesh = read(&strip, &set(1)).unwrap();
    assert_eq!((mesh.uv()[0], mesh.positions().len()), ([0.25; 2], 12));
    assert_eq!(
        read(&strip, &set(7)).unwrap_err(),
        "node \"strip\", mesh 0, primitive 0: must have the UV set 7 (TEXCOORD_7), but has \
         TEXCOORD_0, TEXCOORD_1"
    );
    let mut bare = Strip::new();
    bare.json["meshes"][0]["primitives"][0]["attributes"]
        .as_object_mut()
        .unwrap()
        .remove("TEXCOORD_0");
    let error = read(&bare, &set(0)).unwrap_err();
    assert!(error.ends_with("(TEXCOORD_0), but has no UV coordinates"), "{error}");
}

#[test]
fn primitives_without_the_set_are_left_out() {
    // The second primitive of each of two nodes, and of the second set the whole of one node.
    let mut strip = two_nodes();
    for mesh in 0..2 {
        let attributes = &mut strip.json["meshes"][mesh]["primitives"][1]["attributes"];
        attributes.as_object_mut().unwrap().remove("TEXCOORD_0");
    }
    strip.json["meshes"][1]["primitives"][0]["attributes"]
        .as_object_mut()
        .unwrap()
        .remove("TEXCOORD_1");
    let left_out = |choice: &MeshChoice| {
        let found = read_mesh(&strip.glb(), choice).unwrap();
        let parts = found.without_uv.parts.iter();
        let names = parts.map(|part| format!("{} {}", part.object, part.material));
        (found.mesh.faces().len(), found.without_uv.polygons, names.collect::<Vec<_>>())
    };
    assert_eq!(left_out(&set(0)), (4, 4, vec!["strip skin".to_owned(), "prop skin".to_owned()]));
    assert_eq!(left_out(&set(1)), (6, 2, vec!["prop cloth".to_owned()]));
    assert_eq!(left_out(&named("prop")), (2, 2, vec!["prop skin".to_owned()]));
    assert_eq!(left_out(&named("cloth")).1, 0);
    let error = read(&strip, &named("skin")).unwrap_err();
    assert!(error.ends_with("(TEXCOORD_0), but has TEXCOORD_1"), "{error}");
}

#[test]
fn quantised_and_compressed_files_are_read() {
    for strip in [draco(), meshopt()] {
        let mesh = whole(&strip);
        assert_eq!(mesh.faces().len(), 4);
        let corners = |mesh: &Mesh| {
            let all = mesh.faces().iter().zip(mesh.uv_faces());
            let all = all.flat_map(|(face, uv)| (0..3).map(move |k| (face[k], uv[k])));
            let mut all: Vec<[i32; 5]> = all
                .map(|(vertex, uv)| {
                    let ([x, y, z], [u, v]) =
                        (mesh.positions()[vertex as usize], mesh.uv()[uv as usize]);
                    [x, y, z, u, v].map(|value| (value * 100.0).round() as i32)
                })
                .collect();
            all.sort_unstable();
            all
        };
        for (found, wanted) in corners(&mesh).iter().zip(corners(&whole(&Strip::new()))) {
            assert!((0..5).all(|k| (found[k] - wanted[k]).abs() <= 1), "{found:?} {wanted:?}");
        }
    }
    // Integers that only the texture's transform brings back, as gltfpack stores them.
    let mut strip = Strip::new();
    let bytes: Vec<u8> = [[0_u16, 200], [100, 0]]
        .concat()
        .repeat(3)
        .into_iter()
        .flat_map(u16::to_le_bytes)
        .collect();
    let uv = strip.add(&bytes, 5123, 6, "VEC2");
    let transform =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0], "scale": [0.005, 0.005] } });
    let strip = strip
        .with("/meshes/0/primitives/0/attributes/TEXCOORD_0", uv.into())
        .with("/materials/0/pbrMetallicRoughness/baseColorTexture/extensions", transform);
    let mesh = whole(&strip);
    for (found, wanted) in mesh.uv().iter().zip([[0.5, 1.0], [1.0, 0.0]]) {
        assert!((0..2).all(|k| (found[k] - wanted[k]).abs() < 1e-6), "{found:?}");
    }
}

#[test]
fn sparse_accessors_are_read() {
    let mut strip = Strip::new();
    let indices = strip.view(&[4, 0, 0, 0]);
    let values = strip.view(&floats(&[0.125, 0.25]));
    strip.json["accessors"][strip::UV]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values }
    });
    assert_eq!(whole(&strip).uv()[4], [0.125, 0.25]);
    strip.json["accessors"][strip::UV]["sparse"]["count"] = 2.into();
    assert!(read(&strip, &set(0)).unwrap_err().contains("exceed buffer view"));
}

#[test]
fn strips_fans_and_plain_lists_are_triangles_and_lines_are_not() {
    let of_mode = |mode: u32| {
        let mut strip = Strip::new().with("/meshes/0/primitives/0/mode", json!(mode));
        strip.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
        read(&strip, &set(0))
    };
    assert_eq!(of_mode(5).unwrap().faces()[..2], [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(of_mode(6).unwrap().faces()[..2], [[1, 2, 0], [2, 3, 0]]);
    assert_eq!(of_mode(4).unwrap().faces(), [[0, 1, 2], [3, 4, 5]]);
    for mode in 0..4 {
        let error = of_mode(mode).unwrap_err();
        assert_eq!(error, "mesh must have triangles, but the scene of the file has none");
    }
    assert!(of_mode(7).unwrap_err().contains("mode must be 0 to 6"));
    // Lines beside triangles are skipped.
    let mut beside = two_nodes().with("/meshes/0/primitives/1/mode", json!(1));
    beside.json["meshes"][0]["primitives"][1]["attributes"]
        .as_object_mut()
        .unwrap()
        .remove("TEXCOORD_0");
    assert_eq!(whole(&beside).faces().len(), 6);
}

#[test]
fn looks_do_not_matter() {
    // Neither a damaged image nor an unsupported format of textures.
    let strip = Strip::new()
        .with("/images/0", json!({ "uri": "none.png" }))
        .with("/extensionsRequired", json!(["EXT_texture_avif", "KHR_materials_unheard_of"]));
    assert_eq!(whole(&strip).faces().len(), 4);
    let strip = strip.with("/extensionsRequired", json!(["EXT_mesh_of_fog"]));
    assert!(read(&strip, &set(0)).unwrap_err().contains("EXT_mesh_of_fog"));
}

#[test]
fn buffers_may_be_external() {
    let folder = tempfile::tempdir().unwrap();
    let strip = Strip::new().with("/buffers/0/uri", "parts.bin".into());
    let path = folder.path().join("me.gltf");
    std::fs::write(&path, strip.json.to_string()).unwrap();
    let error = load_mesh(&path, &MeshChoice::default()).unwrap_err().to_string();
    assert!(error.contains("me.gltf: buffer 0: ") && error.contains("parts.bin"), "{error}");
    std::fs::write(folder.path().join("parts.bin"), &strip.binary).unwrap();
    assert_eq!(load_mesh(&path, &MeshChoice::default()).unwrap().mesh, whole(&Strip::new()));
    // Bytes have no files beside them.
    let bytes = |bytes: Vec<u8>| Input::bytes(&path, bytes);
    let refused = load_mesh(bytes(strip.json.to_string().into()), &MeshChoice::default());
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("me.gltf: buffer 0: refers to the external file"), "{refused}");
    let glb = bytes(Strip::new().glb());
    assert_eq!(load_mesh(glb, &MeshChoice::default()).unwrap().mesh, whole(&Strip::new()));
}

#[test]
fn damaged_files_are_refused_with_a_reason() {
    let nan = f32::NAN.to_le_bytes();
    let strip = Strip::new;
    let accessor = |index: usize, key: &str| format!("/accessors/{index}/{key}");
    let many: Vec<Value> = vec![json!({ "mesh": 0 }); 2_000];
    let heavy: Vec<Value> = vec![json!({}); 10_000];
    let cases = [
        (strip().with_bytes(strip::INDICES, 0, [6, 0, 0, 0]), "index 0 must be less than 6, got 6"),
        (strip().with_bytes(strip::JOINTS, 0, [7, 1, 0, 0]), "uses joint 7, but skin 0 has 2"),
        (strip().with_bytes(strip::POSITIONS, 12, nan), "accessor 0: element 1 must be finite"),
        (strip().with_bytes(strip::UV, 0, nan), "accessor 1: element 0 must be finite"),
        (strip().with(&accessor(0, "count"), json!(u64::MAX)), "must have at most"),
        (strip().with(&accessor(0, "count"), json!(5)), "must have 5 elements, got 6"),
        (strip().with(&accessor(1, "count"), json!(5)), "accessor 1: must have 6 elements, got 5"),
        (strip().with(&accessor(1, "bufferView"), json!(99)), "refers to buffer view 99"),
        (strip().with(&accessor(4, "count"), json!(11)), "multiple of 3, got 11"),
        (strip().with("/nodes/0/children", json!([0])), "must not be its own ancestor"),
        (strip().with("/nodes/2/mesh", json!(3)), "refers to mesh 3"),
        (strip().with("/nodes/2/scale", json!([1e38, 1e38, 1e39])), "must be finite"),
        (strip().with("/meshes/0/primitives/0/material", json!(3)), "refers to material 3"),
        (strip().with("/meshes/0/primitives", json!([])), "the scene of the file has none"),
        (strip().with("/scenes/0/nodes", json!([])), "the scene of the file has none"),
        (strip().with("/accessors/4/count", json!(0)), "the scene of the file has none"),
        (
            strip().with("/nodes", json!(many)).with("/scenes", json!([])).with(
                "/meshes/0/primitives",
                json!(vec![strip().json["meshes"][0]["primitives"][0].clone(); 1_000]),
            ),
            "must have at most 1048576 primitives",
        ),
        (
            strip()
                .with("/nodes", json!(many))
                .with("/scenes", json!([]))
                .with("/meshes/0/primitives/0/targets", json!(heavy)),
            "weights of morph targets",
        ),
    ];
    for (strip, wanted) in cases {
        let error = read(&strip, &set(0)).expect_err(wanted);
        assert!(error.contains(wanted), "wanted {wanted:?}, got {error:?}");
    }
    let glb = Strip::new().glb();
    for length in (0..glb.len()).step_by(16).chain([glb.len() - 1]) {
        let error = read_mesh(&glb[..length], &set(0)).expect_err("cut off").to_string();
        let wanted = if length < 4 { "not a glTF file" } else { "truncated" };
        assert!(error.contains(wanted), "{length}: {error}");
    }
}

#[test]
fn flipped_bytes_never_panic() {
    let mut accepted = 0;
    for strip in [two_nodes(), draco(), meshopt()] {
        let glb = strip.glb();
        for at in 0..glb.len() {
            for flip in [0x01, 0x80] {
                let mut bytes = glb.clone();
                bytes[at] ^= flip;
                accepted += usize::from(read_mesh(&bytes, &set(0)).is_ok());
            }
        }
    }
    assert!(accepted > 1000, "{accepted} accepted: not a test of both ways");
}

#[test]
fn a_written_avatar_has_the_mesh_of_the_avatar() {
    let avatar = crate::glb::testing::tube();
    let color = uvgraft::Texture::filled(
        uvgraft::Size::square(8),
        uvgraft::Channels::Rgb,
        uvgraft::Encoding::Srgb,
        uvgraft::Depth::U8,
        &[0.5; 3],
    );
    let format = crate::glb::EmbeddedFormat::Png;
    let looks = AvatarMaterial::new(EmbeddedImage::encode(color.unwrap(), format, 90).unwrap());
    let written = write(&avatar, std::slice::from_ref(&looks), &Export::default()).unwrap();
    let mesh = read_mesh(&written.bytes, &set(0)).unwrap().mesh;
    let original = &avatar.mesh;
    assert_eq!(mesh.faces().len(), original.faces().len());
    for face in 0..mesh.faces().len() {
        assert_eq!(mesh.uv_triangle(face), original.uv_triangle(face), "{face}");
        for k in 0..3 {
            let found = mesh.positions()[mesh.faces()[face][k] as usize];
            let wanted = original.positions()[original.faces()[face][k] as usize];
            // Rounding of the joints' inverse bind matrices.
            assert!((0..3).all(|axis| (found[axis] - wanted[axis]).abs() < 1e-6), "{face}");
        }
    }
}
