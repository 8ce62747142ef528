//! Textures that come one by one: the results are those of a transfer between files.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use uvgraft::{Depth, Encoding, FitOptions, Pair, Size, Texture};
use uvgraft_figure::{Figure, paint_body_in_tone, paint_head};
use uvgraft_image::{self as image, Format, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_pipeline::{
    BaseSource, Blending, Existing, Fault, Inputs, Length, Manifest, MaterialMap, PreparedTransfer,
    Role, Transfer, Values,
};

/// A temporary folder with the demo's figure: a pair, a base of 96² and faces of several sizes.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let figure = Figure::new();
        let ids: Vec<i64> = figure.vertex_map.iter().map(|&id| i64::from(id)).collect();
        let pair = Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &ids).unwrap();
        let file = PairFile {
            pair: pair.into(),
            source_name: "head".to_owned(),
            target_name: "body".to_owned(),
            note: String::new(),
        };
        pair_file::write(&file, desk.path("demo.uvpair")).unwrap();
        let body = paint_body_in_tone(&figure, Size::square(192), [0.7, 0.65, 0.6]);
        desk.save("base.png", body);
        for (name, side) in [("a.png", 128), ("b.png", 160), ("c.png", 128)] {
            desk.save(name, paint_head(&figure, Size::square(side)));
        }
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn save(&self, name: &str, texture: Texture) {
        let path = self.path(name);
        let written = image::write(&texture.into(), &path, &WriteOptions::default()).unwrap();
        assert_eq!(written.losses, []);
    }

    fn transfer(&self, sources: &[&str], output: &str) -> Transfer {
        let inputs = Inputs::Textures {
            sources: sources.iter().map(|name| self.path(name).into()).collect(),
            onto: Some(BaseSource::image(self.path("base.png"))),
            values: Values::Albedo,
        };
        Transfer::new(self.path("demo.uvpair"), inputs, self.path(output))
    }

    fn prepare(&self, change: impl FnOnce(&mut Transfer)) -> PreparedTransfer {
        let mut transfer = self.transfer(&[], "");
        change(&mut transfer);
        transfer.prepare(&()).unwrap()
    }
}

fn membrane(transfer: &mut Transfer) {
    let mut blending = Blending::default();
    blending.options.membrane = true;
    blending.options.match_skin = true;
    blending.feather = Length::millimeters(15.0);
    transfer.blending = Some(blending);
}

fn data(transfer: &mut Transfer) {
    let Inputs::Textures { values, .. } = &mut transfer.inputs else { unreachable!() };
    *values = Values::Data;
}

#[test]
fn results_are_those_of_files() {
    let desk = Desk::new();
    let deep = image::read(desk.path("a.png")).unwrap().texture;
    let channels = deep.channels();
    let deep = deep.converted(channels, Depth::U16);
    desk.save("deep.png", deep.clone());
    desk.save("float.exr", deep.converted(channels, Depth::F32).encoded_as(Encoding::Linear));
    type Change = fn(&mut Transfer);
    let cases: [(&str, &str, Change); 9] = [
        ("a.png", "out.png", |_| {}),
        ("b.png", "out.webp", |_| {}),
        ("b.png", "out.png", |transfer| transfer.write = transfer.write.compress(true)),
        ("a.png", "out.png", membrane),
        ("b.png", "out.jpg", membrane),
        ("a.png", "out.png", |it| it.fit = Some(FitOptions::default().max_steps(3))),
        ("deep.png", "out.tif", |_| {}),
        ("float.exr", "out.exr", |it| it.size = Some(Size::square(100))),
        ("a.png", "out.png", data),
    ];
    for (index, (source, output, change)) in cases.into_iter().enumerate() {
        let mut transfer = desk.transfer(&[source], output);
        change(&mut transfer);
        assert_eq!(transfer.run(&()).unwrap().worst(), None);
        let wanted = desk.bytes(output);
        let prepared = desk.prepare(change);

        let format = Format::from_path(Path::new(output)).unwrap();
        let (bytes, transferred) =
            prepared.transfer_bytes(&desk.bytes(source), "row", format).unwrap();
        assert!(bytes == wanted, "case {index}: bytes");
        assert_eq!((transferred.bytes, transferred.size), (wanted.len() as u64, prepared.size()));
        let is_blended = transfer.blending.is_some();
        assert_eq!(transferred.boundary_delta_e.is_some(), is_blended, "case {index}");

        let target = desk.path("carried").with_extension(Path::new(output).extension().unwrap());
        let again = prepared.transfer_file(&desk.path(source), &target).unwrap();
        assert!(std::fs::read(&target).unwrap() == wanted, "case {index}: file");
        assert_eq!(
            (again.bytes, again.boundary_delta_e),
            (transferred.bytes, transferred.boundary_delta_e)
        );
    }
}

