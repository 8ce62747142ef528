//! Materials, separate heads, levels of detail and their VRM metadata, read back with the crate
//! `gltf`.

use glam::Vec3;
use serde_json::{Value, json as value};
use uvgraft::{Channels, Depth, Encoding, Size, Texture};
use uvgraft_avatar::rig::{Expression, Joint, Morph, Skeleton};

use super::testing::tube;
use super::tests::{Player, human, json, looks, meta, picture};
use super::*;
use crate::scene::Scene;

/// Assigns the second material to the upper half of an avatar's triangles.
fn divided(mut avatar: Avatar) -> Avatar {
    let faces = avatar.mesh.faces().len();
    avatar.materials = (0..faces).map(|face| u8::from(face >= faces / 2)).collect();
    avatar
}

fn head() -> AvatarMaterial {
    let green = [0.2, 0.8, 0.3];
    let texture =
        Texture::filled(Size::square(4), Channels::Rgb, Encoding::Srgb, Depth::U8, &green);
    let color = EmbeddedImage::encode(texture.unwrap(), EmbeddedFormat::Png, 90).unwrap();
    AvatarMaterial { name: "head".to_owned(), is_head: true, ..AvatarMaterial::new(color) }
}

fn grey(side: u32) -> EmbeddedImage {
    let texture =
        Texture::filled(Size::square(side), Channels::Rgb, Encoding::Data, Depth::U8, &[0.5; 3]);
    EmbeddedImage::encode(texture.unwrap(), EmbeddedFormat::Png, 90).unwrap()
}

#[test]
fn each_material_has_its_triangles() {
    let avatar = divided(tube());
    let exported = write(&avatar, &[looks(), head()], &Export::default()).unwrap();
    let report = exported.report;
    assert_eq!((report.triangles, report.meshes, report.materials), (96, 1, 2));
    let player = Player::new(&exported.bytes);
    let mesh = player.document.meshes().next().unwrap();
    let mut vertices = 0;
    for (number, primitive) in mesh.primitives().enumerate() {
        assert_eq!(primitive.material().index(), Some(number));
        assert_eq!(primitive.indices().unwrap().count(), 48 * 3);
        assert_eq!(primitive.morph_targets().count(), 2);
        let reader = primitive.reader(|buffer| player.buffer(buffer));
        let heights: Vec<f32> = reader.read_positions().unwrap().map(|[_, y, _]| y).collect();
        vertices += heights.len();
        // Three rings of squares each; both share the ring at 30 cm.
        let off = |y: &f32| if number == 0 { *y > 0.3001 } else { *y < 0.2999 };
        assert!(!heights.iter().any(off), "{number}");
    }
    assert_eq!(report.vertices, vertices);
    // The scene is the same as with a single material.
    let whole = write(&tube(), &looks(), &Export::default()).unwrap();
    let [whole, parts] = [whole, exported].map(|file| Scene::read(&file.bytes).unwrap());
    assert_eq!((parts.triangles(), parts.textures().len()), (whole.triangles(), 2));

    let error = write(&avatar, &looks(), &Export::default()).unwrap_err();
    assert!(matches!(error, GlbError::Material { found: 1, materials: 1 }), "{error}");
}

#[test]
fn maps_use_the_slots_of_gltf() {
    let (rough, own) = (grey(8), grey(4));
    let looks = AvatarMaterial {
        normal: Some(picture(EmbeddedFormat::Png)),
        roughness: Some(rough.clone()),
        occlusion: Some(rough),
        emissive: Some(own.clone()),
        ..looks()
    };
    assert_eq!(looks.pictures().count(), 4);
    let found = json(&write(&tube(), &looks, &Export::default()).unwrap().bytes);
    let material = &found["materials"][0];
    let pbr = &material["pbrMetallicRoughness"];
    assert_eq!(pbr["baseColorTexture"]["index"], 0);
    assert_eq!(material["normalTexture"]["index"], 1);
    // One image holds occlusion, roughness and metalness.
    assert_eq!(pbr["metallicRoughnessTexture"]["index"], 2);
    assert_eq!(material["occlusionTexture"]["index"], 2);
    assert_eq!(material["emissiveTexture"]["index"], 3);
    assert_eq!(material["emissiveFactor"], value!([1.0, 1.0, 1.0]));
    assert_eq!(found["images"].as_array().unwrap().len(), 4);
    assert_eq!(material["extensions"], Value::Null);

    let alone = AvatarMaterial { roughness: None, occlusion: Some(own), ..looks };
    let found = json(&write(&tube(), &alone, &Export::default()).unwrap().bytes);
    assert_eq!(found["materials"][0]["occlusionTexture"]["index"], 2);
    assert_eq!(
        found["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"],
        Value::Null
    );
}

