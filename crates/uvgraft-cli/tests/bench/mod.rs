//! A folder with two small meshes, their vertex map and their pair, in which to run the program.
//!
//! Both layouts contain the same sheet of 4×4 quads: from 0.1 to 0.9 in the source, and at the top
//! left of the target from 0.1 to 0.5. The target has one more quad, which is not linked.

#![allow(dead_code, reason = "each test file uses a part of it")]
#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

pub mod charts;
pub mod plane;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;
use uvgraft::{Channels, Depth, Encoding, Mesh, Pair, Size, Texels, Texture};
use uvgraft_figure::{Figure, paint_body_in_tone, paint_head};
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_io::pair_file::PairFile;
use uvgraft_io::{obj, pair_file, vertex_map};
use uvgraft_tests::browser::Browser;

/// Vertices of the sheet; the target has four more.
pub const SHEET_VERTICES: u32 = 25;
pub const TARGET_VERTICES: u32 = 29;

pub struct Bench {
    folder: TempDir,
}

/// The result of running the program.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    /// Without the closing lines.
    pub stderr: String,
    /// The lines that say what was written and how to look at it.
    pub closing: String,
}

impl Bench {
    /// Creates `source.obj`, `target.obj`, `ids.npy` and `my.uvpair`.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let [source, target] = [source(), target()];
        let ids: Vec<u32> = (0..SHEET_VERTICES).map(target_of).collect();
        obj::save(&source, folder.path().join("source.obj")).unwrap();
        obj::save(&target, folder.path().join("target.obj")).unwrap();
        vertex_map::save_npy(&ids, folder.path().join("ids.npy")).unwrap();
        let ids: Vec<i64> = ids.into_iter().map(i64::from).collect();
        let file = pair_file::PairFile {
            pair: Pair::by_vertex_map(source, target, &ids).unwrap().into(),
            source_name: "source.obj".to_owned(),
            target_name: "target.obj".to_owned(),
            note: "synthetic".to_owned(),
        };
        pair_file::write(&file, folder.path().join("my.uvpair")).unwrap();
        Self { folder }
    }

    /// Adds the demo's figure: `demo.uvpair`, `face.png`, and `base.png` with darker skin.
    pub fn of_figure(figure: &Figure, side: u32) -> Self {
        let bench = Self::new();
        let size = Size::square(side);
        bench.save("face.png", paint_head(figure, size));
        bench.save("base.png", paint_body_in_tone(figure, size, [0.7, 0.65, 0.6]));
        let (head, body) = (figure.head.clone(), figure.body.clone());
        bench.save_pair("demo.uvpair", head, body, &figure.vertex_map);
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn exists(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    pub fn make_folder(&self, name: &str) {
        std::fs::create_dir_all(self.path(name)).unwrap();
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// Writes a copy of a file with its bytes changed.
    pub fn derive(&self, name: &str, from: &str, change: impl FnOnce(&mut Vec<u8>)) {
        let mut bytes = self.bytes(from);
        change(&mut bytes);
        self.write(name, bytes);
    }

    pub fn image(&self, name: &str) -> Image {
        image::read(self.path(name)).unwrap_or_else(|error| panic!("{error}"))
    }

    pub fn texture(&self, name: &str) -> Texture {
        self.image(name).texture
    }

    /// Writes an image of one colour.
    pub fn paint(&self, name: &str, size: (u32, u32), channels: Channels, color: &[u8]) {
        let size = Size::new(size.0, size.1);
        let texels = Texels::U8(color.repeat(size.texels()));
        self.save(name, Texture::new(size, channels, Encoding::Srgb, texels).unwrap());
    }

    /// Writes a 64 by 64 greyscale image, its left half of one value and its right half of another.
    pub fn paint_halves(&self, name: &str, [left, right]: [u8; 2]) {
        let row = [[left; 32], [right; 32]].concat();
        let texels = Texels::U8(row.repeat(64));
        let texture = Texture::new(Size::square(64), Channels::Grey, Encoding::Srgb, texels);
        self.save(name, texture.unwrap());
    }

    /// Writes an image with a pseudo-random value in each texel, deterministic for a name's size.
    pub fn paint_noise(&self, name: &str, size: (u32, u32), channels: Channels, depth: Depth) {
        let size = Size::new(size.0, size.1);
        let count = size.texels() * channels.count();
        let mut state = 7u32;
        let mut next = || {
            // Any generator without visible patterns will do; this is Numerical Recipes' `ranqd1`.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as u16
        };
        let texels = match depth {
            Depth::U8 => Texels::U8((0..count).map(|_| (next() >> 8) as u8).collect()),
            Depth::U16 => Texels::U16((0..count).map(|_| next()).collect()),
            Depth::F32 => Texels::F32((0..count).map(|_| f32::from(next()) / 65_535.0).collect()),
        };
        let encoding = if depth == Depth::F32 { Encoding::Linear } else { Encoding::Srgb };
        self.save(name, Texture::new(size, channels, encoding, texels).unwrap());
    }

    /// Writes an 8-bit image, its texels a function of position.
    pub fn draw<const C: usize>(
        &self,
        name: &str,
        size: (u32, u32),
        color: impl Fn(u32, u32) -> [u8; C],
    ) {
        let channels = [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba][C - 1];
        let size = Size::new(size.0, size.1);
        let count = size.texels() as u32;
        let texels = (0..count).flat_map(|k| color(k % size.width, k / size.width)).collect();
        self.save(name, Texture::new(size, channels, Encoding::Srgb, Texels::U8(texels)).unwrap());
    }

    /// Writes an image losslessly.
    pub fn save(&self, name: &str, texture: Texture) {
        let written =
            image::write(&texture.into(), self.path(name), &WriteOptions::default()).unwrap();
        assert_eq!(written.losses, [], "{name}");
    }

    /// Everything in the folder: files with their bytes, links with their targets, folders.
    pub fn content(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut content = BTreeMap::new();
        let mut folders = vec![self.folder.path().to_path_buf()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                let found = if path.is_symlink() {
                    format!("link to {}", path.read_link().unwrap().display()).into_bytes()
                } else if path.is_dir() {
                    folders.push(path.clone());
                    b"folder".to_vec()
                } else {
                    std::fs::read(&path).unwrap()
                };
                content.insert(path.strip_prefix(self.folder.path()).unwrap().to_owned(), found);
            }
        }
        content
    }

    /// Runs the program in the folder, with arguments separated by spaces.
    pub fn run(&self, args: &str) -> Run {
        self.run_args(&args.split_whitespace().collect::<Vec<_>>())
    }

    /// Writes the pair of a head and a body, given the body's vertex for each of the head's.
    pub fn save_pair(&self, name: &str, head: Mesh, body: Mesh, ids: &[u32]) {
        let ids: Vec<i64> = ids.iter().map(|&id| i64::from(id)).collect();
        let file = PairFile {
            pair: Pair::by_vertex_map(head, body, &ids).unwrap().into(),
            source_name: "head".to_owned(),
            target_name: "body".to_owned(),
            note: String::new(),
        };
        pair_file::write(&file, self.path(name)).unwrap();
    }

    pub fn run_args(&self, args: &[&str]) -> Run {
        let output = self.command().args(args).stdin(Stdio::null()).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        let lines = stderr.split_inclusive('\n');
        let is_closing =
            |line: &&str| ["wrote: ", "look at it: "].iter().any(|it| line.starts_with(it));
        let (closing, stderr): (Vec<&str>, Vec<&str>) = lines.partition(is_closing);
        Run {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: stderr.concat(),
            closing: closing.concat(),
        }
    }

    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_uvgraft"));
        command.current_dir(self.folder.path());
        // Ignore any networks that the user has imported.
        command.env("UVGRAFT_WEIGHTS", self.path("lpips.safetensors"));
        command.env("UVGRAFT_FACE_WEIGHTS", self.path("faces.safetensors"));
        command
    }

    /// Asserts that Khronos' validator, if installed, reports nothing about some files.
    pub fn assert_valid<N: AsRef<str>>(&self, names: &[N]) {
        let Some(browser) = Browser::find() else { return };
        let paths: Vec<PathBuf> = names.iter().map(|name| self.path(name.as_ref())).collect();
        let paths: Vec<_> = paths.iter().map(PathBuf::as_path).collect();
        let found = browser.validate(&paths);
        assert_eq!(found.len(), names.len());
        for (name, found) in names.iter().zip(found) {
            let name = name.as_ref();
            assert_eq!((found.errors, found.warnings), (0, 0), "{name}: {:?}", found.messages);
        }
    }

    /// Runs the program and expects success, without output on standard error.
    pub fn succeed(&self, args: &str) -> String {
        let run = self.run(args);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "uvgraft {args}");
        self.assert_no_litter();
        run.stdout
    }

    /// Runs the program and expects success, with any notes and warnings.
    pub fn make(&self, args: &str) -> String {
        let run = self.run(args);
        assert_eq!(run.code, Some(0), "uvgraft {args}\n{}", run.stderr);
        self.assert_no_litter();
        run.stdout
    }

    /// Runs the program and expects a rejection: exit code 2, one message that contains all of
    /// `wanted`, nothing on standard output, and an unchanged folder. If the output is a file, runs
    /// it a second time with an existing file in its place.
    pub fn refuse(&self, args: &str, wanted: &[&str]) {
        self.refuse_args(&args.split_whitespace().collect::<Vec<_>>(), wanted);
    }

    pub fn refuse_args(&self, args: &[&str], wanted: &[&str]) {
        self.refuse_once(args, wanted);
        let named = args.iter().position(|arg| *arg == "-o").and_then(|at| args.get(at + 1));
        let Some(output) = named.map(|name| self.path(name)) else { return };
        let new = !output.exists() && !output.is_symlink();
        if new && output.parent().is_some_and(Path::is_dir) && output.extension().is_some() {
            std::fs::write(&output, "old").unwrap();
            self.refuse_once(args, wanted);
            std::fs::remove_file(output).unwrap();
        }
    }

    fn refuse_once(&self, args: &[&str], wanted: &[&str]) {
        let case = args.join(" ");
        let before = self.content();
        let run = self.run_args(args);
        assert_eq!(run.code, Some(2), "exit code of: uvgraft {case}\n{run:?}");
        let document: Option<serde_json::Value> = serde_json::from_str(&run.stdout).ok();
        let is_reported = match document.filter(|_| args.contains(&"--json")) {
            Some(document) => document["uvgraft"]["ok"] == false,
            None => run.stdout.is_empty(),
        };
        assert!(is_reported, "standard output of: uvgraft {case}\n{}", run.stdout);
        assert!(run.stderr.starts_with("error: "), "uvgraft {case}\n{}", run.stderr);
        for wanted in wanted {
            let found = run.stderr.contains(wanted);
            assert!(found, "uvgraft {case}\nwanted: {wanted}\nfound:  {}", run.stderr);
        }
        let clauses: Vec<&str> = run.stderr.trim().split(": ").collect();
        let said_twice = clauses.windows(2).any(|pair| pair[0] == pair[1]);
        assert!(!said_twice, "uvgraft {case}\n{}", run.stderr);
        for never in ["panicked", "RUST_BACKTRACE", ".uvgraft-", "warning"] {
            assert!(!run.stderr.contains(never), "uvgraft {case}\n{}", run.stderr);
        }
        let after = self.content();
        let changed: Vec<_> = before
            .keys()
            .chain(after.keys())
            .filter(|path| before.get(*path) != after.get(*path))
            .collect();
        assert!(changed.is_empty(), "uvgraft {case}\nchanged: {changed:?}");
    }

    pub fn assert_no_litter(&self) {
        let litter = |path: &&PathBuf| path.extension().is_some_and(|found| found == "tmp");
        let content = self.content();
        assert_eq!(content.keys().find(litter), None);
    }
}

