//! Emissive, normal and occlusion maps, and highlights, against values computed by hand.

use uvgraft::color::linear_from_srgb;
use uvgraft::{Channels, Encoding, Size, Texels};
use uvgraft_gltf::scene::{ScaledTexture, SpecularGloss, TextureUse, Wrap};

use super::tests::{ahead, square, texel};
use super::*;

const FIRST: TextureUse =
    TextureUse { index: 0, wrap: [Wrap::Repeat; 2], nearest: false, coordinates: 0 };

/// A texture of one colour, with the encoding that PNG files have.
fn one(color: [u8; 3]) -> Texture {
    let texels = Texels::U8(color.repeat(4));
    Texture::new(Size::square(2), Channels::Rgb, Encoding::Srgb, texels).unwrap()
}

/// Linear colour at the centre of a picture of the square with a material.
fn seen(material: &Material, textures: &[Texture], piece: &PosedPrimitive) -> [f32; 3] {
    let renderer = Renderer::new(std::slice::from_ref(material), textures);
    let options =
        RenderOptions { background: Background::Plain([0; 3]), ..RenderOptions::default() };
    let piece = std::slice::from_ref(piece);
    let picture = renderer.render(piece, &ahead(), &options, Size::square(9));
    let found = texel(&picture, 4, 4);
    [0, 1, 2].map(|k| linear_from_srgb(f32::from(found[k]) / 255.0))
}

/// The square with an upright texture: U to the right, V down.
fn upright() -> PosedPrimitive {
    let uv = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    PosedPrimitive { uv: uv.into(), ..square(0.0, 0) }
}

fn grey() -> Material {
    Material { color: [0.4, 0.4, 0.4, 1.0], ..Material::default() }
}

#[test]
fn emission_adds_light() {
    let plain = seen(&grey(), &[], &upright());
    let texture = one([188, 0, 255]);
    let mut material = Material { emissive: [0.3, 0.3, 0.1], ..grey() };
    let bare = seen(&material, &[], &upright());
    material.emissive_texture = Some(FIRST);
    let mapped = seen(&material, &[texture], &upright());
    let light = linear_from_srgb(188.0 / 255.0);
    // The picture has 8 bits; one step is at most 0.009 in linear light.
    let near = |a: f32, b: f32| (a - b).abs() < 0.01;
    for (k, (whole, part)) in [(0.3, 0.3 * light), (0.3, 0.0), (0.1, 0.1)].into_iter().enumerate() {
        assert!(near(bare[k] - plain[k], whole), "{bare:?} {plain:?}");
        assert!(near(mapped[k] - plain[k], part), "{mapped:?} {plain:?}");
    }
    // Unlit, only the texture's own colour is visible.
    material.unlit = true;
    assert!(near(seen(&material, &[one([9; 3])], &upright())[0], 0.4));
}

#[test]
fn a_normal_map_turns_the_surface() {
    // Tilted by 45° towards U, against V, and against V with the scale negated.
    let tilted = |x: f32, y: f32| {
        let [x, y] = [x, y].map(|value| (127.5 + 127.5 * value).round() as u8);
        one([x, y, (127.5 + 127.5 * std::f32::consts::FRAC_1_SQRT_2) as u8])
    };
    let side = std::f32::consts::FRAC_1_SQRT_2;
    let map = |scale| Material { normal: Some(ScaledTexture { texture: FIRST, scale }), ..grey() };
    let leaning = |normal: [f32; 3]| PosedPrimitive { normals: vec![normal; 4], ..upright() };
    for (texture, scale, normal) in [
        (tilted(side, 0.0), 1.0, [side, 0.0, side]),
        (tilted(0.0, side), 1.0, [0.0, side, side]),
        (tilted(0.0, side), -1.0, [0.0, -side, side]),
        (tilted(0.0, 0.0), 1.0, [0.0, 0.0, 1.0]),
    ] {
        let found = seen(&map(scale), &[texture], &upright());
        let wanted = seen(&grey(), &[], &leaning(normal));
        assert!((0..3).all(|k| (found[k] - wanted[k]).abs() < 0.02), "{found:?} {wanted:?}");
    }
    // Mirrored texture coordinates mirror the map's direction.
    let mut mirrored = upright();
    mirrored.uv = vec![[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]].into();
    let found = seen(&map(1.0), &[tilted(side, 0.0)], &mirrored);
    let wanted = seen(&grey(), &[], &leaning([-side, 0.0, side]));
    assert!((0..3).all(|k| (found[k] - wanted[k]).abs() < 0.02), "{found:?} {wanted:?}");
    // Without UV area, and where the map's value is zero, the normal is unchanged.
    let flat = seen(&grey(), &[], &upright());
    assert_eq!(seen(&map(1.0), &[tilted(side, 0.0)], &square(0.0, 0)), flat);
}

#[test]
fn occlusion_darkens_the_sky_light() {
    let map =
        |scale| Material { occlusion: Some(ScaledTexture { texture: FIRST, scale }), ..grey() };
    let plain = seen(&grey(), &[], &upright());
    let of = |value: u8, scale: f32| seen(&map(scale), &[one([value, 0, 0])], &upright())[1];
    assert_eq!(of(255, 1.0), plain[1]);
    assert_eq!(of(0, 0.0), plain[1]);
    let (dark, half, weak) = (of(0, 1.0), of(128, 1.0), of(0, 0.5));
    assert!(dark < 0.7 * plain[1] && dark > 0.1 * plain[1], "{dark} {plain:?}");
    // Values are data, not colours: 128 is half of the effect, and so is a strength of one half.
    assert!(dark < half && half < plain[1] && (half - weak).abs() < 0.01, "{half} {weak}");
}

#[test]
fn specular_light_is_missing_from_diffuse() {
    let gloss = |specular, glossiness| Material {
        gloss: Some(SpecularGloss { specular, glossiness, texture: None }),
        ..grey()
    };
    let dull = seen(&gloss([0.0; 3], 0.0), &[], &upright());
    // Half of the red light is mirrored, so every channel keeps at most half of its diffuse light.
    let red = seen(&gloss([0.5, 0.0, 0.0], 0.9), &[], &upright());
    assert!((red[1] / dull[1] - 0.5).abs() < 0.03, "{red:?} {dull:?}");
    assert!(red[0] > 1.2 * red[1], "{red:?}");
    // Where the surface mirrors the key light, a glossy one is bright.
    let half = glam::vec3(-0.55, 0.62, 0.75).normalize_or_zero();
    let half = (half + glam::vec3(0.0, 0.0, 1.0)).normalize_or_zero();
    let facing = PosedPrimitive { normals: vec![half.into(); 4], ..upright() };
    let bright = |glossiness| seen(&gloss([0.3; 3], glossiness), &[], &facing)[1];
    assert!(bright(0.8) > 1.5 * bright(0.1), "{} {}", bright(0.8), bright(0.1));
}
