//! Which part of the surface is transferred, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::Bench;
use crate::bench::plane::{self, LINKED, source_columns, target_columns};
use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_io::vertex_map;

/// A bench with a white texture for the source, and masks and lists of its left half.
fn bench() -> Bench {
    let bench = plane::bench();
    bench.paint("white.png", (64, 64), Channels::Grey, &[255]);
    let half = source_columns(0..=4);
    vertex_map::save_npy(&half, bench.path("half.npy")).unwrap();
    vertex_map::save_npy(&source_columns(5..=8), bench.path("right.npy")).unwrap();
    bench.write("half.txt", text(&half));
    // In the target it is in columns 4 to 8, and unlinked vertices do not count.
    bench.write("body.txt", text(&target_columns(0..=8)));
    bench.write(
        "parts.json",
        format!(
            "{{\"left\": {half:?}, \"right\": {:?}, \"corner\": [0, 1, 9, 10]}}",
            source_columns(4..=8)
        ),
    );
    // Over the centre of a column of quads, without any vertex.
    bench.draw("painted.png", (64, 64), |x, _| [if x < 28 { 255 } else { 0 }]);
    bench.draw("on_target.png", (128, 128), |x, _| [if x < 60 { 255 } else { 0 }]);
    bench
}

fn text(ids: &[u32]) -> String {
    ids.iter().map(|id| format!("{id}\n")).collect()
}

/// Transfers white onto black, and returns the white texels in the centre row of the linked area,
/// and in the centre column of its left half.
fn white(bench: &Bench, options: &str) -> [Vec<u32>; 2] {
    let run = bench.run(&format!(
        "transfer plane.uvpair white.png --onto #000 --size 128 --gutter 0 --filter nearest \
         {options} -o out.png"
    ));
    let reported = ["", "note: --region has no effect: it covers everything linked\n"];
    assert!(run.code == Some(0) && reported.contains(&run.stderr.as_str()), "{options}: {run:?}");
    let out = bench.texture("out.png");
    let is_white = |x, y| match out.get(x, y, 0) {
        0.0 => false,
        1.0 => true,
        grey => panic!("{options}: {grey} at {x}, {y}"),
    };
    [
        (0..128).filter(|&x| is_white(x, 63)).collect(),
        (0..128).filter(|&y| is_white(48, y)).collect(),
    ]
}

#[test]
fn vertices_groups_and_masks() {
    let bench = bench();
    let all: Vec<u32> = LINKED.collect();
    let half: Vec<u32> = (32..64).collect();
    assert_eq!(white(&bench, "")[0], all);
    for region in ["half.npy", "half.txt", "source:half.npy", "target:body.txt", "parts.json#left"]
    {
        assert_eq!(white(&bench, &format!("--region {region}")), [half.clone(), all.clone()]);
    }
    for regions in [
        "parts.json#left,right",
        "parts.json#left --region parts.json#right",
        "parts.json#right --region target:body.txt",
    ] {
        assert_eq!(white(&bench, &format!("--region {regions}"))[0], all, "{regions}");
    }
    // Painted masks are followed to about half a texel, even inside triangles.
    for region in ["painted.png", "source:painted.png", "target:on_target.png"] {
        let [row, column] = white(&bench, &format!("--region {region}"));
        let wanted: Vec<u32> = (32..60).collect();
        assert!(row.len().abs_diff(wanted.len()) <= 1, "{region}: {row:?}");
        assert_eq!((row[0], column), (32, all.clone()), "{region}");
    }
    // A file name may look as if it named groups.
    bench.derive("odd#name.txt", "half.txt", |_| {});
    assert_eq!(white(&bench, "--region odd#name.txt")[0], half);
}

#[test]
fn a_part_is_left_out() {
    let bench = bench();
    let right: Vec<u32> = (64..96).collect();
    for exclude in ["half.npy", "target:body.txt", "parts.json#left,corner"] {
        assert_eq!(white(&bench, &format!("--exclude {exclude}"))[0], right, "{exclude}");
    }
    let [row, _] = white(&bench, "--exclude painted.png");
    assert!((35..=37).contains(&row.len()) && row.last() == Some(&95), "{row:?}");
    let [row, column] = white(&bench, "--region half.npy --exclude parts.json#corner");
    // The corner is one quad, which is not in the column.
    assert_eq!((row.len(), column.len()), (32, 64));
    assert_eq!(bench.texture("out.png").get(33, 33, 0), 0.0);
}

