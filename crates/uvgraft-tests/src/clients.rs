//! Loads avatars in the programs that people open them with: Blender and Godot, both headless.
//!
//! `make test-setup` installs them, and `make test-clients` enables their tests by
//! setting `UVGRAFT_CLIENTS`; elsewhere these skip visibly, since Blender alone takes half a
//! gigabyte.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde::Deserialize;

/// Time limit for an import.
const IMPORT_AT_MOST: Duration = Duration::from_secs(120);

/// What a program reports about a file.
#[derive(Debug, Deserialize)]
pub struct Loaded {
    /// Number of joints in all skeletons.
    pub bones: usize,
    /// Number of triangles in all meshes.
    pub triangles: usize,
    /// Names of morph targets, sorted.
    pub morphs: Vec<String>,
    /// Names of animations, sorted.
    pub animations: Vec<String>,
    /// Number of materials.
    pub materials: usize,
    /// Number of images, if the program reports it.
    #[serde(default)]
    pub images: Option<usize>,
    /// Height of the lowest vertex at rest, in metres, if the program reports it.
    #[serde(default)]
    pub lowest_m: Option<f32>,
}

/// A program that loads avatars.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Client {
    /// Debian's `blender`.
    Blender,
    /// Debian's `godot3-server`.
    Godot,
}

impl Client {
    const fn program(self) -> &'static str {
        match self {
            Self::Blender => "blender",
            Self::Godot => "godot3-server",
        }
    }

    /// Itself if its tests are enabled and it is installed; else `None`, with a message.
    ///
    /// # Panics
    /// If its tests are enabled and `CI` is set, but it is not installed.
    pub fn find(self) -> Option<Self> {
        let program = self.program();
        if std::env::var_os("UVGRAFT_CLIENTS").is_none() {
            #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
            {
                eprintln!("skipped: `make test-clients` loads avatars with {program}");
            }
            return None;
        }
        let is_there = Command::new(program).arg("--version").output().is_ok();
        if !is_there {
            assert!(std::env::var_os("CI").is_none(), "there is no {program}");
            #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
            {
                eprintln!("skipped: there is no {program}; `make test-setup` installs it");
            }
        }
        is_there.then_some(self)
    }

    /// Loads a GLB or VRM file.
    ///
    /// - `folder`: an empty folder for the program's own files.
    ///
    /// # Panics
    /// If loading fails.
    pub fn load(self, file: &Path, folder: &Path) -> Loaded {
        let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("clients");
        let output = match self {
            Self::Blender => Command::new(self.program())
                .args(["--background", "--factory-startup", "--python-exit-code", "1", "--python"])
                .arg(scripts.join("blender.py"))
                .arg("--")
                .arg(file)
                .output(),
            Self::Godot => {
                let copied = |from: PathBuf, name: &str| {
                    std::fs::copy(from, folder.join(name)).expect("a copy in the folder");
                };
                copied(file.to_path_buf(), "avatar.glb");
                copied(scripts.join("count.gd"), "count.gd");
                let project = "config_version=4\n[application]\nconfig/name=\"avatars\"\n";
                std::fs::write(folder.join("project.godot"), project).expect("a project");
                import(self.program(), folder);
                Command::new(self.program())
                    .arg("--path")
                    .arg(folder)
                    .args(["--script", "count.gd"])
                    .env("HOME", folder)
                    .output()
            }
        };
        let output = output.expect("a program that runs");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let found = text.lines().find_map(|line| line.strip_prefix("FOUND "));
        let errors = String::from_utf8_lossy(&output.stderr);
        let found = found.unwrap_or_else(|| panic!("{self:?}: {text}\n{errors}"));
        serde_json::from_str(found).expect("what the scripts print")
    }
}

/// Imports a Godot project's files, as the editor does when it opens a project.
///
/// The editor may hang in spite of `--quit`, so it is killed once the files that it writes last
/// exist.
fn import(program: &str, project: &Path) {
    let mut editor = Command::new(program)
        .arg("--path")
        .arg(project)
        .args(["--editor", "--quit"])
        .env("HOME", project)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("an editor");
    let is_imported = || {
        let imported = std::fs::read_dir(project.join(".import"));
        imported.is_ok_and(|files| {
            files.flatten().any(|file| file.path().extension().is_some_and(|end| end == "md5"))
        })
    };
    let begin = Instant::now();
    while begin.elapsed() < IMPORT_AT_MOST && !is_imported() {
        if editor.try_wait().expect("an editor that can be waited for").is_some() {
            break;
        }
        sleep(Duration::from_millis(50));
    }
    // Fails if the editor has exited by itself.
    let _ = editor.kill();
    editor.wait().expect("an editor that can be waited for");
    assert!(is_imported(), "{program} imported nothing in {:?}", begin.elapsed());
}