/// Within a pool whose threads take up other calls while they wait, and with sizes that are not
/// prepared yet.
#[test]
fn threads_share_it() {
    let desk = Desk::new();
    let mut transfer = desk.transfer(&["a.png", "b.png", "c.png"], "out");
    membrane(&mut transfer);
    assert_eq!(transfer.run(&()).unwrap().written, 3);
    let prepared = desk.prepare(membrane);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    pool.install(|| {
        (0..24).into_par_iter().for_each(|index| {
            let name = ["a.png", "b.png", "c.png"][index % 3];
            let wanted = desk.bytes(&format!("out/{name}"));
            if index % 8 == 5 {
                let failure = prepared.transfer_bytes(b"no image", name, Format::PNG).unwrap_err();
                assert_eq!(failure.fault(), Fault::Input);
                return;
            }
            let (bytes, _) = prepared.transfer_bytes(&desk.bytes(name), name, Format::PNG).unwrap();
            assert!(bytes == wanted, "{name}");
        });
    });
}

#[test]
fn failures_name_the_texture() {
    let desk = Desk::new();
    let prepared = desk.prepare(|_| {});
    let face = desk.bytes("a.png");
    let (cut, mut damaged) = (&face[..face.len() / 2], face.clone());
    let middle = damaged.len() / 2;
    damaged[middle] ^= 0xff;
    for bytes in [b"no image at all", &b""[..], cut, &damaged] {
        let failure = prepared.transfer_bytes(bytes, "row 17", Format::PNG).unwrap_err();
        assert_eq!(failure.fault(), Fault::Input, "{failure}");
        assert!(failure.to_string().starts_with("row 17: "), "{failure}");
    }
    let clear = desk.prepare(|transfer| {
        let Inputs::Textures { onto, .. } = &mut transfer.inputs else { unreachable!() };
        *onto = None;
        transfer.size = Some(Size::square(64));
    });
    let failure = clear.transfer_bytes(&face, "row 17", Format::JPEG).unwrap_err();
    let wanted = "cannot write row 17: the result has an alpha channel";
    assert!(failure.to_string().starts_with(wanted), "{failure}");

    let fails = |source: &str, output: &str, wanted: &str| {
        let failure = prepared.transfer_file(&desk.path(source), &desk.path(output)).unwrap_err();
        assert_eq!(failure.fault(), Fault::Input, "{failure}");
        assert!(failure.to_string().contains(wanted), "{failure}");
    };
    fails("none.png", "out.png", "none.png");
    fails("a.png", "out.bmp", "extension must be one of");
    fails("a.png", "none/out.png", "none does not exist");
    fails("a.png", "a.png", "a.png is also an input");
    fails("a.png", "base.png", "base.png is also an input");
    std::fs::create_dir(desk.path("folder.png")).unwrap();
    fails("a.png", "folder.png", "must be a file, but is a folder");
    assert!(!desk.path("out.png").exists());
}