#[test]
fn regions_grow_and_shrink() {
    let bench = bench();
    let end = |options: &str| {
        let [row, column] = white(&bench, &format!("--region half.npy {options}"));
        (row[0], row[row.len() - 1] + 1, column.len())
    };
    // A ring is a quad of 8 texels; a region never leaves the linked area.
    assert_eq!(end("--grow 1ring"), (32, 72, 64));
    assert_eq!(end("--grow 3rings"), (32, 88, 64));
    assert_eq!(end("--grow 1000rings"), (32, 96, 64));
    // Shrinking starts from the edge of the linked area, too.
    assert_eq!(end("--grow -1ring"), (40, 56, 48));
    assert_eq!(end("--grow 0rings"), (32, 64, 64));
    assert_eq!(end("--grow 0"), (32, 64, 64));
    // Lengths: 5 mm are 4 texels, in any unit.
    for grow in ["5mm", "0.5cm", "0.005m", "+5mm", "0.19685039in"] {
        assert_eq!(end(&format!("--unit m --grow {grow}")), (32, 68, 64), "{grow}");
        let shrink = grow.trim_start_matches('+');
        assert_eq!(end(&format!("--unit m --grow -{shrink}")), (36, 60, 56), "-{grow}");
    }
    // The same coordinates in another unit.
    assert_eq!(end("--unit mm --grow 0.005mm").1, 68);
    assert_eq!(end("--unit in --grow -0.0127cm").1, 60);
}

/// A length means nothing without the mesh's unit, which defaults to metres, with a note.
#[test]
fn the_unit_is_said_where_it_counts() {
    let bench = bench();
    let note = |options: &str| {
        let run = bench.run(&format!(
            "transfer plane.uvpair white.png --onto #000 --size 128 {options} -o out.png"
        ));
        assert_eq!(run.code, Some(0), "{options}: {}", run.stderr);
        run.stderr
    };
    for silent in [
        "",
        "--region half.npy",
        "--region half.npy --grow 2rings",
        "--feather 0",
        "--feather 0mm",
        "--region half.npy --grow 0.0",
        "--feather 10mm --unit m",
        "--blend membrane --unit m --tone none",
        "--blend none",
        "--preview preview.png",
    ] {
        assert_eq!(note(silent), "", "{silent}");
    }
    for said in ["--feather 10mm", "--grow -5mm", "--blend feather", "--feather 1cm --grow -1cm"] {
        let note = note(said);
        assert_eq!(
            note,
            "note: the mesh has no unit; assuming metres, which makes its largest dimension 16.0 cm; use --unit to change this\n",
            "{said}"
        );
    }
    bench.paint("sheet.png", (128, 128), Channels::Rgb, &[9, 9, 9]);
    let run = bench.run("seams plane.uvpair sheet.png --distance 3mm");
    assert!(run.code == Some(0) && run.stderr.starts_with("note: the mesh has no unit"), "{run:?}");
    let run = bench.run("seams plane.uvpair sheet.png");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
}

#[test]
fn seams_take_regions() {
    let bench = bench();
    // Two colours that meet along the edge of the half.
    bench.draw("sheet.png", (128, 128), |x, _| if x < 64 { [200, 60, 60] } else { [60, 60, 200] });
    let rim = |options: &str| {
        let printed = bench.succeed(&format!("seams plane.uvpair sheet.png --json {options}"));
        let value: serde_json::Value = serde_json::from_str(&printed).unwrap();
        let rim = &value["edges"]["rim"];
        let [length, mean] =
            [&rim["length"], &rim["delta_e"]["mean"]].map(|v| v.as_f64().unwrap_or(f64::NAN));
        assert!(length.is_finite() && mean.is_finite(), "{options}: {rim}");
        (length, mean)
    };
    let (length, all) = rim("");
    assert!((length - 0.32).abs() < 1e-6, "{length}");
    let (length, half) = rim("--region half.npy");
    assert!((length - 0.24).abs() < 1e-6, "{length}");
    assert!(half > 10.0 && half > all + 5.0, "{half} {all}");
    let (length, inner) = rim("--region half.npy --grow -1ring");
    assert!((length - 0.16).abs() < 1e-6, "{length}");
    assert_eq!(inner, 0.0);
    bench.refuse(
        "seams plane.uvpair sheet.png --region half.npy --exclude half.txt",
        &["region is empty"],
    );
    bench.refuse(
        "seams plane.uvpair sheet.png --region half.npy --picture half.npy",
        &["half.npy", ".png"],
    );
    bench.refuse(
        "seams plane.uvpair sheet.png --region painted.png --picture painted.png",
        &["painted.png is also an input"],
    );
}

