//! Valid files of every kind, made by code: small, so that many inputs fit a second.

use std::io::Cursor;

use serde_json::json;
use uvgraft::{Channels, Depth, Direction, Encoding, MapOptions, Mesh, Pair, SamplingMap, Size};
use uvgraft::{Texels, Texture};
use uvgraft_avatar::body::BodyKind;
use uvgraft_image::{Format, Image, WriteOptions, encode};
use uvgraft_io::arrays::{NamedArrays, NumericArray, write_npz, write_npz_compressed};
use uvgraft_io::pair_file::PairFile;
use uvgraft_io::sampling_map::{Convention, write_npy, write_st_map};
use uvgraft_io::torch::write_pth;
use uvgraft_io::{obj as obj_file, pair_file as pairs, sampling_map, vertex_map as maps};
use uvgraft_tests::bodies::synthetic_motion;
use uvgraft_tests::mannequin;
use uvgraft_tests::strip::{Strip, WEIGHTS};

use crate::sealed::png_resealed;
use crate::{exr_seeds, tflite_seed, tiff_seeds};

/// What a writer wrote.
fn written<E: std::fmt::Debug>(
    write: impl FnOnce(&mut Cursor<Vec<u8>>) -> Result<(), E>,
) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write(&mut out).expect("memory can be written");
    out.into_inner()
}

/// A square of two triangles, with a layout of its own.
fn square(turned: bool) -> Mesh {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.2], [0.0, 1.0, 0.0]];
    let uv = vec![[0.1, 0.2], [0.8, 0.1], [0.9, 0.9], [0.2, 0.7]];
    let uv = if turned { uv.iter().map(|&[u, v]| [1.0 - v, u]).collect() } else { uv };
    let faces = [[0, 1, 2], [0, 2, 3]];
    Mesh::from_triangles(positions, uv, &faces, &faces).expect("a sound mesh")
}

fn pair() -> Pair {
    Pair::by_vertex_map(square(false), square(true), &[0, 1, 2, 3]).expect("a sound pair")
}

fn map() -> SamplingMap {
    let options = MapOptions::with_gutter(2);
    SamplingMap::new(&pair(), Direction::Forward, Size::new(9, 7), &options)
}

fn arrays() -> NamedArrays {
    let mut arrays = NamedArrays::new();
    let floats = NumericArray::new_f32(vec![2, 3], vec![0.5, -1.0, 2.0, 3.5, 0.0, 1e9]);
    arrays.insert("floats", floats.expect("six values"));
    let integers = NumericArray::new_i64(vec![4], vec![0, 1, 2, -1]);
    arrays.insert("integers", integers.expect("four values"));
    arrays.insert_text("text", "words");
    arrays
}

pub(crate) fn obj() -> Vec<Vec<u8>> {
    let mesh = written(|out| obj_file::write(&square(false), out));
    let text = "# a\no head\ng face skin\nusemtl m\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0\nv 0 1 0\n\
                vt 0 0\nvt 1 0 0\nvt 1 1\nvn 0 0 1\ns off\nf 1/1/1 2/2/1 3/3/1 4/1/1\n\
                f -4/-3 -3/-2 \\\n -2/-1\n";
    vec![mesh, text.into()]
}

pub(crate) fn ply() -> Vec<Vec<u8>> {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment a\nelement vertex 3\nproperty float x\nproperty float \
             y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\nproperty list \
             uchar int vertex_indices\nend_header\n"
        )
    };
    let values =
        [[0.0f32, 0.0, 0.0, 0.1, 0.2], [1.0, 0.0, 0.0, 0.9, 0.1], [0.0, 1.0, 0.0, 0.5, 0.8]];
    let text = "0 0 0 0.1 0.2\n1 0 0 0.9 0.1\n0 1 0 0.5 0.8\n3 0 1 2\n";
    let [mut little, mut big] =
        ["binary_little_endian", "binary_big_endian"].map(|name| header(name).into_bytes());
    for value in values.as_flattened() {
        little.extend(value.to_le_bytes());
        big.extend(value.to_be_bytes());
    }
    little.push(3);
    big.push(3);
    for index in 0..3i32 {
        little.extend(index.to_le_bytes());
        big.extend(index.to_be_bytes());
    }
    vec![(header("ascii") + text).into(), little, big]
}

