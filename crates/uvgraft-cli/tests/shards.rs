//! Shards of a batch, lists of textures, and rows about them.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::collections::BTreeMap;
use std::io::Write as _;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::bench::Bench;
use uvgraft::Channels;

/// A bench with a base and a number of textures in the folder `in`, each of its own colour.
fn bench_with(textures: u8) -> Bench {
    let bench = Bench::new();
    bench.paint("base.png", (64, 64), Channels::Rgb, &[9, 9, 9]);
    bench.make_folder("in");
    for index in 0..textures {
        bench.paint(&input(index), (32, 32), Channels::Rgb, &[index, 100, 200]);
    }
    bench
}

fn input(index: u8) -> String {
    format!("in/{index:03}.png")
}

/// The images of a folder and of its subfolders, with their bytes.
fn images(bench: &Bench, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let root = bench.path(folder);
    let content = bench.content().into_iter();
    let images = content.filter_map(|(path, bytes)| {
        let path = bench.path("").join(path);
        let name = path.strip_prefix(&root).ok()?.to_str()?.to_owned();
        name.ends_with(".png").then_some((name, bytes))
    });
    images.collect()
}

/// The number of images in a folder that may be written to at the same time.
fn count(bench: &Bench, folder: &str) -> usize {
    let entries = bench.path(folder).read_dir().into_iter().flatten().flatten();
    entries.filter(|entry| entry.path().extension().is_some_and(|end| end == "png")).count()
}

