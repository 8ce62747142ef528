//! Pairing two meshes and looking at the result, through the program.

use crate::bench::{self, Bench, texel_u8};
use serde_json::Value;
use uvgraft::{Channels, Size, Texels};

const PAIR: &str = "pair source.obj target.obj --vertex-map ids.npy -o new.uvpair";
/// At these sizes both sheets end on texel borders, so that the counts follow from the layouts.
const SIZES: &str = "--source-size 40x30 --target-size 40";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in: {text}"))
}

#[test]
fn the_report_has_the_right_numbers() {
    let bench = Bench::new();
    let report = json(&bench.succeed(&format!("{PAIR} {SIZES} --json --note hello")));
    for (side, wanted) in [
        (
            "source",
            r#"{ "vertices": 25, "uv_coordinates": 25, "faces": 32, "polygons": 16, "islands": 1,
                 "linked": 32, "degenerate": 0, "mirrored": 0, "outside": 0,
                 "size": { "width": 40, "height": 30 } }"#,
        ),
        (
            "target",
            r#"{ "vertices": 29, "uv_coordinates": 29, "faces": 34, "polygons": 17, "islands": 2,
                 "linked": 32, "degenerate": 0, "mirrored": 0, "outside": 0,
                 "size": { "width": 40, "height": 40 } }"#,
        ),
    ] {
        for (key, wanted) in json(wanted).as_object().unwrap() {
            assert_eq!(&report[side][key], wanted, "{side} {key}");
        }
    }
    // 0.8² of 40×30 texels; 0.4² of 40×40 and another 0.3² without links.
    let texels = |side: &str, key: &str| report[side]["texels"][key].as_u64().unwrap();
    assert_eq!((texels("source", "linked"), texels("source", "covered")), (768, 768));
    assert_eq!((texels("target", "linked"), texels("target", "covered")), (256, 256 + 144));
    assert_eq!(texels("target", "overlapping"), 0);
    assert_eq!((&report["links"], &report["mirrored"]), (&32.into(), &0.into()));
    // Half the length on 40 texels across in both, on 40 instead of 30 down.
    let density = report["forward_density"]["median"].as_f64().unwrap();
    assert!((density - (0.25f64 * 40.0 / 30.0).sqrt()).abs() < 1e-5, "{density}");
    assert_eq!(report["source_name"], "source.obj");
    assert_eq!(report["target_name"], "target.obj");
    assert_eq!(report["note"], "hello");
    let fingerprints =
        ["source", "target"].map(|side| report[format!("{side}_fingerprint")].clone());
    assert_ne!(fingerprints[0], fingerprints[1]);
    assert!(fingerprints.iter().all(|print| print.as_str().unwrap().len() == 32));
}

#[test]
fn the_report_reads_well_and_inspect_repeats_it() {
    let bench = Bench::new();
    let report = bench.succeed(&format!("{PAIR} {SIZES}"));
    let report = after_method(&report);
    let rows: Vec<Vec<&str>> =
        report.lines().map(|line| line.split_whitespace().collect()).collect();
    for wanted in [
        "source source.obj target target.obj",
        "vertices 25 29",
        "triangles 32 34",
        "polygons 16 17",
        "UV islands 1 2",
        "linked 32 (100.0 %) 32 (94.1 %)",
        "not linked 0 2",
        "at texture size 40×30 40×40",
        "texels linked 768 (64.0 %) 256 (16.0 %)",
    ] {
        let wanted: Vec<&str> = wanted.split_whitespace().collect();
        assert!(rows.contains(&wanted), "{wanted:?} in:\n{report}");
    }
    // The columns line up.
    let widths: Vec<usize> = report.lines().take(12).map(|line| line.chars().count()).collect();
    assert!(widths.iter().all(|&width| width == widths[0] && width <= 80), "{report}");
    assert!(report.contains("note: made from source.obj and target.obj, whose licences hold"));

    assert_eq!(bench.succeed(&format!("inspect new.uvpair {SIZES}")), report);
    let mut as_json = json(&bench.succeed(&format!("{PAIR} {SIZES} --json")));
    let mut inspected = json(&bench.succeed(&format!("inspect new.uvpair {SIZES} --json")));
    let [of_pair, of_inspect] = [&mut as_json, &mut inspected]
        .map(|document| document.as_object_mut().unwrap().remove("uvgraft").unwrap());
    assert_eq!(of_pair["written"], serde_json::json!(["new.uvpair"]));
    assert_eq!(of_inspect["command"], "inspect");
    assert_eq!(of_inspect["written"], serde_json::json!([]));
    let fields = as_json.as_object_mut().unwrap();
    assert_eq!(fields.remove("linked_by").unwrap(), "vertex_map");
    assert_eq!(fields.remove("not_linked_by").unwrap(), serde_json::json!([]));
    assert_eq!(inspected, as_json);
}

/// A report without its first lines, which say how the meshes were linked.
fn after_method(report: &str) -> &str {
    let rest = report.strip_prefix("linked by the vertex map\n\n");
    rest.unwrap_or_else(|| panic!("another method in: {report}"))
}