/// The strip three times, with its weights compressed to version 1 of meshoptimizer's bitstream, in
/// which bytes 2 and 3 do not change.
pub(crate) fn instances() -> Strip {
    let mut strip = Strip::new();
    let places = [0.0_f32, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, -1.0].map(f32::to_le_bytes);
    let places = strip.add(&places.concat(), 5126, 3, "VEC3");
    let mut stream = vec![0xa1, 0b10_10_11_11];
    // Differences in zigzag code: from 255 down by 127 after every two vertices, and up from 0.
    stream.extend([0, 0, 253, 0, 253, 0, 0, 0, 254, 0, 254, 0]);
    stream.extend([0; 24 - 5]);
    stream.extend([255, 0, 0, 0, 0]);
    let packed = strip.view(&stream);
    let packed = strip.json["bufferViews"][packed]["byteOffset"].clone();
    let view = &strip.json["accessors"][WEIGHTS]["bufferView"];
    let view = format!("/bufferViews/{view}");
    let meshopt = json!({
        "buffer": 0, "byteOffset": packed, "byteLength": stream.len(), "byteStride": 4, "count": 6,
        "mode": "ATTRIBUTES"
    });
    strip.json["buffers"].as_array_mut().expect("a list").push(json!({ "byteLength": 24 }));
    strip
        .with(
            &view,
            json!({
                "buffer": 1, "byteLength": 24, "extensions": { "KHR_meshopt_compression": meshopt }
            }),
        )
        .with(&format!("/accessors/{WEIGHTS}/componentType"), json!(5121))
        .with(&format!("/accessors/{WEIGHTS}/normalized"), json!(true))
        .with(
            "/nodes/2/extensions",
            json!({
                "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } }
            }),
        )
}

pub(crate) fn glb() -> Vec<Vec<u8>> {
    let strip = Strip::new();
    vec![strip.glb(), mannequin::file(true), instances().glb(), strip.json.to_string().into()]
}

pub(crate) fn npy() -> Vec<Vec<u8>> {
    let ids = written(|out| maps::write_npy(&[3, 1, 4, 1, 5], out));
    let floats = written(|out| write_npy(&map(), out));
    vec![ids, floats]
}

pub(crate) fn npz() -> Vec<Vec<u8>> {
    vec![
        written(|out| write_npz(&arrays(), out)),
        written(|out| write_npz_compressed(&arrays(), out)),
    ]
}

pub(crate) fn pickle() -> Vec<Vec<u8>> {
    // Protocol 0, 2 and 4: dictionaries with lists, tuples, memo and numbers; and an array of NumPy.
    let text = b"(dp0\nVface\np1\n(lp2\nI1\naI2\naF0.5\nas.".to_vec();
    let binary =
        b"\x80\x02}q\x00(X\x04\x00\x00\x00faceq\x01]q\x02(K\x01M\x02\x01J\x03\x00\x01\x00eX\x01\
                   \x00\x00\x00bq\x03G?\xe0\x00\x00\x00\x00\x00\x00N\x86u."
            .to_vec();
    let framed =
        b"\x80\x04\x95\x15\x00\x00\x00\x00\x00\x00\x00}\x94\x8c\x04face\x94]\x94(K\x01K\x02K\x03e\
                   s."
        .to_vec();
    let array = b"\x80\x02cnumpy.core.multiarray\n_reconstruct\nq\x00cnumpy\nndarray\nq\x01K\x00\x85q\x02U\
                  \x01bq\x03\x87q\x04Rq\x05(K\x01K\x02\x85q\x06cnumpy\ndtype\nq\x07U\x02i4q\x08K\x00K\x01\
                  \x87q\x09Rq\x0a(K\x03U\x01<q\x0bNNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tq\x0cb\x89U\
                  \x08\x01\x00\x00\x00\x02\x00\x00\x00q\x0dtq\x0eb."
        .to_vec();
    vec![text, binary, framed, array]
}