fn lines(bench: &Bench, name: &str) -> Vec<serde_json::Value> {
    let text = String::from_utf8(bench.bytes(name)).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

const TRANSFER: &str = "transfer my.uvpair in --onto base.png";

#[test]
fn shards_are_disjoint_parts_of_the_batch() {
    let bench = bench_with(40);
    bench.succeed(&format!("{TRANSFER} -o all"));
    let mut union = BTreeMap::new();
    for shard in 0..4 {
        bench.succeed(&format!("{TRANSFER} --shard {shard}/4 -o part{shard}"));
        let part = images(&bench, &format!("part{shard}"));
        assert!(!part.is_empty() && part.len() < 40, "{}", part.len());
        for (name, bytes) in part {
            assert_eq!(union.insert(name, bytes), None);
        }
    }
    assert!(union == images(&bench, "all"));

    // A texture more leaves the others where they are.
    bench.paint("in/more.png", (32, 32), Channels::Rgb, &[1, 2, 3]);
    let mut more = 0;
    for shard in 0..4 {
        bench.succeed(&format!("{TRANSFER} --shard {shard}/4 -o again{shard}"));
        let mut part = images(&bench, &format!("again{shard}"));
        more += usize::from(part.remove("more.png").is_some());
        assert!(part == images(&bench, &format!("part{shard}")));
    }
    assert_eq!(more, 1);
}

/// Which shard a texture belongs to must never change: batches of several versions go on.
#[test]
fn membership_is_pinned() {
    let bench = Bench::new();
    bench.paint("0001.png", (32, 32), Channels::Rgb, &[1, 2, 3]);
    // `int.from_bytes(hashlib.sha256(b"0001.png").digest()[:8], "big") % 64` in Python.
    let args = "transfer my.uvpair 0001.png --size 32 -o out.png --shard";
    let reported = bench.succeed("transfer my.uvpair 0001.png --size 32 -o out/ --shard 0/64");
    assert_eq!(reported, "no textures in shard 0/64\n");
    assert!(!bench.exists("out"));
    let index = PINNED;
    bench.succeed(&format!("transfer my.uvpair 0001.png --size 32 -o out/ --shard {index}/64"));
    assert!(bench.exists("out/0001.png"));
    // The output decides, not the source.
    let reported: Vec<String> =
        (0..3).map(|index| bench.succeed(&format!("{args} {index}/3"))).collect();
    assert_eq!(reported.iter().filter(|reported| reported.is_empty()).count(), 1, "{reported:?}");
    assert!(bench.exists("out.png"));
}

const PINNED: u32 = 10;

#[test]
fn shards_that_run_at_once_share_a_folder() {
    let bench = bench_with(40);
    bench.succeed(&format!("{TRANSFER} -o all"));
    let start = |shard: u32| {
        let mut command = bench.command();
        command.args(TRANSFER.split(' ')).args(["--skip-existing", "-o", "out"]);
        command.args(["--shard", &format!("{shard}/8"), "--jobs", "1"]);
        command.stdin(Stdio::null()).stdout(Stdio::null()).spawn().unwrap()
    };
    let shards: Vec<Child> = (0..8).map(start).collect();
    for mut shard in shards {
        assert_eq!(shard.wait().unwrap().code(), Some(0));
    }
    bench.assert_no_litter();
    assert!(images(&bench, "out") == images(&bench, "all"));
    let records: Vec<_> = (0..8)
        .map(|shard| format!("out/.uvgraft-manifest-{shard:04}-of-0008.jsonl"))
        .filter(|name| bench.exists(name))
        .flat_map(|name| lines(&bench, &name))
        .collect();
    assert_eq!(records.len(), 40);

    // Any number of shards, and none, find what is done.
    let done = |shard: &str| bench.succeed(&format!("{TRANSFER} --skip-existing -o out {shard}"));
    assert_eq!(done(""), "40 of 40 up to date\n");
    let of_three = (0..3).map(|shard| done(&format!("--shard {shard}/3")));
    let counts: Vec<usize> = of_three
        .map(|reported| {
            let words: Vec<&str> = reported.split_whitespace().collect();
            assert_eq!(words[0], words[2], "{reported}");
            words[0].parse().unwrap()
        })
        .collect();
    assert_eq!(counts.iter().sum::<usize>(), 40, "{counts:?}");
    // Records of other options do not hide those of the current ones, whichever file is read last.
    bench.succeed(&format!("{TRANSFER} --filter nearest --skip-existing -o out"));
    bench.succeed(&format!("{TRANSFER} --skip-existing -o out --shard 0/1"));
    assert_eq!(done(""), "40 of 40 up to date\n");
}

/// Processes of one machine append to one file.
#[test]
fn processes_without_shards_keep_records_whole() {
    let bench = bench_with(40);
    let start = |index: u8| {
        let mut command = bench.command();
        let sources = (0..10).map(|k| input(4 * k + index));
        command.args(["transfer", "my.uvpair", "--onto", "base.png", "--skip-existing"]);
        command.args(["-o", "out/"]).args(sources);
        command.stdin(Stdio::null()).stdout(Stdio::null()).spawn().unwrap()
    };
    let processes: Vec<Child> = (0..4).map(start).collect();
    for mut process in processes {
        assert_eq!(process.wait().unwrap().code(), Some(0));
    }
    assert_eq!(lines(&bench, "out/.uvgraft-manifest.jsonl").len(), 40);
    let reported = bench.succeed(&format!("{TRANSFER} --skip-existing -o out"));
    assert_eq!(reported, "40 of 40 up to date\n");
}

#[cfg(unix)]
#[test]
fn a_killed_shard_is_finished_by_the_next_run() {
    let bench = bench_with(40);
    bench.succeed(&format!("{TRANSFER} --size 512 -o all"));
    let wanted = images(&bench, "all");
    let args = format!("{TRANSFER} --size 512 --skip-existing --shard 0/1 -o out");
    // Again and again, as on machines that are taken away.
    for _ in 0..5 {
        let before = count(&bench, "out");
        let mut command = bench.command();
        command.args(args.split(' ')).args(["--jobs", "2"]);
        let mut process = command.stdin(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        while count(&bench, "out") <= before
            && process.try_wait().unwrap().is_none()
            && start.elapsed() < Duration::from_secs(60)
        {
            std::thread::sleep(Duration::from_millis(1));
        }
        // SIGKILL: nothing is cleaned up.
        process.kill().unwrap();
        process.wait().unwrap();
        // Whatever has its name is whole.
        for (name, bytes) in images(&bench, "out") {
            assert!(name.starts_with(".uvgraft-") || wanted[&name] == bytes, "{name}");
        }
    }
    let run = bench.run(&args);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(images(&bench, "out") == wanted);
    let reported = bench.run(&args).stdout;
    assert_eq!(reported, "40 of 40 up to date\n");
}

#[test]
fn lists_name_textures() {
    let bench = bench_with(4);
    bench.succeed(&format!("{TRANSFER} -o all"));
    bench.write("list.txt", "# faces\nin/000.png\n\nin/001.png\tsub/deep/one.png\r\nin/002.png");
    let transfer = "transfer my.uvpair --onto base.png --manifest list.txt -o";
    bench.succeed(&format!("{transfer} out"));
    let all = images(&bench, "all");
    let wanted = [("000.png", 0), ("002.png", 2), ("sub/deep/one.png", 1)];
    let wanted =
        wanted.map(|(name, index)| (name.to_owned(), all[&format!("{index:03}.png")].clone()));
    assert!(images(&bench, "out") == BTreeMap::from(wanted.clone()));

    // The subfolders of an existing folder are created too, and records have their names.
    bench.make_folder("old");
    bench.succeed(&format!("{transfer} old --skip-existing"));
    assert!(images(&bench, "old") == BTreeMap::from(wanted.clone()));
    let reported = bench.succeed(&format!("{transfer} old --skip-existing"));
    assert_eq!(reported, "3 of 3 up to date\n");
    let records = lines(&bench, "old/.uvgraft-manifest.jsonl");
    let mut names: Vec<&str> = records.iter().map(|it| it["output"].as_str().unwrap()).collect();
    names.sort_unstable();
    assert_eq!(names, ["000.png", "002.png", "sub/deep/one.png"]);

    // In shards, and from standard input.
    for shard in 0..3 {
        let mut command = bench.command();
        command.args("transfer my.uvpair --onto base.png --manifest - -o piped".split(' '));
        command.args(["--shard", &format!("{shard}/3")]);
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
        process.stdin.take().unwrap().write_all(&bench.bytes("list.txt")).unwrap();
        assert_eq!(process.wait().unwrap().code(), Some(0));
    }
    assert!(images(&bench, "piped") == BTreeMap::from(wanted));

    bench.write("formats.txt", "in/000.png\nin/001.png\tb.webp\n");
    bench.succeed("transfer my.uvpair --size 32 --manifest formats.txt --format webp -o formats");
    assert!(bench.exists("formats/000.webp") && bench.exists("formats/b.webp"));
}

#[test]
fn a_missing_texture_fails_alone() {
    let bench = bench_with(2);
    bench.write("list.txt", "in/000.png\nin/none.png\nin\tfolder.png\nin/001.png\n");
    let args = "transfer my.uvpair --onto base.png --manifest list.txt -o out";
    let run = bench.run(args);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("error: ") && run.stderr.contains("in/none.png"), "{}", run.stderr);
    assert!(run.stderr.contains("2 of 4 textures transferred"), "{}", run.stderr);
    assert_eq!(images(&bench, "out").len(), 2);
    bench.assert_no_litter();
}

#[test]
fn bad_lists_are_refused() {
    let bench = bench_with(2);
    let args = "transfer my.uvpair --onto base.png --manifest list.txt -o out";
    for (text, wanted) in [
        ("in/000.png\tout/a.png\tb\n", "list.txt: line 1: must be an image, or an image, a tab"),
        ("in/000.png\n\tb.png\n", "list.txt: line 2: the path of the image is missing"),
        (
            "# faces\nin/000.png\t../a.png\n",
            "list.txt: line 2: the output must be the path of a file",
        ),
        ("in/000.png\t/a.png\n", "list.txt: line 1: the output must be the path of a file"),
        ("in/000.png\ta.bmp\n", "list.txt: line 1: a.bmp: extension must be one of"),
        ("in/000\n", "list.txt: line 1: in/000: cannot infer the format of the output out/000"),
        ("in/000.png\nelsewhere/000.png\n", "have the same output out/000.png"),
        ("in/000.png\n./in/001.png\t000.png\n", "have the same output out/000.png"),
        ("\n# nothing\n", "list.txt: must list at least one texture"),
    ] {
        bench.write("list.txt", text);
        bench.refuse(args, &[wanted]);
        bench.refuse(&format!("{args} --shard 0/1"), &[wanted]);
    }
    bench.write("list.txt", "in/000.png\ta.png\n");
    bench
        .refuse(&format!("{args} --format webp"), &["list.txt: line 1: --format webp contradicts"]);
    bench.refuse(&args.replace("list.txt", "none.txt"), &["cannot read none.txt"]);
    bench.refuse(&args.replace("list.txt", "in"), &["in: must be a text file that lists textures"]);
    bench.refuse(&args.replace("list.txt", "base.png"), &["base.png: line 1: must be UTF-8 text"]);
    bench.refuse(
        &args.replace("-o out", "-o out.png"),
        &["with --manifest, the output must be a folder"],
    );
    bench.refuse(&format!("{args} --labels labels.png"), &["--labels"]);
    bench.write("over.txt", "in/000.png\t000.png\n");
    bench.refuse(
        "transfer my.uvpair --onto base.png --manifest over.txt -o in",
        &["output in/000.png is also an input"],
    );
    let both = bench.run("transfer my.uvpair in/000.png --manifest list.txt -o out");
    assert_eq!(both.code, Some(2));
    assert!(both.stderr.contains("cannot be used with"), "{}", both.stderr);
}

#[test]
fn bad_shards_are_refused() {
    let bench = bench_with(2);
    for (shard, wanted) in [
        ("4/4", "the shards of 4 are numbers 0 to 3, got 4"),
        ("0/0", "the number of shards must be at least 1, got 0"),
        ("a/b", "must be two whole numbers such as 0/64"),
        ("-1/4", "must be two whole numbers such as 0/64"),
        ("1", "must be two whole numbers such as 0/64"),
    ] {
        bench.refuse(&format!("{TRANSFER} --shard {shard} -o out"), &[wanted]);
    }
    let sharded = format!("{TRANSFER} --shard 0/2 -o out");
    bench.refuse(&format!("{sharded} --mask mask.png"), &["--shard cannot be used with --mask"]);
    let material = "transfer my.uvpair --map albedo=in/000.png --size 32 --shard 0/2 -o out";
    bench.refuse(material, &["--shard cannot be used with --map"]);
}

#[test]
fn rows_tell_what_became_of_textures() {
    let bench = bench_with(3);
    bench.write("in/broken.png", "must be an image");
    let args = format!("{TRANSFER} --skip-existing --report rows.jsonl -o out");
    assert_eq!(bench.run(&args).code, Some(2));
    let rows = lines(&bench, "rows.jsonl");
    assert_eq!(rows.len(), 4);
    let of = |rows: &[serde_json::Value], source: &str| {
        rows.iter().find(|row| row["source"] == source).unwrap().clone()
    };
    let row = of(&rows, "in/000.png");
    assert_eq!((&row["output"], &row["status"]), (&"out/000.png".into(), &"written".into()));
    assert_eq!(row["bytes"], bench.bytes("out/000.png").len());
    assert!(row["ms"].as_f64().unwrap() >= 0.0 && row["error"].is_null());
    let row = of(&rows, "in/broken.png");
    assert_eq!(row["status"], "failed");
    assert!(row["error"].as_str().unwrap().contains("not a supported image"), "{row}");
    // Rows of further runs follow.
    assert_eq!(bench.run(&args).code, Some(2));
    let rows = lines(&bench, "rows.jsonl");
    assert_eq!(rows.len(), 8);
    assert_eq!(of(&rows[4..], "in/000.png")["status"], "up to date");

    bench.refuse(&format!("{TRANSFER} --report my.uvpair -o out"), &["must be a .jsonl file"]);
    bench.refuse(&format!("{TRANSFER} --report no/rows.jsonl -o out"), &["no does not exist"]);
}

/// A list of a million lines takes seconds; here of a tenth, in a build that is not optimised for
/// speed, and with one texture in the shard.
#[test]
fn long_lists_are_read_fast() {
    let bench = bench_with(1);
    let mut list: String = (0..100_000).map(|index| format!("in/none-{index}.png\n")).collect();
    list += "in/000.png\n";
    bench.write("list.txt", list);
    let start = Instant::now();
    let args = "transfer my.uvpair --onto base.png --manifest list.txt -o out --shard";
    let run = bench.run(&format!("{args} 0/4000000000"));
    assert_eq!((run.code, run.stdout.as_str()), (Some(0), "no textures in shard 0/4000000000\n"));
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}
