//! The requests compiled for WebAssembly make under Node what they make here.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use uvgraft::{Size, Texels, Texture};
use uvgraft_assembly::{AvatarRequest, Body};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_pipeline::BaseSource;
use uvgraft_tests::downloads;

use crate::bench::Bench;

const SIDE: u32 = 256;

/// The module of the library's example `web`; `None` where it is not built, with a message.
#[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
fn module() -> Option<PathBuf> {
    let module = std::env::var_os("UVGRAFT_WEB_MODULE").map(PathBuf::from);
    if module.is_none() {
        eprintln!("skipped: `make test-web` makes avatars in WebAssembly");
    }
    module
}

/// Calls a function of the module; its answer is a file of the bench.
fn call(bench: &Bench, module: &Path, words: &[&str]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/run-web.mjs");
    let output = Command::new("node")
        .args([&script, module])
        .args(words)
        .current_dir(bench.path(""))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words:?}: {said}");
}

/// Asserts that two textures show the same.
///
/// WebAssembly has sines and exponentials of Rust's library, which differ from the C library's in the last bits, and after
/// them decisions of some texels: by 3 of 255 at most, on the inputs below.
fn assert_close(found: &Texture, wanted: &Texture) {
    assert_eq!(found.size(), wanted.size());
    let (Texels::U8(found), Texels::U8(wanted)) = (found.texels(), wanted.texels()) else {
        panic!("not 8 bits");
    };
    let differences = found.iter().zip(wanted).map(|(a, b)| a.abs_diff(*b));
    assert!(differences.max().is_some_and(|largest| largest <= 6));
}

fn picture(bench: &Bench, avatar: &str) -> Texture {
    bench.make(&format!("render {avatar} -o picture.png --size 192x256"));
    bench.texture("picture.png")
}

#[test]
fn the_figure() {
    let Some(module) = module() else { return };
    let figure = Figure::new();
    let bench = Bench::of_figure(&figure, SIDE);
    call(&bench, &module, &["figure", &SIDE.to_string(), "there.glb"]);
    bench.assert_valid(&["there.glb"]);

    bench.save("painted_face.png", paint_head(&figure, Size::square(SIDE)));
    bench.save("painted_body.png", paint_body(&figure, Size::square(SIDE)));
    let mut request = AvatarRequest::new(Body::Figure, "here.glb");
    request.face = Some(bench.path("painted_face.png").into());
    request.onto = Some(BaseSource::image(bench.path("painted_body.png")));
    std::fs::write(bench.path("here.glb"), request.make(&()).unwrap().file).unwrap();
    assert_close(&picture(&bench, "there.glb"), &picture(&bench, "here.glb"));
}

#[test]
fn a_photograph() {
    let Some(module) = module() else { return };
    let (Some(package), Some(photo)) =
        (downloads::face_mesh_package(), downloads::photograph("astronaut"))
    else {
        return;
    };
    let bench = Bench::of_figure(&Figure::new(), SIDE);
    bench.run_args(&["weights", "import", package.to_str().unwrap()]);
    bench.save("astronaut.png", photo);
    let [photo, networks] = ["astronaut.png", "faces.safetensors"];
    call(&bench, &module, &["selfie", "512", photo, networks, "there.png"]);
    bench.make("selfie astronaut.png --head demo --size 512 -o here.png");
    assert_close(&bench.texture("there.png"), &bench.texture("here.png"));
    call(&bench, &module, &["avatar", photo, networks, "there.glb"]);
    bench.assert_valid(&["there.glb"]);
    bench.make("avatar --selfie astronaut.png --body demo -o here.glb");
    assert_close(&picture(&bench, "there.glb"), &picture(&bench, "here.glb"));
}
