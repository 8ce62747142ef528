//! Transfers from files to files, as a library.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use uvgraft::{Channels, Depth, Encoding, FitOptions, Mesh, Pair, Size, Texels, Texture};
use uvgraft_io::image::{self, Image, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_pipeline::{
    Blending, Event, Existing, Fault, Inputs, MaterialMap, Observer, Onto, Role, Transfer, Values,
};

/// A folder with a pair of squares, one upright and one on its side, and textures.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let upright = vec![[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]];
        let aside = vec![[0.9, 0.1], [0.9, 0.9], [0.1, 0.9], [0.1, 0.1]];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let mesh = |uv| Mesh::from_triangles(positions.clone(), uv, &faces, &faces).unwrap();
        let pair = Pair::by_vertex_map(mesh(upright), mesh(aside), &[0, 1, 2, 3]).unwrap();
        let file = PairFile {
            pair: Arc::new(pair),
            source_name: "upright".to_owned(),
            target_name: "aside".to_owned(),
            note: String::new(),
        };
        pair_file::write(&file, &desk.path("my.uvpair")).unwrap();
        desk.paint("base.png", 48, [0.2, 0.3, 0.4]);
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn paint(&self, name: &str, side: u32, color: [f32; 3]) {
        let size = Size::square(side);
        let texture = Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &color);
        let image = Image::from(texture.unwrap());
        let written = image::write(&image, &self.path(name), &WriteOptions::default()).unwrap();
        assert!(written.losses.is_empty());
    }

    fn transfer(&self, sources: &[&str], output: &str) -> Transfer {
        let inputs = Inputs::Textures {
            sources: sources.iter().map(|name| self.path(name)).collect(),
            onto: Some(Onto::Image(self.path("base.png"))),
            values: Values::Albedo,
        };
        Transfer::new(self.path("my.uvpair"), inputs, self.path(output))
    }

    fn middle(&self, name: &str) -> f32 {
        let texture = image::read(&self.path(name)).unwrap().texture;
        texture.get(texture.size().width / 2, texture.size().height / 2, 0)
    }
}

/// Keeps what it is told, and cancels when so many textures have begun.
struct Log {
    told: Mutex<Vec<String>>,
    begun: AtomicUsize,
    cancels_at: usize,
}

impl Log {
    fn new(cancels_at: usize) -> Self {
        Self { told: Mutex::default(), begun: AtomicUsize::new(0), cancels_at }
    }
}

impl Observer for Log {
    fn event(&self, event: Event<'_>) {
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let text = match event {
            Event::TextureStarted { .. } => {
                self.begun.fetch_add(1, Ordering::SeqCst);
                return;
            }
            Event::Planned { textures, up_to_date } => format!("{textures} {up_to_date:?}"),
            Event::TextureReport { output, result, .. } => {
                format!(
                    "{} {}",
                    name(output),
                    result.map_or_else(ToString::to_string, |_| "done".into())
                )
            }
            Event::FitProgress { source, progress } => {
                format!("{} {}", name(source), progress.step)
            }
            _ => return,
        };
        self.told.lock().unwrap().push(text);
    }

    fn is_cancelled(&self) -> bool {
        self.begun.load(Ordering::SeqCst) >= self.cancels_at
    }
}

#[test]
fn textures_are_carried_and_told_in_their_order() {
    let desk = Desk::new();
    for (name, red) in [("a.png", 0.8), ("c.png", 0.6)] {
        desk.paint(name, 32, [red, 0.5, 0.5]);
    }
    std::fs::write(desk.path("b.png"), "no image").unwrap();
    for jobs in [1, 3] {
        let log = Log::new(usize::MAX);
        let mut transfer = desk.transfer(&["a.png", "b.png", "c.png"], "out");
        transfer.jobs = Some(jobs);
        let done = transfer.run(&log).unwrap();
        assert_eq!((done.written, done.failures.len(), done.worst()), (2, 1, Some(Fault::Input)));
        assert!(done.failures[0].to_string().contains("b.png: not an image"));
        let told = log.told.into_inner().unwrap();
        assert_eq!(told[0], "3 None");
        assert_eq!(told[1], "a.png done");
        assert!(told[2].starts_with("b.png ") && told[2].contains("not an image"), "{told:?}");
        assert_eq!(told[3..], ["c.png done"]);
        assert_eq!(desk.middle("out/a.png"), 0.8);
        assert_eq!(desk.middle("out/c.png"), 0.6);
        assert!(!desk.path("out/b.png").exists());
    }
}

