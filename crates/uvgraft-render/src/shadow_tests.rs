//! Shadows of surfaces that are partly transparent.

use uvgraft::{Channels, Encoding, Size, Texels};
use uvgraft_gltf::scene::{AlphaMode, TextureUse, Wrap};

use super::tests::{ahead, texel};
use super::*;

/// A rectangle at a depth, with an upright texture.
fn rectangle(
    [left, right]: [f32; 2],
    [low, high]: [f32; 2],
    z: f32,
    material: usize,
) -> PosedPrimitive {
    PosedPrimitive {
        positions: [[left, low], [right, low], [right, high], [left, high]]
            .map(|[x, y]| [x, y, z])
            .to_vec(),
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uv: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].into(),
        more_uv: Vec::new(),
        colors: None,
        triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
        material,
    }
}

/// Grey levels of a wall where a rectangle with a texture casts a shadow in the light from the upper
/// left: below its left half, whose alpha is 204 of 255, and below its right half, whose alpha is 51.
fn shadows(alpha: AlphaMode, factor: f32) -> [u8; 2] {
    let texels = [[255, 255, 255, 204], [255, 255, 255, 51]].concat();
    let texture =
        Texture::new(Size::new(2, 1), Channels::Rgba, Encoding::Srgb, Texels::U8(texels)).unwrap();
    let place = TextureUse { index: 0, wrap: [Wrap::Clamp; 2], nearest: true, coordinates: 0 };
    let pane = Material {
        color: [1.0, 1.0, 1.0, factor],
        texture: Some(place),
        alpha,
        ..Material::default()
    };
    let renderer = Renderer::new(&[Material::default(), pane], &[texture]);
    // At a depth of 0.6 light moves by 0.44 to the right and 0.5 downwards on its way to the wall.
    let drawn =
        [rectangle([-1.0, 1.0], [0.0, 2.0], 0.0, 0), rectangle([-0.4, 0.0], [1.1, 1.5], 0.6, 1)];
    let options =
        RenderOptions { background: Background::Plain([0; 3]), ..RenderOptions::default() };
    let picture = renderer.render(&drawn, &ahead(), &options, Size::square(200));
    // A hundred pixels are a unit of the wall.
    [14, 34].map(|x| texel(&picture, 100 + x, 120)[0])
}

#[test]
fn transparent_texels_cast_no_shadow() {
    let [dark, same] = shadows(AlphaMode::Opaque, 1.0);
    assert_eq!(dark, same);
    let [lit, _] = shadows(AlphaMode::Blend, 0.4);
    assert!(lit > dark + 30, "{lit} {dark}");
    for (alpha, factor, wanted) in [
        (AlphaMode::Mask(0.5), 1.0, [dark, lit]),
        (AlphaMode::Mask(0.1), 1.0, [dark, dark]),
        (AlphaMode::Mask(0.9), 1.0, [lit, lit]),
        (AlphaMode::Mask(0.5), 0.5, [lit, lit]),
        (AlphaMode::Blend, 1.0, [dark, lit]),
        (AlphaMode::Blend, 0.6, [lit, lit]),
    ] {
        let found = shadows(alpha, factor);
        // Ambient occlusion differs by what is in the picture.
        let near = (0..2).all(|k| found[k].abs_diff(wanted[k]) <= 6);
        assert!(near, "{alpha:?} times {factor}: {found:?} {wanted:?}");
    }
}
