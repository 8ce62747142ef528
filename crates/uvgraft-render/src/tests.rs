//! The renderer as a whole.

use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_gltf::scene::{AlphaMode, PoseRequest, TextureUse, Wrap};

use super::*;

/// The figure's face, slightly from the side.
const FACE: View =
    View { azimuth: 18.0, elevation: 4.0, target: [0.0, 1.615, 0.01], height: 0.36, floor: false };

fn skin(_: &MeshPart) -> Shading {
    Shading::Skin
}

#[test]
fn shows_a_face_where_the_mannequin_has_none() {
    let figure = Figure::new();
    let (width, height) = (60_u32, 80_u32);
    let size = Size::new(width, height);
    let head = paint_head(&figure, Size::square(512));
    let body = paint_body(&figure, Size::square(512));
    let painted = render(&figure.head, &head, skin, &FACE, size);
    let plain = render(&figure.body, &body, skin, &FACE, size);
    assert_eq!(painted, render(&figure.head, &head, skin, &FACE, size));
    let differing = |a: &Texture, b: &Texture| {
        (0..size.texels() as u32)
            .filter(|k| {
                let (x, y) = (k % width, k / width);
                (0..3).any(|c| (a.get(x, y, c) - b.get(x, y, c)).abs() > 0.05)
            })
            .count()
    };
    assert!(differing(&painted, &plain) > size.texels() / 8);
    let away = View { target: [9.0, 9.0, 9.0], ..FACE };
    let empty = render(&figure.head, &head, skin, &away, size);
    assert!(differing(&plain, &empty) > size.texels() / 3);
}

/// The strip of the scene tests.
fn strip() -> Scene {
    Scene::read(&uvgraft_tests::strip::Strip::new().glb()).unwrap()
}

