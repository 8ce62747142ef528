//! Avatars as loaded by Blender and Godot: everything we wrote is present.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use uvgraft::{Channels, Depth, Encoding, Size, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyModel, Shape};
use uvgraft_avatar::mouth::Mouth;
use uvgraft_figure::Figure;
use uvgraft_gltf::glb::{
    self, AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export, Permissions, VrmMeta,
};
use uvgraft_tests::clients::{Client, Loaded};
use uvgraft_tests::made_up::{self, Entanglement};

/// The figure and, with real data, SMPL-X with its expressions; both with a mouth.
fn avatars() -> Vec<(&'static str, Avatar)> {
    let with_mouth = |avatar: Avatar| Mouth::fit(&avatar).unwrap().attach(avatar).unwrap();
    let mut avatars = vec![("figure", with_mouth(Figure::new().avatar().standing().unwrap()))];
    if let Some(made) = made_up::smplx(&Entanglement::default()) {
        let model = BodyModel::from_arrays(&made.arrays).unwrap();
        let shaped = model.shaped(&Shape::default()).unwrap();
        let mut avatar = shaped.avatar(made.mesh).unwrap();
        shaped.add_expressions(&mut avatar).unwrap();
        avatars.push(("SMPL-X", with_mouth(avatar.standing().unwrap())));
    }
    avatars
}

fn load(client: Client, avatar: &Avatar, is_vrm: bool) -> Loaded {
    let skin = [0.7, 0.5, 0.4];
    let color =
        Texture::filled(Size::square(64), Channels::Rgb, Encoding::Srgb, Depth::U8, &skin).unwrap();
    let looks = AvatarMaterial::new(EmbeddedImage::encode(color, EmbeddedFormat::Png, 90).unwrap());
    let meta = VrmMeta::new("somebody", vec!["somebody".to_owned()], Permissions::ONLY_AUTHOR);
    let export = Export { vrm: is_vrm.then_some(meta), ..Export::default() };
    let written = glb::write(avatar, &looks, &export).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(if is_vrm { "written.vrm" } else { "written.glb" });
    std::fs::write(&file, written.bytes).unwrap();
    let project = folder.path().join("project");
    std::fs::create_dir(&project).unwrap();
    client.load(&file, &project)
}

fn all_is_there(client: Client) {
    let Some(client) = client.find() else { return };
    for (name, avatar) in avatars() {
        for is_vrm in [false, true] {
            let found = load(client, &avatar, is_vrm);
            let case = format!("{client:?} {name} VRM {is_vrm}: {found:?}");
            assert_eq!(found.bones, avatar.skeleton.joints().len(), "{case}");
            let mut morphs: Vec<&str> = avatar.morphs.iter().map(|morph| &*morph.name).collect();
            morphs.sort_unstable();
            assert_eq!(found.morphs, morphs, "{case}");
            assert_eq!(found.animations.len(), avatar.clips.len(), "{case}");
            assert_eq!(found.materials, 1, "{case}");
            // Importers may drop triangles without area.
            let lost = avatar.mesh.faces().len() - found.triangles.min(avatar.mesh.faces().len());
            assert!(lost * 500 < found.triangles, "{case}");
            if let Some(lowest_m) = found.lowest_m {
                assert!(lowest_m.abs() < 0.001, "{case}");
            }
        }
    }
}

#[test]
fn blender_loads_everything() {
    all_is_there(Client::Blender);
}

#[test]
fn godot_loads_everything() {
    all_is_there(Client::Godot);
}
