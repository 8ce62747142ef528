//! Folders that are damaged, foreign or malicious: errors that name the file.

use super::frames::archive;
use super::*;

#[track_caller]
fn refused(folder: &Path, wanted: &[&str]) {
    let found = read(folder).unwrap_err().to_string();
    for wanted in wanted {
        assert!(found.contains(wanted), "found:  {found}\nwanted: {wanted}");
    }
}

/// Reads the folder of a data set after each change of its JSON.
fn each_change(file: &str, make: fn(&Path) -> Value, changes: &[(&str, Value, &[&str])]) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let whole = make(folder);
    put_text(&folder.join(file), &whole.to_string());
    read(folder).unwrap();
    for (pointer, value, wanted) in changes {
        let mut changed = whole.clone();
        *changed.pointer_mut(pointer).unwrap() = value.clone();
        put_text(&folder.join(file), &changed.to_string());
        let found = read(folder).unwrap_err().to_string();
        for wanted in *wanted {
            assert!(found.contains(wanted), "{pointer}: {found}\nwanted: {wanted}");
        }
        assert!(found.contains(&*folder.to_string_lossy()), "{pointer}: {found}");
    }
}

#[test]
fn foreign_folders() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(detect(folder).unwrap(), None);
    put_image(&folder.join("photo.png"), Size::new(4, 3));
    assert_eq!(detect(folder).unwrap(), None);
    refused(folder, &["must be a folder of VHAP (transforms.json"]);
    assert!(detect(&folder.join("none")).unwrap_err().to_string().contains("none"));
    assert!(detect(&folder.join("photo.png")).is_err());
    // Other data sets of the same form.
    let frame = json!({ "file_path": "photo.png", "transform_matrix": along_z() });
    put_text(&folder.join("transforms.json"), &json!({ "frames": [frame] }).to_string());
    put_text(&folder.join("flame_params.json"), &json!({ "frames": [{ "x": 1 }] }).to_string());
    assert_eq!(detect(folder).unwrap(), None);
    std::fs::remove_file(folder.join("transforms.json")).unwrap();
    put_text(&folder.join("tracked_flame_params_30.npz"), "PK");
    refused(folder, &["VHAP's parameters (tracked_flame_params_30.npz) without images", "export"]);
}

#[test]
fn damaged_json() {
    for file in ["transforms.json", "flame_params.json"] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        for text in ["", "{", "[]", "{\"frames\": 3}", "{\"frames\": [", "\u{0}\u{1}"] {
            put_text(&folder.join(file), text);
            refused(folder, &[file, "must be the JSON of "]);
        }
        let deep = format!("{{\"frames\": [{}", "[".repeat(100_000));
        put_text(&folder.join(file), &deep);
        refused(folder, &[file]);
        put_text(&folder.join(file), "{\"frames\": []}");
        refused(folder, &["must be a folder of VHAP"]);
    }
}

#[test]
fn vhap() {
    let mirrored = json!([[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]]);
    each_change(
        "transforms.json",
        vhap_folder,
        &[
            ("/frames/1/file_path", json!("images/none.png"), &["images/none.png"]),
            (
                "/frames/1/file_path",
                json!("/etc/passwd"),
                &["frame 1: `file_path`", "`/etc/passwd`"],
            ),
            (
                "/frames/2/fg_mask_path",
                json!("../../x.png"),
                &["frame 2: `fg_mask_path`", "beside"],
            ),
            ("/frames/1/flame_param_path", json!("none.npz"), &["none.npz"]),
            ("/frames/1/flame_param_path", json!("images/00000_00.png"), &["NPZ archive", "PNG"]),
            (
                "/frames/1/flame_param_path",
                Value::Null,
                &["frame 1: `flame_param_path`", "nothing"],
            ),
            (
                "/frames/1/transform_matrix",
                mirrored,
                &["frame 1: `transform_matrix` must be a rotation"],
            ),
            ("/frames/1/transform_matrix", json!([[1, 0, 0, 0]]), &["transforms.json", "length 4"]),
            (
                "/frames/1/fl_x",
                json!(-3),
                &["frame 1: `focal length x` must be above 0 pixels, got -3"],
            ),
            ("/frames/1/w", json!(640.5), &["frame 1: `width` must be a number of pixels"]),
            ("/frames/1/h", json!(1e12), &["frame 1: `height` must be a number of pixels"]),
            ("/frames/1/camera_id", json!([1]), &["a string or an integer"]),
            ("/frames/1/timestep_index", json!(-1), &["transforms.json", "line 1"]),
        ],
    );
}

