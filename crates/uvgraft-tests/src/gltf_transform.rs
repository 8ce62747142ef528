//! gltf-transform, which makes files like those in the wild: compressed with Draco or
//! meshoptimizer, with other image formats. `scripts/install-browser-packages.sh` installs it.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The program, run by Node.
#[derive(Debug)]
pub struct GltfTransform {
    script: PathBuf,
}

impl GltfTransform {
    /// `None`, with a message, if it is not installed.
    ///
    /// # Panics
    /// If it is not installed and `CI` is set.
    pub fn find() -> Option<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let script = root.join("target/browser/node_modules/@gltf-transform/cli/bin/cli.js");
        let node = Command::new("node").arg("--version").output();
        if script.is_file() && node.is_ok_and(|node| node.status.success()) {
            return Some(Self { script });
        }
        let reason = "there is no gltf-transform; scripts/install-browser-packages.sh installs it";
        assert!(std::env::var_os("CI").is_none(), "{reason}");
        #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
        {
            eprintln!("skipped: {reason}");
        }
        None
    }

    /// Runs one of its commands, such as `draco`, from one file to another.
    ///
    /// # Panics
    /// If it fails.
    pub fn run(&self, command: &str, from: &Path, to: &Path) {
        let output = Command::new("node").arg(&self.script).arg(command).args([from, to]).output();
        let output = output.expect("node, which was there before");
        let reported = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && to.is_file(), "{command}: {reported}");
    }
}
