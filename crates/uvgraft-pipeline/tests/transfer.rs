//! File-to-file transfers through the library API.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use uvgraft::{Channels, Depth, Encoding, FitOptions, Mesh, Pair, Size, Texels, Texture};
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_pipeline::{
    BaseSource, Blending, Correspondence, Event, Existing, Fault, Inputs, MaterialMap, Observer,
    Role, Transfer, Values,
};

/// A temporary folder with a pair of squares, one upright and one rotated by a quarter turn, and
/// with textures.
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
        pair_file::write(&file, desk.path("my.uvpair")).unwrap();
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
        let written = image::write(&image, self.path(name), &WriteOptions::default()).unwrap();
        assert!(written.losses.is_empty());
    }

    fn transfer(&self, sources: &[&str], output: &str) -> Transfer {
        let inputs = Inputs::Textures {
            sources: sources.iter().map(|name| self.path(name).into()).collect(),
            onto: Some(BaseSource::image(self.path("base.png"))),
            values: Values::Albedo,
        };
        Transfer::new(self.path("my.uvpair"), inputs, self.path(output))
    }

    fn center(&self, name: &str) -> f32 {
        let texture = image::read(self.path(name)).unwrap().texture;
        texture.get(texture.size().width / 2, texture.size().height / 2, 0)
    }
}

/// Records events, and cancels once `cancels_at` textures have started.
struct Log {
    lines: Mutex<Vec<String>>,
    started: AtomicUsize,
    cancels_at: usize,
}

impl Log {
    fn new(cancels_at: usize) -> Self {
        Self { lines: Mutex::default(), started: AtomicUsize::new(0), cancels_at }
    }
}

