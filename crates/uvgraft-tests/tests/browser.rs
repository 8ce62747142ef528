//! Our files in third-party programs: Khronos' validator, three.js and three-vrm in Chromium, and
//! the page of `uvgraft view` there. A mannequin shows whether joints and colours are where our own
//! arithmetic puts them.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::TempDir;
use uvgraft::Texels;
use uvgraft_avatar::rig::Pose;
use uvgraft_tests::browser::Browser;
use uvgraft_tests::mannequin;
use uvgraft_viewer::{Glb, PAGE, Page, Template, WebImage};

/// Joint positions are sums and products of a few numbers below 2 in 32 bits, and rotations in
/// files are rounded to 1e-7.
const JOINT_TOLERANCE: f64 = 2e-6;
/// In levels: sRGB textures are decoded to linear light and encoded again.
const COLOR_TOLERANCE: u8 = 2;

const SIZE: [u32; 2] = [480, 640];
const EYE: [f32; 3] = [0.0, 1.0, 4.0];
const FIELD_OF_VIEW: f32 = 30.0;

fn camera() -> Value {
    json!({ "eye": EYE, "target": [0, 1, 0], "fovY": FIELD_OF_VIEW })
}

/// The pixel that a point projects to.
fn pixel([x, y, z]: [f32; 3]) -> [u32; 2] {
    let [width, height] = SIZE.map(|side| side as f32);
    let scale = height / 2.0 / (FIELD_OF_VIEW / 2.0).to_radians().tan() / (EYE[2] - z);
    let at = [width / 2.0 + (x - EYE[0]) * scale, height / 2.0 - (y - EYE[1]) * scale];
    at.map(|value| value as u32)
}

/// Asserts the colours of the boxes' fronts in an unlit picture.
fn check_colors(picture: &Path, fronts: &[[f32; 3]], color: impl Fn(usize) -> [u8; 3]) {
    let picture = uvgraft_image::read(picture).unwrap().texture;
    assert_eq!([picture.size().width, picture.size().height], SIZE);
    let Texels::U8(values) = picture.texels() else { panic!("8 bits") };
    for (number, &front) in fronts.iter().enumerate() {
        let [x, y] = pixel(front);
        let at = (y * SIZE[0] + x) as usize * picture.channels().count();
        let (found, wanted) = (&values[at..at + 3], color(number));
        let is_near = found.iter().zip(wanted).all(|(&a, b)| a.abs_diff(b) <= COLOR_TOLERANCE);
        assert!(is_near, "box {number} at {x}, {y}: found {found:?}, wanted {wanted:?}");
    }
}

/// Asserts the positions of joints, looked up by their names or their bones' names.
fn check_joints(found: &Value, pose: &Pose, by_bone: bool) {
    let avatar = mannequin::avatar();
    let motions = avatar.skeleton.motions(pose).unwrap();
    for (joint, motion) in avatar.skeleton.joints().iter().zip(motions) {
        let name = if by_bone { joint.human.unwrap().name() } else { &joint.name };
        let wanted = motion.point(joint.position);
        for axis in 0..3 {
            let found = found[name][axis].as_f64().unwrap_or(f64::NAN);
            let distance = (found - f64::from(wanted[axis])).abs();
            assert!(distance <= JOINT_TOLERANCE, "{name}, axis {axis}: {found}, wanted {wanted:?}");
        }
    }
}

/// A pose in the form of three-vrm's normalized bones.
fn rotations(pose: &Pose) -> Value {
    let avatar = mannequin::avatar();
    let joints = avatar.skeleton.joints().iter();
    let pairs = joints.zip(&pose.rotations);
    pairs.map(|(joint, q)| (joint.human.unwrap().name().to_owned(), json!(q))).collect()
}

/// Humanoid bones are not given the translation.
fn in_place(pose: Pose) -> Pose {
    Pose { translation: [0.0; 3], ..pose }
}