pub(crate) fn torch() -> Vec<Vec<u8>> {
    let file = written(|out| write_pth(&arrays(), out));
    // Its pickle, which is stored as it is.
    let start = file.windows(2).position(|pair| pair == b"\x80\x02").unwrap_or(0);
    let end = file.windows(2).skip(start).position(|pair| pair == b"PK");
    let pickle = file[start..end.map_or(file.len(), |end| start + end)].to_vec();
    vec![file, pickle]
}

pub(crate) fn tflite() -> Vec<Vec<u8>> {
    vec![tflite_seed::model()]
}

fn texture(size: Size, channels: Channels, depth: Depth) -> Texture {
    let mut random = fastrand::Rng::with_seed(5);
    let count = size.texels() * channels.count();
    let texels = match depth {
        Depth::U8 => Texels::U8((0..count).map(|at| (at / 3) as u8 ^ random.u8(0..8)).collect()),
        Depth::U16 => Texels::U16((0..count).map(|_| random.u16(..)).collect()),
        Depth::F32 => Texels::F32((0..count).map(|_| random.f32()).collect()),
    };
    let encoding = if depth == Depth::F32 { Encoding::Linear } else { Encoding::Srgb };
    Texture::new(size, channels, encoding, texels).expect("as many values")
}

pub(crate) fn image() -> Vec<Vec<u8>> {
    let mut seeds = Vec::new();
    for &format in Format::ALL {
        for (channels, depth) in [
            (Channels::Grey, Depth::U8),
            (Channels::Rgb, Depth::U8),
            (Channels::Rgba, Depth::U16),
            (Channels::Rgb, Depth::F32),
        ] {
            if channels.has_alpha() && !format.codec().has_alpha {
                continue;
            }
            let texture = texture(Size::new(19, 11), channels, depth);
            let image = Image { texture, icc: Some(vec![7; 20]) };
            for compress in [false, true] {
                let options = WriteOptions::default().compress(compress);
                seeds.push(written(|out| encode(&image, format, &options, out).map(drop)));
            }
        }
    }
    seeds.extend(declared_spaces());
    seeds.extend(tiff_seeds::all());
    seeds.extend(exr_seeds::all());
    seeds
}

/// PNGs that declare a colour space.
fn declared_spaces() -> Vec<Vec<u8>> {
    let image = Image::from(texture(Size::new(5, 3), Channels::Rgb, Depth::U8));
    let options = WriteOptions::default();
    let plain = written(|out| encode(&image, Format::PNG, &options, out).map(drop));
    let chunk = |kind: &[u8; 4], content: &[u8]| {
        let length = (content.len() as u32).to_be_bytes();
        [&length[..], kind, content, &[0; 4]].concat()
    };
    let p3 = [31_270u32, 32_900, 68_000, 32_000, 26_500, 69_000, 15_000, 6_000];
    [
        chunk(b"gAMA", &55_556u32.to_be_bytes()),
        chunk(b"cHRM", &p3.map(u32::to_be_bytes).concat()),
        chunk(b"cICP", &[9, 16, 0, 1]),
        chunk(b"cICP", &[12, 18, 0, 0]),
    ]
    .map(|chunk| png_resealed(&[&plain[..33], &chunk, &plain[33..]].concat()))
    .to_vec()
}

pub(crate) fn pair_file() -> Vec<Vec<u8>> {
    let file = PairFile {
        pair: pair().into(),
        source_name: "a.obj".to_owned(),
        target_name: "b.obj".to_owned(),
        note: "a note".to_owned(),
    };
    vec![pairs::encode(&file).expect("a sound pair")]
}

pub(crate) fn map_file() -> Vec<Vec<u8>> {
    let reference = written(|out| sampling_map::write_npz(&map(), Convention::Reference, out));
    vec![written(|out| write_npy(&map(), out)), reference, written(|out| write_st_map(&map(), out))]
}

