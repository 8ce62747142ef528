//! Loads avatars in a browser and runs Khronos' glTF validator, by means of `browser/browser.mjs`.
//!
//! `make test-setup` installs Chromium and Node, and `scripts/install-browser-packages.sh` packages from npm. Tests skip
//! visibly where something is missing;
//! where `CI` is set they fail.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use serde::Deserialize;
use serde_json::{Value, json};

/// One browser at a time: tests run in parallel, and each browser renders on all cores.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Node with its packages, and Chromium.
#[derive(Debug)]
pub struct Browser {
    script: PathBuf,
}

/// The validator's report on a file.
#[derive(Debug, Deserialize)]
pub struct Validation {
    /// Number of violations of the glTF specification.
    pub errors: u32,
    /// Number of likely mistakes.
    pub warnings: u32,
    /// The messages, at most a hundred.
    pub messages: Vec<Value>,
}

impl Browser {
    /// `None`, with a message, if something is not installed.
    ///
    /// # Panics
    /// If something is not installed and `CI` is set.
    pub fn find() -> Option<Self> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("browser/browser.mjs");
        let browser = Self { script };
        match browser.run("check", &json!({})) {
            Ok(_) => Some(browser),
            Err(reason) => {
                let reason = format!(
                    "{reason}`make test-setup` and \
                     scripts/install-browser-packages.sh install what is missing"
                );
                assert!(std::env::var_os("CI").is_none(), "{reason}");
                #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
                {
                    eprintln!("skipped: {reason}");
                }
                None
            }
        }
    }

    /// Validates GLB files with Khronos' validator; one report per file, in order.
    ///
    /// # Panics
    /// If it cannot be run; the methods below panic likewise.
    pub fn validate(&self, files: &[&Path]) -> Vec<Validation> {
        let found = self.run("validate", &json!({ "files": files }));
        serde_json::from_value(found.expect("a report")).expect("a report as validate.mjs gives it")
    }

    /// Loads a GLB or VRM with three.js and three-vrm and takes screenshots of it.
    ///
    /// - `shots`: as described in `browser/shoot.mjs`, along with the result.
    pub fn shoot(&self, file: &Path, shots: &Value) -> Value {
        self.run("shoot", &json!({ "file": file, "shots": shots })).expect("pictures")
    }

    /// Opens a page written by `uvgraft view` from its file, and interacts with it.
    ///
    /// - `steps`: as described in `browser/viewer.mjs`, along with the result.
    pub fn view(&self, page: &Path, steps: &Value) -> Value {
        let request = json!({ "file": page, "width": 900, "height": 600, "steps": steps });
        self.run("viewer", &request).expect("a page that works")
    }

    fn run(&self, command: &str, request: &Value) -> Result<Value, String> {
        let _turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let output = Command::new("node")
            .arg(&self.script)
            .args([command, &request.to_string()])
            .output()
            .map_err(|error| format!("node: {error}; "))?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
    }
}