impl Observer for Log {
    fn event(&self, event: Event<'_>) {
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let text = match event {
            Event::TextureStarted { .. } => {
                self.started.fetch_add(1, Ordering::SeqCst);
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
        self.lines.lock().unwrap().push(text);
    }

    fn is_cancelled(&self) -> bool {
        self.started.load(Ordering::SeqCst) >= self.cancels_at
    }
}

#[test]
fn textures_are_transferred_and_reported_in_order() {
    let desk = Desk::new();
    for (name, red) in [("a.png", 0.8), ("c.png", 0.6)] {
        desk.paint(name, 32, [red, 0.5, 0.5]);
    }
    std::fs::write(desk.path("b.png"), "at least one image").unwrap();
    for jobs in [1, 3] {
        let log = Log::new(usize::MAX);
        let mut transfer = desk.transfer(&["a.png", "b.png", "c.png"], "out");
        transfer.jobs = Some(jobs);
        let done = transfer.run(&log).unwrap();
        assert_eq!((done.written, done.failures.len(), done.worst()), (2, 1, Some(Fault::Input)));
        assert!(done.failures[0].to_string().contains("b.png: not a supported image"));
        let reported = log.lines.into_inner().unwrap();
        assert_eq!(reported[0], "3 None");
        assert_eq!(reported[1], "a.png done");
        assert!(
            reported[2].starts_with("b.png ") && reported[2].contains("not a supported image"),
            "{reported:?}"
        );
        assert_eq!(reported[3..], ["c.png done"]);
        assert_eq!(desk.center("out/a.png"), 0.8);
        assert_eq!(desk.center("out/c.png"), 0.6);
        assert!(!desk.path("out/b.png").exists());
    }
}

#[test]
fn cancelling_keeps_existing_outputs() {
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
    // Cancelled before the start: no texture starts, and no folder is created.
    for existing in [Existing::Replace, Existing::KeepUpToDate] {
        let mut transfer = desk.transfer(&names, "new");
        transfer.existing = existing;
        let log = Log::new(0);
        assert_eq!(transfer.run(&log).unwrap_err().fault(), Fault::Cancelled);
        assert_eq!(log.started.into_inner(), 0);
        assert!(!desk.path("new").exists());
    }
    // The remaining textures are not started.
    let mut transfer = desk.transfer(&names, "some");
    transfer.jobs = Some(1);
    let log = Log::new(2);
    assert_eq!(transfer.run(&log).unwrap_err().fault(), Fault::Cancelled);
    assert_eq!(log.started.into_inner(), 2);
    // Finished textures are kept and not repeated.
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
    let missing = fails(&|transfer| {
        transfer.correspondence = Correspondence::Pair(desk.path("none.uvpair").into());
    });
    assert!(missing.contains("none.uvpair: "), "{missing}");
    let folder = fails(&|transfer| transfer.output = desk.path("none/out.png"));
    assert!(folder.contains("does not exist"), "{folder}");
    let taken = fails(&|transfer| transfer.extra_outputs.push(desk.path("a.png")));
    assert!(taken.contains("also an input"), "{taken}");
    let mask = fails(&|transfer| transfer.mask = Some(desk.path("mask.jpg")));
    assert!(mask.contains("must not be a JPEG file"), "{mask}");
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
    assert!(turned.contains("normal maps"), "{turned}");
    let format = fails(&|transfer| transfer.format = Some("bmp".to_owned()));
    assert!(format.contains("must be one of .png"), "{format}");
    let nothing = fails(&|transfer| transfer.inputs = Inputs::Material(Vec::new()));
    assert!(nothing.contains("no texture"), "{nothing}");
    let deeper = fails(&|transfer| transfer.output = desk.path("none/deeper/"));
    assert!(
        deeper.contains("cannot create the folder") && deeper.contains("does not exist"),
        "{deeper}"
    );
    // An unknown role is refused, listing the known ones.
    assert!(Role::named("banana").unwrap_err().to_string().contains("must be one of albedo"));
}

#[test]
fn fits_and_materials() {
    let desk = Desk::new();
    desk.paint("a.png", 32, [0.8, 0.5, 0.5]);
    let mut transfer = desk.transfer(&["a.png"], "fitted.png");
    transfer.fit = Some(FitOptions::default().max_steps(3));
    let log = Log::new(usize::MAX);
    assert_eq!(transfer.run(&log).unwrap().written, 1);
    assert!(log.lines.into_inner().unwrap().contains(&"a.png 0".to_owned()));
    assert_eq!(desk.center("fitted.png"), 0.8);

    let map = |role, onto| MaterialMap {
        role: Role::named(role).unwrap(),
        source: desk.path("a.png").into(),
        onto,
    };
    let base = BaseSource::image(desk.path("base.png"));
    let maps = vec![map("albedo", Some(base)), map("roughness", None)];
    let mut transfer =
        Transfer::new(desk.path("my.uvpair"), Inputs::Material(maps), desk.path("material"));
    transfer.size = Some(Size::square(24));
    let mut blending = Blending::default();
    blending.options.membrane = true;
    transfer.blending = Some(blending);
    let done = transfer.run(&()).unwrap();
    assert_eq!((done.written, done.blend.is_some()), (2, true));
    assert_eq!(desk.center("material/roughness.png"), 0.8);
}

/// Records warnings.
#[derive(Default)]
struct Warnings(Mutex<Vec<String>>);

impl Observer for Warnings {
    fn event(&self, event: Event<'_>) {
        if let Event::TextureReport { warnings, .. } = event {
            self.0.lock().unwrap().extend_from_slice(warnings);
        }
    }
}

/// NaN marks an unknown texel: it does not spread, and causes a warning.
#[test]
fn non_finite_texels_are_unknown() {
    let desk = Desk::new();
    let spots = |k: u32| (12..15).contains(&(k % 32)) && (14..17).contains(&(k / 32));
    let save = |name: &str, spot: f32| {
        let value = |k: u32| if spots(k) { [0.5, spot, 0.5] } else { [0.5; 3] };
        let values = (0..32 * 32).flat_map(value).collect();
        let size = Size::square(32);
        let texture = Texture::new(size, Channels::Rgb, Encoding::Linear, Texels::F32(values));
        let image = Image::from(texture.unwrap());
        let written = image::write(&image, desk.path(name), &WriteOptions::default()).unwrap();
        assert!(written.losses.is_empty());
    };
    let nothing = Texture::new(
        Size::square(8),
        Channels::Grey,
        Encoding::Linear,
        Texels::F32(vec![f32::NAN; 64]),
    );
    let written = image::write(
        &Image::from(nothing.unwrap()),
        desk.path("nothing.exr"),
        &WriteOptions::default(),
    )
    .unwrap();
    assert!(written.losses.is_empty());
    save("whole.exr", 0.5);
    for (name, spot) in [("nan.exr", f32::NAN), ("infinite.tif", f32::NEG_INFINITY)] {
        save(name, spot);
    }
    let transfer = |source: &str, values: Values, fit: Option<FitOptions>| {
        let mut transfer = desk.transfer(&[source], "out.exr");
        let Inputs::Textures { values: meant, .. } = &mut transfer.inputs else { unreachable!() };
        *meant = values;
        transfer.fit = fit;
        let log = Warnings::default();
        assert_eq!(transfer.run(&log).unwrap().worst(), None);
        let texture = image::read(desk.path("out.exr")).unwrap().texture;
        assert_eq!(texture.channels(), Channels::Rgb);
        (texture, log.0.into_inner().unwrap())
    };
    let differing = |a: &Texture, b: &Texture| {
        let off = |k: u32| {
            (0..3).any(|c| (a.get(k % 48, k / 48, c) - b.get(k % 48, k / 48, c)).abs() > 1e-5)
        };
        (0..48 * 48).filter(|&k| off(k)).count()
    };
    for fit in [None, Some(FitOptions::default())] {
        let (whole, none) = transfer("whole.exr", Values::Albedo, fit);
        assert!(none.is_empty(), "{none:?}");
        for source in ["nan.exr", "infinite.tif"] {
            let (transferred, warnings) = transfer(source, Values::Albedo, fit);
            let warning = format!("{source}: 9 texels are NaN or infinite; showing the base there");
            assert!(warnings.len() == 1 && warnings[0].contains(&warning), "{warnings:?}");
            let Texels::F32(values) = transferred.texels() else { panic!("floats") };
            assert!(values.iter().all(|value| value.is_finite()));
            // The base's green of 0.3 in linear light. The hole has 4.5 texels a side, plus the
            // filter's support.
            let hole =
                (0..48 * 48).filter(|k| (transferred.get(k % 48, k / 48, 1) - 0.0732).abs() < 2e-3);
            let at_middle =
                hole.filter(|k| (12..36).contains(&(k % 48)) && (12..36).contains(&(k / 48)));
            assert!(at_middle.count() >= 9, "{source}");
            let differing = differing(&transferred, &whole);
            // At most the filter's support around the spot: nine source texels a side.
            assert!((12..=14 * 14).contains(&differing), "{source}: {differing}");
        }
        // A texture without any known texel leaves the base.
        let (nothing, warnings) = transfer("nothing.exr", Values::Albedo, fit);
        assert!(warnings[0].contains("nothing.exr: 64 texels are NaN"), "{warnings:?}");
        let green = |texture: &Texture, k: u32| texture.get(k % 48, k / 48, 1);
        assert!((0..48 * 48).all(|k| (green(&nothing, k) - 0.0732).abs() < 2e-3));
        // Data has no alpha; unknown texels take the nearest value.
        let (whole, _) = transfer("whole.exr", Values::Data, fit);
        let (transferred, warnings) = transfer("nan.exr", Values::Data, fit);
        assert!(
            warnings[0].contains("9 texels are NaN or infinite; using the value"),
            "{warnings:?}"
        );
        assert_eq!(differing(&transferred, &whole), 0);
    }
}