/// The target vertex for a source vertex: the order is reversed.
pub fn target_of(vertex: u32) -> u32 {
    TARGET_VERTICES - 1 - vertex
}

fn source() -> Mesh {
    mesh(SHEET_VERTICES, |vertex| vertex, 0.1, 0.2, &[])
}

fn target() -> Mesh {
    let extra = [[0.6, 0.6], [0.9, 0.6], [0.9, 0.9], [0.6, 0.9]];
    mesh(TARGET_VERTICES, target_of, 0.1, 0.1, &extra)
}

/// The sheet with quads of side `step` from `(low, low)`, and one more quad after it.
fn mesh(
    vertices: u32,
    renumber: impl Fn(u32) -> u32,
    low: f32,
    step: f32,
    extra: &[[f32; 2]],
) -> Mesh {
    let at = |index: u32| [index % 5, index / 5];
    let mut uv: Vec<[f32; 2]> =
        (0..SHEET_VERTICES).map(|index| at(index).map(|k| low + step * k as f32)).collect();
    uv.extend(extra);
    let mut corners = Vec::new();
    let mut polygon = |ring: [u32; 4]| {
        corners.extend(ring.map(|index| uvgraft::Corner { vertex: renumber(index), uv: index }));
    };
    let first = |k: u32| k / 4 * 5 + k % 4;
    (0..16).map(first).for_each(|k| polygon([k, k + 1, k + 6, k + 5]));
    if !extra.is_empty() {
        polygon([25, 26, 27, 28]);
    }
    let positions = (0..vertices).map(|vertex| [vertex as f32, 0.0, 0.0]).collect();
    let sizes = vec![4; corners.len() / 4];
    Mesh::from_polygons(positions, uv, &corners, &sizes).unwrap()
}

/// The values of one texel; 1.0 is full intensity.
pub fn texel(texture: &Texture, x: u32, y: u32) -> Vec<f32> {
    let count = texture.channels().count();
    let at = (y * texture.size().width + x) as usize * count;
    match texture.texels() {
        Texels::U8(values) => {
            values[at..at + count].iter().map(|&value| f32::from(value) / 255.0).collect()
        }
        Texels::U16(values) => {
            values[at..at + count].iter().map(|&value| f32::from(value) / 65_535.0).collect()
        }
        Texels::F32(values) => values[at..at + count].to_vec(),
    }
}

/// The values of one texel of an 8-bit texture.
pub fn texel_u8(texture: &Texture, x: u32, y: u32) -> Vec<u8> {
    assert_eq!(texture.depth(), Depth::U8);
    texel(texture, x, y).into_iter().map(|value| (value * 255.0).round() as u8).collect()
}
