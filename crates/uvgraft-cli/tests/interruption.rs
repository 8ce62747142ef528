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
    if is_ignored() {
        eprintln!("skipped: this process was started with signals ignored");
        return;
    }
    let bench = Bench::new();
    bench.paint_noise("noise.png", (4096, 4096), Channels::Rgb, Depth::U8);
    bench.write("out.png", b"what was there before");
    let before = bench.content();
    for signal in ["INT", "TERM", "HUP"] {
        let mut command = bench.command();
        // Compressing noise takes seconds: it is interrupted while it writes.
        command.args("transfer my.uvpair noise.png --size 4096 --compress -o out.png".split(' '));
        let mut program = command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        wait_for(|| has_unfinished(&bench), &mut program);
        send(signal, &program);
        let output = program.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(stderr, "interrupted; unfinished outputs left unchanged\n", "{signal}");
        assert_eq!(output.status.code(), Some(130), "{signal}");
        assert!(bench.content() == before, "{signal}");
    }
}

#[test]
fn no_temporary_folder_stays() {
    if is_ignored() {
        eprintln!("skipped: this process was started with signals ignored");
        return;
    }
    let bench = Bench::new();
    bench.make_folder("temporary");
    let entries = || bench.path("temporary").read_dir().unwrap().count();
    let mut command = bench.command();
    command.env("TMPDIR", bench.path("temporary"));
    command.args("bench my.uvpair --size 2048 --source-size 2048 --runs 1000".split(' '));
    let mut program = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for(|| entries() > 0, &mut program);
    send("INT", &program);
    assert_eq!(program.wait().unwrap().code(), Some(130));
    assert_eq!(entries(), 0);
}

fn send(signal: &str, program: &Child) {
    let id = program.id().to_string();
    assert!(Command::new("kill").args(["-s", signal, &id]).status().unwrap().success());
}

fn has_unfinished(bench: &Bench) -> bool {
    let mut entries = bench.path("").read_dir().unwrap();
    entries.any(|entry| entry.unwrap().file_name().to_string_lossy().ends_with(".tmp"))
}

fn wait_for(condition: impl Fn() -> bool, program: &mut Child) {
    let start = Instant::now();
    while !condition() {
        assert!(program.try_wait().unwrap().is_none(), "the program ended too soon");
        assert!(start.elapsed() < PATIENCE, "the program never wrote");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Whether one of the signals is ignored, as under `nohup`; child processes inherit that.
fn is_ignored() -> bool {
    // Only Linux reports it.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    let [hup, int, term] = [1, 2, 15].map(|signal| mask >> (signal - 1) & 1 == 1);
    hup || int || term
}
