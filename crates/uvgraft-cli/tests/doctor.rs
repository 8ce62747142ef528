//! What the program tells of itself and of files.

use crate::bench::Bench;
use uvgraft_tests::strip::Strip;

#[test]
fn the_program_and_what_files_state() {
    let bench = Bench::new();
    let strip = Strip::new();
    bench.write("silent.glb", strip.glb());
    let stated = strip.with("/asset/copyright", serde_json::json!("CC BY 4.0, Jane\u{1b}[2J"));
    bench.write("stated.glb", stated.glb());
    let text = bench.succeed("doctor my.uvpair silent.glb stated.glb");
    let version = env!("CARGO_PKG_VERSION");
    for (name, value) in [
        ("version", version),
        ("SIMD", uvgraft::simd_level()),
        ("networks for LPIPS", "not imported"),
        ("networks for faces", "not imported"),
        ("my.uvpair", "pair of source.obj and target.obj; note: synthetic"),
        ("silent.glb", "states no licence; ask where it is from"),
        ("stated.glb", "CC BY 4.0, Jane\\u{1b}[2J"),
    ] {
        let line = text.lines().find(|line| line.starts_with(&format!("{name} ")));
        let line = line.unwrap_or_else(|| panic!("{name}: {text}"));
        assert!(line.ends_with(&format!(" {value}")), "{line}");
    }
    let json: serde_json::Value = serde_json::from_str(&bench.succeed("doctor --json")).unwrap();
    assert_eq!(json["uvgraft"]["command"], "doctor");
    assert_eq!(json["rows"][0], serde_json::json!({ "name": "version", "value": version }));
    bench.refuse("doctor source.obj", &["source.obj: must be a pair (.uvpair)"]);
    bench.refuse("doctor none.uvpair", &["none.uvpair: "]);
}

#[test]
fn versions_in_short_and_in_full() {
    let bench = Bench::new();
    let name = format!("uvgraft {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(bench.succeed("--version"), name);
    let full = bench.succeed("--version --verbose");
    assert!(
        full.starts_with(&name) && full.contains("\ncommit ") && full.contains("\nfeatures "),
        "{full}"
    );
}
