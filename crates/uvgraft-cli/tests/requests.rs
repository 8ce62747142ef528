//! Requests of the library give the bytes that the command writes, from paths and from bytes in memory.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::sync::Mutex;

use uvgraft::blend::Side;
use uvgraft::{Channels, Size};
use uvgraft_assembly::avatar::{MapRole, Metadata};
use uvgraft_assembly::render::{Aim, Shot};
use uvgraft_assembly::selfie::{Head, Networks};
use uvgraft_assembly::{AvatarRequest, Body, Fault, Input, Observer, RenderRequest, SelfieRequest};
use uvgraft_figure::Figure;
use uvgraft_figure::motion::as_amass;
use uvgraft_gltf::glb::{EmbeddedFormat, Permissions};
use uvgraft_io::arrays::{self, NamedArrays, NumericArray};
use uvgraft_pipeline::{BaseSource, Event, RegionPart, Unit};
use uvgraft_tests::downloads;

use crate::bench::Bench;

const SIDE: u32 = 256;

/// A file of the bench as bytes in memory.
fn bytes(bench: &Bench, name: &str) -> Input {
    Input::bytes(name, bench.bytes(name))
}

/// The avatar of the command in `avatar_from_files_and_from_bytes`.
fn request(body: Body, given: impl Fn(&str) -> Input) -> AvatarRequest {
    let mut request = AvatarRequest::new(body, "me.vrm");
    request.pair = Some(given("demo.uvpair"));
    request.face = Some(given("face.png"));
    request.onto = Some(BaseSource::Image(given("base.png")));
    request.region.unit = Some(Unit::M);
    request.region.exclude =
        vec![RegionPart { side: Side::Source, input: given("nape.txt"), names: Vec::new() }];
    request.motions.recordings = vec![given("wave.npz")];
    request.source_mask = Some(given("trusted.png"));
    request.fill = Some(given("face.png"));
    request.materials.maps = vec![(MapRole::Roughness, given("rough.png"))];
    request.textures.quality = Some(80);
    request.textures.format = Some(EmbeddedFormat::Jpeg);
    request.metadata = Metadata {
        authors: vec!["Nobody".to_owned()],
        license: Some(Permissions::ONLY_AUTHOR),
        ..Metadata::default()
    };
    request
}

fn bench() -> Bench {
    let figure = Figure::new();
    let bench = Bench::of_figure(&figure, SIDE);
    bench.paint("trusted.png", (64, 64), Channels::Grey, &[255]);
    bench.paint("rough.png", (64, 64), Channels::Grey, &[90]);
    bench.write("nape.txt", "0 1 2 3 4 5\n");
    let avatar = figure.avatar();
    let wave = avatar.clips.iter().find(|clip| clip.name == "wave").unwrap();
    let wave = as_amass(&avatar.skeleton, wave);
    let mut motion = NamedArrays::new();
    let floats = |shape: &[usize], values| NumericArray::new_f32(shape.to_vec(), values).unwrap();
    motion.insert("poses", floats(&[wave.frames, 156], wave.poses));
    motion.insert("trans", floats(&[wave.frames, 3], wave.trans));
    motion.insert("mocap_framerate", floats(&[], vec![wave.mocap_framerate]));
    arrays::save_npz(&motion, bench.path("wave.npz")).unwrap();
    bench
}

#[test]
fn avatar_from_files_and_from_bytes() {
    let bench = bench();
    let printed = bench.make(
        "avatar demo.uvpair face.png --onto base.png --unit m --exclude nape.txt --body demo \
         --source-mask trusted.png --fill face.png --map roughness=rough.png --texture jpeg \
         --quality 80 --motion wave.npz --author Nobody --license only-author -o me.vrm",
    );
    let wanted = bench.bytes("me.vrm");
    let by_path = request(Body::Figure, |name| bench.path(name).into()).make(&()).unwrap();
    let by_bytes = request(Body::Figure, |name| self::bytes(&bench, name)).make(&()).unwrap();
    assert!(by_path.file == wanted && by_bytes.file == wanted);
    assert_eq!(by_bytes.report, by_path.report);
    assert_eq!(by_path.report.to_string(), printed);
}

/// Remembers what it is told, and may cancel.
#[derive(Default)]
struct Notebook {
    reported: Mutex<Vec<String>>,
    cancels: bool,
}

impl Observer for Notebook {
    fn event(&self, event: Event<'_>) {
        if let Event::Note(text) | Event::Warning(text) = event {
            self.reported.lock().unwrap().push(text.to_owned());
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancels
    }
}

#[test]
fn observers_are_reported_and_may_cancel() {
    let bench = bench();
    let mut request = request(Body::Figure, |name| bench.path(name).into());
    let mut reported = Notebook::default();
    request.make(&reported).unwrap();
    let said = reported.reported.lock().unwrap().join("\n");
    assert!(said.contains("wave.npz: falling back to `ground` feet: the demo"), "{said}");
    reported.cancels = true;
    assert_eq!(request.make(&reported).unwrap_err().fault(), Fault::Cancelled);
    request.onto = None;
    let failure = request.make(&()).unwrap_err();
    assert_eq!(failure.fault(), Fault::Input);
    // Parameters are named as the fields are, not as the command's options.
    assert!(failure.to_string().starts_with("`onto` must include"), "{failure}");
}

#[test]
fn renders() {
    let bench = bench();
    bench.make("avatar demo.uvpair face.png --onto base.png --unit m --body demo -o me.glb");
    bench.make("render me.glb -o me.png --camera head --size 64x96 --clip walk --frame 0.3");
    let wanted = bench.texture("me.png");
    let mut request = RenderRequest::new(self::bytes(&bench, "me.glb"));
    request.aim = Aim::Shot(Shot::Head);
    request.size = Size::new(64, 96);
    request.clip = Some("walk".to_owned());
    request.frame = Some(0.3);
    let rendering = request.open(&()).unwrap();
    let pictures: Vec<_> = rendering.pictures().map(Result::unwrap).collect();
    assert_eq!(pictures, [wanted]);
    request.zoom = 0.0;
    let failure = request.open(&()).map(drop).unwrap_err().to_string();
    assert_eq!(failure, "`zoom` must be 0.1 to 50, got 0");
}

#[test]
fn selfies_from_files_and_from_bytes() {
    let (Some(package), Some(photo)) =
        (downloads::face_mesh_package(), downloads::photograph("astronaut"))
    else {
        return;
    };
    let bench = bench();
    bench.run_args(&["weights", "import", package.to_str().unwrap()]);
    bench.save("astronaut.png", photo);
    bench.make("selfie astronaut.png --head demo --size 512 -o face.png --cameras cameras.json");
    bench.make("avatar --selfie astronaut.png --body demo --size 512 -o me.glb");
    let networks = || Networks::File(self::bytes(&bench, "faces.safetensors"));
    let mut request = SelfieRequest::new(Head::Figure, [bench.path("astronaut.png")]);
    request.size = Size::square(512);
    request.photo_options.networks = networks();
    let made = request.make(&()).unwrap();
    assert_eq!(*made.texture(), bench.texture("face.png"));
    assert_eq!(made.cameras_json().unwrap().into_bytes(), bench.bytes("cameras.json"));
    let mut request = AvatarRequest::new(Body::Figure, "me.glb");
    request.photos = vec![self::bytes(&bench, "astronaut.png")];
    request.textures.size = Some(Size::square(512));
    request.photo_options.networks = networks();
    let file = request.make(&()).unwrap().file;
    assert!(file == bench.bytes("me.glb"));
}