#[test]
fn styles_are_extensions() {
    let with = |style| {
        let exported =
            write(&tube(), &AvatarMaterial { style, ..looks() }, &Export::default()).unwrap();
        let scene = Scene::read(&exported.bytes).unwrap();
        (json(&exported.bytes), scene.materials()[0].unlit)
    };
    let (found, is_unlit) = with(ShadingModel::Unlit);
    assert!(is_unlit);
    assert_eq!(found["extensionsUsed"], value!(["KHR_materials_unlit"]));
    assert_eq!(found["extensionsRequired"], Value::Null);
    let extensions = &found["materials"][0]["extensions"];
    assert_eq!(*extensions, value!({ "KHR_materials_unlit": {} }));
    let (found, is_unlit) = with(ShadingModel::MToon);
    assert!(!is_unlit);
    assert_eq!(found["extensionsUsed"], value!(["VRMC_materials_mtoon"]));
    assert_eq!(found["extensionsRequired"], Value::Null);
    // Its shaders fail with tangents.
    let normal = Some(picture(EmbeddedFormat::Png));
    let looks = AvatarMaterial { style: ShadingModel::MToon, normal, ..looks() };
    let with_normals = json(&write(&tube(), &looks, &Export::default()).unwrap().bytes);
    let attributes = &with_normals["meshes"][0]["primitives"][0]["attributes"];
    assert_eq!(attributes["TANGENT"], Value::Null);
    let mtoon = &found["materials"][0]["extensions"]["VRMC_materials_mtoon"];
    assert_eq!(mtoon["specVersion"], "1.0");
    assert_eq!(mtoon["shadeMultiplyTexture"]["index"], 0);
    assert_eq!(with(ShadingModel::Pbr).0["extensionsUsed"], Value::Null);
}

/// Tangents have length 1 and are perpendicular to normals, also where morphs move these.
#[test]
fn tangents_follow_morphs() {
    let looks = AvatarMaterial { normal: Some(picture(EmbeddedFormat::Png)), ..looks() };
    let mut normals = vec![[0.0; 3]; tube().mesh.positions().len()];
    // A normal that leans down, as from a finer mesh.
    normals[0] = [0.0, -0.6, 0.8];
    let export = Export { normals: Some(normals), ..Export::default() };
    let exported = write(&tube(), &looks, &export).unwrap();
    let player = Player::new(&exported.bytes);
    let primitive = player.document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|buffer| player.buffer(buffer));
    let normals: Vec<Vec3> = reader.read_normals().unwrap().map(Vec3::from).collect();
    let tangents: Vec<[f32; 4]> = reader.read_tangents().unwrap().collect();
    let tangent = |[x, y, z, _]: [f32; 4]| Vec3::new(x, y, z);
    assert!(normals[0].abs_diff_eq(Vec3::new(0.0, -0.6, 0.8), 1e-6));
    let mut most = 0.0_f32;
    for (_, normal_changes, tangent_changes) in reader.read_morph_targets() {
        let changes = normal_changes.unwrap().zip(tangent_changes.unwrap());
        for (vertex, (normal_change, change)) in changes.enumerate() {
            let before = tangent(tangents[vertex]);
            assert!(
                (before.length() - 1.0).abs() < 1e-5 && before.dot(normals[vertex]).abs() < 1e-5
            );
            let normal = (normals[vertex] + Vec3::from(normal_change)).normalize();
            let moved = before + Vec3::from(change);
            assert!((moved.length() - 1.0).abs() < 1e-4 && moved.dot(normal).abs() < 1e-4);
            most = most.max(Vec3::from(change).length());
        }
    }
    assert!(most > 0.05, "{most}");
}

