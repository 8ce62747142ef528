//! Readers of structured files, with what each may take.
//!
//! Beside what any file may take (`oracle.rs`), there are sizes that a file declares within the limits
//! of its reader:
//! - of an image, its decoded size, as its header is understood;
//! - of a scene, the elements of its accessors as often as they are shown, as if they were in the file:
//!   zeros need no bytes there; but no more than the budget of scenes allows;
//! - of an archive, what its entries unpack to.

use std::hint::black_box;
use std::io::Cursor;

use serde_json::Value;
use uvgraft_avatar::motion::Motion;
use uvgraft_files::input::Input;
use uvgraft_gltf::container::Glb;
use uvgraft_gltf::scene::{
    Budget, MeshChoice, PoseRequest, Scene, contents, read_mesh, whole_within,
};
use uvgraft_image::{self as image, BandDecoder, ImageError};
use uvgraft_io::{
    arrays, correspondence_table, fate, pickle, sampling_map, torch, vertex_groups, vertex_map,
};
use uvgraft_selfie::tflite;

use crate::oracle::{ANY_FILE, EACH_BYTE, allowed, within};
use crate::readers;

/// Images that decode to at most this many bytes are also compared, whole and in bands.
const COMPARED: u64 = 1 << 22;

/// What is unpacked may be there as it is stored, as numbers, and as the next larger kind of numbers.
const EACH_UNPACKED_BYTE: usize = 24;

