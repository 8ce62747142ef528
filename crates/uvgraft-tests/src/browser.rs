//! Avatars in a browser, and under Khronos' validator: what `browser/browser.mjs` does, for tests.
//!
//! `scripts/install-browser.sh` installs what that needs. Tests skip visibly where it is missing; where
//! `CI` is set they fail.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use serde::Deserialize;
use serde_json::{Value, json};

/// One browser at a time: tests run at once, and each browser draws with all processors.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Node with its packages, and Chromium.
#[derive(Debug)]
pub struct Browser {
    script: PathBuf,
}

/// What the validator says about a file.
#[derive(Debug, Deserialize)]
pub struct Validation {
    /// Rules of glTF that are broken.
    pub errors: u32,
    /// What is likely wrong.
    pub warnings: u32,
    /// Each message; the first hundred.
    pub messages: Vec<Value>,
}

impl Browser {
    /// `None`, with a message, where something is not installed.
    ///
    /// # Panics
    /// If it is not, and `CI` is set.
    pub fn find() -> Option<Self> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("browser/browser.mjs");
        let browser = Self { script };
        match browser.run("check", &json!({})) {
            Ok(_) => Some(browser),
            Err(reason) => {
                let reason = format!("{reason}scripts/install-browser.sh installs what is missing");
                assert!(std::env::var_os("CI").is_none(), "{reason}");
                #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
                {
                    eprintln!("skipped: {reason}");
                }
                None
            }
        }
    }

    /// What Khronos' validator says about GLB files, in their order.
    ///
    /// # Panics
    /// If it cannot be run, as all below.
    pub fn validate(&self, files: &[&Path]) -> Vec<Validation> {
        let found = self.run("validate", &json!({ "files": files }));
        serde_json::from_value(found.expect("a report")).expect("a report as validate.mjs gives it")
    }

    /// Loads a GLB or VRM with three.js and three-vrm and takes pictures of it.
    ///
    /// - `shots`: as `browser/shoot.mjs` takes them; it also tells what comes back.
    pub fn shoot(&self, file: &Path, shots: &Value) -> Value {
        self.run("shoot", &json!({ "file": file, "shots": shots })).expect("pictures")
    }

    /// Opens a page of `uvgraft view` from its file, and uses it.
    ///
    /// - `steps`: as `browser/viewer.mjs` takes them; it also tells what comes back.
    pub fn view(&self, page: &Path, steps: &Value) -> Value {
        let wanted = json!({ "file": page, "width": 900, "height": 600, "steps": steps });
        self.run("viewer", &wanted).expect("a page that works")
    }

    fn run(&self, command: &str, wanted: &Value) -> Result<Value, String> {
        let _turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let output = Command::new("node")
            .arg(&self.script)
            .args([command, &wanted.to_string()])
            .output()
            .map_err(|error| format!("node: {error}; "))?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
    }
}
