use uvgraft::{Channels, Depth, Encoding};

use super::*;
use crate::glb::testing::tube;

fn tiny(triangles: usize) -> Preset {
    Preset { triangles, ..QUEST }
}

#[test]
fn presets_have_names() {
    assert_eq!(Preset::named("visionos"), Some(&VISIONOS));
    assert_eq!(Preset::named("Quest"), None);
    for preset in Preset::ALL {
        // A preset's triangle budget must be one of the platform's limits, if it has such limits.
        let limits =
            preset.limits.quantities.iter().find(|(quantity, _)| *quantity == Quantity::Triangles);
        if let Some((_, limits)) = limits {
            assert!(limits.contains(&(preset.triangles as f64)), "{}", preset.name);
        }
    }
}

#[test]
fn textures_are_made_smaller_and_never_larger() {
    for (found, wanted) in [
        (Size::new(2048, 1024), Size::new(1024, 512)),
        (Size::square(512), Size::square(512)),
        (Size::new(4096, 1), Size::new(1024, 1)),
    ] {
        let texture =
            Texture::filled(found, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.2, 0.4, 0.6]);
        let picture = QUEST.picture(texture.unwrap()).unwrap();
        assert_eq!((picture.size(), picture.format()), (wanted, EmbeddedFormat::Png));
    }
}

#[test]
fn half_the_size_is_the_mean_of_four_texels() {
    let values = (0..16 * 16 * 3).map(|k: usize| (k * k * 7 % 251) as u8).collect();
    let size = Size::square(16);
    let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, uvgraft::Texels::U8(values));
    let texture = texture.unwrap();
    let small = Preset { texture_side: 8, ..QUEST };
    let picture = small.picture(texture.clone()).unwrap();
    let found = uvgraft_image::decode(picture.bytes()).unwrap().texture;
    for (x, y) in [(0, 0), (3, 5), (7, 7)] {
        let level = |dx, dy| texture.get(2 * x + dx, 2 * y + dy, 1);
        let wanted = (level(0, 0) + level(1, 0) + level(0, 1) + level(1, 1)) / 4.0;
        // Up to rounding to 8 bits.
        assert!((found.get(x, y, 1) - wanted).abs() < 0.51 / 255.0, "{x} {y}");
    }
}

#[test]
fn avatars_within_the_budget_are_unchanged() {
    let fitted = tiny(96).fit(tube()).unwrap();
    assert_eq!((fitted.before, fitted.hidden, fitted.after), (96, 0, 96));
    assert_eq!(fitted.avatar.mesh, tube().mesh);
}

#[cfg(feature = "simplify")]
#[test]
fn avatars_over_the_budget_are_simplified() {
    let fitted = tiny(60).fit(tube()).unwrap();
    assert_eq!((fitted.before, fitted.hidden, fitted.wanted), (96, 0, 60));
    assert!(fitted.after <= 63 && fitted.avatar.mesh.faces().len() == fitted.after);
}

#[cfg(not(feature = "simplify"))]
#[test]
fn without_the_feature_an_exceeded_budget_is_an_error() {
    let error = tiny(60).fit(tube()).unwrap_err().to_string();
    assert!(error.contains("at most 60 triangles, got 96; simplifying"), "{error}");
}

/// The example figure fits the mobile budget: the backs of its eyes are removed first, no holes
/// open, the number of UV islands is unchanged, and the file reaches the platform's rank.
#[cfg(feature = "simplify")]
#[test]
fn the_figure_fits_a_headset() {
    use super::testing::borders;
    use crate::glb::{AvatarMaterial, Export, write};

    let figure = uvgraft_figure::Figure::new().avatar();
    let before = borders(&figure.mesh);
    let islands = uvgraft::islands::Islands::new(&figure.mesh).count();
    let fitted = QUEST.fit(figure.clone()).unwrap();
    assert!(fitted.hidden > 0 && fitted.hidden < 340, "{}", fitted.hidden);
    assert!(fitted.after <= 10_000 && fitted.after > 9_900, "{}", fitted.after);
    let after = borders(&fitted.avatar.mesh);
    assert_eq!(after.loops, before.loops);
    // Boundary corners are cut, by this at most; the eyes' new boundaries are shorter too.
    assert!((after.length / before.length - 1.0).abs() < 0.03, "{before:?} {after:?}");
    assert_eq!(uvgraft::islands::Islands::new(&fitted.avatar.mesh).count(), islands);
    fitted.avatar.check().unwrap();
    assert_eq!(fitted.avatar.morphs.len(), figure.morphs.len());

    let texture =
        Texture::filled(Size::square(2048), Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]);
    let looks = AvatarMaterial::new(QUEST.picture(texture.unwrap()).unwrap());
    let export = Export { normals: fitted.normals, ..Export::default() };
    let report = write(&fitted.avatar, &looks, &export).unwrap().report;
    let measured = Measurements::new(&report, &looks);
    assert_eq!(QUEST.limits.rank(&measured), Some("Good"));
    // 1024 · 1024 bytes plus a third for mip levels.
    assert_eq!(measured.texture_memory, 1_398_101);
    assert_eq!(measured.texture_memory_raw, 5_592_405);
}

