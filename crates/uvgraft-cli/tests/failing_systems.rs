//! Every command that writes, on systems that fail: full disks and read-only folders, limits on files,
//! open files and memory, outputs that cannot be printed, inputs and folders that change under it.
//!
//! Whatever fails, the exit code is 0, 1 or 2; every output is the old file or the new one; nothing else is
//! left; and standard error, where there is one, says what it is about.

#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use uvgraft::{Channels, Depth};
use uvgraft_figure::Figure;
use uvgraft_tests::strip::Strip;

use crate::bench::Bench;

/// A command that writes, and its outputs that are files which may be there already.
struct Case {
    words: &'static str,
    files: &'static [&'static str],
}

const CASES: [Case; 17] = [
    case("pair source.obj target.obj --vertex-map ids.npy -o out.uvpair", &["out.uvpair"]),
    case(
        "pair source.obj target.obj --vertex-map ids.npy -o out.uvpair --preview out.png",
        &["out.uvpair", "out.png"],
    ),
    case("inspect my.uvpair --preview out.png", &["out.png"]),
    case("inspect mesh target.obj --preview out.png", &["out.png"]),
    case("transfer my.uvpair noise.png --size 512 -o out.png", &["out.png"]),
    case("transfer my.uvpair noise.png --size 512 --compress -o out.tif", &["out.tif"]),
    case(
        "transfer demo.uvpair face.png --onto base.png --blend membrane --preview out.png -o out.webp",
        &["out.webp", "out.png"],
    ),
    case(
        "transfer my.uvpair noise.png deep.tif --size 256 --format png -o out --report out.jsonl",
        &[],
    ),
    case("transfer my.uvpair noise.png --size 256 --fit --fit-steps 2 -o out.exr", &["out.exr"]),
    case("seams demo.uvpair base.png --picture out.png", &["out.png"]),
    case("compare noise.png deep.tif --metrics l1,ssim --heatmap out.png", &["out.png"]),
    case("roundtrip my.uvpair noise.png --via 256 --metrics l1 -o out", &[]),
    case("map my.uvpair --size 256 -o out.npz", &["out.npz"]),
    case(
        "avatar demo.uvpair face.png --onto base.png --unit m --body demo -o out.vrm \
         --author Nobody --license only-author",
        &["out.vrm"],
    ),
    case("render strip.glb --size 200 -o out.png --print-camera", &["out.png"]),
    case("render strip.glb --size 64 --turntable 4 -o out.gif", &["out.gif"]),
    case("man out", &[]),
];

const fn case(words: &'static str, files: &'static [&'static str]) -> Case {
    Case { words, files }
}

/// The files that all cases read, made once.
fn inputs() -> &'static BTreeMap<PathBuf, Vec<u8>> {
    static INPUTS: OnceLock<BTreeMap<PathBuf, Vec<u8>>> = OnceLock::new();
    INPUTS.get_or_init(|| {
        let bench = Bench::of_figure(&Figure::new(), 128);
        bench.paint_noise("noise.png", (300, 300), Channels::Rgb, Depth::U8);
        bench.paint_noise("deep.tif", (300, 300), Channels::Rgb, Depth::U16);
        bench.write("strip.glb", Strip::new().glb());
        bench.content()
    })
}

fn bench() -> Bench {
    let bench = Bench::new();
    for (name, bytes) in inputs() {
        bench.write(&name.to_string_lossy(), bytes);
    }
    bench
}

/// What each case writes where nothing fails, made once.
fn outputs() -> impl Iterator<Item = (&'static Case, &'static BTreeMap<PathBuf, Vec<u8>>)> {
    static OUTPUTS: OnceLock<Vec<BTreeMap<PathBuf, Vec<u8>>>> = OnceLock::new();
    CASES.iter().zip(OUTPUTS.get_or_init(|| CASES.iter().map(Case::output).collect()))
}

/// What a case left in its folder beside its inputs.
fn left(bench: &Bench) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut content = bench.content();
    content.retain(|name, _| !inputs().contains_key(name));
    content
}

impl Case {
    /// What it writes where nothing fails.
    fn output(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let bench = bench();
        let run = bench.run(self.words);
        assert_eq!(run.code, Some(0), "uvgraft {}\n{}", self.words, run.stderr);
        left(&bench)
    }

    /// Whether a file may be there afterwards with other bytes than on a sound system: measured times,
    /// tables that end early, and records of them.
    fn may_differ(name: &Path) -> bool {
        let is = |ending: &str| name.extension().is_some_and(|it| it == ending);
        is("jsonl") || name.ends_with("report.md") || name.ends_with("report.json")
    }

