//! The bound on memory holds, or the transfer is refused.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

mod bench;

use std::process::Stdio;
use std::time::Duration;

use bench::Bench;
use uvgraft::{Channels, Depth};
use uvgraft_figure::Figure;

/// Runs a transfer, and returns its exit code, its messages and its peak memory in MiB.
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
