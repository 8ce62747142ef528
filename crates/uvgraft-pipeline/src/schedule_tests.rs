//! Transfers whose threads are disturbed: they pause at random, some do not start, a caller cancels
//! or panics. All end, with the same files or none.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;

use uvgraft::{Channels, Depth, Encoding, Mesh, Pair, Size, Texels, Texture};
use uvgraft_image::{self as image, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};

use crate::spawn::disturbance;
use crate::{BaseSource, Event, Failure, Fault, Inputs, Observer, Transfer, Transferred, Values};

/// Longer than any of these transfers takes, however slow the machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Cancels or panics after some events.
struct Interfering {
    left: AtomicU32,
    panics: bool,
}

impl Interfering {
    fn after(events: u32, panics: bool) -> Self {
        Self { left: AtomicU32::new(events), panics }
    }

    fn is_time(&self) -> bool {
        let left = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| {
            Some(left.saturating_sub(1))
        });
        left == Ok(0)
    }
}

impl Observer for Interfering {
    fn event(&self, event: Event<'_>) {
        // In the midst of a worker, not of the caller's thread.
        let is_workers = matches!(event, Event::TextureStarted { .. } | Event::TextureEnded { .. });
        if is_workers && self.panics && self.is_time() {
            panic!("on purpose");
        }
    }

    fn is_cancelled(&self) -> bool {
        !self.panics && self.is_time()
    }
}

fn save(path: &Path, size: Size, seed: u64) {
    let mut random = fastrand::Rng::with_seed(seed);
    let values = (0..size.texels() * 3).map(|_| random.u8(..)).collect();
    let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).unwrap();
    assert_eq!(texture.depth(), Depth::U8);
    image::write(&texture.into(), path, &WriteOptions::default()).map(drop).unwrap();
}

fn pair() -> Pair {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let faces = [[0, 1, 2], [0, 2, 3]];
    let mesh = |low: f32, high: f32| {
        let uv = vec![[low, low], [high, low], [high, high], [low, high]];
        Mesh::from_triangles(positions.clone(), uv, &faces, &faces).unwrap()
    };
    Pair::by_vertex_map(mesh(0.1, 0.9), mesh(0.3, 0.6), &[0, 1, 2, 3]).unwrap()
}

/// The transfers of a folder with sources and a base.
fn transfers(folder: &Path) -> Vec<Transfer> {
    let name = String::new;
    let file =
        PairFile { pair: pair().into(), source_name: name(), target_name: name(), note: name() };
    pair_file::write(&file, folder.join("my.uvpair")).unwrap();
    let sources: Vec<PathBuf> = (0..5).map(|k| folder.join(format!("{k}.png"))).collect();
    for (seed, source) in (0..).zip(&sources) {
        save(source, Size::new(150 + 10 * seed as u32, 200), seed);
    }
    save(&folder.join("base.png"), Size::new(700, 1500), 9);
    let base = || Some(BaseSource::image(folder.join("base.png")));
    let transfer = |sources: &[PathBuf], onto, output: &str| {
        let inputs = Inputs::Textures {
            sources: sources.iter().map(Into::into).collect(),
            onto,
            values: Values::Color,
        };
        Transfer::new(folder.join("my.uvpair"), inputs, folder.join(output))
    };
    let mut batch = transfer(&sources, base(), "batch");
    batch.jobs = Some(3);
    let mut colored = transfer(&sources[..3], None, "colored");
    colored.size = Some(Size::new(400, 900));
    colored.format = Some("tif".to_owned());
    vec![transfer(&sources[..1], base(), "alone.png"), batch, colored]
}

/// Everything below a folder.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut content = BTreeMap::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            content.extend(self::content(&path));
        } else {
            content.insert(path.clone(), std::fs::read(&path).unwrap());
        }
    }
    content
}

/// Runs a transfer, and fails the test if it does not end; `None` if it panicked.
fn ended(transfer: &Transfer, observer: Interfering) -> Option<Result<Transferred, Failure>> {
    let (sender, receiver) = channel();
    let transfer = transfer.clone();
    std::thread::spawn(move || {
        let run = AssertUnwindSafe(|| transfer.run(&observer));
        let _ = sender.send(catch_unwind(run).ok());
    });
    receiver.recv_timeout(PATIENCE).expect("the transfer hangs")
}

#[test]
fn disturbed_transfers_end_with_the_same_files_or_none() {
    const SEEDS: u64 = 60;
    let folder = tempfile::tempdir().unwrap();
    let transfers = transfers(folder.path());
    let inputs = content(folder.path());
    for transfer in &transfers {
        ended(transfer, Interfering::after(u32::MAX, false)).unwrap().unwrap();
    }
    let all = content(folder.path());
    assert_eq!(all.len(), inputs.len() + 1 + 5 + 3);
    let outputs: Vec<&PathBuf> = all.keys().filter(|path| !inputs.contains_key(*path)).collect();
    for seed in 0..SEEDS {
        outputs.iter().for_each(|path| drop(std::fs::remove_file(path)));
        for (index, transfer) in (0..).zip(&transfers) {
            disturbance::begin(seed * 31 + index);
            // Each third is left alone.
            let interfering = match seed % 3 {
                0 => Interfering::after(u32::MAX, false),
                kind => Interfering::after((seed % 11) as u32, kind == 1),
            };
            let result = ended(transfer, interfering);
            disturbance::end();
            match (seed % 3, result) {
                (0, result) => {
                    assert!(result.unwrap().unwrap().failures.is_empty(), "seed {seed}");
                }
                (1, _) => {}
                (_, result) => {
                    let cancelled = result.unwrap().err().map(|failure| failure.fault());
                    assert!([None, Some(Fault::Cancelled)].contains(&cancelled), "seed {seed}");
                }
            }
        }
        // A worker that goes on after another's panic may write a moment later.
        for (path, bytes) in content(folder.path()) {
            assert!(all.get(&path) == Some(&bytes), "seed {seed}: {}", path.display());
        }
        if seed % 3 == 0 {
            assert!(outputs.iter().all(|path| path.exists()), "seed {seed}");
        }
    }
}