#[test]
fn parameters_of_vhap() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    put_text(&folder.join("transforms.json"), &vhap_folder(folder).to_string());
    let path = folder.join("flame_param/00001.npz");
    let change = |name: &str, shape: &[usize], value: f32| {
        let mut arrays = crate::arrays::read(folder.join("flame_param/00000.npz")).unwrap();
        let values = vec![value; shape.iter().product()];
        arrays.insert(name, NumericArray::new_f32(shape.to_vec(), values).unwrap());
        save_npz(&arrays, &path).unwrap();
    };
    for (name, shape, value, wanted) in [
        (
            "shape",
            &[2, 300][..],
            0.0,
            "must be of shape [n] or [1, n], with n up to 1000, got [2, 300]",
        ),
        ("expr", &[1, 1001], 0.0, "n up to 1000, got [1, 1001]"),
        ("rotation", &[1, 6], 0.0, "`rotation` must be 3 numbers, got 6"),
        ("jaw_pose", &[1, 3], f32::NAN, "`jaw_pose` must be finite, got NaN"),
        ("static_offset", &[5, 2], 0.0, "`static_offset` must be of shape [1, n, 3]"),
    ] {
        change(name, shape, value);
        refused(folder, &["00001.npz", wanted]);
    }
    let mut arrays = crate::arrays::read(folder.join("flame_param/00000.npz")).unwrap();
    arrays.take("neck_pose").unwrap();
    save_npz(&arrays, &path).unwrap();
    refused(folder, &["00001.npz: no array `neck_pose`"]);
}

#[test]
fn metrical_tracker() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let sound = Checkpoint::default();
    let put = |bytes: &[u8]| std::fs::write(folder.join("checkpoint/00000.frame"), bytes).unwrap();
    metrical_folder(folder, &[("00000", sound.clone())]);
    let bytes = sound.bytes();
    for cut in (0..bytes.len()).step_by(97) {
        put(&bytes[..cut]);
        refused(folder, &["00000.frame"]);
    }
    put(&archive(b"\x80\x02cos\nsystem\nX\x04\0\0\0true\x85R."));
    refused(folder, &["00000.frame", "refused: the pickle imports os.system"]);
    put(&archive(b"\x80\x02}."));
    refused(folder, &["00000.frame: no array `img_size`"]);
    let cases = [
        (Checkpoint { jaw: vec![0.0; 6], ..sound.clone() }, "`flame.jaw` must be two independent"),
        (Checkpoint { jaw: vec![0.0; 3], ..sound.clone() }, "`flame.jaw` must be 6 numbers, got 3"),
        (Checkpoint { six: [0.0; 6], ..sound.without_opencv() }, "`camera.R` must be two"),
        (
            Checkpoint { focal_length: -1.0, ..sound.without_opencv() },
            "`focal length x` must be above 0 pixels, got -240",
        ),
        (
            Checkpoint { translation: [f32::NAN; 3], ..sound.without_opencv() },
            "`camera.t` must be 3 finite numbers",
        ),
    ];
    for (checkpoint, wanted) in cases {
        put(&checkpoint.bytes());
        refused(folder, &["00000.frame", wanted]);
    }
    put(&bytes);
    std::fs::remove_file(folder.join("input/00000.png")).unwrap();
    refused(folder, &["input/00000.png"]);
}

#[test]
fn insta() {
    each_change(
        "transforms.json",
        insta_folder,
        &[
            (
                "/frames/1/file_path",
                json!("../x.png"),
                &["frame 1: `file_path`", "within the folder"],
            ),
            ("/frames/1/exp_path", json!("none.txt"), &["none.txt"]),
            ("/frames/1/exp_path", Value::Null, &["frame 1: `exp_path`"]),
            (
                "/frames/1/exp_path",
                json!("canonical.obj"),
                &["canonical.obj: `coefficients`", "`v`"],
            ),
            ("/frames/1/exp_path", json!("images/00001.png"), &["00001.png", "UTF-8"]),
            ("/w", Value::Null, &["frame 0: `w` must be a number, got nothing"]),
        ],
    );
}

#[test]
fn imavatar() {
    each_change(
        "flame_params.json",
        imavatar_folder,
        &[
            ("/frames/1/file_path", json!("./image/9"), &["image/9.png"]),
            ("/frames/1/file_path", json!("../image/1"), &["frame 1: `file_path`"]),
            ("/frames/1/pose", json!([0.0]), &["frame 1: `pose` must be 15 numbers, got 1"]),
            ("/frames/1/world_mat", json!([[1, 0, 0, 0]]), &["frame 1: `world_mat`", "3×4 or 4×4"]),
            (
                "/frames/1/expression",
                json!(vec![0.0; 1001]),
                &["frame 1: `expression` must be at most"],
            ),
            (
                "/intrinsics",
                json!([3, 3, 0.5, 0.5]),
                &["`intrinsics`", "a negative and a positive"],
            ),
            ("/intrinsics", json!([0, 3, 0.5, 0.5]), &["`intrinsics`"]),
            (
                "/shape_params",
                json!(vec![0.0; 1001]),
                &["`shape_params` must be at most 1000 numbers"],
            ),
        ],
    );
}
