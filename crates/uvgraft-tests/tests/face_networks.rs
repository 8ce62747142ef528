//! Face networks against LiteRT, and what they find in photographs.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
#![allow(clippy::print_stdout, reason = "how near the results are is worth knowing")]

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;
use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_selfie::face_networks::import::{self, Imported};
use uvgraft_selfie::face_networks::{self, FaceModels};
use uvgraft_selfie::landmarks::{FaceChoice, FaceError, FaceNetworks, FoundFace, regions};
use uvgraft_selfie::network::Network;
use uvgraft_selfie::tflite::Model;
use uvgraft_tests::downloads;

/// Both sum in single precision in different orders; the fixtures are rounded to 1e-4. In pixels, or in
/// the networks' own units.
const TOLERANCE: f64 = 1e-3;

/// Of the detector's 896 anchors, the fixtures have every so many.
const ANCHOR_STEP: usize = 28;

#[derive(Deserialize)]
struct Fixture {
    #[serde(rename = "box")]
    face: [f64; 3],
    patterns: BTreeMap<String, Vec<Vec<f64>>>,
    photographs: Vec<Photograph>,
}

#[derive(Deserialize)]
struct Photograph {
    enlarged: u32,
    score: f64,
    points: Vec<f64>,
    irises: [Vec<f64>; 2],
    lids: [Vec<f64>; 2],
}

static FIXTURE: LazyLock<Fixture> =
    LazyLock::new(|| serde_json::from_str(include_str!("../fixtures/faces.json")).unwrap());

/// Imported, saved and read back; `None`, with a message, if they have not been fetched.
static MODELS: LazyLock<Option<FaceModels>> = LazyLock::new(|| {
    let import = |path| import::import(&std::fs::read(path).unwrap()).unwrap();
    let (package, wheel) = (downloads::face_mesh_package()?, downloads::iris_wheel()?);
    let Imported::Face(mut files) = import(package) else { panic!("no face networks") };
    let Imported::Iris(iris) = import(wheel) else { panic!("no iris network") };
    files.iris = Some(iris);
    let bytes = face_networks::encode(&files).unwrap();
    Some(face_networks::decode(&bytes).unwrap().parse().unwrap())
});

static NETWORKS: LazyLock<Option<FaceNetworks>> =
    LazyLock::new(|| Some(FaceNetworks::new(MODELS.as_ref()?).unwrap()));

fn assert_near(found: impl IntoIterator<Item = f64>, wanted: &[f64], what: &str) {
    let found: Vec<f64> = found.into_iter().collect();
    assert_eq!(found.len(), wanted.len(), "{what}");
    let differences = found.iter().zip(wanted).map(|(found, wanted)| (found - wanted).abs());
    let largest = differences.fold(0.0, f64::max);
    println!("{what}: {largest:.1e}");
    assert!(largest < TOLERANCE, "{what}: {largest}");
}

#[test]
fn networks_equal_litert() {
    let Some(models) = &*MODELS else { return };
    let run = |name: &str, model: &Model| {
        let side = model.tensors[model.inputs[0]].shape[1];
        let value = |index: usize| {
            let (c, x, y) = (index % 3, index / 3 % side, index / 3 / side);
            ((x * x + 3 * x * y + 7 * y * c + 11 * c) % 251) as f32 / 250.0
        };
        let input: Vec<f32> = (0..side * side * 3).map(value).collect();
        let network = Network::new(model).unwrap();
        let mut outputs = network.run(&input).unwrap();
        assert_eq!(outputs, network.run_reference(&input).unwrap(), "{name}");
        outputs.sort_by_key(Vec::len);
        assert_eq!(outputs.len(), FIXTURE.patterns[name].len());
        for (index, (found, wanted)) in outputs.iter().zip(&FIXTURE.patterns[name]).enumerate() {
            let each = if name == "detection" { found.len() / 896 } else { found.len() };
            let found = found.chunks_exact(each).step_by(ANCHOR_STEP).flatten();
            let found = found.map(|&value| f64::from(value));
            assert_near(found, wanted, &format!("{name}, output {index}"));
        }
    };
    run("landmark", &models.landmark);
    run("detection", &models.detection);
    run("iris", models.iris.as_ref().unwrap());
}

fn enlarged(texture: &Texture, factor: u32) -> Texture {
    let Texels::U8(values) = texture.texels() else { panic!("8-bit pictures only") };
    let Size { width, height } = texture.size();
    let texel = |index: u32| {
        let (x, y) = (index % (width * factor) / factor, index / (width * factor) / factor);
        let start = (y * width + x) as usize * 3;
        [values[start], values[start + 1], values[start + 2]]
    };
    let texels = (0..width * height * factor * factor).flat_map(texel).collect();
    let size = Size::new(width * factor, height * factor);
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels)).unwrap()
}

#[test]
fn landmarks_of_a_photograph_equal_litert() {
    let Some(networks) = &*NETWORKS else { return };
    let Some(astronaut) = downloads::photograph("astronaut") else { return };
    for wanted in &FIXTURE.photographs {
        let factor = f64::from(wanted.enlarged);
        let [x, y, side] = FIXTURE.face.map(|value| value * factor);
        // The script has the eyes level.
        let mut keypoints = [[x, y]; 6];
        keypoints[1][0] += 1.0;
        let face =
            FoundFace { score: 1.0, center: [x, y], box_size: [side; 2], angle: 0.0, keypoints };
        let found = networks.landmarks(&enlarged(&astronaut, wanted.enlarged), &face);
        let what = |what: &str| format!("{what}, {factor}×");
        assert_near(found.points.into_iter().flatten(), &wanted.points, &what("landmarks"));
        assert_near([found.score], &[wanted.score], &what("score"));
        for (index, iris) in found.irises.unwrap().into_iter().enumerate() {
            let points = [iris.center].into_iter().chain(iris.outline).flatten();
            assert_near(points, &wanted.irises[index], &what("iris"));
            // The network has the lower lid first, then the upper one from the outside.
            let (lower, upper) = iris.lids.split_at(9);
            let points = lower.iter().chain(upper.iter().rev()).copied().flatten();
            assert_near(points, &wanted.lids[index], &what("lids"));
        }
    }
}

