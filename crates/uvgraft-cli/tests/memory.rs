//! The bound on memory holds, or the transfer is refused.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

mod bench;

use std::process::Stdio;
use std::time::Duration;

use bench::Bench;
use uvgraft::{Channels, Depth};
use uvgraft_figure::Figure;
use uvgraft_tests::greedy;
use uvgraft_tests::strip::Strip;

/// Runs a command, and returns its exit code, its messages and its peak memory in MiB.
fn peak(bench: &Bench, args: &str) -> (Option<i32>, String, u64) {
    let mut command = bench.command();
    command.args(args.split_whitespace()).stdin(Stdio::null()).stderr(Stdio::piped());
    let mut program = command.stdout(Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", program.id());
    let mut peak = 0;
    while program.try_wait().unwrap().is_none() {
        // The system keeps the peak, so that only one of the last moments can be missed.
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let found = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = found.and_then(|text| text.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        peak = peak.max(kib.unwrap_or(0) >> 10);
        std::thread::sleep(Duration::from_millis(1));
    }
    let output = program.wait_with_output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap(), peak)
}

/// Runs a command with bounds, of which each holds or is refused. Returns how often either happened.
#[track_caller]
fn within(bench: &Bench, command: &str, bounds: &[u64]) -> (usize, usize) {
    let (mut held, mut refused) = (0, 0);
    for bound in bounds {
        let args = format!("{command} --threads 2 --memory {bound}M");
        let (code, messages, peak) = peak(bench, &args);
        match code {
            Some(0) => {
                assert!(peak <= *bound, "{args}: took {peak} MiB");
                held += 1;
            }
            Some(2) if messages.contains("no viewer") => {}
            Some(2) => {
                assert!(messages.contains("--memory allows"), "{args}: {messages}");
                refused += 1;
            }
            code => panic!("{args}: {code:?}, {messages}"),
        }
        let _ = std::fs::remove_dir_all(bench.path("many"));
    }
    (held, refused)
}

#[test]
fn the_bound_holds_or_the_transfer_is_refused() {
    let bench = Bench::of_figure(&Figure::new(), 2048);
    bench.paint_noise("deep.tif", (1024, 1024), Channels::Rgb, Depth::U16);
    bench.paint_noise("float.exr", (1024, 1024), Channels::Rgb, Depth::F32);
    let transfers = [
        "face.png --onto base.png -o out.png",
        "face.png --onto base.png --blend membrane --tone both -o out.png",
        "face.png --onto base.png -o out.webp",
        "face.png --onto base.png --size 3000 -o out.tif",
        "float.exr --onto base.png -o out.exr",
        "deep.tif --size 2048 --fit --fit-steps 1 -o out.png",
        "face.png deep.tif float.exr --onto base.png --format png --jobs 3 -o many",
    ];
    let (mut held, mut refused) = (0, 0);
    for transfer in transfers {
        let command = format!("transfer demo.uvpair {transfer}");
        let found = within(&bench, &command, &[40, 90, 160, 250, 600, 1500]);
        (held, refused) = (held + found.0, refused + found.1);
    }
    assert!(held >= 20 && refused >= 7, "{held} held, {refused} refused");
}

/// Some decoders need more than the texels: floats of EXR, canvases of WebP, coefficients of progressive JPEG, a
/// copy to turn what a camera stored on its side.
#[test]
fn decoders_are_part_of_the_bound() {
    let bench = Bench::of_figure(&Figure::new(), 256);
    bench.paint("flat.webp", (4096, 4096), Channels::Rgb, &[90, 70, 60]);
    bench.paint("flat.png", (4096, 4096), Channels::Rgb, &[90, 70, 60]);
    bench.write("progressive.jpg", flat_progressive_jpeg(4096, false));
    bench.write("turned.jpg", flat_progressive_jpeg(4096, true));
    let mut found = Vec::new();
    for base in ["flat.webp", "progressive.jpg", "turned.jpg", "flat.png"] {
        let command = format!("transfer demo.uvpair face.png --onto {base} -o out.png");
        found.push(within(&bench, &command, &[85, 100, 115, 135, 160, 200]));
    }
    // Two of three texels' bytes are enough for a PNG, whose rows are decoded one by one.
    assert_eq!(found[3], (6, 0), "{found:?}");
    assert!(found[..3].iter().all(|(held, refused)| held * refused > 0), "{found:?}");
}

#[test]
fn measuring_is_refused_beyond_the_bound() {
    let bench = Bench::of_figure(&Figure::new(), 2048);
    bench.paint("flat.webp", (2048, 2048), Channels::Rgba, &[90, 70, 60, 200]);
    bench.paint_noise("deep.tif", (2048, 2048), Channels::Rgb, Depth::U16);
    let bounds = [40, 70, 100, 150, 220, 330, 500, 800];
    for command in [
        "compare base.png base.png --metrics l1,ssim",
        "compare base.png flat.webp --metrics l1,ssim --heatmap out.png",
        "compare deep.tif base.png --metrics ssimulacra2 --mask base.png",
        "seams demo.uvpair base.png --onto base.png --face face.png",
        "seams demo.uvpair deep.tif",
        "roundtrip demo.uvpair base.png --via 1024 --metrics l1 --repeats 1",
        "roundtrip demo.uvpair flat.webp --via 2048 --metrics l1 --repeats 1 --baseline affine",
        "roundtrip demo.uvpair deep.tif --via 1024 --metrics l1 --repeats 1 --fit",
    ] {
        let (held, refused) = within(&bench, command, &bounds);
        assert!(held > 0 && refused > 0, "{command}: {held} held, {refused} refused");
    }
    // Without the option, no more than most machines have: a few kilobytes could ask for more.
    bench.paint("huge.png", (32_000, 32_000), Channels::Rgb, &[90, 70, 60]);
    for command in ["compare huge.png huge.png", "roundtrip demo.uvpair base.png --via 16384 --fit"]
    {
        let (code, messages, peak) = peak(&bench, command);
        assert_eq!(code, Some(2), "{command}: {messages}");
        assert!(messages.contains("--memory allows 6144"), "{messages}");
        assert!(peak < 60, "{command}: {peak} MiB");
    }
}

/// No file may ask for more than 64 MB and 50 times its size, unless an array or an image of it says that it is
/// large: all that these have is refused.
#[test]
fn small_scenes_take_little_memory() {
    let bench = Bench::new();
    for greedy::Greedy { name, file, .. } in greedy::files() {
        bench.write("greedy.glb", &file);
        let most = 64 + 50 * (file.len() as u64 >> 20);
        for command in ["render -o out.png --size 64", "view --no-open", "inspect", "inspect mesh"]
        {
            let (code, messages, peak) = peak(&bench, &format!("{command} greedy.glb --threads 2"));
            assert!(peak <= most, "{name}, {command}: {} bytes take {peak} MiB", file.len());
            assert!(matches!(code, Some(0 | 2)), "{name}, {command}: {code:?}, {messages}");
            assert!(messages.len() < 1000, "{name}, {command}: {messages}");
        }
    }
}

/// The strip with a sheet of `side` by `side` quads and a texture.
fn sheet(side: usize, texture: &[u8]) -> Vec<u8> {
    let mut strip = Strip::new();
    let at = |k: usize| [k % (side + 1), k / (side + 1)].map(|step| step as f32 / side as f32);
    let points = 0..(side + 1) * (side + 1);
    let positions = points.clone().flat_map(|k| [at(k)[0], at(k)[1], 0.0]);
    let uv = points.clone().flat_map(at);
    let corners = (0..side * side).flat_map(|quad| {
        let first = quad / side * (side + 1) + quad % side;
        [0, 1, side + 2, 0, side + 2, side + 1].map(|step| (first + step) as u32)
    });
    let bytes =
        |floats: Vec<f32>| floats.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<_>>();
    let indices: Vec<u8> = corners.flat_map(u32::to_le_bytes).collect();
    let count = points.len();
    let positions = strip.add(&bytes(positions.collect()), 5126, count, "VEC3");
    let uv = strip.add(&bytes(uv.collect()), 5126, count, "VEC2");
    let indices = strip.add(&indices, 5125, 6 * side * side, "SCALAR");
    let primitive = &mut strip.json["meshes"][0]["primitives"][0];
    primitive["attributes"] = [("POSITION", positions), ("TEXCOORD_0", uv)].into_iter().collect();
    primitive["indices"] = indices.into();
    primitive["targets"] = Vec::<u8>::new().into();
    let view = strip.view(texture);
    strip.json["images"][0]["bufferView"] = view.into();
    strip.glb()
}

#[test]
fn the_bound_holds_or_the_scene_is_refused() {
    let bench = Bench::new();
    bench.paint_noise("texture.png", (1024, 1024), Channels::Rgb, Depth::U8);
    let texture = bench.bytes("texture.png");
    for (name, side) in [("fine.glb", 300), ("coarse.glb", 20)] {
        bench.write(name, sheet(side, &texture));
    }
    let (mut held, mut refused) = (0, 0);
    for command in [
        "render fine.glb -o out.png",
        "render coarse.glb -o out.png",
        "render coarse.glb --size 2048 --background transparent -o out.webp",
        "view fine.glb --no-open",
    ] {
        let found = within(&bench, command, &[30, 60, 120, 180, 300, 500]);
        (held, refused) = (held + found.0, refused + found.1);
    }
    assert!(held >= 6 && refused >= 6, "{held} held, {refused} refused");
}

/// A JPEG of one grey, of which the first of all scans is stored: all of its codes are a zero bit.
///
/// - `is_turned`: whether its EXIF block says that it lies on its side.
fn flat_progressive_jpeg(side: u16, is_turned: bool) -> Vec<u8> {
    let [high, low] = side.to_be_bytes();
    let mut file = vec![0xff, 0xd8];
    let mut segment = |marker: u8, content: &[u8]| {
        file.extend([0xff, marker]);
        file.extend((content.len() as u16 + 2).to_be_bytes());
        file.extend(content);
    };
    if is_turned {
        segment(0xe1, b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0");
    }
    segment(0xdb, &[&[0][..], &[1; 64]].concat());
    // Three components, the first of them with 2×2 blocks.
    segment(0xc2, &[8, high, low, high, low, 3, 1, 0x22, 0, 2, 0x11, 0, 3, 0x11, 0]);
    // One code, of one bit, for a difference of no bits.
    segment(0xc4, &[&[0, 1][..], &[0; 15], &[0]].concat());
    segment(0xda, &[3, 1, 0, 2, 0, 3, 0, 0, 0, 0]);
    let units = usize::from(side).div_ceil(16).pow(2);
    file.extend(vec![0; units * 6 / 8]);
    file.extend([0xff, 0xd9]);
    file
}