#[test]
fn empty_regions_are_refused() {
    let bench = bench();
    bench.write("one.txt", "3\n");
    bench.write("beyond.txt", text(&target_columns(13..=16)));
    bench.paint("black.png", (8, 8), Channels::Grey, &[0]);
    bench.paint("clear.png", (8, 8), Channels::Rgba, &[255, 255, 255, 0]);
    let cases: &[(&str, &[&str])] = &[
        ("--region half.npy --exclude half.npy", &["the region is empty"]),
        ("--exclude parts.json#left,right", &["the region is empty"]),
        ("--region one.txt", &["one.txt: the region is empty", "span no linked triangle"]),
        ("--region target:beyond.txt", &["the region is empty: it contains no linked triangle"]),
        ("--region black.png", &["black.png: the region is empty", "black at every vertex"]),
        ("--region target:clear.png", &["clear.png: the region is empty", "black"]),
        (
            "--source-mask black.png --feather 1mm",
            &["black.png: --source-mask must be white where"],
        ),
    ];
    for (options, wanted) in cases {
        bench.refuse(
            &format!("transfer plane.uvpair white.png --size 32 --unit m {options} -o out.png"),
            wanted,
        );
    }
}

#[test]
fn files_that_are_no_regions() {
    let bench = bench();
    let half = bench.bytes("half.npy").len();
    bench.derive("cut.npy", "half.npy", |bytes| bytes.truncate(half - 3));
    bench.derive("head.npy", "half.npy", |bytes| bytes.truncate(40));
    bench.derive("text.png", "half.txt", |_| {});
    bench.derive("image.npy", "white.png", |_| {});
    bench.derive("list.json", "half.npy", |_| {});
    bench.derive("list.pkl", "half.npy", |_| {});
    bench.write("beyond.txt", "0 1 81");
    bench.write("below.txt", "0 -1");
    bench.write("words.txt", "left ear");
    bench.write("empty.txt", "");
    bench.write("float.txt", "0.5 1.0");
    bench.write("array.json", "[1, 2, 3]");
    bench.write("deep.json", "{\"left\": {\"more\": [1]}}");
    bench.write("cut.json", "{\"left\": [1, 2");
    bench.write("beyond.json", "{\"left\": [1, 2, 100000]}");
    // What `pickle.dumps` produces for an object whose `__reduce__` returns os.system.
    bench.write("evil.pkl", b"\x80\x04cos\nsystem\n\x8c\x08touch oh!\x85R.");
    bench.write("posix.pkl", b"cposix\nsystem\n(S'touch owned'\ntR.");
    bench.make_folder("folder");
    bench.make_folder("folder.png");
    let nan = Texture::new(
        Size::square(8),
        Channels::Grey,
        Encoding::Linear,
        Texels::F32(vec![f32::NAN; 64]),
    );
    bench.save("nan.exr", nan.unwrap());
    let cases: &[(&str, &[&str])] = &[
        ("none.npy", &["none.npy: ", "No such file"]),
        ("none.png", &["none.png", "No such file"]),
        ("none.json#left", &["none.json: ", "No such file"]),
        ("target:none.npy", &["none.npy: ", "No such file"]),
        ("source:", &["'source:'", "--region", "must be a file"]),
        ("", &["--region", "must be a file"]),
        ("#left", &["'#left'", "--region", "must be a file"]),
        ("folder", &["folder: "]),
        ("folder.png", &["folder.png"]),
        (
            "source.obj",
            &["source.obj: must be a vertex list (.npy, .txt), vertex groups (.pkl, .json)"],
        ),
        ("plane.uvpair", &["plane.uvpair: must be a vertex list"]),
        ("cut.npy", &["cut.npy: ", "bytes"]),
        ("head.npy", &["head.npy: ", "truncated"]),
        ("image.npy", &["image.npy: "]),
        ("text.png", &["text.png: not a supported image"]),
        (
            "beyond.txt",
            &["beyond.txt: entry 3: must be a vertex of the mesh, from 0 to 80, got 81"],
        ),
        ("target:body.txt --region body.txt", &["body.txt: ", "from 0 to 80"]),
        ("below.txt", &["below.txt: entry 2: must be"]),
        ("words.txt", &["words.txt: line 1: must be an integer, got `left`"]),
        ("empty.txt", &["empty.txt: ", "empty"]),
        ("float.txt", &["float.txt: line 1: ", "`0.5`"]),
        ("half.npy#left", &["half.npy holds no named groups", "#left", ".pkl or .json"]),
        ("painted.png#left", &["painted.png holds no named groups"]),
        (
            "parts.json",
            &["parts.json holds named groups", "parts.json#corner", "corner, left, right"],
        ),
        ("parts.json#", &["parts.json holds named groups", "corner, left, right"]),
        ("parts.json#,", &["parts.json holds named groups", "corner, left, right"]),
        ("parts.json#ear", &["parts.json: no group `ear`; the file has `corner`, `left`, `right`"]),
        ("parts.json#left,ear", &["no group `ear`"]),
        ("array.json#left", &["array.json: invalid JSON: "]),
        ("deep.json#left", &["deep.json: "]),
        ("cut.json#left", &["cut.json: invalid JSON: ", "EOF"]),
        (
            "beyond.json#left",
            &["beyond.json: group `left`: entry 3: must be a vertex", "0 to 80, got 100000"],
        ),
        ("list.json#left", &["got an NPY array"]),
        ("list.pkl#left", &["got an NPY array"]),
        ("evil.pkl#left", &["evil.pkl: ", "os.system"]),
        ("posix.pkl#left", &["posix.pkl: ", "posix.system"]),
        ("nan.exr", &["nan.exr: the region is empty"]),
    ];
    for (region, wanted) in cases {
        for option in ["--region", "--exclude"] {
            let line = "transfer plane.uvpair white.png --size 32 --unit m";
            let mut args: Vec<&str> = line.split_whitespace().collect();
            args.push(option);
            // Some cases have two regions.
            let mut parts = region.split(' ');
            args.push(parts.next().unwrap());
            args.extend(parts);
            args.extend(["-o", "out.png"]);
            let wanted: Vec<String> =
                wanted.iter().map(|text| text.replace("--region", option)).collect();
            bench.refuse_args(&args, &wanted.iter().map(String::as_str).collect::<Vec<_>>());
        }
    }
    assert!(!bench.exists("owned") && !bench.exists("oh!"));
}

