//! Inputs in memory: the results are those of files, and no file is read.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::path::{Path, PathBuf};

use uvgraft::blend::{BlendDomain, Side};
use uvgraft::{
    Channels, Direction, Encoding, MapOptions, Pair, SamplingMap, Size, Texels, Texture, Tone,
};
use uvgraft_figure::{Figure, paint_body_in_tone, paint_head};
use uvgraft_image::{self as image, Format, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_io::sampling_map;
use uvgraft_pipeline::{
    BaseSource, Blending, Correspondence, Existing, Fault, Input, Inputs, Length, MaterialMap,
    Region, RegionPart, Role, Transfer,
};

/// A temporary folder with the demo's figure, and a file for each kind of input.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        std::fs::create_dir(desk.path("in")).unwrap();
        let figure = Figure::new();
        let ids: Vec<i64> = figure.vertex_map.iter().map(|&id| i64::from(id)).collect();
        let pair = Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &ids).unwrap();
        let name = String::new;
        let pair =
            PairFile { pair: pair.into(), source_name: name(), target_name: name(), note: name() };
        pair_file::write(&pair, desk.path("in/demo.uvpair")).unwrap();
        let face = paint_head(&figure, Size::square(128));
        let domain = BlendDomain::new(pair.pair, Direction::Forward);
        desk.save("labels.png", domain.labels(&face).unwrap().picture());
        desk.save("face.png", face);
        desk.save("mean.png", paint_body_in_tone(&figure, Size::square(64), [0.6, 0.5, 0.4]));
        desk.save("base.png", paint_body_in_tone(&figure, Size::square(192), [0.7, 0.65, 0.6]));
        desk.save("mask.png", halves(Size::square(128), 0.9));
        desk.save("skin.png", halves(Size::square(96), 0.8));
        desk.save("painted.png", halves(Size::square(64), 0.95));
        let above = |y: f32| {
            let vertices = (0..).zip(figure.head.positions());
            vertices.filter(move |(_, position)| position[1] > y).map(|(index, _): (u32, _)| index)
        };
        let middle = median(figure.head.positions().iter().map(|position| position[1]));
        let groups = serde_json::json!({ "upper": above(middle).collect::<Vec<_>>() });
        std::fs::write(desk.path("in/groups.json"), groups.to_string()).unwrap();
        let list: String = above(middle - 0.05).map(|index| format!("{index}\n")).collect();
        std::fs::write(desk.path("in/list.txt"), list).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn save(&self, name: &str, texture: Texture) {
        let path = self.path("in").join(name);
        let written = image::write(&texture.into(), path, &WriteOptions::default()).unwrap();
        assert_eq!(written.losses, []);
    }

    /// All files of the inputs, as they are or in memory.
    fn inputs(&self, in_memory: bool) -> impl Fn(&str) -> Input {
        let folder = self.path("in");
        move |name| {
            let path = folder.join(name);
            if in_memory { Input::bytes(name, std::fs::read(path).unwrap()) } else { path.into() }
        }
    }

    fn remove_inputs(&self) {
        std::fs::remove_dir_all(self.path("in")).unwrap();
    }
}

/// White above a share of the height.
fn halves(size: Size, share: f32) -> Texture {
    let white = (size.height as f32 * share) as usize * size.width as usize;
    let values = (0..size.texels()).map(|texel| if texel < white { 255 } else { 0 }).collect();
    Texture::new(size, Channels::Grey, Encoding::Srgb, Texels::U8(values)).unwrap()
}

