//! The README and the book: every command in them runs, and every link leads somewhere.
//!
//! Blocks tagged `sh` hold commands that work, page by page, from top to bottom, in a folder with
//! the files that the documents use as examples.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use uvgraft::{Channels, Mesh, Size};
use uvgraft_avatar::body::BodyKind;
use uvgraft_figure::motion::as_amass;
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_io::arrays::{self, NamedArrays, NumericArray};
use uvgraft_io::{obj, vertex_map};
use uvgraft_tests::walkers;

use crate::bench::Bench;

/// Side of every example texture, in texels.
const SIDE: u32 = 256;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// All Markdown files written for readers.
fn documents() -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = Vec::new();
    let mut folders = vec![root().join("docs/src")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                found.push(path);
            }
        }
    }
    for name in ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"] {
        found.push(root().join(name));
    }
    found.sort();
    found
}

/// The command lines of a page's `sh` blocks, with continued lines joined.
fn commands(text: &str) -> Vec<String> {
    let mut commands: Vec<String> = Vec::new();
    let (mut is_inside, mut goes_on) = (false, false);
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            is_inside = !is_inside && line.trim() == "```sh";
            continue;
        }
        let line = line.trim();
        if !is_inside || line.is_empty() || line.starts_with('#') {
            continue;
        }
        let (part, more) = line.strip_suffix('\\').map_or((line, false), |part| (part, true));
        match commands.last_mut().filter(|_| goes_on) {
            Some(command) => command.push_str(part),
            None => commands.push(part.to_owned()),
        }
        goes_on = more;
    }
    commands
}

/// The words of a command, without its comment; single quotes hold words together.
fn words(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let (mut is_quoted, mut is_open) = (false, false);
    for letter in command.chars() {
        match letter {
            '\'' => (is_quoted, is_open) = (!is_quoted, true),
            ' ' if !is_quoted => {
                if is_open {
                    words.push(String::new());
                }
                is_open = false;
            }
            '#' if !is_quoted && !is_open => break,
            _ => {
                words.last_mut().unwrap().push(letter);
                is_open = true;
            }
        }
    }
    if !is_open {
        words.pop();
    }
    words
}