    /// Runs it by a shell that first takes something from the program. Returns the exit code.
    ///
    /// - `loss`: shell code before the program.
    /// - `streams`: redirections of the program, or options.
    /// - `wanted`: what it writes where nothing fails.
    fn run(&self, loss: &str, streams: &str, wanted: &BTreeMap<PathBuf, Vec<u8>>) -> i32 {
        let bench = bench();
        for output in self.files {
            bench.write(output, "old");
        }
        let before = left(&bench);
        let program = bench.command();
        let mut shell = Command::new("bash");
        let script = format!("{loss}\n\"$@\" {streams}\n");
        shell.args(["-c", &script, "bash"]).arg(program.get_program());
        shell.args(self.words.split_whitespace()).current_dir(bench.path("")).stdin(Stdio::null());
        shell.envs(program.get_envs().filter_map(|(name, value)| Some((name, value?))));
        let run = shell.output().expect("bash runs");
        let stderr = String::from_utf8_lossy(&run.stderr);
        let reported = format!("{loss}; uvgraft {} {streams}: {stderr}", self.words);
        let code = run.status.code();
        assert!(matches!(code, Some(0..=2)), "{code:?}, {reported}");
        let code = code.unwrap_or_default();
        if code != 0 && !streams.contains("2>") {
            assert!(!stderr.trim().is_empty(), "nothing is said: {reported}");
            assert!(!stderr.contains("panicked"), "{reported}");
        }
        let after = left(&bench);
        for (name, bytes) in &after {
            let is_known = before.get(name) == Some(bytes) || wanted.get(name) == Some(bytes);
            assert!(is_known || Self::may_differ(name), "{}: {reported}", name.display());
        }
        // A result that cannot be printed is the last of all.
        if code == 0 || streams.contains(">/dev/full") {
            assert!(wanted.keys().all(|name| after.contains_key(name)), "{reported}");
        }
        code
    }
}

/// Runs all cases under something that fails. Returns how many failed.
fn failures(losses: &[&str], streams: &[&str]) -> usize {
    let mut failed = 0;
    for (case, wanted) in outputs() {
        for loss in losses {
            for streams in streams {
                failed += usize::from(case.run(loss, streams, wanted) != 0);
            }
        }
    }
    failed
}

#[test]
fn outputs_that_cannot_be_printed() {
    // Messages that nobody can read change nothing.
    assert_eq!(failures(&[":"], &["2>/dev/full", "2>&-", "2> >(exit)"]), 0);
    // Nor do results that nobody wants.
    assert_eq!(failures(&[":"], &[">&-", "> >(exit)"]), 0);
    for (case, wanted) in outputs() {
        let prints = !bench().run(case.words).stdout.is_empty();
        for streams in [">/dev/full", ">/dev/full 2>&1"] {
            let code = case.run(":", streams, wanted);
            assert_eq!(code, i32::from(prints), "uvgraft {} {streams}", case.words);
        }
    }
}

/// Help and versions are results, too.
#[test]
fn help_that_cannot_be_printed_is_a_failure() {
    let bench = Bench::new();
    for words in ["--help", "--version", "--version --verbose", "transfer -h", "completions bash"] {
        for (streams, wanted) in [(">/dev/full", 1), ("| head -c 1", 0), ("", 0)] {
            let mut shell = Command::new("bash");
            let script = format!("set -o pipefail; \"$@\" {streams}");
            shell.args(["-c", &script, "bash"]).arg(bench.command().get_program());
            let run = shell.args(words.split_whitespace()).output().unwrap();
            assert_eq!(run.status.code(), Some(wanted), "uvgraft {words} {streams}");
        }
    }
    let bad = Command::new("bash")
        .args(["-c", "\"$@\" 2>/dev/full", "bash"])
        .arg(bench.command().get_program())
        .arg("no-such-command")
        .status();
    assert_eq!(bad.unwrap().code(), Some(2));
}

#[test]
fn limits_of_files_and_open_files() {
    // In blocks of 1024 bytes, by bash.
    let failed = failures(&["ulimit -f 0", "ulimit -f 4", "ulimit -n 12"], &[""]);
    assert!(failed >= CASES.len(), "{failed} failed");
}

/// What cannot be allocated ends the program with a message and code 1.
#[test]
fn limits_of_memory() {
    // Below its own size the program cannot even start.
    let program = std::fs::metadata(env!("CARGO_BIN_EXE_uvgraft")).unwrap().len() >> 10;
    let limits =
        [14_000, 22_000, 40_000, 90_000].map(|more| format!("ulimit -v {}", program + more));
    let failed = failures(&limits.each_ref().map(|limit| &**limit), &["--threads 2"]);
    assert!(failed >= CASES.len(), "{failed} failed");
}

/// The program needs the stack that it starts on for hardly anything.
#[test]
fn a_small_stack() {
    assert_eq!(failures(&["ulimit -s 64"], &[""]), 0);
}