/// A size in bytes; the largest where sizes have fewer bits.
fn size(bytes: u64) -> usize {
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

/// Whole, and in bands, which are dropped.
pub(super) fn image(bytes: &[u8]) {
    let header = within("reading a header", allowed(bytes), || image::decode_header(bytes));
    let declared = header.as_ref().map_or(0, |header| header.decoding_bytes);
    let most = allowed(bytes).saturating_add(size(declared));
    let whole = within("decoding", most, || image::decode(bytes).map(drop));
    if let Err(error @ ImageError::GaveUp { .. }) = &whole {
        panic!("a caught panic is one all the same: {error}");
    }
    within("decoding in bands", most, || {
        let Ok(mut bands) = BandDecoder::new(bytes) else { return };
        while let Ok(Some(band)) = bands.next_band(16) {
            bands.recycle(band);
        }
    });
    if declared <= COMPARED {
        readers::image(bytes);
    }
}

/// As many bytes as the elements of accessors would take as floats of 32 bits, those of a mesh for each
/// time that a node or an instance shows it.
fn declared_elements(bytes: &[u8]) -> u64 {
    let json = Glb::read(bytes).map_or(bytes, |glb| glb.json);
    let Ok(json) = serde_json::from_slice::<Value>(json) else { return 0 };
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let values = |value: &Value| {
        value.as_object().into_iter().flat_map(|it| it.values().cloned()).collect::<Vec<_>>()
    };
    let count = |accessor: &Value| {
        let accessor = accessor.as_u64().map(|index| &json["accessors"][index as usize]);
        // Readers refuse more.
        accessor.and_then(|it| it["count"].as_u64()).filter(|&count| count <= 1 << 26).unwrap_or(0)
    };
    let elements = |accessor: &Value| {
        let numbers = accessor.as_u64().map(|index| &json["accessors"][index as usize]["type"]);
        4 * count(accessor) * if numbers.and_then(Value::as_str) == Some("MAT4") { 16 } else { 4 }
    };
    let of_mesh = |mesh: &Value| -> u64 {
        let arrays = list(&mesh["primitives"]).into_iter().flat_map(|primitive| {
            let targets = list(&primitive["targets"]);
            let targets = targets.iter().flat_map(values);
            let own = values(&primitive["attributes"]).into_iter();
            own.chain([primitive["indices"].clone()]).chain(targets).collect::<Vec<_>>()
        });
        arrays.map(|accessor| elements(&accessor)).sum()
    };
    let meshes: Vec<u64> = list(&json["meshes"]).iter().map(of_mesh).collect();
    let shown = list(&json["nodes"]).into_iter().map(|node| {
        let instances = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        let times = values(instances).iter().map(count).max().unwrap_or(1);
        let mesh = node["mesh"].as_u64().and_then(|mesh| meshes.get(mesh as usize));
        times.saturating_mul(mesh.copied().unwrap_or(0))
    });
    let accessors = (0..list(&json["accessors"]).len()).map(|index| elements(&index.into()));
    shown.chain(accessors).fold(0, u64::saturating_add)
}

/// All that reads scenes; the scene itself with a budget that suits the file, and by default.
pub(super) fn scene(bytes: &[u8]) {
    let suitable = allowed(bytes);
    let by_default = (1 << 30) + 200 * bytes.len();
    // What is read, and how, depends on the bytes: all of it would take twice as long, and the default
    // budget allows a gibibyte.
    let choice = bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    let (budget, most) = if choice % 16 > 0 {
        (Budget::bytes(suitable as u64), suitable)
    } else {
        (Budget::default(), by_default)
    };
    if choice & 16 > 0 {
        within("reading and posing a scene", most, || {
            if let Ok(scene) = Scene::read_within(bytes, budget) {
                let _ = black_box(scene.pose(&PoseRequest::default()));
                black_box(scene.expressions());
            }
        });
    } else {
        within("unpacking a scene", most, || {
            let _ = black_box(whole_within(Input::bytes("fuzzed.glb", bytes), budget));
        });
    }
    let declared = size(declared_elements(bytes));
    let most = suitable.saturating_add(EACH_BYTE.saturating_mul(declared)).min(by_default);
    if choice & 32 > 0 {
        within("reading a mesh", most, || {
            let _ = black_box(read_mesh(bytes, &MeshChoice::default()));
        });
    } else {
        within("listing contents", most, || {
            let _ = black_box(contents(Input::bytes("fuzzed.glb", bytes)));
        });
    }
}

/// What the entries of an archive unpack to, as far as they are believed.
fn unpacked(bytes: &[u8]) -> usize {
    let Ok(mut archive) = zip::ZipArchive::new(Cursor::new(bytes)) else { return 0 };
    let mut sum = 0_u64;
    for index in 0..archive.len() {
        let Ok(entry) = archive.by_index_raw(index) else { return 0 };
        // Deflate makes at most 1,032 bytes of one.
        sum = sum.saturating_add(entry.size().min(entry.compressed_size().saturating_mul(1032)));
    }
    if sum <= arrays::MAX_UNPACKED_BYTES { size(sum) } else { 0 }
}

/// What becomes of arrays by name.
pub(super) fn arrays(bytes: &[u8]) {
    let most = EACH_UNPACKED_BYTE.saturating_mul(unpacked(bytes)).saturating_add(allowed(bytes));
    within("reading arrays", most, || black_box(arrays::parse(bytes).is_ok()));
    within("reading a vertex map", most, || black_box(vertex_map::parse(bytes).is_ok()));
    within("reading correspondences", most, || {
        black_box(correspondence_table::parse(bytes).is_ok());
    });
    within("reading a sampling map", most, || black_box(sampling_map::parse(bytes).is_ok()));
    within("reading a motion", most, || {
        let arrays = arrays::parse(bytes);
        black_box(arrays.is_ok_and(|arrays| Motion::from_arrays(&arrays).is_ok()));
    });
}

/// A single array.
pub(super) fn array(bytes: &[u8]) {
    let most = allowed(bytes);
    within("reading an array", most, || readers::npy(bytes));
    within("reading a vertex map", most, || readers::vertex_map(bytes));
    within("reading a vertex list", most, || readers::vertex_list(bytes));
    within("reading a sampling map", most, || readers::map_file(bytes));
}

pub(super) fn pickled(bytes: &[u8]) {
    let most = allowed(bytes);
    within("reading a pickle", most, || black_box(pickle::parse(bytes).is_ok()));
    within("reading arrays", most, || black_box(arrays::parse(bytes).is_ok()));
    within("reading vertex groups", most, || black_box(vertex_groups::parse(bytes).is_ok()));
    within("reading correspondences", most, || {
        black_box(correspondence_table::parse(bytes).is_ok());
    });
}

pub(super) fn tensors(bytes: &[u8]) {
    let most = EACH_UNPACKED_BYTE.saturating_mul(unpacked(bytes)).saturating_add(allowed(bytes));
    within("reading tensors", most, || black_box(torch::parse(bytes).is_ok()));
    within("reading a texture", most.saturating_add(ANY_FILE), || {
        black_box(fate::parse_dump(bytes, 8).is_ok());
    });
}

pub(super) fn network(bytes: &[u8]) {
    within("reading a network", allowed(bytes), || black_box(tflite::parse(bytes).is_ok()));
}
