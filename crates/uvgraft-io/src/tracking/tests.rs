//! Folders in the form of each tracker, with pixels found by hand.

mod damaged;
mod frames;

use std::f32::consts::FRAC_PI_2;
use std::path::Path;

use serde_json::{Value, json};
use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Size, Texels, Texture};

use self::frames::{Checkpoint, metrical_folder};
use super::*;
use crate::arrays::{NamedArrays, NumericArray, save_npz};
use uvgraft_image::{self as image, WriteOptions};

fn put_image(path: &Path, size: Size) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let texels = Texels::U8(vec![9; size.texels()]);
    let texture = Texture::new(size, Channels::Grey, Encoding::Srgb, texels).unwrap();
    let _ = image::write(&texture.into(), path, &WriteOptions::default()).unwrap();
}

fn put_text(path: &Path, text: &str) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, text).unwrap();
}

#[track_caller]
fn assert_pixel(camera: &TrackedCamera, world: [f64; 3], wanted: [f64; 2]) {
    let found = camera.project(world).unwrap();
    let is_near = found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-4);
    assert!(is_near, "{found:?}, wanted {wanted:?}");
}

#[track_caller]
fn assert_turn(found: [f32; 3], wanted: [f32; 3]) {
    let is_near = found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-6);
    assert!(is_near, "{found:?}, wanted {wanted:?}");
}