#[test]
fn what_is_cancelled_leaves_what_was_there() {
    let desk = Desk::new();
    let names = ["a.png", "b.png", "c.png", "d.png"];
    for name in names {
        desk.paint(name, 32, [0.8, 0.5, 0.5]);
    }
    std::fs::create_dir(desk.path("out")).unwrap();
    for name in names {
        std::fs::write(desk.path("out").join(name), "before").unwrap();
    }
    for jobs in [1, 2] {
        let mut transfer = desk.transfer(&names, "out");
        transfer.jobs = Some(jobs);
        let failure = transfer.run(&Log::new(1)).unwrap_err();
        assert_eq!(failure.fault(), Fault::Cancelled);
        let files: Vec<PathBuf> = std::fs::read_dir(desk.path("out"))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        assert_eq!(files.len(), names.len(), "{files:?}");
        for file in files {
            assert_eq!(std::fs::read(&file).unwrap(), b"before", "{}", file.display());
        }
    }
    // Cancelled before anything is begun: then nothing is, and no folder is made.
    for existing in [Existing::Replace, Existing::KeepUpToDate] {
        let mut transfer = desk.transfer(&names, "new");
        transfer.existing = existing;
        let log = Log::new(0);
        assert_eq!(transfer.run(&log).unwrap_err().fault(), Fault::Cancelled);
        assert_eq!(log.begun.into_inner(), 0);
        assert!(!desk.path("new").exists());
    }
    // What is left is not begun any more.
    let mut transfer = desk.transfer(&names, "some");
    transfer.jobs = Some(1);
    let log = Log::new(2);
    assert_eq!(transfer.run(&log).unwrap_err().fault(), Fault::Cancelled);
    assert_eq!(log.begun.into_inner(), 2);
    // One that was done before stays done, and is not done again.
    let mut transfer = desk.transfer(&names, "out");
    transfer.jobs = Some(1);
    transfer.existing = Existing::KeepUpToDate;
    assert_eq!(transfer.run(&Log::new(3)).unwrap_err().fault(), Fault::Cancelled);
    let done = transfer.run(&()).unwrap();
    assert_eq!((done.up_to_date, done.written), (2, 2));
}

#[test]
fn failures_say_whose_fault_they_are() {
    let desk = Desk::new();
    desk.paint("a.png", 32, [0.8, 0.5, 0.5]);
    let fails = |change: &dyn Fn(&mut Transfer)| {
        let mut transfer = desk.transfer(&["a.png"], "out.png");
        change(&mut transfer);
        let failure = transfer.run(&()).unwrap_err();
        assert_eq!(failure.fault(), Fault::Input, "{failure}");
        assert!(!desk.path("out.png").exists());
        failure.to_string()
    };
    let missing = fails(&|transfer| transfer.pair = desk.path("none.uvpair"));
    assert!(missing.contains("none.uvpair: "), "{missing}");
    let folder = fails(&|transfer| transfer.output = desk.path("none/out.png"));
    assert!(folder.contains("there is no folder"), "{folder}");
    let taken = fails(&|transfer| transfer.also_written.push(desk.path("a.png")));
    assert!(taken.contains("also an input"), "{taken}");
    let mask = fails(&|transfer| transfer.mask = Some(desk.path("mask.jpg")));
    assert!(mask.contains("JPEG would blur the mask"), "{mask}");
    let nearest = fails(&|transfer| {
        transfer.fit = Some(FitOptions::default());
        transfer.filter = Some(uvgraft::Filter::Nearest);
    });
    assert!(nearest.contains("nearest"), "{nearest}");
    let turned = fails(&|transfer| {
        transfer.fit = Some(FitOptions::default());
        if let Inputs::Textures { values, .. } = &mut transfer.inputs {
            *values = Values::Normals;
        }
    });
    assert!(turned.contains("normals turn"), "{turned}");
    let format = fails(&|transfer| transfer.format = Some("bmp".to_owned()));
    assert!(format.contains("bmp: wanted one of .png"), "{format}");
    let nothing = fails(&|transfer| transfer.inputs = Inputs::Material(Vec::new()));
    assert!(nothing.contains("no texture"), "{nothing}");
    let deeper = fails(&|transfer| transfer.output = desk.path("none/deeper/"));
    assert!(deeper.contains("cannot make the folder") && deeper.contains("no folder"), "{deeper}");
    // A file of a batch, which stops no other.
    let size = Size::square(8);
    let nan = Texture::new(size, Channels::Grey, Encoding::Linear, Texels::F32(vec![f32::NAN; 64]));
    let written =
        image::write(&Image::from(nan.unwrap()), &desk.path("nan.exr"), &WriteOptions::default());
    assert!(written.unwrap().losses.is_empty());
    let mut transfer = desk.transfer(&["nan.exr"], "out.png");
    transfer.fit = Some(FitOptions::default());
    let done = transfer.run(&()).unwrap();
    assert_eq!(done.worst(), Some(Fault::Input));
    assert!(done.failures[0].to_string().contains("nan.exr: texel (0, 0) of the texture"));
    assert!(Role::named("banana").unwrap_err().to_string().contains("wanted one of albedo"));
}

#[test]
fn fits_and_materials() {
    let desk = Desk::new();
    desk.paint("a.png", 32, [0.8, 0.5, 0.5]);
    let mut transfer = desk.transfer(&["a.png"], "fitted.png");
    transfer.fit = Some(FitOptions::default().max_steps(3));
    let log = Log::new(usize::MAX);
    assert_eq!(transfer.run(&log).unwrap().written, 1);
    assert!(log.told.into_inner().unwrap().contains(&"a.png 0".to_owned()));
    assert_eq!(desk.middle("fitted.png"), 0.8);

    let map = |role, onto| MaterialMap {
        role: Role::named(role).unwrap(),
        source: desk.path("a.png"),
        onto,
    };
    let base = Onto::Image(desk.path("base.png"));
    let maps = vec![map("albedo", Some(base)), map("roughness", None)];
    let mut transfer =
        Transfer::new(desk.path("my.uvpair"), Inputs::Material(maps), desk.path("material"));
    transfer.size = Some(Size::square(24));
    let mut blending = Blending::default();
    blending.membrane = true;
    transfer.blending = Some(blending);
    let done = transfer.run(&()).unwrap();
    assert_eq!((done.written, done.blend.is_some()), (2, true));
    assert_eq!(desk.middle("material/roughness.png"), 0.8);
}