#[test]
fn levels_are_outside_the_scene() {
    let avatar = tube();
    let mut coarse = avatar.clone();
    // Any other mesh will do: this one is wider.
    coarse.mesh = coarse
        .mesh
        .clone()
        .with_positions(coarse.mesh.positions().iter().map(|&[x, y, z]| [1.1 * x, y, z]).collect())
        .unwrap();
    let level = || CoarserLevel { avatar: coarse.clone(), normals: None };
    let export = Export { levels: vec![level(), level()], ..Export::default() };
    let exported = write(&avatar, &looks(), &export).unwrap();
    assert_eq!((exported.report.triangles, exported.report.meshes), (96, 1));
    let found = json(&exported.bytes);
    assert_eq!(found["extensionsUsed"], value!(["MSFT_lod"]));
    assert_eq!(found["scenes"][0]["nodes"], value!([0, 6]));
    let node = &found["nodes"][6];
    assert_eq!(node["extensions"]["MSFT_lod"]["ids"], value!([7, 8]));
    assert_eq!(node["extras"]["MSFT_screencoverage"], value!([0.25, 0.125, 0.0]));
    assert_eq!((&found["nodes"][7]["mesh"], &found["nodes"][7]["skin"]), (&value!(1), &value!(0)));
    let names: Vec<&str> =
        (6..9).map(|node| found["nodes"][node]["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["avatar", "avatar level 1", "avatar level 2"]);
    assert_eq!(found["meshes"][2]["extras"]["targetNames"], value!(["bump", "thick"]));
    assert_eq!(found["images"].as_array().unwrap().len(), 1);
    // Readers without level support show the finest level only.
    assert_eq!(Scene::read(&exported.bytes).unwrap().triangles(), 96);

    let mut other = level();
    other.avatar.morphs.pop();
    other.avatar.expressions.clear();
    let export = Export { levels: vec![other], ..Export::default() };
    let error = write(&avatar, &looks(), &export).unwrap_err().to_string();
    assert!(error.contains("morphs of a level"), "{error}");
    let export = Export { vrm: Some(meta()), levels: vec![level()], ..Export::default() };
    assert!(matches!(write(&human(), &looks(), &export), Err(GlbError::VrmLevels)));
}

#[test]
fn a_separate_head_is_hidden_in_first_person() {
    let mut avatar = divided(human());
    // This morph moves only the last ring, which is the head's; the other one moves everything.
    avatar.morphs[0] = Morph { name: "brow".to_owned(), offsets: vec![(55, [0.0, 0.01, 0.0])] };
    let export = Export { vrm: Some(meta()), ..Export::default() };
    let exported = write(&avatar, &[looks(), head()], &export).unwrap();
    assert_eq!((exported.report.meshes, exported.report.materials), (2, 2));
    let found = json(&exported.bytes);
    let vrm = &found["extensions"]["VRMC_vrm"];
    let annotations = value!([
        { "node": 17, "type": "auto" },
        { "node": 18, "type": "thirdPersonOnly" }
    ]);
    assert_eq!(vrm["firstPerson"]["meshAnnotations"], annotations);
    assert_eq!(found["scenes"][0]["nodes"], value!([0, 17, 18]));
    // Expressions bind the meshes that their morphs move.
    let binds = |name: &str, list: &str| {
        let binds = vrm["expressions"][list][name]["morphTargetBinds"].as_array().unwrap().clone();
        binds.iter().map(|bind| bind["node"].as_u64().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(binds("happy", "preset"), [18]);
    assert_eq!(binds("huge", "custom"), [17, 18]);
}

/// The human without eye joints, with morphs that move the eyes.
fn without_eyes() -> Avatar {
    let mut avatar = human();
    let joints = avatar.skeleton.joints().to_vec().into_iter();
    let joints = joints.map(|joint| Joint {
        human: joint.human.filter(|bone| !bone.name().ends_with("Eye")),
        ..joint
    });
    avatar.skeleton = Skeleton::new(joints.collect()).unwrap();
    for (index, name) in ["lookUp", "lookDown", "lookLeft", "lookRight"].into_iter().enumerate() {
        let offsets = vec![(48, [0.001 * (index as f32 + 1.0), 0.0, 0.0]), (52, [0.001; 3])];
        avatar.morphs.push(Morph { name: name.to_owned(), offsets });
        let morphs = vec![(index + 2, 1.0)];
        avatar.expressions.push(Expression { name: name.to_owned(), preset: None, morphs });
    }
    avatar
}

#[test]
fn gaze_without_eye_joints_uses_expressions() {
    let export = Export { vrm: Some(meta()), ..Export::default() };
    let vrm = |avatar: &Avatar| {
        json(&write(avatar, &looks(), &export).unwrap().bytes)["extensions"]["VRMC_vrm"].clone()
    };
    let avatar = without_eyes();
    let found = vrm(&avatar);
    let look_at = &found["lookAt"];
    assert_eq!(look_at["type"], "expression");
    assert_eq!(
        look_at["rangeMapVerticalUp"],
        value!({ "inputMaxValue": 25.0, "outputScale": 1.0 })
    );
    // The tube's upper end is at 0.6 m, the head joint at 1.5 m.
    assert!((look_at["offsetFromHeadBone"][1].as_f64().unwrap() + 0.9).abs() < 1e-6);
    assert!(found["expressions"]["preset"]["lookLeft"]["morphTargetBinds"][0]["node"].is_u64());
    let mut one_missing = avatar;
    one_missing.expressions.pop();
    assert_eq!(vrm(&one_missing)["lookAt"], Value::Null);
}

#[test]
fn a_thumbnail_is_an_image_without_a_material() {
    let export = Export {
        vrm: Some(meta()),
        thumbnail: Some(picture(EmbeddedFormat::Jpeg)),
        ..Export::default()
    };
    let found = json(&write(&human(), &looks(), &export).unwrap().bytes);
    assert_eq!(found["extensions"]["VRMC_vrm"]["meta"]["thumbnailImage"], 1);
    assert_eq!(found["images"][1]["name"], "thumbnail");
    assert_eq!(found["textures"].as_array().unwrap().len(), 1);
    let export = Export { thumbnail: Some(picture(EmbeddedFormat::WebP)), ..export };
    let error = write(&human(), &looks(), &export).unwrap_err().to_string();
    assert!(error.contains("a square PNG or JPEG"), "{error}");
}