/// A pickle of protocol 2: a dictionary of lists of integers.
fn pickled(groups: &[(&str, Vec<u32>)]) -> Vec<u8> {
    let mut bytes = b"\x80\x02}(".to_vec();
    for (name, ids) in groups {
        bytes.push(b'X');
        bytes.extend((name.len() as u32).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.extend(b"](");
        for id in ids {
            bytes.push(b'J');
            bytes.extend(id.to_le_bytes());
        }
        bytes.push(b'e');
    }
    bytes.extend(b"u.");
    bytes
}

/// A folder with every file that the documents' commands start from.
fn examples() -> Bench {
    let figure = Figure::new();
    let bench = Bench::new();
    let size = Size::square(SIDE);
    let face = paint_head(&figure, size);
    obj::save(&figure.head, bench.path("head.obj")).unwrap();
    obj::save(&figure.body, bench.path("body.obj")).unwrap();
    vertex_map::save_npy(&figure.vertex_map, bench.path("ids.npy")).unwrap();
    let (head, body) = (&figure.head, &figure.body);
    bench.save_pair("head_to_body.uvpair", head.clone(), body.clone(), &figure.vertex_map);
    // The model has triangles, so its polygons must be split in the same way.
    let (positions, uv) = (body.positions().to_vec(), body.uv().to_vec());
    let model = Mesh::from_triangles(positions, uv, body.faces(), body.uv_faces()).unwrap();
    obj::save(head, bench.path("flame.obj")).unwrap();
    obj::save(&model, bench.path("smplx.obj")).unwrap();
    vertex_map::save_npy(&figure.vertex_map, bench.path("smplx_flame_ids.npy")).unwrap();
    bench.save_pair("flame_to_smplx.uvpair", head.clone(), model, &figure.vertex_map);
    bench.make_folder("faces");
    for name in ["face.png", "mean.png", "faces/anna.png", "faces/ben.png"] {
        bench.save(name, face.clone());
    }
    bench.save("body.png", paint_body(&figure, Size::square(2 * SIDE)));
    for name in ["face_n.png", "body_n.png"] {
        bench.paint(name, (SIDE, SIDE), Channels::Rgb, &[128, 128, 255]);
    }
    for name in ["face_r.png", "body_r.png"] {
        bench.paint(name, (SIDE, SIDE), Channels::Grey, &[170]);
    }
    bench.paint("known.png", (SIDE, SIDE), Channels::Grey, &[255]);
    let (neck, rest): (Vec<u32>, Vec<u32>) = (0..figure.head.positions().len() as u32)
        .partition(|&vertex| figure.head.positions()[vertex as usize][1] < 1.5);
    bench.write("FLAME_masks.pkl", pickled(&[("face", rest), ("neck", neck)]));
    let model = walkers::model(BodyKind::SmplX);
    arrays::save_npz(&model, bench.path("SMPLX_NEUTRAL.npz")).unwrap();
    let avatar = figure.avatar();
    let wave = as_amass(&avatar.skeleton, &avatar.clips[0]);
    let mut motion = NamedArrays::new();
    let mut insert = |name, shape: &[usize], values| {
        motion.insert(name, NumericArray::new_f32(shape.to_vec(), values).unwrap());
    };
    insert("poses", &[wave.frames, 156], wave.poses);
    insert("trans", &[wave.frames, 3], wave.trans);
    insert("mocap_framerate", &[], vec![wave.mocap_framerate]);
    arrays::save_npz(&motion, bench.path("walking_poses.npz")).unwrap();
    bench.make_folder("fate_workspace/baking_1/dump_texture");
    let dump = "crates/uvgraft-io/tests/array_samples/fate_tex_dump.pth";
    let to = bench.path("fate_workspace/baking_1/dump_texture/x_tex_dump.pth");
    fs::copy(root().join(dump), to).unwrap();
    bench
}

/// Copies a folder and its contents.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}

/// Runs the program on a line of a document. Commands for features missing in this build are
/// skipped.
fn run(bench: &Bench, page: &Path, command: &str) {
    let mut words = words(command);
    words.remove(0);
    let needs_simplify = words.iter().any(|word| word == "--lods" || word == "--preset");
    if words[0] == "view" {
        words.push("--no-open".to_owned());
    }
    let is_built = match words[0].as_str() {
        "view" => cfg!(feature = "viewer"),
        _ => cfg!(feature = "simplify") || !needs_simplify,
    };
    if is_built {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let run = bench.run_args(&words);
        assert_eq!(run.code, Some(0), "{}: {command}\n{}", page.display(), run.stderr);
    }
}

/// Checks that the repository has what a line names: targets, scripts, features, tests.
fn check_command(page: &Path, command: &str) {
    let words = words(command);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let makefile = fs::read_to_string(root().join("Makefile")).unwrap();
    let manifest = fs::read_to_string(root().join("crates/uvgraft-cli/Cargo.toml")).unwrap();
    let option = |name: &str| {
        words.iter().position(|&word| word == name).and_then(|at| words.get(at + 1).copied())
    };
    let is_known = match words[..] {
        ["make", ref targets @ ..] => {
            let made = |line: &str| line.split(':').next().unwrap_or_default().to_owned();
            let made: Vec<String> =
                makefile.lines().filter(|line| !line.starts_with('\t')).map(made).collect();
            let is_made =
                |target: &&str| made.iter().any(|line| line.split(' ').any(|it| it == *target));
            let is_variable = |word: &&str| word.contains('=');
            !targets.is_empty() && targets.iter().all(|it| is_variable(it) || is_made(it))
        }
        ["cd", ..] | ["git", ..] => true,
        [script] if script.starts_with("scripts/") => root().join(script).is_file(),
        ["cargo", ..] | ["UVGRAFT_REWRITE_HASHES=1", "cargo", ..] => {
            let features = option("--features").unwrap_or_default();
            let names = features.split(',').filter(|name| !name.is_empty());
            let mut names = names.map(|name| name.rsplit('/').next().unwrap_or(name));
            let package = option("-p").map(|name| root().join("crates").join(name));
            let path = option("--path").map(|name| root().join(name));
            names.all(|name| manifest.contains(&format!("\n{name} = [")))
                && package.or(path).is_none_or(|path| path.is_dir())
        }
        _ => false,
    };
    assert!(is_known, "{}: {command}", page.display());
}

#[test]
fn every_command_runs() {
    let examples = examples();
    let mut seen = 0;
    for page in documents() {
        let commands = commands(&fs::read_to_string(&page).unwrap());
        let own = commands.iter().any(|command| command.starts_with("uvgraft ")).then(Bench::new);
        if let Some(bench) = &own {
            copy(&examples.path("."), &bench.path("."));
        }
        for command in commands {
            match &own {
                Some(bench) if command.starts_with("uvgraft ") => {
                    run(bench, &page, &command);
                    seen += 1;
                }
                _ => check_command(&page, &command),
            }
        }
    }
    assert!(seen > 40, "{seen}");
}

#[test]
fn every_link_leads_somewhere() {
    for page in documents() {
        let text = fs::read_to_string(&page).unwrap();
        for (at, _) in text.match_indices("](") {
            let target = text[at + 2..].split([')', ' ']).next().unwrap_or_default();
            let path = target.split('#').next().unwrap_or_default();
            if path.is_empty() || path.contains("://") {
                continue;
            }
            let found = page.parent().unwrap().join(path);
            assert!(found.exists(), "{}: {target}", page.display());
        }
    }
}

#[test]
fn the_book_has_every_page() {
    let folder = root().join("docs/src");
    let summary = fs::read_to_string(folder.join("SUMMARY.md")).unwrap();
    let listed: BTreeSet<PathBuf> = summary
        .match_indices("](")
        .map(|(at, _)| folder.join(summary[at + 2..].split(')').next().unwrap_or_default()))
        .collect();
    for page in documents() {
        if page.starts_with(&folder) && page.file_name().is_some_and(|name| name != "SUMMARY.md") {
            assert!(listed.contains(&page), "{} is not in SUMMARY.md", page.display());
        }
    }
}

#[test]
fn texts_stay_short() {
    for (name, most) in [("README.md", 150), ("ARCHITECTURE.md", 150)] {
        let lines = fs::read_to_string(root().join(name)).unwrap().lines().count();
        assert!(lines <= most, "{name} has {lines} lines, at most {most} are read");
    }
}