/// A file of parameters as VHAP exports it.
fn flame_param(path: &Path, jaw: f32) {
    let mut arrays = NamedArrays::new();
    let mut put = |name: &str, shape: &[usize], values: &[f32]| {
        arrays.insert(name, NumericArray::new_f32(shape.to_vec(), values.to_vec()).unwrap());
    };
    put("translation", &[1, 3], &[0.01, 0.02, 0.03]);
    put("rotation", &[1, 3], &[0.1, 0.2, 0.3]);
    put("neck_pose", &[1, 3], &[0.4, 0.5, 0.6]);
    put("jaw_pose", &[1, 3], &[jaw, 0.0, 0.0]);
    put("eyes_pose", &[1, 6], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    put("shape", &[4], &[0.5, -1.0, 0.25, 0.0]);
    put("expr", &[1, 2], &[1.5, -0.5]);
    put("static_offset", &[1, 2, 3], &[0.0, 0.0, 0.001, 0.0, 0.0, 0.002]);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    save_npz(&arrays, path).unwrap();
}

/// A camera at `[2, 0, 0]` that looks along -x, in OpenGL's axes: its right is -z of the world, its
/// up is y, and its back is x.
fn along_x() -> Value {
    json!([[0.0, 0.0, 1.0, 2.0], [0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
}

/// A camera at `[0, 0, 1]` that looks along -z, in OpenGL's axes.
fn along_z() -> Value {
    json!([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]])
}

fn vhap_frame(timestep: u32, camera: (u32, Value), matrix: &Value) -> Value {
    let (index, id) = camera;
    let name = format!("{timestep:05}_{index:02}.png");
    json!({
        "timestep_index": timestep, "timestep_id": "x", "camera_index": index, "camera_id": id,
        "cx": 320.0, "cy": 240.0, "fl_x": 1000.0, "fl_y": 1100.0, "h": 480, "w": 640,
        "camera_angle_x": 0.6, "camera_angle_y": 0.4, "transform_matrix": matrix,
        "file_path": format!("images/{name}"), "fg_mask_path": format!("fg_masks/{name}"),
        "flame_param_path": format!("flame_param/{timestep:05}.npz"),
    })
}

/// Two time steps seen by two cameras, the later one first.
fn vhap_folder(folder: &Path) -> Value {
    let frames: Vec<Value> = [(1, 0), (1, 1), (0, 0), (0, 1)]
        .map(|(timestep, camera)| match camera {
            0 => vhap_frame(timestep, (0, json!("222200042")), &along_x()),
            _ => vhap_frame(timestep, (1, json!(222_200_043)), &along_z()),
        })
        .into();
    for frame in &frames {
        put_image(&folder.join(frame["file_path"].as_str().unwrap()), Size::new(4, 3));
    }
    put_image(&folder.join("fg_masks/00000_00.png"), Size::new(4, 3));
    flame_param(&folder.join("flame_param/00000.npz"), 0.0);
    flame_param(&folder.join("flame_param/00001.npz"), 0.25);
    json!({ "frames": frames, "w": 1, "h": 1, "timestep_indices": [0, 1], "camera_indices": [0, 1] })
}

#[test]
fn vhap() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    put_text(&folder.join("transforms.json"), &vhap_folder(folder).to_string());
    assert_eq!(detect(folder).unwrap(), Some(Tracker::Vhap));
    let found = read(folder).unwrap();
    let ids: Vec<(u32, &str)> =
        found.frames.iter().map(|frame| (frame.timestep, &*frame.camera_id)).collect();
    let cameras = ["222200042", "222200043"];
    assert_eq!(ids, [(0, cameras[0]), (0, cameras[1]), (1, cameras[0]), (1, cameras[1])]);
    let [first, second, third, _] = &found.frames[..] else { unreachable!() };
    assert_eq!(first.image, folder.join("images/00000_00.png"));
    assert_eq!(first.mask, Some(folder.join("fg_masks/00000_00.png")));
    assert_eq!((&second.mask, &second.mesh, second.subset), (&None, &None, Subset::Whole));
    assert_eq!(first.camera.size, Size::new(640, 480));
    // 2 forward, 0.1 right, 0.2 up: 320 + 1000 * 0.1 / 2, 240 - 1100 * 0.2 / 2.
    assert_pixel(&first.camera, [0.0, 0.2, -0.1], [370.0, 130.0]);
    // 1 forward.
    assert_pixel(&second.camera, [0.1, 0.2, 0.0], [420.0, 20.0]);
    assert_eq!(second.camera.project([0.0, 0.0, 1.5]), None);

    let flame = &first.flame;
    assert_eq!((flame.rotation, flame.translation), ([0.1, 0.2, 0.3], [0.01, 0.02, 0.03]));
    assert_eq!((flame.neck, flame.jaw), ([0.4, 0.5, 0.6], Some([0.0; 3])));
    assert_eq!(flame.eyes, Some([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]));
    assert_eq!((&flame.expression[..], flame.scale), (&[1.5, -0.5][..], 1.0));
    let offset = flame.static_offset.as_ref().unwrap();
    assert_eq!(**offset, [[0.0, 0.0, 0.001], [0.0, 0.0, 0.002]]);
    assert_eq!(third.flame.jaw, Some([0.25, 0.0, 0.0]));
    // Time steps share what is the same.
    assert!(Arc::ptr_eq(offset, third.flame.static_offset.as_ref().unwrap()));
    assert!(Arc::ptr_eq(&found.shape, &third.flame.shape));
    assert_eq!(found.shape[..], [0.5, -1.0, 0.25, 0.0]);
}

#[test]
fn combined_subsets_of_vhap() {
    let parent = tempfile::tempdir().unwrap();
    let all = vhap_folder(&parent.path().join("EMO-1"));
    let union = parent.path().join("UNION");
    let moved = |index: usize| {
        let mut frame = all["frames"][index].clone();
        for key in ["file_path", "flame_param_path", "fg_mask_path"] {
            frame[key] = json!(format!("../EMO-1/{}", frame[key].as_str().unwrap()));
        }
        // GaussianAvatars' own data has a field of view only: tan(angle / 2) = 320 / 640.
        for key in ["fl_x", "fl_y", "cx", "cy", "camera_angle_y"] {
            frame.as_object_mut().unwrap().remove(key);
        }
        frame["camera_angle_x"] = json!(2.0 * 0.5_f64.atan());
        frame
    };
    let put = |name: &str, frames: &[Value]| {
        put_text(&union.join(name), &json!({ "frames": frames }).to_string());
    };
    put("transforms_train.json", &[moved(0), moved(2)]);
    put("transforms_val.json", &[]);
    put("transforms_test.json", &[moved(1), moved(2)]);
    let found = read(&union).unwrap();
    let subsets: Vec<(u32, Subset)> =
        found.frames.iter().map(|frame| (frame.timestep, frame.subset)).collect();
    assert_eq!(subsets, [(0, Subset::Train), (1, Subset::Train), (1, Subset::Test)]);
    assert_eq!(found.frames[0].image, union.join("../EMO-1/images/00000_00.png"));
    // 640 pixels of focal length, for both axes.
    assert_pixel(&found.frames[2].camera, [0.1, 0.2, 0.0], [384.0, 112.0]);
}

#[test]
fn metrical_tracker() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let checkpoint = Checkpoint::default();
    metrical_folder(
        folder,
        &[("00000", checkpoint.clone()), ("00007", checkpoint.without_opencv())],
    );
    put_text(&folder.join("mesh/00007.ply"), "ply");
    put_text(&folder.join("canonical.obj"), "v 0 0 0");
    assert_eq!(detect(folder).unwrap(), Some(Tracker::MetricalTracker));
    let found = read(folder).unwrap();
    assert_eq!(found.canonical_mesh, Some(folder.join("canonical.obj")));
    let [opencv, optimised] = &found.frames[..] else { unreachable!() };
    assert_eq!((opencv.timestep, optimised.timestep), (0, 7));
    assert_eq!(opencv.image, folder.join("input/00000.png"));
    assert_eq!((&opencv.mesh, &optimised.mesh), (&None, &Some(folder.join("mesh/00007.ply"))));
    for frame in [opencv, optimised] {
        // 1 forward, 0.1 right, 0.2 up: 296 + 480 * 0.1, 252 - 480 * 0.2.
        assert_pixel(&frame.camera, [0.1, 0.2, 0.0], [344.0, 156.0]);
        assert_eq!(frame.camera.size, Size::new(640, 480));
        let flame = &frame.flame;
        // The jaw's first two rows are those of a quarter turn about z, which takes x to y.
        assert_turn(flame.jaw.unwrap(), [0.0, 0.0, FRAC_PI_2]);
        let [left, right] = flame.eyes.unwrap();
        assert_turn(left, [0.0; 3]);
        assert_turn(right, [FRAC_PI_2, 0.0, 0.0]);
        assert_eq!((&flame.expression[..], flame.eyelids), (&[0.5, -0.5][..], Some([0.25, 0.75])));
        assert_eq!((flame.rotation, flame.translation, flame.scale), ([0.0; 3], [0.0; 3], 1.0));
    }
    assert_eq!(found.shape[..], [1.0, 2.0, 3.0]);
}

#[test]
fn cameras_of_pytorch3d_multiply_rows() {
    let folder = tempfile::tempdir().unwrap();
    let turned = Checkpoint {
        six: [0.0, 1.0, 0.0, -1.0, 0.0, 0.0],
        translation: [0.0, 0.0, 2.0],
        principal_point: [0.0; 2],
        ..Checkpoint::default()
    };
    metrical_folder(folder.path(), &[("00000", turned.without_opencv())]);
    let found = read(folder.path()).unwrap();
    // [0.1, 0.2, 0] times the rows is [-0.2, 0.1, 0]: 2 forward, 0.2 right, 0.1 up.
    assert_pixel(&found.frames[0].camera, [0.1, 0.2, 0.0], [368.0, 216.0]);
}

fn insta_frame(name: &str) -> Value {
    // The inverse of metrical-tracker's `opencv` in `Checkpoint`.
    json!({
        "transform_matrix": [[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 1.0],
            [0.0, 0.0, 0.0, 1.0]],
        "file_path": format!("images/{name}.png"), "mesh_path": format!("meshes/{name}.obj"),
        "exp_path": format!("flame/exp/{name}.txt"), "depth_path": format!("depth/{name}.png"),
        "seg_mask_path": format!("seg_mask/{name}.png"),
    })
}

fn insta_folder(folder: &Path) -> Value {
    for name in ["00003", "00001"] {
        put_image(&folder.join(format!("images/{name}.png")), Size::new(4, 3));
        put_text(&folder.join(format!("flame/exp/{name}.txt")), "0.50000000\n-0.50000000\n");
        put_text(&folder.join(format!("meshes/{name}.obj")), "v 0 0 0");
    }
    put_text(&folder.join("canonical.obj"), "v 0 0 0");
    json!({
        "frames": [insta_frame("00003"), insta_frame("00001")], "w": 640.0, "h": 480.0,
        "fl_x": 480.0, "fl_y": 480.0, "cx": 296.0, "cy": 252.0, "camera_angle_x": 1.0,
        "camera_angle_y": 1.0, "x_fov": 57.0, "y_fov": 57.0, "integer_depth_scale": 0.001,
    })
}

#[test]
fn insta() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    put_text(&folder.join("transforms.json"), &insta_folder(folder).to_string());
    assert_eq!(detect(folder).unwrap(), Some(Tracker::Insta));
    let found = read(folder).unwrap();
    let [first, second] = &found.frames[..] else { unreachable!() };
    assert_eq!((first.timestep, second.timestep), (1, 3));
    assert_eq!(first.mesh, Some(folder.join("meshes/00001.obj")));
    assert_eq!(found.canonical_mesh, Some(folder.join("canonical.obj")));
    // As metrical-tracker's.
    assert_pixel(&first.camera, [0.1, 0.2, 0.0], [344.0, 156.0]);
    let flame = &first.flame;
    assert_eq!((&flame.expression[..], flame.jaw, flame.eyes), (&[0.5, -0.5][..], None, None));
    assert!(found.shape.is_empty());

    // Parameters that its script can be made to write.
    put_text(&folder.join("flame/jaw/00001.txt"), "0 -1 0 1 0 0");
    put_text(&folder.join("flame/shape/00001.txt"), "1\n2\n");
    let found = read(folder).unwrap();
    assert_turn(found.frames[0].flame.jaw.unwrap(), [0.0, 0.0, FRAC_PI_2]);
    // The mean, with 0 for the frame without.
    assert_eq!(found.frames[0].flame.shape[..], [1.0, 2.0]);
    assert_eq!(found.shape[..], [0.5, 1.0]);
}