/// Straight ahead: at the distance of the strip, heights 0 to 2 fill the picture.
pub(super) fn ahead() -> Perspective {
    let (eye, target, up) = ([0.0, 1.0, 4.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
    let fov_y = 2.0 * 0.25_f32.atan().to_degrees();
    Perspective { eye, target, up, fov_y, near: 0.1, far: 100.0 }
}

fn unlit(background: Background) -> RenderOptions {
    RenderOptions { lit: false, background, ..RenderOptions::default() }
}

pub(super) fn texel(picture: &Texture, x: u32, y: u32) -> Vec<u8> {
    let count = picture.channels().count();
    (0..count).map(|k| (picture.get(x, y, k) * 255.0).round() as u8).collect()
}

#[test]
fn without_light_colours_are_the_textures_own() {
    let scene = strip();
    let drawn = scene.pose(&PoseRequest::default()).unwrap();
    let options = unlit(Background::Plain([9, 8, 7]));
    let picture = Renderer::for_scene(&scene).render(&drawn, &ahead(), &options, Size::square(40));
    // The strip is half as wide as the picture and equally high.
    for (at, wanted) in [
        ((11, 1), [255, 0, 0]),
        ((28, 18), [0, 255, 0]),
        ((11, 21), [0, 0, 255]),
        ((28, 38), [255, 255, 255]),
        ((9, 20), [9, 8, 7]),
        ((30, 20), [9, 8, 7]),
    ] {
        assert_eq!(texel(&picture, at.0, at.1), wanted, "{at:?}");
    }
}

#[test]
fn a_transparent_picture_has_alpha_where_something_is_drawn() {
    let scene = strip();
    let drawn = scene.pose(&PoseRequest::default()).unwrap();
    // Shifted by half a pixel, so that an edge runs through pixel centres.
    let mut camera = ahead();
    camera.eye[0] += 0.025;
    camera.target[0] += 0.025;
    let options = unlit(Background::Transparent);
    let picture = Renderer::for_scene(&scene).render(&drawn, &camera, &options, Size::square(40));
    assert_eq!(picture.channels(), uvgraft::Channels::Rgba);
    assert_eq!(texel(&picture, 20, 5)[3], 255);
    assert_eq!(texel(&picture, 3, 5), [0, 0, 0, 0]);
    // Half covered, without darkening by the empty half.
    assert_eq!(texel(&picture, 9, 5), [255, 0, 0, 128]);
}

#[test]
fn a_surface_that_leans_back_is_drawn_in_perspective() {
    // A ramp from (±1, -1, 1) to (±1, 1, -3) under a texture whose lower half is black, seen from
    // (0, 0, 3). Its centre, at height 0 and distance 4, appears at height 0. With affine
    // interpolation the edge between black and white would lie between heights -1/2 and 1/6.
    let uv: Vec<[f32; 2]> = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let drawn = PosedPrimitive {
        positions: vec![[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -3.0], [-1.0, 1.0, -3.0]],
        normals: vec![[0.0, 0.9, 0.45]; 4],
        uv: uv.into(),
        more_uv: Vec::new(),
        colors: None,
        triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
        material: 0,
    };
    let values = [[255_u8; 8].to_vec(), [0; 8].to_vec()].concat();
    let texture = Texture::new(
        Size::new(8, 2),
        uvgraft::Channels::Grey,
        uvgraft::Encoding::Srgb,
        uvgraft::Texels::U8(values),
    );
    let texture_use =
        TextureUse { index: 0, wrap: [Wrap::Clamp; 2], nearest: true, coordinates: 0 };
    let material = Material { texture: Some(texture_use), ..Material::default() };
    let camera = Perspective {
        eye: [0.0, 0.0, 3.0],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        fov_y: 90.0,
        near: 0.1,
        far: 10.0,
    };
    let renderer = Renderer::new(&[material], &[texture.unwrap()]);
    let picture =
        renderer.render(&[drawn], &camera, &unlit(Background::Plain([99; 3])), Size::square(120));
    // Rows are 1/60 high; row 60 begins at height 0. With affine interpolation the edge would be at
    // row 70.
    for (row, wanted) in [(52, 255), (58, 255), (61, 0), (68, 0), (80, 0)] {
        assert_eq!(texel(&picture, 60, row), [wanted; 3], "row {row}");
    }
    assert_eq!(texel(&picture, 60, 48), [99; 3]);
}

/// A square of one colour at a given depth.
pub(super) fn square(z: f32, material: usize) -> PosedPrimitive {
    PosedPrimitive {
        positions: [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]]
            .map(|[x, y]| [x, y, z])
            .to_vec(),
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uv: vec![[0.5, 0.5]; 4].into(),
        more_uv: Vec::new(),
        colors: None,
        triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
        material,
    }
}

fn plain(color: [f32; 4], alpha: AlphaMode) -> Material {
    Material { color, alpha, ..Material::default() }
}

#[test]
fn translucent_surfaces_blend_from_back_to_front() {
    let materials = [
        plain([1.0, 0.0, 0.0, 0.5], AlphaMode::Blend),
        plain([0.0, 0.0, 1.0, 0.25], AlphaMode::Blend),
        plain([0.0, 1.0, 0.0, 0.1], AlphaMode::Opaque),
        plain([1.0, 1.0, 1.0, 0.4], AlphaMode::Mask(0.5)),
    ];
    let renderer = Renderer::new(&materials, &[]);
    let options = unlit(Background::Plain([0; 3]));
    let color = |drawn: &[PosedPrimitive]| {
        let picture = renderer.render(drawn, &ahead(), &options, Size::square(4));
        [0, 1, 2].map(|k| uvgraft::color::linear_from_srgb(picture.get(1, 1, k)))
    };
    let near = |found: [f32; 3], wanted: [f32; 3]| {
        // Rounded to 8 bits, in steps of at most 0.009 in linear light.
        assert!((0..3).all(|k| (found[k] - wanted[k]).abs() < 0.005), "{found:?} {wanted:?}");
    };
    // Green behind a quarter of blue behind half of red, in any drawing order.
    let wanted = [0.5, 0.375, 0.125];
    near(color(&[square(0.0, 0), square(-1.0, 1), square(-2.0, 2)]), wanted);
    near(color(&[square(-2.0, 2), square(-1.0, 1), square(0.0, 0)]), wanted);
    // Surfaces behind an opaque one are hidden, and masked-out texels are absent.
    near(color(&[square(0.0, 2), square(-1.0, 0)]), [0.0, 1.0, 0.0]);
    near(color(&[square(0.0, 3), square(-1.0, 2)]), [0.0, 1.0, 0.0]);
    // On a transparent background the remaining transmittance becomes alpha.
    let options = unlit(Background::Transparent);
    let picture = renderer.render(&[square(0.0, 0)], &ahead(), &options, Size::square(4));
    assert_eq!(texel(&picture, 1, 1), [255, 0, 0, 128]);
}

#[test]
fn a_pixel_on_a_crease_has_the_colours_of_both_sides() {
    // Two slopes that meet at x = 0, in the middle of a pixel of the picture, lit from one side.
    let slope = |side: f32| PosedPrimitive {
        positions: [[0.0, -9.0, 0.0], [0.0, 9.0, 0.0], [9.0 * side, 0.0, -9.0]].to_vec(),
        normals: vec![[side, 0.0, 1.0]; 3],
        uv: vec![[0.5; 2]; 3].into(),
        triangles: vec![if side > 0.0 { [1, 0, 2] } else { [0, 1, 2] }].into(),
        ..square(0.0, 0)
    };
    let renderer = Renderer::new(&[plain([0.5, 0.5, 0.5, 1.0], AlphaMode::Opaque)], &[]);
    let options = RenderOptions::default();
    let drawn = [slope(-1.0), slope(1.0)];
    let picture = renderer.render(&drawn, &ahead(), &options, Size::square(45));
    let light = |x: u32| uvgraft::color::linear_from_srgb(picture.get(x, 22, 1));
    let (left, here, right) = (light(21), light(22), light(23));
    assert!(left > 1.3 * right, "{left} {right}");
    assert!((here - 0.5 * (left + right)).abs() < 0.01, "{left} {here} {right}");
}

#[test]
fn backs_are_seen_only_where_the_material_has_two_sides() {
    let mut material = plain([1.0, 0.0, 0.0, 1.0], AlphaMode::Opaque);
    let mut back = square(0.0, 0);
    back.triangles = vec![[0, 2, 1], [0, 3, 2]].into();
    let options = unlit(Background::Plain([0; 3]));
    for (double_sided, wanted) in [(false, 0), (true, 255)] {
        material.double_sided = double_sided;
        let renderer = Renderer::new(std::slice::from_ref(&material), &[]);
        let picture = renderer.render(&[back.clone()], &ahead(), &options, Size::square(4));
        assert_eq!(texel(&picture, 1, 1), [wanted, 0, 0]);
    }
}

#[test]
fn a_figure_stands_in_light_with_its_shadow_on_the_floor() {
    let scene = strip();
    let drawn = scene.pose(&PoseRequest::default()).unwrap();
    let bounds = Bounds::of(drawn[0].positions.iter().copied()).unwrap();
    let camera = Perspective::framing(&bounds, 30.0, 35.0, 30.0, 1.0, 0.7);
    let renderer = Renderer::for_scene(&scene);
    let draw = |floor| {
        let options = RenderOptions {
            floor,
            background: Background::Plain([255; 3]),
            ..RenderOptions::default()
        };
        renderer.render(&drawn, &camera, &options, Size::square(64))
    };
    let (without, with) = (draw(None), draw(Some(0.0)));
    let darker = (0..64 * 64).filter(|k| {
        let (x, y) = (k % 64, k / 64);
        let is_background = texel(&without, x, y) == [255; 3];
        is_background && with.get(x, y, 1) < 0.95
    });
    let darker = darker.count();
    assert!(darker > 40, "{darker}");
    // The picture's corners are far from the shadow.
    assert_eq!(texel(&with, 0, 0), [255; 3]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(pool.install(|| draw(Some(0.0))), with);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| draw(Some(0.0))), with);
}

