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
        // What a preset allows must have a rank where the platform ranks triangles.
        let limits = preset.limits.figures.iter().find(|(figure, _)| *figure == Figure::Triangles);
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
        assert_eq!((picture.size(), picture.format()), (wanted, PictureFormat::Png));
    }
}

#[test]
fn what_fits_stays() {
    let fitted = tiny(96).fit(tube()).unwrap();
    assert_eq!((fitted.before, fitted.hidden, fitted.after), (96, 0, 96));
    assert_eq!(fitted.avatar.mesh, tube().mesh);
}

#[cfg(feature = "simplify")]
#[test]
fn what_does_not_fit_is_simplified() {
    let fitted = tiny(60).fit(tube()).unwrap();
    assert_eq!((fitted.before, fitted.hidden, fitted.wanted), (96, 0, 60));
    assert!(fitted.after <= 63 && fitted.avatar.mesh.faces().len() == fitted.after);
}

#[cfg(not(feature = "simplify"))]
#[test]
fn without_the_feature_a_budget_that_is_exceeded_is_told() {
    let error = tiny(60).fit(tube()).unwrap_err().to_string();
    assert!(error.contains("96 triangles, more than the 60 of `quest`"), "{error}");
}
