//! Array files written by NumPy, SciPy, chumpy and torch, by means of `array_samples/make.py`.

use std::path::{Path, PathBuf};

use uvgraft_io::arrays::{self, ArraysError, NamedArrays, NumericArray};
use uvgraft_io::{fate, torch};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/array_samples").join(name)
}

fn sample(name: &str) -> NamedArrays {
    arrays::read(path(name)).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn check(arrays: &NamedArrays, name: &str, shape: &[usize], values: &[f64]) {
    let array = arrays.require(name).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((array.shape(), &*array.f64s()), (shape, values), "{name}");
}

const REGRESSOR: [f64; 8] = [0.0, 0.5, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0];

fn counted(count: u32, factor: f64) -> Vec<f64> {
    (0..count).map(|number| f64::from(number) * factor).collect()
}

#[test]
fn models_as_python_2_pickled_them() {
    for name in ["python2_protocol0.pkl", "python2_protocol2.pkl"] {
        let model = sample(name);
        check(&model, "v_template", &[2, 3], &counted(6, 1.0));
        check(&model, "shapedirs", &[2, 3, 2], &counted(12, 0.25));
        check(&model, "first_direction", &[2, 3, 1], &counted(6, 0.5));
        check(&model, "J_regressor", &[2, 4], &REGRESSOR);
        assert_eq!(model.get("f").unwrap().integers().unwrap(), [0, 1, 2, 2, 1, 0]);
        let parents = model.get("kintree_table").unwrap();
        assert_eq!(parents.integers().unwrap(), [4_294_967_295, 0, 0, 1]);
        assert_eq!(model.text("bs_type"), Some("lrotmin"));
        assert_eq!(model.names().count(), 7, "{name}");
    }
}

#[test]
fn a_model_as_python_3_pickles_it() {
    let model = sample("python3_protocol4.pkl");
    check(&model, "shapedirs", &[2, 3, 2], &counted(12, 0.25));
    for matrix in ["csc", "csr", "coo"] {
        check(&model, matrix, &[2, 4], &REGRESSOR);
    }
    check(&model, "rows", &[2, 2], &[1.0, 2.0, 3.0, 4.0]);
    check(&model, "frames.rate", &[], &[30.0]);
    check(&model, "frames.count", &[], &[7.0]);
    assert_eq!(model.text("gender"), Some("female"));
}

#[test]
fn a_deflated_npz_of_every_kind() {
    let model = sample("deflated.npz");
    check(&model, "v_template", &[2, 3], &counted(6, 1.0));
    let smallest = 2.0_f64.powi(-24);
    check(&model, "half", &[5], &[1.0, 0.5, -2.0, smallest, f64::INFINITY]);
    check(&model, "big", &[1, 2], &[1.5, -2.5]);
    check(&model, "f", &[1, 3], &[0.0, 1.0, 2.0]);
    check(&model, "kintree_table", &[2, 2], &[4_294_967_295.0, 0.0, 0.0, 1.0]);
    check(&model, "hidden", &[2], &[1.0, 0.0]);
    check(&model, "mocap_framerate", &[], &[120.0]);
    check(&model, "J_regressor", &[2, 4], &REGRESSOR);
    check(&model, "joint2num.Pelvis", &[], &[0.0]);
    assert_eq!((model.text("gender"), model.text("gender_bytes")), (Some("neutral"), Some("male")));
    let when = model.require("when").unwrap_err().to_string();
    assert_eq!(when, "array `when` cannot be used: an array of dtype `<M8[D]`");
    let missing = model.require("weights").unwrap_err();
    assert!(matches!(&missing, ArraysError::Missing { names, .. } if names.len() == 11));
}

#[test]
fn tensors() {
    let found = sample("tensors.pth");
    assert_eq!(torch::read(path("tensors.pth")).unwrap(), found);
    check(&found, "plain", &[2, 3], &counted(6, 1.0));
    check(&found, "turned", &[3, 2], &[0.0, 3.0, 1.0, 4.0, 2.0, 5.0]);
    check(&found, "column", &[2], &[1.0, 4.0]);
    check(&found, "parameter", &[1], &[0.25]);
    check(&found, "half", &[2], &[1.5, -2.0]);
    check(&found, "brain", &[2], &[1.5, -2.0]);
    check(&found, "double", &[], &[0.1]);
    assert_eq!(found.get("long").unwrap().integers().unwrap(), [-1, 1 << 40]);
    check(&found, "bytes", &[1], &[255.0]);
    check(&found, "bools", &[2], &[1.0, 0.0]);
    check(&found, "layer.weight", &[1], &[3.0]);
    check(&found, "epoch", &[], &[7.0]);
    let bare = torch::read(path("bare.pth")).unwrap();
    check(&bare, "", &[2, 3], &counted(6, 1.0));
    assert_eq!(bare.names().collect::<Vec<_>>(), [""]);
}

#[test]
fn other_files_of_torch_are_refused_by_name() {
    for (name, wanted) in [
        ("script.pt", "got a TorchScript program"),
        ("before_1_6.pth", "got a torch file from before version 1.6"),
        ("deflated.npz", "got an archive without data.pkl"),
        ("make.py", "got a file that starts with `"),
    ] {
        let error = torch::read(path(name)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(wanted), "{error}");
    }
    for name in ["script.pt", "before_1_6.pth", "make.py"] {
        assert!(matches!(
            arrays::parse(&std::fs::read(path(name)).unwrap()),
            Err(ArraysError::Foreign { .. })
        ));
    }
}

/// The dump's colours are ramps from 0.1 to 0.9, of u in red and of v in green; its opacity is a
/// value whose sigmoid runs from 0.2 to 0.8. All its tensors are in one storage.
#[test]
fn a_dump_of_fate() {
    for size in [8, 16] {
        let read = fate::read(path("fate_tex_dump.pth"), size).unwrap();
        let (color, confidence) = (read.texture.color, read.texture.confidence.unwrap());
        for at in 0..size {
            let centre = (at as f32 + 0.5) / size as f32;
            let found = [color.get(at, 3, 0), color.get(3, at, 1), color.get(at, at, 2)];
            let wanted = [0.1 + 0.8 * centre, 0.9 - 0.8 * centre, 0.5];
            for (found, wanted) in found.into_iter().zip(wanted) {
                // The sample went through atanh and back, in floats.
                assert!((found - wanted).abs() < 1e-6, "{size} {at}: {found}, not {wanted}");
            }
            // Between its texels the opacity is interpolated before the sigmoid, not after.
            let found = confidence.get(at, 0, 0);
            assert!((found - (0.2 + 0.6 * centre)).abs() < 3e-3, "{size} {at}: {found}");
        }
    }
}

#[test]
fn what_is_written_is_read() {
    let mut arrays = NamedArrays::new();
    arrays.insert("poses", NumericArray::new_f64(vec![2, 2], counted(4, 0.1)).unwrap());
    arrays.insert("trans", NumericArray::new_f32(vec![1, 3], vec![0.5, -1.0, 2.0]).unwrap());
    arrays.insert("ids", NumericArray::new_i64(vec![0, 3], vec![]).unwrap());
    arrays.insert("rate", NumericArray::new_i64(vec![], vec![-60]).unwrap());
    arrays.insert_text("gender", "weiblich ♀");
    arrays.insert_text("empty", "");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motion.npz");
    arrays::save_npz(&arrays, &path).unwrap();
    assert_eq!(arrays::read(&path).unwrap(), arrays);
    let first = std::fs::read(&path).unwrap();
    arrays::save_npz(&arrays, &path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), first);

    let path = folder.path().join("tensors.pth");
    torch::save_pth(&arrays, &path).unwrap();
    let found = torch::read(&path).unwrap();
    assert_eq!(found.names().collect::<Vec<_>>(), ["poses", "trans", "ids", "rate"]);
    for name in found.names() {
        let (found, wanted) = (found.get(name).unwrap(), arrays.get(name).unwrap());
        assert_eq!((found.shape(), found.f32s()), (wanted.shape(), wanted.f32s()), "{name}");
    }
}