#[test]
fn malformed_scenes_still_give_a_picture() {
    let bad = [f32::NAN, f32::INFINITY, 1e38, -1e38, 0.0, 1e-38];
    let materials = [Material::default(), plain([1.0; 4], AlphaMode::Blend)];
    let renderer = Renderer::new(&materials, &[]);
    for a in bad {
        for b in bad {
            let positions = vec![[a, b, 0.0], [b, a, a], [1.0, 0.0, b], [0.0, 2.0, 0.0]];
            let mut drawn: Vec<PosedPrimitive> = (0..3)
                .map(|material| PosedPrimitive {
                    positions: positions.clone(),
                    ..square(0.0, material)
                })
                .collect();
            drawn[1].normals.clear();
            drawn[1].uv = vec![[a, b]].into();
            drawn[1].triangles = vec![[0, 1, 2], [3, 3, 3], [0, 1, 77]].into();
            for floor in [None, Some(a), Some(0.0)] {
                let options = RenderOptions { floor, ..RenderOptions::default() };
                let camera = Perspective { near: 0.1, ..ahead() };
                let _ = renderer.render(&drawn, &camera, &options, Size::new(5, 3));
            }
            let camera = Perspective { eye: [a, b, 1.0], fov_y: 90.0, ..ahead() };
            let _ = renderer.render(&drawn, &camera, &RenderOptions::default(), Size::new(5, 3));
        }
    }
    let _ = renderer.render(&[], &ahead(), &RenderOptions::default(), Size::new(5, 3));
}