fn imavatar_folder(folder: &Path) -> Value {
    put_image(&folder.join("image/1.png"), Size::new(256, 256));
    put_image(&folder.join("image/2.png"), Size::new(256, 128));
    put_image(&folder.join("mask/2.png"), Size::new(256, 128));
    let frame = |number: u32| {
        let pose: Vec<f32> = (0..15).map(|index| index as f32 / 16.0).collect();
        json!({
            "file_path": format!("./image/{number}"),
            "world_mat": [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -4.0]],
            "expression": [0.5, -0.5], "pose": pose, "bbox": [-1, -1, 1, 1],
            "flame_keypoints": [[0.0, 0.0]],
        })
    };
    json!({
        "frames": [frame(2), frame(1)], "intrinsics": [-3.0, 3.0, 0.5, 0.5],
        "shape_params": [1.0, 2.0],
    })
}

#[test]
fn imavatar() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut file = imavatar_folder(folder);
    put_text(&folder.join("flame_params.json"), &file.to_string());
    assert_eq!(detect(folder).unwrap(), Some(Tracker::Imavatar));
    let check = || {
        let found = read(folder).unwrap();
        let [first, second] = &found.frames[..] else { unreachable!() };
        assert_eq!((first.timestep, second.timestep), (1, 2));
        assert_eq!((&first.mask, &second.mask), (&None, &Some(folder.join("mask/2.png"))));
        // The world is 4 times as large: 4 forward, 0.4 right, 0.2 up. 128 + 768 * 0.4 / 4, and
        // 128 - 768 * 0.2 / 4 or 64 - 384 * 0.2 / 4.
        assert_pixel(&first.camera, [0.4, 0.2, 0.0], [204.8, 89.6]);
        assert_pixel(&second.camera, [0.4, 0.2, 0.0], [204.8, 44.8]);
        let flame = &first.flame;
        assert_eq!((flame.scale, &flame.shape[..]), (4.0, &[1.0, 2.0][..]));
        assert_eq!(flame.rotation, [0.0, 0.0625, 0.125]);
        assert_eq!(flame.neck, [0.1875, 0.25, 0.3125]);
        assert_eq!(flame.jaw, Some([0.375, 0.4375, 0.5]));
        assert_eq!(flame.eyes, Some([[0.5625, 0.625, 0.6875], [0.75, 0.8125, 0.875]]));
        assert_eq!(flame.expression, [0.5, -0.5]);
    };
    check();
    // The old form is in pixels of 512.
    file["intrinsics"] = json!([-1536.0, 1536.0, 256.0, 256.0]);
    put_text(&folder.join("flame_params.json"), &file.to_string());
    check();
}
