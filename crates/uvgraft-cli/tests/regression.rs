//! No byte of any result changes unnoticed: `scripts/regression.sh` runs the program with some 200
//! commands, and `regression.sha256` next to this file holds the hashes of the results.
//!
//! If results change on purpose, `UVGRAFT_REWRITE_HASHES=1` rewrites the file; its diff shows the
//! changes, and belongs in the same commit. With `UVGRAFT_REGRESSION_KEEP=folder` the script keeps
//! the results there, for inspection.

#![expect(clippy::unwrap_used, reason = "a test that cannot read its files has failed")]

use std::collections::{BTreeMap, BTreeSet};
use std::env;
use std::fmt::Write as _;
use std::hint::black_box;
use std::process::{Command, Stdio};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scripts/regression.sh");
const WANTED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/regression.sha256");

/// The name among the hashes of the fingerprint of the system's math functions.
const LIBM: &str = "libm";

/// Hashes by the names of results.
type Hashes = BTreeMap<String, String>;

#[test]
fn no_result_changes() {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux", target_env = "gnu")) {
        eprintln!("skipped: the hashes of {WANTED} are those of x86-64, Linux and glibc");
        return;
    }
    let rewrite = env::var_os("UVGRAFT_REWRITE_HASHES").is_some_and(|value| value == "1");
    let libm = libm_fingerprint();
    let mut wanted = match std::fs::read_to_string(WANTED) {
        Ok(text) => parse(&text),
        Err(_) if rewrite => Hashes::new(),
        Err(error) => panic!("{WANTED}: {error}"),
    };
    if !rewrite && wanted.get(LIBM) != Some(&libm) {
        eprintln!(
            "skipped: this system's mathematical functions round otherwise than those that \
             {WANTED} was made with"
        );
        return;
    }
    let (mut found, skipped) = run_script();
    found.insert(LIBM.to_owned(), libm);
    // A dependency rounds these according to the processor.
    found.retain(|name, _| !name.starts_with("processor/"));
    let is_skipped = |name: &String| {
        let command = name.split('.').next().unwrap();
        skipped.contains(command)
    };

    if rewrite {
        wanted.retain(|name, _| is_skipped(name));
        wanted.extend(found);
        let text: String = wanted.iter().map(|(name, hash)| format!("{hash}  {name}\n")).collect();
        std::fs::write(WANTED, text).unwrap();
        eprintln!("wrote {WANTED}: {} hashes", wanted.len());
        return;
    }
    let mut changes = String::new();
    for (name, hash) in &wanted {
        match found.get(name) {
            Some(found) if found == hash => {}
            Some(_) => writeln!(changes, "  {name} differs").unwrap(),
            None if is_skipped(name) => {}
            None => writeln!(changes, "  {name} is missing").unwrap(),
        }
    }
    for name in found.keys().filter(|name| !wanted.contains_key(*name)) {
        writeln!(changes, "  {name} is new").unwrap();
    }
    assert!(
        changes.is_empty(),
        "results are not what they were:\n{changes}\
         UVGRAFT_REGRESSION_KEEP=folder leaves them in a folder, to look at. If they change on purpose, \
         write {WANTED} anew: UVGRAFT_REWRITE_HASHES=1 cargo test -p uvgraft-cli --test main \
         --features simplify,flip -- regression::"
    );
}

/// The script's results for the program, and the commands that this build cannot run.
#[expect(clippy::print_stderr, reason = "what is skipped must be visible")]
fn run_script() -> (Hashes, BTreeSet<String>) {
    let output = Command::new("bash")
        .args([SCRIPT, env!("CARGO_BIN_EXE_uvgraft")])
        // Results for meshes that are not in the repository must not be in it either.
        .env_remove("UVGRAFT_REGRESSION_REAL")
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    eprint!("{said}");
    assert!(output.status.success(), "{SCRIPT}: {}", output.status);
    let skipped = said
        .lines()
        .filter_map(|line| Some(line.strip_prefix("skipped: ")?.split_once(':')?.0.to_owned()))
        .collect();
    (parse(&String::from_utf8(output.stdout).unwrap()), skipped)
}

/// Lines as printed by `sha256sum`.
fn parse(text: &str) -> Hashes {
    text.lines()
        .map(|line| {
            let (hash, name) = line.split_once("  ").unwrap_or_else(|| panic!("{line}"));
            (name.to_owned(), hash.to_owned())
        })
        .collect()
}

/// Distinguishes systems whose functions round differently. Those in double precision are excluded:
/// they differ with every processor, but results are coarser than that.
fn libm_fingerprint() -> String {
    const FUNCTIONS: [fn(f32) -> f32; 16] = [
        |x| (8.0 * x).sin(),
        |x| (8.0 * x).cos(),
        |x| (1.5 * x).tan(),
        |x| (9.0 * x).atan(),
        |x| x.atan2(0.7),
        f32::asin,
        f32::acos,
        |x| (2.0 * x).tanh(),
        |x| (20.0 * x - 15.0).exp(),
        |x| (4.0 * x).exp2(),
        f32::ln,
        f32::log2,
        f32::log10,
        |x| x.powf(2.4),
        |x| x.powf(1.0 / 2.4),
        |x| x.hypot(0.3),
    ];
    let values = FUNCTIONS.iter().flat_map(|function| {
        (1..10_000).map(move |k| function(black_box(k as f32 / 10_000.0)).to_bits())
    });
    // FNV-1a, one word at a time.
    let hash = values.fold(0xcbf2_9ce4_8422_2325_u64, |hash, bits| {
        (hash ^ u64::from(bits)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}