#[test]
fn lengths_that_are_none() {
    let bench = bench();
    let cases: &[(&str, &[&str])] = &[
        ("--grow five", &["'five'", "--grow", "15mm", "2rings"]),
        ("--grow 5miles", &["'5miles'", "15mm", "got `miles`"]),
        ("--grow 1e400m", &["'1e400m'"]),
        ("--grow nanmm", &["'nanmm'"]),
        ("--grow infm", &["'infm'"]),
        ("--grow 2.5rings", &["'2.5rings'", "such as 2rings"]),
        ("--grow 99999rings", &["'99999rings'", "-1000 to 1000"]),
        ("--grow --region", &["--grow"]),
        ("--feather -5mm", &["'-5mm'", "--feather", "at least 0"]),
        ("--feather=-5mm", &["'-5mm'", "--feather", "at least 0"]),
        ("--feather 10", &["'10'", "--feather", "must have a unit", "10mm, 10cm, 10m or 10in"]),
        ("--feather 10 mm", &["'10'", "must have a unit, without a space before it"]),
        ("--feather 10 cm", &["'10'", "without a space"]),
        ("--feather 5 inches", &["'5'", "without a space"]),
        ("--feather 5inches", &["mm, cm, m or in", "got `inches`"]),
        ("--feather 10px", &["mm, cm, m or in", "got `px`"]),
        ("--feather nan", &["'nan'", "must be a number with a unit"]),
        ("--feather 0,5mm", &["'0,5mm'", "such as 15mm, 1.5cm"]),
        ("--grow -0.02", &["'-0.02'", "must have a unit", "-0.02mm", "2rings"]),
        ("--grow 1e3", &["'1e3'", "must have a unit"]),
        ("--unit feet --feather 1mm", &["'feet'", "mm, cm, m, in"]),
        ("--feather 1e308m --unit mm", &["'1e308m'", "--feather", "at most 1e9"]),
        ("--grow -1e308m", &["'-1e308m'", "--grow", "at most 1e9"]),
    ];
    for (options, wanted) in cases {
        bench.refuse(
            &format!("transfer plane.uvpair white.png --size 32 {options} -o out.png"),
            wanted,
        );
    }
    bench.refuse_args(
        &["transfer", "plane.uvpair", "white.png", "--feather", "10mm mm", "-o", "out.png"],
        &["'10mm mm'", "must be a number with a unit"],
    );
    bench.paint("sheet.png", (128, 128), Channels::Rgb, &[9, 9, 9]);
    bench.refuse("seams plane.uvpair sheet.png --distance 3", &["'3'", "must have a unit"]);
    bench.refuse(
        "seams plane.uvpair sheet.png --distance 3 mm",
        &["'mm'", "tip: a unit follows its number without a space, as in 3mm"],
    );
    // The smallest lengths are lengths, too.
    for option in ["--region half.npy --grow", "--feather", "--blend membrane --feather"] {
        let line = "transfer plane.uvpair white.png --onto #808080 --size 32 --unit mm";
        for length in ["1e-300mm", "1e-9m"] {
            bench.succeed(&format!("{line} {option} {length} -o out.png"));
        }
    }
}

