//! The cost of each stage, through the program. Never the amount, which depends on the machine.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::Bench;
use serde_json::Value;

const TINY: &str = "--source-size 24 --size 32x20 --runs 2";

fn json(bench: &Bench, options: &str) -> Value {
    let text = bench.succeed(&format!("bench my.uvpair --json {options}"));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error} in: {text}"))
}

/// `stage` or `stage with` of each row.
fn names(report: &Value) -> Vec<String> {
    let stages = report["stages"].as_array().unwrap().iter();
    stages
        .map(|row| match row["with"].as_str() {
            Some(with) => format!("{} {with}", row["stage"].as_str().unwrap()),
            None => row["stage"].as_str().unwrap().to_owned(),
        })
        .collect()
}

#[test]
fn the_json_has_all_stages() {
    let bench = Bench::new();
    let before = bench.content();
    let report = json(&bench, &format!("{TINY} --threads 2"));
    assert_eq!(bench.content(), before);
    assert_eq!(report["uvgraft"]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&report["threads"], &report["runs"]), (&2.into(), &2.into()));
    assert!(report["copy"]["gigabytes_per_second"].as_f64().unwrap() > 0.0);
    assert!(report["copy"]["buffer_bytes"].as_u64().unwrap() >= 64 << 20);
    let wanted = [
        "read-pair",
        "map",
        "padding",
        "decode source",
        "decode base",
        "resample bilinear",
        "resample catmull-rom",
        "resample lanczos3",
        "apply bilinear",
        "apply catmull-rom",
        "apply lanczos3",
        "encode",
        "file bilinear",
        "file catmull-rom",
        "file lanczos3",
    ];
    assert_eq!(names(&report), wanted);
    for row in report["stages"].as_array().unwrap() {
        let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"));
        let [min, median, max] = ["min_ms", "median_ms", "max_ms"].map(number);
        assert!(min <= median && median <= max, "{row}");
        assert_eq!(row["times_ms"].as_array().unwrap().len(), 2);
        // The time of the padding is a difference of two times.
        if row["stage"] == "padding" {
            assert!(min >= 0.0, "{row}");
            continue;
        }
        assert!(min > 0.0, "{row}");
        if row["stage"] != "read-pair" {
            assert!(number("texels") > 0.0 && number("megatexels_per_second") > 0.0, "{row}");
        }
        if !matches!(row["stage"].as_str(), Some("read-pair" | "map")) {
            assert!(number("moved_bytes") > 0.0 && number("share_of_copy") > 0.0, "{row}");
        }
        assert_eq!(row["direction"], "forward");
    }
    // The sheet's part of the result, 13 by 8 texels, and a gutter around it; 20 by 20 of the
    // source.
    let resample = &report["stages"][5];
    let texels = resample["texels"].as_u64().unwrap();
    assert!((13 * 8 + 1..32 * 20).contains(&texels), "{resample}");
    assert_eq!(resample["moved_bytes"], (texels + 20 * 20) * 3);
}

#[test]
fn directions_sizes_filters_and_stages_are_chosen() {
    let bench = Bench::new();
    let report = json(
        &bench,
        "--source-size 24 --size 16,20x32 --both --filter lanczos3,nearest --stage resample --runs 1",
    );
    let size = |size: &Value| format!("{}×{}", size["width"], size["height"]);
    let rows: Vec<String> = report["stages"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| {
            let text = |key: &str| row[key].as_str().unwrap().to_owned();
            format!(
                "{} {} {} {}",
                text("direction"),
                size(&row["from"]),
                size(&row["to"]),
                text("with")
            )
        })
        .collect();
    let wanted = [
        "forward 24×24 16×16 nearest",
        "forward 24×24 16×16 lanczos3",
        "reverse 16×16 24×24 nearest",
        "reverse 16×16 24×24 lanczos3",
        "forward 24×24 20×32 nearest",
        "forward 24×24 20×32 lanczos3",
        "reverse 20×32 24×24 nearest",
        "reverse 20×32 24×24 lanczos3",
    ];
    assert_eq!(rows, wanted);
    let back = json(&bench, "--source-size 24 --size 16 --reverse --stage encode,map --runs 1");
    assert_eq!(names(&back), ["map", "encode"]);
    assert!(back["stages"].as_array().unwrap().iter().all(|row| row["direction"] == "reverse"));
}

#[test]
fn the_table_reads_well() {
    let bench = Bench::new();
    let text = bench.succeed(&format!("bench my.uvpair {TINY} --threads 1 --filter bilinear"));
    for wanted in ["1 thread,", "memory copy: ", "GB/s", "Mtexel/s", "24×24 → 32×20"] {
        assert!(text.contains(wanted), "{wanted} in:\n{text}");
    }
    let stages: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("| "))
        .map(|line| line.split('|').next().unwrap().trim())
        .collect();
    let wanted = [
        "stage",
        "read pair",
        "build map",
        "prepare padding",
        "decode PNG, source",
        "decode PNG, base",
        "resample, bilinear",
        "resample a copy, bilinear",
        "encode PNG",
        "file to file, bilinear",
    ];
    assert_eq!(stages, wanted);
    let table: Vec<&str> = text.lines().filter(|line| line.starts_with('|')).collect();
    let width = table[0].chars().count();
    assert!(table.iter().all(|line| line.chars().count() == width) && width <= 110, "{text}");
}

#[test]
fn what_is_refused() {
    let bench = Bench::new();
    bench.write("prose.uvpair", "This is not a pair.\n");
    for (args, wanted) in [
        ("bench none.uvpair", &["none.uvpair: ", "No such file"][..]),
        ("bench my.uvpair --stage map --filter nearest", &["--filter means nothing to the stages"]),
        ("bench my.uvpair --stage decode,encode,read-pair --filter lanczos3", &["--filter means"]),
        ("bench prose.uvpair", &["prose.uvpair: ", "pair file"]),
        ("bench", &["<PAIR>"]),
        ("bench my.uvpair --size 16,", &["must be N or WxH"]),
        ("bench my.uvpair --size 0", &["must be N or WxH"]),
        ("bench my.uvpair --source-size 16,16", &["must be N or WxH"]),
        ("bench my.uvpair --runs 0", &["from 1 to 1000"]),
        ("bench my.uvpair --filter cubic", &["cubic", "catmull-rom"]),
        ("bench my.uvpair --stage all", &["all", "resample"]),
        ("bench my.uvpair --reverse --both", &["--reverse", "--both"]),
    ] {
        bench.refuse(args, wanted);
    }
}
