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
        for bound in [40, 90, 160, 250, 600, 1500] {
            let args = format!("transfer demo.uvpair {transfer} --threads 2 --memory {bound}M");
            let (code, messages, peak) = peak(&bench, &args);
            match code {
                Some(0) => {
                    assert!(peak <= bound, "{args}: took {peak} MiB");
                    held += 1;
                }
                Some(2) => {
                    assert!(messages.contains("--memory allows"), "{args}: {messages}");
                    refused += 1;
                }
                code => panic!("{args}: {code:?}, {messages}"),
            }
            let _ = std::fs::remove_dir_all(bench.path("many"));
        }
    }
    assert!(held >= 20 && refused >= 7, "{held} held, {refused} refused");
}

/// No file may ask for more than 64 MB and 50 times its size, unless an array or an image of it says that it is
/// large: all that these have is refused.
#[test]
fn small_scenes_take_little_memory() {
    let bench = Bench::new();
    let mut much = Vec::new();
    for greedy::Greedy { name, file, .. } in greedy::files() {
        bench.write("greedy.glb", &file);
        let most = 64 + 50 * (file.len() as u64 >> 20);
        for command in ["render -o out.png --size 64", "view --no-open", "inspect", "inspect mesh"]
        {
            let (code, messages, peak) = peak(&bench, &format!("{command} greedy.glb --threads 2"));
            if peak > most {
                much.push(format!("{name}, {command}: {} bytes take {peak} MiB", file.len()));
            }
            assert!(matches!(code, Some(0 | 2)), "{name}, {command}: {code:?}, {messages}");
            assert!(messages.len() < 1000, "{name}, {command}: {messages}");
        }
    }
    assert!(much.is_empty(), "{much:#?}");
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
        for bound in [30, 60, 120, 180, 300, 500] {
            let args = format!("{command} --threads 2 --memory {bound}M");
            let (code, messages, peak) = peak(&bench, &args);
            match code {
                Some(0) => {
                    assert!(peak <= bound, "{args}: took {peak} MiB");
                    held += 1;
                }
                Some(2) if messages.contains("no viewer") => {}
                Some(2) => {
                    assert!(messages.contains("--memory allows"), "{args}: {messages}");
                    refused += 1;
                }
                code => panic!("{args}: {code:?}, {messages}"),
            }
        }
    }
    assert!(held >= 6 && refused >= 6, "{held} held, {refused} refused");
}