pub(crate) fn vertex_map() -> Vec<Vec<u8>> {
    let mut seeds = npy();
    seeds.extend(npz());
    seeds.push(b"# ids\n0 3\n-1, 7\n".to_vec());
    seeds
}

pub(crate) fn vertex_list() -> Vec<Vec<u8>> {
    vec![b"0 1 2\n39\n".to_vec(), npy().swap_remove(0), b"[1, 2, 3]".to_vec()]
}

pub(crate) fn vertex_groups() -> Vec<Vec<u8>> {
    let mut seeds = pickle();
    seeds.push(br#"{"face": [0, 1, 2], "neck": [3], "ear\u00e4": []}"#.to_vec());
    seeds
}

pub(crate) fn correspondence_table() -> Vec<Vec<u8>> {
    let mut seeds = pickle();
    seeds.extend(npz());
    seeds.push(b"0 1 2 0.5 0.25 0.25\n3 4 5 1 0 0\n".to_vec());
    seeds.push(br#"{"faces": [0, 1], "weights": [[1, 0, 0], [0.5, 0.5, 0]]}"#.to_vec());
    seeds
}

pub(crate) fn body_model() -> Vec<Vec<u8>> {
    resampling()
}

pub(crate) fn motion() -> Vec<Vec<u8>> {
    vec![written(|out| write_npz(&synthetic_motion(BodyKind::SmplH, 2), out))]
}

pub(crate) fn networks() -> Vec<Vec<u8>> {
    let model = tflite_seed::model();
    let safetensors =
        b"\x3c\0\0\0\0\0\0\0{\"a\":{\"dtype\":\"U8\",\"shape\":[4],\"data_offsets\":[0,4]}}   \
                        \x01\x02\x03\x04"
            .to_vec();
    vec![[&model[..], &model, &model].concat(), safetensors]
}

pub(crate) fn imports() -> Vec<Vec<u8>> {
    npz()
}

pub(crate) fn resampling() -> Vec<Vec<u8>> {
    let mut random = fastrand::Rng::with_seed(3);
    (0..8).map(|_| (0..400).map(|_| random.u8(..)).collect()).collect()
}

pub(crate) fn png_round_trip() -> Vec<Vec<u8>> {
    resampling()
}

#[cfg(test)]
mod tests {
    use uvgraft_avatar::motion::Motion;
    use uvgraft_gltf::scene::{MeshChoice, Scene, read_mesh};
    use uvgraft_image as images;
    use uvgraft_io::{arrays, ply as ply_file, sampling_map, torch as torch_file};
    use uvgraft_io::{pickle as pickles, vertex_groups as groups};
    use uvgraft_selfie::tflite as models;

    use super::*;

    /// Mutations of files that are refused at once would test little.
    #[test]
    fn seeds_are_read() {
        obj().iter().for_each(|seed| drop(obj_file::parse(seed).unwrap()));
        ply().iter().for_each(|seed| drop(ply_file::parse(seed).unwrap()));
        for seed in &glb()[..3] {
            Scene::read(seed).unwrap();
            read_mesh(seed, &MeshChoice::default()).unwrap();
        }
        npy().iter().for_each(|seed| drop(arrays::parse_npy(seed).unwrap()));
        npz().iter().for_each(|seed| drop(arrays::parse(seed).unwrap()));
        pickle().iter().for_each(|seed| drop(pickles::parse(seed).unwrap()));
        torch_file::parse(&torch()[0]).unwrap();
        pickles::parse_with_outside(&torch()[1]).unwrap();
        models::parse(&tflite()[0]).unwrap();
        image().iter().for_each(|seed| drop(images::decode(seed).unwrap()));
        map_file().iter().for_each(|seed| drop(sampling_map::parse(seed).unwrap()));
        groups::parse(vertex_groups().last().unwrap()).unwrap();
        Motion::from_arrays(&arrays::parse(&motion()[0]).unwrap()).unwrap();
        pairs::decode(&pair_file()[0]).unwrap();
    }
}