/// SMPL-X's mesh with synthetic weights: each eye follows its own joint, the rest is weighted by
/// height.
#[cfg(feature = "simplify")]
fn smplx() -> Option<Avatar> {
    use uvgraft_avatar::rig::{HumanBone, Joint, Skeleton, Skin};

    let Some(folder) = std::env::var_os("UVGRAFT_DATA") else {
        eprintln!("skipped: UVGRAFT_DATA is not set, so there are no real meshes to test with");
        return None;
    };
    let mesh = uvgraft_io::obj::read(std::path::Path::new(&folder).join("smplx_addon.obj"));
    let mesh = mesh.expect("a sound mesh");
    let joint = |name: &str, parent, position, human| Joint {
        name: name.to_owned(),
        parent,
        position,
        human,
    };
    let eye = |side: f32| [0.0325 * side, 0.3245, 0.0637];
    let joints = vec![
        joint("hips", None, [0.0, -0.4, 0.0], Some(HumanBone::Hips)),
        joint("head", Some(0), [0.0, 0.2, 0.0], Some(HumanBone::Head)),
        joint("left", Some(1), eye(1.0), Some(HumanBone::LeftEye)),
        joint("right", Some(1), eye(-1.0), Some(HumanBone::RightEye)),
    ];
    // The eyeballs are the last 1092 of 10,475 vertices, the left one first.
    let weights = mesh.positions().iter().enumerate().map(|(vertex, &[_, y, _])| match vertex {
        0..9383 => {
            let share = (0.5 + 5.0 * (y - 0.1)).clamp(0.0, 1.0);
            vec![(0, 1.0 - share), (1, share)]
        }
        9383..9929 => vec![(2, 1.0)],
        _ => vec![(3, 1.0)],
    });
    let skin = Skin::new(weights, 4).unwrap();
    let (skeleton, clips) = (Skeleton::new(joints).unwrap(), Vec::new());
    let (morphs, expressions, materials) = (Vec::new(), Vec::new(), Vec::new());
    Some(Avatar { mesh, materials, skeleton, skin, morphs, expressions, clips })
}

#[cfg(feature = "simplify")]
#[test]
fn a_real_body_stays_closed() {
    use super::testing::borders;

    let Some(avatar) = smplx() else { return };
    let before = borders(&avatar.mesh);
    let is_hidden = hidden(&avatar);
    let count = |vertices: std::ops::Range<u32>| {
        let faces = avatar.mesh.faces().iter().zip(&is_hidden);
        faces.filter(|(face, is_hidden)| **is_hidden && vertices.contains(&face[0])).count()
    };
    // More than half of each eyeball's 1088 triangles, and none of the body's.
    let counts = [count(9383..9929), count(9929..10_475)];
    assert!(counts.iter().all(|count| (545..900).contains(count)), "{counts:?}");
    assert_eq!(count(0..9383), 0);

    let fitted = QUEST.fit(avatar.clone()).unwrap();
    assert_eq!(fitted.hidden, counts.iter().sum::<usize>());
    assert!(fitted.after <= 10_000 && fitted.after > 9_900, "{}", fitted.after);
    // Boundary loops: the mouth, and afterwards the backs of both eyes.
    assert_eq!((before.loops, borders(&fitted.avatar.mesh).loops), (1, 3));
    let islands = |avatar: &Avatar| uvgraft::islands::Islands::new(&avatar.mesh).count();
    assert_eq!(islands(&fitted.avatar), islands(&avatar));
    // Outlines of UV islands keep their shape: their area is almost unchanged.
    let area = |avatar: &Avatar| {
        let area = |face| {
            let [a, b, c] = avatar.mesh.uv_triangle(face);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
        };
        (0..avatar.mesh.faces().len()).map(area).sum::<f32>()
    };
    let body = simplify(avatar.clone(), 12_000).unwrap().avatar;
    assert_eq!(borders(&body.mesh).loops, 1);
    let ratio = area(&body) / area(&avatar);
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}