#[test]
fn what_belongs_to_a_whole_run_is_refused() {
    let desk = Desk::new();
    let refused = |change: &dyn Fn(&mut Transfer), wanted: &str| {
        let mut transfer = desk.transfer(&[], "");
        change(&mut transfer);
        let failure = transfer.prepare(&()).err().unwrap();
        assert_eq!(failure.fault(), Fault::Input, "{failure}");
        assert!(failure.to_string().contains(wanted), "{failure}");
    };
    refused(&|it| it.mask = Some(desk.path("mask.png")), "`mask`");
    refused(&|it| it.draw_labels = Some(desk.path("labels.png")), "`labels`");
    refused(&|it| it.extra_outputs.push(desk.path("preview.png")), "other outputs");
    refused(
        &|it| it.correspondence = uvgraft_pipeline::Correspondence::Pair("no.uvpair".into()),
        "no",
    );
    let onto = |name: &str| Some(BaseSource::image(desk.path(name)));
    let with_base = |name: &'static str| {
        move |transfer: &mut Transfer, onto: Option<BaseSource>| {
            let Inputs::Textures { onto: base, .. } = &mut transfer.inputs else { unreachable!() };
            *base = onto.or(Some(BaseSource::image(name)));
        }
    };
    refused(&|it| with_base("")(it, onto("base_<UDIM>.png")), "image for each tile");
    refused(&|it| with_base("none.png")(it, None), "none.png");
    refused(
        &|it| {
            let (role, source) = (Role::named("albedo").unwrap(), desk.path("a.png").into());
            it.inputs = Inputs::Material(vec![MaterialMap { role, source, onto: None }]);
        },
        "single textures",
    );
    refused(
        &|it| {
            data(it);
            membrane(it);
        },
        "data has no tone",
    );
}

/// Records of a run and of single textures agree.
#[test]
fn fingerprints_are_those_of_the_manifest() {
    let desk = Desk::new();
    for change in [membrane, data, |_: &mut Transfer| {}] {
        let mut transfer = desk.transfer(&["a.png", "b.png"], "out");
        change(&mut transfer);
        transfer.existing = Existing::KeepUpToDate;
        assert_eq!(transfer.run(&()).unwrap().written, 2);

        let prepared = desk.prepare(change);
        assert_eq!(prepared.fingerprint().len(), 64);
        let manifest = Manifest::open(&desk.path("out"), None).unwrap();
        let fingerprint = prepared.fingerprint_of_bytes(&desk.bytes("a.png"));
        assert_eq!(prepared.fingerprint_of_file(&desk.path("a.png")).unwrap(), fingerprint);
        let text = String::from_utf8(desk.bytes("out/.uvgraft-manifest.jsonl")).unwrap();
        assert!(text.contains(&format!("\"made_from\":\"{fingerprint}\"")), "{text}");
        let [a, b, c] = ["out/a.png", "out/b.png", "out/c.png"].map(|name| desk.path(name));
        assert!(manifest.is_up_to_date(&a, &fingerprint));
        assert!(!manifest.is_up_to_date(&b, &fingerprint));
        assert!(!manifest.is_up_to_date(&c, &fingerprint));

        // What a caller records, a run skips.
        let fingerprint = prepared.fingerprint_of_file(&desk.path("c.png")).unwrap();
        prepared.transfer_file(&desk.path("c.png"), &c).unwrap();
        manifest.record(&c, &fingerprint).unwrap();
        assert!(manifest.is_up_to_date(&c, &fingerprint));
        let mut transfer = desk.transfer(&["a.png", "b.png", "c.png"], "out");
        change(&mut transfer);
        transfer.existing = Existing::KeepUpToDate;
        assert_eq!(transfer.run(&()).unwrap().up_to_date, 3);
        std::fs::remove_dir_all(desk.path("out")).unwrap();
    }
}

#[test]
fn records_name_what_is_wrong() {
    let desk = Desk::new();
    let manifest = Manifest::open(desk.0.path(), None).unwrap();
    let fingerprint = "0".repeat(64);
    let fails = |output: &Path, fingerprint: &str, wanted: &str| {
        let failure = manifest.record(output, fingerprint).unwrap_err().to_string();
        assert!(failure.contains(wanted), "{failure}");
    };
    fails(Path::new("/elsewhere/a.png"), &fingerprint, "must be in the folder");
    fails(&desk.path("a.png"), "banana", "64 lower-case hexadecimal digits, got \"banana\"");
    fails(&desk.path("none.png"), &fingerprint, "none.png in the manifest");
    assert!(!desk.path(".uvgraft-manifest.jsonl").exists());
}
