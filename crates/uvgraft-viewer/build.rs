//! Locates the page that `scripts/build-viewer.sh` built, if it is to be embedded.

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_BUNDLED").is_none() {
        return;
    }
    let page = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default())
        .join("../../target/viewer/viewer.html");
    println!("cargo::rerun-if-changed={}", page.display());
    if page.is_file() {
        println!("cargo::rustc-env=UVGRAFT_VIEWER_PAGE={}", page.display());
    } else {
        println!(
            "cargo::error=the feature `viewer` (`bundled`) requires target/viewer/viewer.html; \
             run scripts/build-viewer.sh first, which needs npm"
        );
    }
}