#[test]
fn finds_the_astronaut_and_nobody_else() {
    let Some(networks) = &*NETWORKS else { return };
    let Some(astronaut) = downloads::photograph("astronaut") else { return };
    let found = networks.find(&astronaut, FaceChoice::Only).unwrap();
    assert!(found.score > 0.99 && found.flat_part < 0.01, "{} {}", found.score, found.flat_part);
    let angles = [found.yaw(), found.pitch(), found.roll()].map(f64::to_degrees);
    assert!(angles.iter().all(|angle| angle.abs() < 15.0), "{angles:?}");
    // The pupils, as one sees them.
    for (iris, wanted) in found.irises.unwrap().iter().zip([[203.6, 101.0], [246.6, 103.4]]) {
        assert!((0..2).all(|axis| (iris.center[axis] - wanted[axis]).abs() < 1.5), "{iris:?}");
        assert!((iris.radius - 4.0).abs() < 0.5, "{iris:?}");
    }
    for name in ["chelsea", "coffee", "brick", "motorcycle_left"] {
        let Some(photograph) = downloads::photograph(name) else { return };
        assert_eq!(networks.find(&photograph, FaceChoice::Largest), Err(FaceError::None), "{name}");
    }
}

#[test]
fn upside_down_a_face_has_the_same_landmarks() {
    let Some(networks) = &*NETWORKS else { return };
    let Some(astronaut) = downloads::photograph("astronaut") else { return };
    let Texels::U8(values) = astronaut.texels() else { panic!("8-bit pictures only") };
    let turned = values.as_chunks::<3>().0.iter().rev().flatten().copied().collect();
    let size = astronaut.size();
    let turned = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(turned)).unwrap();
    let [upright, turned] = [&astronaut, &turned]
        .map(|picture| networks.find(picture, FaceChoice::Only).unwrap().points);
    let far = upright.iter().zip(&turned).map(|(a, b)| {
        let [x, y] = [f64::from(size.width) - b[0], f64::from(size.height) - b[1]];
        (a[0] - x).hypot(a[1] - y)
    });
    let far = far.fold(0.0, f64::max);
    assert!(far < 2.0, "{far} pixels");
}

#[test]
fn threads_do_not_show() {
    let Some(networks) = &*NETWORKS else { return };
    let Some(astronaut) = downloads::photograph("astronaut") else { return };
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| networks.find(&astronaut, FaceChoice::Largest).unwrap())
    };
    let one = with_threads(1);
    assert!(one == with_threads(2) && one == with_threads(3));
}

#[test]
fn outlines_run_along_edges_and_mirror_each_other() {
    let Some(networks) = &*NETWORKS else { return };
    let face = networks.canonical();
    assert_eq!((face.positions.len(), face.triangles.len()), (468, 898));
    for (landmark, &mirror_partner) in face.mirror_partners.iter().enumerate() {
        assert_eq!(face.mirror_partners[mirror_partner], landmark);
    }
    let is_edge = |a: usize, b: usize| {
        let has = |triangle: &[u32; 3], at: usize| triangle.contains(&u32::try_from(at).unwrap());
        face.triangles.iter().filter(|triangle| has(triangle, a) && has(triangle, b)).count()
    };
    let outlines = [
        &regions::RIGHT_EYE[..],
        &regions::LEFT_EYE,
        &regions::RIGHT_BROW,
        &regions::LEFT_BROW,
        &regions::LIPS_OUTER,
        &regions::LIPS_INNER,
        &regions::FACE_OVAL,
    ];
    for outline in outlines {
        for (index, &from) in outline.iter().enumerate() {
            let to = outline[(index + 1) % outline.len()];
            // The edge of the mesh has a triangle on one side only.
            let wanted = if outline == regions::FACE_OVAL { 1 } else { 2 };
            assert_eq!(is_edge(from, to), wanted, "{from} to {to}");
        }
    }
    for (right, left) in [(outlines[0], outlines[1]), (outlines[2], outlines[3])] {
        assert!(right.iter().zip(left).all(|(&right, &left)| face.mirror_partners[right] == left));
        assert!(right.iter().all(|&right| face.positions[right][0] < 0.0));
    }
    for outline in &outlines[4..] {
        assert!(outline.iter().all(|&at| outline.contains(&face.mirror_partners[at])));
    }
    for middle in [regions::NOSE_TIP, regions::CHIN, regions::FOREHEAD] {
        assert_eq!(face.mirror_partners[middle], middle);
    }
    assert!(regions::NOSE_RIDGE.iter().all(|&at| face.mirror_partners[at] == at));
    let height = |at: usize| face.positions[at][1];
    assert!(height(regions::FOREHEAD) > height(regions::RIGHT_EYE_OUTER));
    assert!(height(regions::RIGHT_EYE[4]) < height(regions::RIGHT_EYE[12]));
}