#[test]
fn read_only_folders_and_full_disks() {
    // Of a kind that binds root, too: file systems of a namespace.
    let namespace = |script: &str| {
        Command::new("unshare")
            .args(["--user", "--map-root-user", "--mount", "bash", "-c", script])
            .output()
    };
    let works = namespace("mount -t tmpfs -o size=64k none /tmp");
    if !works.is_ok_and(|run| run.status.success()) {
        eprintln!("skipped: this system does not let users mount file systems");
        return;
    }
    for case in &CASES {
        for (mount, least) in [("size=64k", 0), ("ro", 1)] {
            let bench = bench();
            let script = format!(
                "set -e; cp -r . /tmp/in; mkdir /tmp/out; cd /tmp/in\n\
                 mount -t tmpfs -o {mount} none /tmp/out\n\
                 set +e; \"$@\"; code=$?; ls -A /tmp/out; exit $code"
            );
            let words = into_folder(case, "/tmp/out");
            let program = bench.command();
            let mut shell = Command::new("unshare");
            let outer = format!("mount -t tmpfs none /tmp && {script}");
            shell.args(["--user", "--map-root-user", "--mount", "bash", "-c", &outer, "bash"]);
            shell.arg(program.get_program()).args(&words).current_dir(bench.path(""));
            let run = shell.output().unwrap();
            let stderr = String::from_utf8_lossy(&run.stderr);
            let stdout = String::from_utf8_lossy(&run.stdout);
            let reported = format!("{mount}: {words:?}\n{stdout}\n{stderr}");
            let code = run.status.code().unwrap_or(-1);
            assert!((least..=2).contains(&code), "{code}, {reported}");
            assert!(!stderr.contains("panicked") && !stdout.contains(".tmp"), "{reported}");
            if code != 0 {
                assert!(stderr.contains("error: "), "{reported}");
            }
        }
    }
}

/// A case's words, with its outputs in another folder.
fn into_folder(case: &Case, folder: &str) -> Vec<String> {
    let moved = |word: &str| {
        let is_output = word == "out" || word.starts_with("out.");
        if is_output { format!("{folder}/{word}") } else { word.to_owned() }
    };
    case.words.split_whitespace().map(moved).collect()
}

/// Inputs are cut, emptied, replaced or removed while they are read, and so is the output's folder.
#[test]
fn inputs_and_folders_that_change() {
    let bench = Bench::new();
    bench.paint_noise("large.png", (2048, 2048), Channels::Rgb, Depth::U8);
    let large = bench.bytes("large.png");
    bench.paint_noise("other.png", (900, 1300), Channels::Rgb, Depth::U8);
    let other = bench.bytes("other.png");
    bench.paint_noise("face.png", (512, 512), Channels::Rgb, Depth::U8);
    let change = |what: &str, path: &Path| match what {
        "cut" => std::fs::File::options().write(true).open(path).unwrap().set_len(99_999).unwrap(),
        "emptied" => std::fs::File::create(path).map(drop).unwrap(),
        "overwritten" => std::fs::write(path, &other).unwrap(),
        "removed" => std::fs::remove_file(path).unwrap(),
        _ => std::fs::remove_dir_all(path.with_file_name("there")).unwrap(),
    };
    let mut failed = 0;
    for what in ["cut", "emptied", "overwritten", "removed", "folder removed"] {
        for wait_ms in [1, 4, 10, 20, 40, 80] {
            bench.write("large.png", &large);
            bench.make_folder("there");
            bench.write("there/out.png", "old");
            let mut command = bench.command();
            command.args(
                "transfer my.uvpair face.png --onto large.png -o there/out.png -q".split(' '),
            );
            let program = command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
            std::thread::sleep(Duration::from_millis(wait_ms));
            change(what, &bench.path("large.png"));
            let run = program.wait_with_output().unwrap();
            let stderr = String::from_utf8(run.stderr).unwrap();
            let reported = format!("{what} after {wait_ms} ms: {stderr}");
            assert!(matches!(run.status.code(), Some(0..=2)), "{:?}, {reported}", run.status);
            assert_eq!(run.status.success(), stderr.is_empty(), "{reported}");
            failed += usize::from(!run.status.success());
            if bench.exists("there") {
                let names = bench.path("there").read_dir().unwrap();
                let names: Vec<_> = names.map(|entry| entry.unwrap().file_name()).collect();
                assert_eq!(names, ["out.png"], "{reported}");
                if run.status.success() {
                    let size = bench.texture("there/out.png").size();
                    assert!([2048, 900].contains(&size.width), "{reported}");
                } else {
                    assert_eq!(bench.bytes("there/out.png"), b"old", "{reported}");
                }
            }
        }
    }
    assert!(failed > 0, "nothing changed in time");
}
