//! Avatar materials in Chromium: three.js and three-vrm draw each style, with and without a normal
//! map and a separate head material, without any error.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use serde_json::{Value, json};
use uvgraft::{Channels, Depth, Encoding, Size, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_figure::{Figure, paint_body};
use uvgraft_gltf::glb::{
    AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export, Permissions, ShadingModel, VrmMeta,
    write,
};
use uvgraft_tests::browser::Browser;

fn flat() -> EmbeddedImage {
    let up = [0.5, 0.5, 1.0];
    let texture =
        Texture::filled(Size::square(16), Channels::Rgb, Encoding::Data, Depth::U8, &up).unwrap();
    EmbeddedImage::encode(texture, EmbeddedFormat::Png, 90).unwrap()
}

/// The avatar with a second material for its upper triangles.
fn divided(avatar: &Avatar) -> Avatar {
    let height = |face: &[u32; 3]| avatar.mesh.positions()[face[0] as usize][1];
    let materials = avatar.mesh.faces().iter().map(|face| u8::from(height(face) > 1.5));
    Avatar { materials: materials.collect(), ..avatar.clone() }
}

/// The report of three.js on a file, and a picture of the head.
fn shoot(browser: &Browser, bytes: &[u8], name: &str) -> (Value, Texture) {
    let folder = tempfile::tempdir().unwrap();
    let (file, picture) = (folder.path().join(name), folder.path().join("picture.png"));
    std::fs::write(&file, bytes).unwrap();
    let camera =
        json!({ "eye": [0.2, 1.65, 0.9], "target": [0, 1.6, 0], "up": [0, 1, 0], "fovY": 30 });
    let shot = json!({
        "output": picture, "width": 200, "height": 200, "camera": camera, "background": "#ff00ff"
    });
    let found = browser.shoot(&file, &json!([shot]));
    (found, uvgraft_image::read(&picture).unwrap().texture)
}

#[test]
fn all_styles_are_drawn() {
    let Some(browser) = Browser::find() else { return };
    let figure = Figure::new();
    let (avatar, color) = (figure.avatar(), paint_body(&figure, Size::square(512)));
    let color = EmbeddedImage::encode(color, EmbeddedFormat::Png, 90).unwrap();
    let meta = VrmMeta::new("figure", vec!["uvgraft".to_owned()], Permissions::EVERYONE);
    for style in [ShadingModel::Pbr, ShadingModel::MToon, ShadingModel::Unlit] {
        for (normal, is_divided) in [(None, false), (Some(flat()), true)] {
            let looks = AvatarMaterial { style, normal, ..AvatarMaterial::new(color.clone()) };
            let head = AvatarMaterial { name: "head".to_owned(), is_head: true, ..looks.clone() };
            let export = Export { vrm: Some(meta.clone()), ..Export::default() };
            let bytes = if is_divided {
                write(&divided(&avatar), &[looks, head][..], &export).unwrap().bytes
            } else {
                write(&avatar, &looks, &export).unwrap().bytes
            };
            let (found, picture) = shoot(&browser, &bytes, "figure.vrm");
            assert_eq!(found["errors"], json!([]), "{style:?} {is_divided}");
            let materials = found["materials"].as_array().unwrap().len();
            assert_eq!(materials, 1 + usize::from(is_divided), "{style:?}");
            // The face shows skin, not the background.
            let [red, green, blue] = [0, 1, 2].map(|channel| picture.get(100, 95, channel));
            assert!(
                red > green && green > 0.2 && red > blue + 0.05,
                "{style:?}: {red} {green} {blue}"
            );
        }
    }
}