fn write(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn the_validator_reports_nothing() {
    let Some(browser) = Browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let glb = write(&folder, "me.glb", &mannequin::file(false));
    let vrm = write(&folder, "me.vrm", &mannequin::file(true));
    let mut broken = mannequin::file(false);
    let at = broken.windows(8).position(|bytes| bytes == b"\"skin\":0").unwrap();
    broken[at + 7] = b'7';
    let broken = write(&folder, "broken.glb", &broken);
    let [glb, vrm, broken] = browser.validate(&[&glb, &vrm, &broken]).try_into().unwrap();
    for report in [glb, vrm] {
        assert_eq!((report.errors, report.warnings), (0, 0), "{:?}", report.messages);
    }
    assert!(broken.errors > 0);
    assert_eq!(broken.messages[0]["code"], "UNRESOLVED_REFERENCE", "{:?}", broken.messages);
}

#[test]
fn three_js_shows_a_glb_as_it_is() {
    let Some(browser) = Browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = write(&folder, "me.glb", &mannequin::file(false));
    let picture = |name: &str| folder.path().join(name);
    let shot = |name: &str, more: Value| {
        let mut shot = json!({ "output": picture(name), "width": SIZE[0], "height": SIZE[1],
            "camera": camera(), "unlit": true, "background": "#000000" });
        shot.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        shot
    };
    let shots = json!([
        shot("rest.png", json!({})),
        shot("clip.png", json!({ "clip": "bow", "time": 0.5, "expressions": { "aside": 1 } })),
        shot("end.png", json!({ "clip": 0, "time": 1 })),
    ]);
    let found = browser.shoot(&file, &shots);
    assert_eq!(found["errors"], json!([]));
    assert_eq!(found["isVrm"], false);
    assert_eq!(found["animations"], json!([{ "name": "bow", "duration": 1 }]));
    // three.js appends numbers to duplicate names, such as the node's and the mesh's here.
    let morphs: Vec<&Value> = found["morphTargets"].as_object().unwrap().values().collect();
    assert_eq!(morphs, [&json!(["aside"])]);
    let avatar = mannequin::avatar();
    let rest = Pose::rest(avatar.skeleton.joints().len());
    let wanted = [("rest.png", rest, 0.0), ("clip.png", mannequin::pose(0.5), 1.0)];
    let wanted = wanted.into_iter().chain([("end.png", mannequin::pose(1.0), 0.0)]);
    for ((name, pose, happy), shot) in wanted.zip(found["shots"].as_array().unwrap()) {
        check_joints(&shot["joints"], &pose, false);
        let fronts = mannequin::fronts(&avatar, &pose, happy);
        check_colors(&picture(name), &fronts, mannequin::color);
    }
}

#[test]
fn three_vrm_poses_a_vrm_as_we_do() {
    let Some(browser) = Browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = write(&folder, "me.vrm", &mannequin::file(true));
    let output = folder.path().join("posed.png");
    let pose = in_place(mannequin::pose(1.0));
    let found = browser.shoot(
        &file,
        &json!([{ "output": output, "width": SIZE[0], "height": SIZE[1], "camera": camera(),
            "unlit": true, "pose": rotations(&pose), "expressions": { "happy": 0.6 } }]),
    );
    assert_eq!(found["errors"], json!([]));
    assert_eq!(found["isVrm"], true);
    assert_eq!(found["meta"]["authors"], json!(["uvgraft's tests"]));
    assert_eq!(found["expressions"], json!(["happy"]));
    let avatar = mannequin::avatar();
    let bones = avatar.skeleton.joints().iter().map(|joint| joint.human.unwrap().name());
    let mut bones: Vec<&str> = bones.collect();
    let mut humanoid: Vec<&str> =
        found["humanoid"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    bones.sort_unstable();
    humanoid.sort_unstable();
    assert_eq!(humanoid, bones);
    check_joints(&found["shots"][0]["bones"], &pose, true);
    check_colors(&output, &mannequin::fronts(&avatar, &pose, 0.6), mannequin::color);
}

/// A page with the mannequin and two textures; `None`, with a message, if the viewer is not built.
fn page(folder: &TempDir, is_vrm: bool, name: &str) -> Option<PathBuf> {
    let Some(html) = PAGE else {
        let reason = "this build has no viewer; scripts/build-viewer.sh makes it, and the feature \
            `viewer` takes it in";
        assert!(std::env::var_os("CI").is_none(), "{reason}");
        #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
        {
            eprintln!("skipped: {reason}");
        }
        return None;
    };
    let model = mannequin::file(is_vrm);
    let (red, green) = (mannequin::plain([200, 40, 30]), mannequin::plain([30, 160, 60]));
    let pictures = [(name, red), ("green", green)];
    let textures =
        pictures.iter().map(|(name, file)| (*name, WebImage::new(file.bytes()).unwrap()));
    let page = Page {
        name,
        model: Glb::new(&model).unwrap(),
        textures: textures.collect(),
        look_at: None,
    };
    let mut html_with_data = Vec::new();
    page.write(&Template::new(html).unwrap(), &mut html_with_data).unwrap();
    Some(write(folder, "me.html", &html_with_data))
}

#[test]
fn the_viewer_shows_poses_motions_expressions_and_textures() {
    let Some(browser) = Browser::find() else { return };
    let avatar = mannequin::avatar();
    let pose = in_place(mannequin::pose(1.0));
    for is_vrm in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let evil = "</title></script><script>throw 'out'</script><!--";
        let Some(page) = page(&folder, is_vrm, evil) else { return };
        let picture = |name: &str| folder.path().join(name);
        let shoot =
            |name: &str| json!({ "picture": picture(name), "width": SIZE[0], "height": SIZE[1] });
        let expression = if is_vrm { "happy" } else { "aside" };
        let steps = json!([
            { "call": "setUnlit", "args": [true] },
            { "call": "setGround", "args": [false] },
            { "call": "setCamera", "args": [camera()] },
            { "call": "setPose", "args": [rotations(&pose)] },
            { "call": "setExpression", "args": [expression, 0.6] },
            { "call": "bones" },
            shoot("posed.png"),
            { "call": "setTime", "args": [1, "bow"] },
            { "call": "bones" },
            { "call": "setExpression", "args": [expression, 0] },
            { "call": "setTexture", "args": [2] },
            shoot("green.png"),
            { "call": "setTexture", "args": [0] },
            { "call": "setPose", "args": ["t"] },
            { "call": "bones" },
            shoot("t.png"),
        ]);
        let found = browser.view(&page, &steps);
        let rest = Pose::rest(avatar.skeleton.joints().len());
        assert_eq!(found["errors"], json!([]));
        assert_eq!(found["requests"], json!([]));
        assert_eq!(found["title"], evil);
        let info = &found["info"];
        assert_eq!(info["isVrm"], is_vrm);
        assert_eq!(info["textures"], json!(["As in the file", evil, "green"]));
        assert_eq!(info["expressions"], json!([expression]));
        assert_eq!(info["clips"], json!([{ "name": "bow", "duration": 1 }]));
        let results = &found["results"];
        let front = |pose: &Pose, happy| mannequin::fronts(&avatar, pose, happy);
        check_joints(&results[5], &pose, true);
        check_colors(&picture("posed.png"), &front(&pose, 0.6), mannequin::color);
        let end = mannequin::pose(1.0);
        check_joints(&results[8], &end, true);
        check_colors(&picture("green.png"), &front(&end, 0.0), |_| [30, 160, 60]);
        // At rest it stands in T-pose.
        check_joints(&results[14], &rest, true);
        check_colors(&picture("t.png"), &front(&rest, 0.0), mannequin::color);
    }
}

#[test]
fn the_viewers_controls_work() {
    let Some(browser) = Browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let Some(page) = page(&folder, true, "me.vrm") else { return };
    let blue = write(&folder, "blue.png", mannequin::plain([20, 60, 200]).bytes());
    let saved = folder.path().join("saved.png");
    let steps = json!([
        { "click": "#play" },
        { "choose": "#speed", "value": "0.5" },
        { "slide": "#time", "value": 0.5 },
        { "call": "bones" },
        { "choose": "#light", "value": "unlit" },
        { "choose": "#background", "value": "white" },
        { "click": "#ground" },
        { "key": "s" }, { "key": "w" }, { "key": "h" }, { "key": "w" }, { "key": "s" },
        { "click": "[data-pose=wave]" },
        { "call": "bones" },
        { "slide": "#expressions input", "value": 0.5 },
        { "click": "#neutral" },
        { "click": "[data-pose=rest]" },
        { "drop": blue },
        { "click": "[data-frame=body]" },
        { "choose": "#picture-size", "value": "1024" },
        { "download": "#save-picture", "output": saved },
        { "call": "info" },
    ]);
    let found = browser.view(&page, &steps);
    assert_eq!(found["errors"], json!([]));
    assert_eq!(found["requests"], json!([]));
    let results = &found["results"];
    check_joints(&results[3], &mannequin::pose(0.5), true);
    let height = |bone: &str| results[13][bone][1].as_f64().unwrap();
    assert!(height("rightHand") > height("rightLowerArm") + 0.1, "the right hand waves");
    assert!(height("leftHand") < height("leftLowerArm") - 0.1, "the left arm hangs");
    assert_eq!(results[20], "me.png");
    let textures = &results[21]["textures"];
    assert_eq!(*textures, json!(["As in the file", "me.vrm", "green", "blue.png"]));

    // On white, the whole figure has the dropped picture's blue: only the two colours and, along
    // edges, their mixtures appear.
    let picture = uvgraft_image::read(&saved).unwrap().texture;
    assert_eq!([picture.size().width, picture.size().height], [1024; 2]);
    let Texels::U8(values) = picture.texels() else { panic!("8 bits") };
    let channels = picture.channels().count();
    let count = |color: [u8; 3]| values.chunks_exact(channels).filter(|v| v[..3] == color).count();
    let (figure, background) = (count([20, 60, 200]), count([255; 3]));
    assert!(figure > 40_000, "{figure} pixels of the figure");
    assert!(background > 700_000, "{background} pixels of the background");
    assert!(figure + background > 1024 * 1024 * 99 / 100, "{figure} and {background}");
}
