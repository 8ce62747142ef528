//! Exported maps in the tools that they are for: SciPy, OpenCV, OpenEXR, and PyTorch where it is
//! installed.
//!
//! `make test-clients` installs the Python packages and enables this; elsewhere it is skipped.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::exports::{figure, map, positions};
use uvgraft_io::arrays::{self, NamedArrays, NumericArray};

/// The Python with the packages; `None` where it is not asked for or missing, with a message.
#[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
fn python() -> Option<PathBuf> {
    if std::env::var_os("UVGRAFT_CLIENTS").is_none() {
        eprintln!("skipped: `make test-clients` applies exported maps in Python");
        return None;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let python = root.join("target/tools-venv/bin/python");
    if root.join("target/tools-venv/installed.txt").is_file() {
        return Some(python);
    }
    assert!(std::env::var_os("CI").is_none(), "there is no {}", python.display());
    eprintln!("skipped: make test-clients installs what is missing");
    None
}

#[test]
fn other_tools_agree() {
    let Some(python) = python() else { return };
    let bench = figure();
    let size = "--size 480x520";
    bench.succeed("map demo.uvpair --size 150x160 --source-size 72x64 -o h.csr.npz");
    bench.succeed("transfer demo.uvpair face.png --size 150x160 -o transfer.png");
    bench.succeed(&format!("map demo.uvpair {size} -o grid.npy"));
    bench.succeed(&format!("map demo.uvpair {size} -o reference.npz"));
    let exact = "--convention exact --source-size 72x64";
    bench.succeed(&format!("map demo.uvpair {size} {exact} -o exact.npz"));
    bench.succeed(&format!("map demo.uvpair {size} -o st.exr"));
    bench.succeed("transfer padded.png --with-map grid.npy --filter bilinear -o one_sample.png");
    let map = map(&bench);
    let single = positions(&map).into_iter().map(|position| matches!(position, Some((_, true))));
    let shape = [map.size().height, map.size().width].map(|side| side as usize);
    let mut named = NamedArrays::new();
    let single: Vec<i64> = single.map(i64::from).collect();
    named.insert("single", NumericArray::new_i64(shape.to_vec(), single).unwrap());
    arrays::save_npz(&named, bench.path("single.npz")).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/other_tools/check.py");
    let output = Command::new(python).arg(script).arg(bench.path(".")).output().unwrap();
    let [out, errors] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(output.status.success(), "{out}{errors}");
    println!("{out}");
}