fn median(values: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = values.collect();
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

/// A transfer with every kind of input.
fn transfer(input: &dyn Fn(&str) -> Input, output: &Path) -> Transfer {
    let inputs = Inputs::textures([input("face.png")], BaseSource::image(input("base.png")));
    let mut transfer = Transfer::new(input("demo.uvpair"), inputs, output);
    transfer.source_mask = Some(input("mask.png"));
    transfer.fill = Some(input("mean.png"));
    let part = |side, name, names: &[&str]| {
        let names = names.iter().map(|&name| name.to_owned()).collect();
        RegionPart { side, input: input(name), names }
    };
    let mut region = Region::default();
    region.include = vec![
        part(Side::Source, "groups.json", &["upper"]),
        part(Side::Source, "list.txt", &[]),
        part(Side::Target, "painted.png", &[]),
    ];
    transfer.region = region;
    let mut blending = Blending::default();
    blending.feather = Length::millimeters(15.0);
    blending.options.membrane = true;
    blending.options.tone = Tone::Both;
    blending.skin = Some(input("skin.png"));
    blending.labels = Some(input("labels.png"));
    transfer.blending = Some(blending);
    transfer
}

#[test]
fn results_are_those_of_files() {
    let desk = Desk::new();
    let (from_files, from_memory) = (desk.inputs(false), desk.inputs(true));
    let mut by_paths = transfer(&from_files, &desk.path("paths.png"));
    by_paths.existing = Existing::KeepUpToDate;
    assert_eq!(by_paths.run(&()).unwrap().written, 1);
    let wanted = std::fs::read(desk.path("paths.png")).unwrap();
    let fingerprint = by_paths.prepare(&()).unwrap().fingerprint().to_owned();

    let mut by_bytes = transfer(&from_memory, &desk.path("bytes.png"));
    let face = from_memory("face.png");
    desk.remove_inputs();
    let done = by_bytes.run(&()).unwrap();
    assert!(done.failures.is_empty() && done.pair.is_some(), "{done:?}");
    assert!(std::fs::read(desk.path("bytes.png")).unwrap() == wanted);

    let prepared = by_bytes.prepare(&()).unwrap();
    assert_eq!(prepared.fingerprint(), fingerprint);
    let bytes = face.read(u64::MAX).unwrap();
    assert!(prepared.transfer_bytes(&bytes, "face.png", Format::PNG).unwrap().0 == wanted);

    // A file and the same bytes are the same input.
    by_bytes.output = desk.path("paths.png");
    by_bytes.existing = Existing::KeepUpToDate;
    assert_eq!(by_bytes.run(&()).unwrap().up_to_date, 1);
}

#[test]
fn every_input_counts_and_is_named() {
    let desk = Desk::new();
    let from_memory = desk.inputs(true);
    let all = transfer(&from_memory, &desk.path("out.png")).prepare(&()).unwrap();
    let names: Vec<String> = desk
        .path("in")
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(names.len(), 10);
    for changed in names {
        let other = |name: &str| match from_memory(name) {
            Input::Bytes { name, bytes } if name == Path::new(&changed) => {
                Input::bytes(name, [&bytes[..], b" "].concat())
            }
            input => input,
        };
        let output = desk.path("out.png");
        match transfer(&other, &output).prepare(&()) {
            Ok(prepared) if changed == "face.png" => {
                assert_eq!(prepared.fingerprint(), all.fingerprint());
            }
            Ok(prepared) => assert_ne!(prepared.fingerprint(), all.fingerprint(), "{changed}"),
            Err(failure) => assert!(failure.to_string().starts_with(&changed), "{failure}"),
        }
        let damaged = |name: &str| match from_memory(name) {
            Input::Bytes { name, .. } if name == Path::new(&changed) => Input::bytes(name, *b"{"),
            input => input,
        };
        let done = transfer(&damaged, &output).run(&());
        let failure = done.and_then(|mut done| Err::<(), _>(done.failures.remove(0))).unwrap_err();
        assert_eq!(failure.fault(), Fault::Input, "{changed}: {failure}");
        assert!(failure.to_string().starts_with(&format!("{changed}: ")), "{failure}");
        assert!(!output.exists());
    }
}

#[test]
fn outputs_in_a_folder_are_named_after_what_is_in_memory() {
    let desk = Desk::new();
    let input = desk.inputs(true);
    let role = Role::named("albedo").unwrap();
    let onto = Some(BaseSource::image(input("base.png")));
    let maps = vec![MaterialMap { role, source: input("face.png"), onto: onto.clone() }];
    let sources = vec![input("face.png"), input("mean.png")];
    let textures = Inputs::Textures { sources, onto, values: role.values() };
    for (inputs, outputs) in
        [(Inputs::Material(maps), &["albedo.png"][..]), (textures, &["face.png", "mean.png"])]
    {
        let pair = input("demo.uvpair");
        let transfer = Transfer::new(pair, inputs, desk.path(&format!("out{}", outputs.len())));
        assert_eq!(transfer.run(&()).unwrap().written, outputs.len());
        for output in outputs {
            assert!(transfer.output.join(output).exists(), "{output}");
        }
        let mut tiled = transfer;
        tiled.output = desk.path("out_<UDIM>.png");
        let refused = tiled.run(&()).unwrap_err().to_string();
        assert!(refused.contains("cannot be used with images in memory"), "{refused}");
    }
}

#[test]
fn maps_can_be_in_memory() {
    let desk = Desk::new();
    let file = pair_file::read(desk.path("in/demo.uvpair")).unwrap();
    let (size, options) = (Size::square(96), MapOptions::default());
    let map = SamplingMap::new(&file.pair, Direction::Forward, size, &options);
    sampling_map::save_npy(&map, desk.path("in/map.npy")).unwrap();
    let results = [false, true].map(|in_memory| {
        let input = desk.inputs(in_memory);
        let inputs = Inputs::textures([input("face.png")], None);
        let output = desk.path(if in_memory { "bytes.png" } else { "paths.png" });
        Transfer::by(Correspondence::Map(input("map.npy")), inputs, &output).run(&()).unwrap();
        std::fs::read(output).unwrap()
    });
    assert!(results[0] == results[1]);
}