#[test]
fn pairing_twice_gives_the_same_bytes() {
    let bench = Bench::new();
    bench.succeed(&format!("{PAIR} {SIZES} --note synthetic"));
    assert_eq!(bench.bytes("new.uvpair"), bench.bytes("my.uvpair"));
    // Over an existing file, and with a text map instead.
    let ids = (0..bench::SHEET_VERTICES).map(|vertex| bench::target_of(vertex).to_string());
    bench.write("ids.txt", ids.collect::<Vec<_>>().join("\n"));
    bench.succeed(&format!("{PAIR} {SIZES} --note synthetic").replace("ids.npy", "ids.txt"));
    assert_eq!(bench.bytes("new.uvpair"), bench.bytes("my.uvpair"));
}

#[test]
fn a_note_may_hold_any_text() {
    let bench = Bench::new();
    let note = "über \"alles\"\n\\ 日本 \u{1f600} version\":1 --json";
    let mut args: Vec<&str> = PAIR.split_whitespace().chain(SIZES.split_whitespace()).collect();
    args.extend(["--note", note]);
    let run = bench.run_args(&args);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let report = json(&bench.succeed(&format!("inspect new.uvpair {SIZES} --json")));
    assert_eq!(report["note"], note);
}

#[test]
fn previews_show_both_layouts() {
    let bench = Bench::new();
    let report = bench.succeed(&format!("{PAIR} {SIZES} --preview pair.png"));
    let again = bench.succeed(&format!("inspect new.uvpair {SIZES} --preview inspect.png"));
    assert_eq!(after_method(&report), again);
    assert_eq!(bench.bytes("pair.png"), bench.bytes("inspect.png"));
    assert!(bench.bytes("pair.png").starts_with(b"\x89PNG"));
    let picture = bench.texture("pair.png");
    let Size { width, height } = picture.size();
    assert!((1000..4000).contains(&width) && (500..3000).contains(&height), "{width}×{height}");
    assert_eq!(picture.channels(), Channels::Rgb);
    // Linked areas are coloured, though palely in the centre: 64 % of the left panel, 16 % of the
    // right one.
    let Texels::U8(values) = picture.texels() else { panic!("8 bits are enough for a picture") };
    let mut colored = [0usize; 2];
    for (index, texel) in values.chunks_exact(3).enumerate() {
        let spread = texel.iter().max().unwrap() - texel.iter().min().unwrap();
        let half = usize::from(index % width as usize > width as usize / 2);
        colored[half] += usize::from(spread > 40);
    }
    let half = (width * height / 2) as usize;
    assert!((half / 3..half * 2 / 3).contains(&colored[0]), "{colored:?} of {half}");
    assert!((half / 15..half / 5).contains(&colored[1]), "{colored:?} of {half}");
    // The quad without links is grey, not background.
    let [r, g, b] = texel_u8(&picture, width * 7 / 8, height * 3 / 4)[..] else { panic!("RGB") };
    assert!(r > 60 && r.abs_diff(g) < 20 && g.abs_diff(b) < 20, "{r} {g} {b}");
}

#[cfg(unix)]
#[test]
fn a_link_as_output_stays_a_link() {
    let bench = Bench::new();
    bench.write("kept.uvpair", "old");
    std::os::unix::fs::symlink("kept.uvpair", bench.path("new.uvpair")).unwrap();
    bench.succeed(&format!("{PAIR} {SIZES} --note synthetic"));
    assert!(bench.path("new.uvpair").is_symlink());
    assert_eq!(bench.bytes("kept.uvpair"), bench.bytes("my.uvpair"));
}

/// A reader that closes the pipe, like `head`, must not cause a panic.
#[test]
fn a_closed_standard_output_is_no_failure() {
    let bench = Bench::new();
    for option in ["", "--json"] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = bench.command();
        command.args(format!("inspect my.uvpair {SIZES} {option}").split_whitespace());
        let output = command.stdout(writer).stderr(std::process::Stdio::piped());
        let output = output.spawn().unwrap().wait_with_output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stderr), "");
        assert_eq!(output.status.code(), Some(0));
    }
}

#[test]
fn help_and_version_go_to_standard_output() {
    let bench = Bench::new();
    for (args, wanted) in [
        ("--help", &["pair", "inspect", "transfer", "demo", "--threads"][..]),
        ("-h", &["pair", "transfer", "Usage"]),
        ("help transfer", &["--onto"]),
        (
            "transfer --help",
            &["--onto", "--reverse", "lanczos3", "[default: 95]", "PNG, JPEG, WebP, TIFF, EXR"],
        ),
        ("pair --help", &["--vertex-map", "OBJ", "-1 for none", "--preview"]),
        ("inspect --help", &["--json", "--preview"]),
        ("map --help", &["--reverse", "* width - 0.5", "cv2.remap", "NaN"]),
        ("bench --help", &["--source-size", "[default: all]", "file to file", "memory"]),
        ("--version", &["uvgraft ", env!("CARGO_PKG_VERSION")]),
    ] {
        let text = bench.succeed(args);
        let on_one_line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        for wanted in wanted {
            assert!(on_one_line.contains(wanted.trim()), "{wanted} in `uvgraft {args}`:\n{text}");
        }
        let longest = text.lines().map(|line| line.chars().count()).max();
        assert!(longest <= Some(100), "`uvgraft {args}` is {longest:?} columns wide");
    }
    // Without a command there is nothing to do, and the help shows the options.
    let run = bench.run("");
    assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""));
    assert!(run.stderr.contains("Usage: uvgraft"), "{}", run.stderr);
}
