//! Dumps and workspaces.

use std::io::Cursor;

use uvgraft::color::Encoding;
use uvgraft::texture::{Depth, Size, Texels};

use super::*;
use crate::arrays::NumericArray;
use uvgraft_image::{Image, WriteOptions};

fn tensor(shape: &[usize], value: impl Fn(usize) -> f32) -> NumericArray {
    let count = shape.iter().product();
    NumericArray::new_f32(shape.to_vec(), (0..count).map(value).collect()).unwrap()
}

fn dump(tensors: impl IntoIterator<Item = (&'static str, NumericArray)>) -> Vec<u8> {
    let mut arrays = NamedArrays::new();
    for (name, array) in tensors {
        arrays.insert(name, array);
    }
    let mut bytes = Cursor::new(Vec::new());
    torch::write_pth(&arrays, &mut bytes).unwrap();
    bytes.into_inner()
}

fn error(bytes: &[u8]) -> String {
    parse_dump(bytes, 4).unwrap_err().to_string()
}

#[test]
fn colours_and_confidence_have_their_own_curves() {
    // One row at the bottom, one at the top; tanh and exp by hand.
    let color = tensor(&[1, 3, 2, 2], |index| [0.0, 0.0, 0.5, 0.5][index % 4]);
    let opacity = tensor(&[1, 1, 2, 2], |index| [-2.0, -2.0, 2.0, 2.0][index % 4]);
    let bytes = dump([("color", color), ("opacity", opacity), ("offset", tensor(&[9], |_| 0.0))]);
    let found = parse_dump(&bytes, 2).unwrap();
    // Centres lie a quarter of the way between the rows. tanh(0.5) = 0.462117.
    let near = |found: f32, wanted: f32| (found - wanted).abs() < 1e-6;
    let (top, bottom) = (0.5 + 0.5 * 0.462_117_2 * 0.75, 0.5 + 0.5 * 0.462_117_2 * 0.25);
    assert!(near(found.color.get(0, 0, 2), top), "{}", found.color.get(0, 0, 2));
    assert!(near(found.color.get(1, 1, 0), bottom), "{}", found.color.get(1, 1, 0));
    // The opacity is interpolated before its sigmoid: 1 / (1 + exp(-1)) = 0.731059.
    let confidence = found.confidence.unwrap();
    assert!(near(confidence.get(0, 0, 0), 0.731_058_6), "{}", confidence.get(0, 0, 0));
    assert!(near(confidence.get(0, 1, 0), 0.268_941_4), "{}", confidence.get(0, 1, 0));
    assert_eq!((found.color.encoding(), found.color.depth()), (Encoding::Srgb, Depth::F32));

    let black = dump([("color", tensor(&[1, 3, 1, 1], |_| f32::NEG_INFINITY))]);
    let found = parse_dump(&black, 4).unwrap();
    assert_eq!((found.color.get(3, 3, 1), found.confidence), (0.0, None));
}

#[test]
fn other_tensors_are_refused_with_their_shapes() {
    let shape = |shape: &[usize]| error(&dump([("color", tensor(shape, |_| 0.0))]));
    assert_eq!(shape(&[3, 8, 8]), "`color` must have shape [1, 3, N, N], got [3, 8, 8]");
    for other in [&[1, 3, 8, 4][..], &[1, 4, 8, 8], &[2, 3, 8, 8], &[1, 3, 0, 0], &[]] {
        assert!(shape(other).starts_with("`color` must have shape "), "{other:?}");
    }
    let opacity = ("opacity", tensor(&[1, 1, 4, 4], |_| 0.0));
    let bytes = dump([("color", tensor(&[1, 3, 8, 8], |_| 0.0)), opacity.clone()]);
    assert_eq!(error(&bytes), "`opacity` must have shape [1, 1, 8, 8], got [1, 1, 4, 4]");
    assert_eq!(error(&dump([opacity])), "no array `color`; the file has `opacity`");
    let broken = dump([("color", tensor(&[1, 3, 2, 2], |index| [0.0, f32::NAN][index % 2]))]);
    assert_eq!(error(&broken), "`color` must be finite, got 6 values that are NaN or infinite");
    let sound = dump([("color", tensor(&[1, 3, 1, 1], |_| 0.0))]);
    assert!(matches!(parse_dump(&sound, 0), Err(FateError::Texture(_))));
}

#[test]
fn the_newest_texture_of_a_workspace_is_read() {
    let workspace = tempfile::tempdir().unwrap();
    let at = |path: &str| workspace.path().join(path);
    let put = |path: &str, level: f32| {
        std::fs::create_dir_all(at(path).parent().unwrap()).unwrap();
        std::fs::write(at(path), dump([("color", tensor(&[1, 3, 1, 1], |_| level))])).unwrap();
    };
    let newest = || find(workspace.path()).unwrap();
    let nothing = read(workspace.path(), 4).unwrap_err().to_string();
    assert!(nothing.contains("must be a FATE workspace"), "{nothing}");
    assert!(nothing.starts_with(&workspace.path().display().to_string()), "{nothing}");

    let picture = |path: &str, channels: Channels, level: u8| {
        std::fs::create_dir_all(at(path).parent().unwrap()).unwrap();
        let texels = Texels::U8(vec![level; 4 * channels.count()]);
        let texture = Texture::new(Size::square(2), channels, Encoding::Srgb, texels).unwrap();
        let image = Image { texture, icc: None };
        let _ = image::write(&image, at(path), &WriteOptions::default()).unwrap();
    };
    picture("baking/visualize_texture/000001_color.png", Channels::Rgb, 0);
    picture("baking/visualize_texture/020000_color.png", Channels::Rgb, 191);
    picture("baking/visualize_texture/020000_opacity.png", Channels::Grey, 51);
    let found = newest();
    assert!(found.file.ends_with("020000_color.png"), "{found:?}");
    assert_eq!((found.kind, found.others), (TextureSource::Picture, 1));
    let texture = read(workspace.path(), 2).unwrap().texture;
    // 0.5 + 0.2820948 · 1.78 · (2 · 191/255 - 1)
    assert!((texture.color.get(0, 0, 0) - 0.750_079_8).abs() < 1e-6, "{texture:?}");
    assert!((texture.confidence.unwrap().get(1, 1, 0) - 0.2).abs() < 1e-6);

    put("baking/dump_texture/tex_dump.pth", 9.0);
    put("baking/dump_texture/002_tex_dump.pth", 9.0);
    put("baking/dump_texture/010_tex_dump.pth", 0.0);
    assert!(newest().file.ends_with("baking/dump_texture/010_tex_dump.pth"));
    let texture = read(workspace.path(), 2).unwrap();
    assert_eq!((texture.texture.color.get(0, 0, 0), texture.kind), (0.5, TextureSource::Dump));
    put("baking_full_head/dump_texture/001_tex_dump.pth", -9.0);
    assert!(newest().file.ends_with("baking_full_head/dump_texture/001_tex_dump.pth"));
    assert_eq!(newest().others, 5);
    // A baking folder, and a dump by itself.
    assert!(find(at("baking")).unwrap().file.ends_with("010_tex_dump.pth"));
    let dump = at("baking/dump_texture/010_tex_dump.pth");
    let bytes = Input::bytes("dump", std::fs::read(&dump).unwrap());
    for input in [Input::from(&dump), bytes] {
        let one = read(&input, 2).unwrap();
        assert_eq!((one.texture.color.get(1, 0, 1), &*one.file), (0.5, input.name()));
    }
    let missing = read(at("none.pth"), 2).unwrap_err().to_string();
    assert!(missing.contains("none.pth"), "{missing}");
}