/// The linked square is 80 mm wide, and its left half 40 mm. Distances are found to within a fifth of an
/// edge where fronts meet, so the centre of the square is at 36.6 mm.
#[test]
fn lengths_beyond_the_region_are_refused_with_its_size() {
    let bench = bench();
    bench.paint("sheet.png", (128, 128), Channels::Rgb, &[9, 9, 9]);
    let cases: &[(&str, &[&str])] = &[
        ("--feather 10m", &["--feather must be at most 36.6mm", "innermost point", "got 10m"]),
        ("--feather 41mm", &["at most 36.6mm", "got 41mm"]),
        ("--feather 1e3mm", &["at most 36.6mm", "got 1000mm"]),
        ("--feather 1e9m", &["at most 36.6mm"]),
        ("--blend membrane --feather 5in", &["at most 36.6mm", "got 5in"]),
        ("--region half.npy --feather 21mm", &["at most 20mm", "got 21mm"]),
        (
            "--region half.npy --grow -15mm --blend feather",
            &["at most 4.9", "got 10mm, the default"],
        ),
        ("--grow -900mm", &["--grow leaves nothing of the region", "is 36.6mm from its boundary"]),
        ("--grow -1m", &["--grow leaves nothing of the region", "is 36.6mm from"]),
        ("--grow -37mm", &["--grow leaves nothing of the region"]),
        ("--grow -9rings", &["--grow leaves nothing of the region", "is 36.6mm from"]),
        ("--region half.npy --grow 1m", &["--grow must be at most 40mm", "--region"]),
        ("--region half.npy --grow 5in", &["--grow must be at most 40mm"]),
        ("--grow 5mm", &["--grow needs --region"]),
        ("--grow 2rings", &["--grow needs --region"]),
    ];
    for (options, wanted) in cases {
        let line = "transfer plane.uvpair white.png --onto #808080 --size 32 --unit m";
        bench.refuse(&format!("{line} {options} -o out.png"), wanted);
    }
    // In a mesh of another unit, as whoever wrote the length thinks of it.
    bench.refuse(
        "transfer plane.uvpair white.png --size 32 --unit in --feather 10mm -o out.png",
        &["--feather must be at most 0.0366in", "got 10mm"],
    );
    for options in
        ["--feather 36.6mm", "--grow -30mm", "--region half.npy --grow 40mm --feather 20mm"]
    {
        let line = "transfer plane.uvpair white.png --onto #808080 --size 32 --unit m";
        let run = bench.run(&format!("{line} {options} -o out.png"));
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{options}");
    }
    // A square of 5 mm.
    let line = "transfer plane.uvpair white.png --onto #808080 --size 32 --unit m --grow -34mm";
    let run = bench.run(&format!("{line} -o out.png"));
    assert_eq!(run.code, Some(0));
    let wanted =
        "warning: --grow leaves only 0.68 % of the region, whose innermost point is 36.6mm";
    assert!(run.stderr.starts_with(wanted), "{}", run.stderr);
    bench.refuse(
        "seams plane.uvpair sheet.png --unit m --distance 1m",
        &["--distance must be at most 160mm", "got 1m"],
    );
    bench.refuse(
        "seams plane.uvpair sheet.png --unit m --region half.npy --grow -1m",
        &["--grow leaves nothing"],
    );
}

