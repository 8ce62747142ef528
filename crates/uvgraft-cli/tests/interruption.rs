//! An interrupted program leaves complete files.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

mod bench;

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use bench::Bench;
use uvgraft::{Channels, Depth};

/// Longer than anything here takes on a slow machine.
const PATIENCE: Duration = Duration::from_secs(120);

#[test]
fn only_whole_files_stay() {
    let bench = with_noise();
    for signal in ["INT", "TERM", "HUP"] {
        if is_ignored(signal) {
            eprintln!("skipped: this process was started with SIG{signal} ignored");
            continue;
        }
        assert_whole(&bench, bench.command(), &[signal]);
    }
}

/// As under `nohup`, and in the background of a script.
#[test]
fn ignoring_one_signal_leaves_the_others_handled() {
    let bench = with_noise();
    for ignored in ["HUP", "INT"] {
        let program = bench.command();
        let mut command = Command::new("sh");
        command.args(["-c", &format!("trap '' {ignored}; exec \"$@\""), "sh"]);
        command.arg(program.get_program()).current_dir(bench.path(""));
        assert_whole(&bench, command, &[ignored, "TERM"]);
    }
}

/// Nothing can be done about SIGKILL, except to leave nothing behind.
#[test]
fn a_killed_program_leaves_nothing_to_the_next() {
    let bench = with_noise();
    let before = bench.content();
    let mut program = compressing(bench.command());
    wait_for(|id| has_unfinished(&bench, id), &mut program);
    program.kill().unwrap();
    program.wait().unwrap();
    // Where files cannot be without a name, the next program removes it.
    let next = bench.run("inspect my.uvpair --preview preview.png");
    assert_eq!(next.code, Some(0), "{next:?}");
    std::fs::remove_file(bench.path("preview.png")).unwrap();
    assert!(bench.content() == before);
}

/// A limit on the size of files ends a write as a full disk does.
#[cfg(target_os = "linux")]
#[test]
fn files_larger_than_allowed_are_an_error() {
    let bench = Bench::new();
    bench.paint_noise("noise.png", (1024, 1024), Channels::Rgb, Depth::U8);
    bench.write("out.png", b"what was there before");
    let before = bench.content();
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -f 64; exec \"$@\"", "sh"]);
    command.arg(bench.command().get_program()).current_dir(bench.path(""));
    command.args("transfer my.uvpair noise.png --size 1024 -o out.png".split(' '));
    let output = command.stdin(Stdio::null()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.starts_with("error: cannot write out.png: "), "{stderr}");
    assert!(bench.content() == before);
}

/// A folder with noise, and a file where the output will be.
fn with_noise() -> Bench {
    let bench = Bench::new();
    bench.paint_noise("noise.png", (4096, 4096), Channels::Rgb, Depth::U8);
    bench.write("out.png", b"what was there before");
    bench
}

/// Asserts that signals, the last of which is handled, end a program that leaves all as it was.
#[track_caller]
fn assert_whole(bench: &Bench, command: Command, signals: &[&str]) {
    let before = bench.content();
    let mut program = compressing(command);
    wait_for(|id| has_unfinished(bench, id), &mut program);
    signals.iter().for_each(|signal| send(signal, &program));
    let output = program.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(stderr, "interrupted; unfinished outputs left unchanged\n", "{signals:?}");
    assert_eq!(output.status.code(), Some(130), "{signals:?}");
    assert!(bench.content() == before, "{signals:?}");
}

/// Starts a transfer that takes seconds to compress noise: it is interrupted while it writes.
fn compressing(mut command: Command) -> Child {
    command.args("transfer my.uvpair noise.png --size 4096 --compress -o out.png".split(' '));
    command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

#[test]
fn no_temporary_folder_stays() {
    if is_ignored("INT") {
        eprintln!("skipped: this process was started with SIGINT ignored");
        return;
    }
    let bench = Bench::new();
    bench.make_folder("temporary");
    let entries = || bench.path("temporary").read_dir().unwrap().count();
    let mut command = bench.command();
    command.env("TMPDIR", bench.path("temporary"));
    command.args("bench my.uvpair --size 2048 --source-size 2048 --runs 1000".split(' '));
    let mut program = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for(|_| entries() > 0, &mut program);
    send("INT", &program);
    assert_eq!(program.wait().unwrap().code(), Some(130));
    assert_eq!(entries(), 0);
}

fn send(signal: &str, program: &Child) {
    let id = program.id().to_string();
    assert!(Command::new("kill").args(["-s", signal, &id]).status().unwrap().success());
}

/// Whether a program is writing in the folder: a file with a temporary name, or an open one without.
fn has_unfinished(bench: &Bench, process: u32) -> bool {
    let folder = bench.path("").canonicalize().unwrap();
    let mut named = folder.read_dir().unwrap().flatten();
    let mut open = std::fs::read_dir(format!("/proc/{process}/fd")).into_iter().flatten();
    named.any(|entry| entry.file_name().to_string_lossy().ends_with(".tmp"))
        || open.any(|entry| {
            let leads_to = entry.and_then(|entry| entry.path().read_link()).unwrap_or_default();
            leads_to.starts_with(&folder) && leads_to.to_string_lossy().ends_with(" (deleted)")
        })
}

fn wait_for(condition: impl Fn(u32) -> bool, program: &mut Child) {
    let start = Instant::now();
    while !condition(program.id()) {
        assert!(program.try_wait().unwrap().is_none(), "the program ended too soon");
        assert!(start.elapsed() < PATIENCE, "the program never wrote");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Whether a signal is ignored, as under `nohup`; child processes inherit that.
fn is_ignored(signal: &str) -> bool {
    // Only Linux reports it.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    let number = [("HUP", 1), ("INT", 2), ("TERM", 15)].iter().find(|(name, _)| *name == signal);
    number.is_some_and(|(_, number)| mask >> (number - 1) & 1 == 1)
}