/// What selects everything, or excludes what is outside, does nothing, and is told.
#[test]
fn parts_that_change_nothing_are_reported() {
    let bench = bench();
    bench.paint("all.png", (64, 64), Channels::Grey, &[255]);
    let said = |options: &str| {
        let line = "transfer plane.uvpair white.png --onto #808080 --size 32";
        let run = bench.run(&format!("{line} {options} -o out.png"));
        assert_eq!(run.code, Some(0), "{options}: {}", run.stderr);
        run.stderr
    };
    let everything = "note: --region has no effect: it covers everything linked\n";
    for region in ["all.png", "parts.json#left,right", "half.npy --region parts.json#right"] {
        assert_eq!(said(&format!("--region {region}")), everything, "{region}");
    }
    assert_eq!(
        said("--region parts.json#left --exclude parts.json#right"),
        "note: --exclude parts.json has no effect: outside of the region\n"
    );
    for reported in
        ["--region half.npy", "--exclude half.npy", "--region half.npy --exclude parts.json#corner"]
    {
        assert_eq!(said(reported), "", "{reported}");
    }
}

/// Masks are laid over layouts, whose images all have one shape.
#[test]
fn painted_masks_have_the_shape_of_textures() {
    let bench = bench();
    bench.draw("wide.png", (128, 64), |x, _| [if x < 50 { 255 } else { 0 }]);
    bench.draw("tall.png", (30, 64), |x, _| [if x < 15 { 255 } else { 0 }]);
    bench.draw("rounded.png", (33, 32), |x, _| [if x < 15 { 255 } else { 0 }]);
    bench.paint("base.png", (96, 96), Channels::Grey, &[9]);
    for (options, wanted) in [
        ("--region wide.png", ["wide.png: must have the aspect ratio of the texture", "64×64"]),
        ("--exclude tall.png", ["tall.png: must have the aspect ratio of the texture", "30×64"]),
        ("--region target:wide.png", ["wide.png: must have the aspect ratio of the base", "96×96"]),
        (
            "--exclude target:tall.png",
            ["tall.png: must have the aspect ratio of the base", "96×96"],
        ),
    ] {
        bench.refuse(
            &format!("transfer plane.uvpair white.png --onto base.png {options} -o out.png"),
            &wanted,
        );
    }
    bench.succeed("transfer plane.uvpair white.png --size 32 --region rounded.png -o out.png");
    // A texture of the same shape as the mask.
    bench.paint("flat.png", (64, 32), Channels::Grey, &[255]);
    bench.succeed("transfer plane.uvpair flat.png --size 32 --region wide.png -o out.png");
    bench.refuse(
        "transfer plane.uvpair --reverse white.png --onto base.png --region wide.png -o out.png",
        &["wide.png: must have the aspect ratio of the base"],
    );
    // The shape of the result is another matter, and a colour has none.
    for onto in ["--onto base.png --size 40x30", "--onto #808080 --size 40x30"] {
        bench.succeed(&format!(
            "transfer plane.uvpair white.png {onto} --region target:on_target.png -o out.png"
        ));
    }
}

#[test]
fn other_options_go_with_regions() {
    let bench = bench();
    let all: Vec<u32> = LINKED.collect();
    // In reverse: the region still refers to the pair's source.
    bench.paint("sheet.png", (128, 128), Channels::Grey, &[255]);
    bench.succeed(
        "transfer plane.uvpair sheet.png --reverse --onto #000 --size 64 --gutter 0 --filter nearest \
         --region half.npy -o out.png",
    );
    let out = bench.texture("out.png");
    let row: Vec<u32> = (0..64).filter(|&x| out.get(x, 31, 0) == 1.0).collect();
    assert_eq!(row, (0..32).collect::<Vec<u32>>());
    bench.succeed(
        "transfer plane.uvpair sheet.png --reverse --onto #000 --size 64 --gutter 0 --filter nearest \
         --region target:body.txt --feather 10mm --unit m -o out.png",
    );
    let out = bench.texture("out.png");
    assert!(
        (0..64).all(|x| (out.get(x, 31, 0) > 0.0) == (1..31).contains(&x) || x == 0 || x == 31)
    );
    assert_eq!(white(&bench, "--data --region half.npy")[0].len(), 32);
    assert_eq!(white(&bench, "--data")[0], all);
    bench.succeed(
        "transfer plane.uvpair white.png --onto #000 --size 128 --gutter 0 --fit --filter bilinear \
         --region half.npy -o out.png",
    );
    let out = bench.texture("out.png");
    for (x, wanted) in [(31, 0.0), (34, 1.0), (60, 1.0), (66, 0.0), (96, 0.0)] {
        assert_eq!(out.get(x, 63, 0), wanted, "{x}");
    }
}
