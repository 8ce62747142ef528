//! The demo's figure as GLB and VRM in Chromium, posed by three.js and three-vrm, compared with
//! pictures by our own renderer with the same camera.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::path::Path;

use serde_json::{Value, json};
use uvgraft::{Channels, Depth, Size, Texels, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::HumanBone;
use uvgraft_figure::{Figure, paint_body};
use uvgraft_gltf::glb::{
    AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export, Permissions, VrmMeta, write,
};
use uvgraft_gltf::scene::{PoseRequest, Scene};
use uvgraft_metrics::{Colors, ssim};
use uvgraft_render::{Background, Perspective, RenderOptions, Renderer};
use uvgraft_tests::browser::Browser;

const SIZE: Size = Size::new(450, 600);
/// No colour of the figure is close to it, so that silhouettes can be separated.
const BACKGROUND: [u8; 3] = [255, 0, 255];
/// In metres. three.js skins with 32-bit sums over chains of up to ten joints.
const BONE_TOLERANCE: f64 = 1e-5;

/// A picture: its camera, and the same pose described for our renderer and for the browser.
struct Shot {
    name: &'static str,
    camera: Perspective,
    posing: PoseRequest,
    browser: Value,
}

fn camera(eye: [f32; 3], target: [f32; 3]) -> Perspective {
    Perspective { eye, target, up: [0.0, 1.0, 0.0], fov_y: 30.0, near: 0.05, far: 20.0 }
}

/// The whole figure from an angle, and its head.
fn cameras() -> [Perspective; 2] {
    [camera([1.4, 1.2, 3.4], [0.0, 0.9, 0.0]), camera([0.2, 1.65, 0.8], [0.0, 1.62, 0.0])]
}

fn file(avatar: &Avatar, is_vrm: bool) -> Vec<u8> {
    let color = paint_body(&Figure::new(), Size::new(1024, 1024));
    let meta = || VrmMeta::new("figure", vec!["uvgraft".to_owned()], Permissions::EVERYONE);
    let export = Export { vrm: is_vrm.then(meta), ..Export::default() };
    let color = EmbeddedImage::encode(color, EmbeddedFormat::Png, 90).unwrap();
    write(avatar, &AvatarMaterial::new(color), &export).unwrap().bytes
}

/// Compares the browser's picture with ours: intersection over union of the silhouettes, and SSIM.
fn likeness(scene: &Scene, shot: &Shot, picture: &Path) -> (f64, f64) {
    let options = RenderOptions {
        lit: false,
        background: Background::Plain(BACKGROUND),
        ..RenderOptions::default()
    };
    let drawn = scene.pose(&shot.posing).unwrap();
    let ours = Renderer::for_scene(scene).render(&drawn, &shot.camera, &options, SIZE);
    let theirs = uvgraft_image::read(picture).unwrap().texture;
    let theirs = theirs.converted(Channels::Rgb, Depth::U8);
    // Edges are blended with the background; more than half of such a pixel must be the figure's.
    let silhouette = |texture: &Texture| -> Vec<bool> {
        let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
        let far = |v: &[u8]| v.iter().zip(BACKGROUND).map(|(&a, b)| u32::from(a.abs_diff(b))).sum();
        values
            .chunks_exact(3)
            .map(|value| {
                let sum: u32 = far(value);
                sum > 120
            })
            .collect()
    };
    let pairs: Vec<(bool, bool)> = silhouette(&ours).into_iter().zip(silhouette(&theirs)).collect();
    let both = pairs.iter().filter(|&&(a, b)| a && b).count();
    let any = pairs.iter().filter(|&&(a, b)| a || b).count();
    assert!(any > SIZE.texels() / 20, "{}: the figure fills some of the picture", shot.name);
    let [ours, theirs] = [ours, theirs].map(|texture| Colors::new(texture).unwrap());
    (both as f64 / any as f64, ssim(&ours, &theirs, None).unwrap())
}

/// Takes all pictures in the browser and asserts that ours match them. Returns the browser's
/// report.
fn compare(browser: &Browser, bytes: &[u8], name: &str, shots: &[Shot]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    std::fs::write(&file, bytes).unwrap();
    let picture = |shot: &Shot| folder.path().join(format!("{}.png", shot.name));
    let [red, green, blue] = BACKGROUND;
    let wanted = shots.iter().map(|shot| {
        let Perspective { eye, target, up, fov_y, .. } = shot.camera;
        let mut wanted = json!({
            "output": picture(shot), "width": SIZE.width, "height": SIZE.height, "unlit": true,
            "camera": { "eye": eye, "target": target, "up": up, "fovY": fov_y },
            "background": format!("rgb({red}, {green}, {blue})"),
        });
        wanted.as_object_mut().unwrap().extend(shot.browser.as_object().unwrap().clone());
        wanted
    });
    let report = browser.validate(&[&file]).pop().unwrap();
    assert_eq!((report.errors, report.warnings), (0, 0), "{name}: {:?}", report.messages);
    let found = browser.shoot(&file, &wanted.collect());
    assert_eq!(found["errors"], json!([]), "{name}");
    let scene = Scene::read(bytes).unwrap();
    for shot in shots {
        let (shared, ssim) = likeness(&scene, shot, &picture(shot));
        // Both take several samples per pixel, but at different positions, and select mip levels
        // differently.
        assert!(shared > 0.99, "{name} {}: silhouettes share {shared}", shot.name);
        assert!(ssim > 0.97, "{name} {}: SSIM {ssim}", shot.name);
    }
    found
}

/// A rotation about one axis in degrees, in our form and in the browser's.
fn turn(bone: &str, axis: usize, degrees: f32) -> ((String, [f32; 3]), (String, Value)) {
    let (sin, cos) = (degrees.to_radians() / 2.0).sin_cos();
    let (mut angles, mut quaternion) = ([0.0; 3], [0.0, 0.0, 0.0, cos]);
    angles[axis] = degrees;
    quaternion[axis] = sin;
    ((bone.to_owned(), angles), (bone.to_owned(), json!(quaternion)))
}

#[test]
fn a_vrm_looks_alike_in_three_vrm_and_in_our_renderer() {
    let Some(browser) = Browser::find() else { return };
    let avatar = Figure::new().avatar();
    let [body, head] = cameras();
    let turns = [
        turn("leftUpperArm", 2, -60.0),
        turn("leftLowerArm", 1, -50.0),
        turn("rightUpperArm", 2, 30.0),
        turn("rightLowerArm", 1, 70.0),
        turn("rightHand", 0, 25.0),
        turn("rightIndexProximal", 2, 40.0),
        turn("head", 1, 25.0),
        turn("leftUpperLeg", 0, -50.0),
        turn("leftLowerLeg", 0, 60.0),
        turn("spine", 0, 12.0),
    ];
    let rotations: Vec<_> = turns.iter().map(|(ours, _)| ours.clone()).collect();
    let pose: serde_json::Map<String, Value> =
        turns.into_iter().map(|(_, theirs)| theirs).collect();
    let weights = vec![("happy".to_owned(), 1.0), ("blink".to_owned(), 0.5)];
    let expressions = json!({ "happy": 1.0, "blink": 0.5 });
    let shots = [
        Shot { name: "rest", camera: body, posing: PoseRequest::default(), browser: json!({}) },
        Shot {
            name: "posed",
            camera: body,
            posing: PoseRequest { rotations, ..PoseRequest::default() },
            browser: json!({ "pose": pose }),
        },
        Shot {
            name: "face",
            camera: head,
            posing: PoseRequest { weights, ..PoseRequest::default() },
            browser: json!({ "expressions": expressions }),
        },
    ];
    let found = compare(&browser, &file(&avatar, true), "figure.vrm", &shots);
    assert_eq!(found["isVrm"], true);
    let humanoid = found["humanoid"].as_array().unwrap();
    for bone in HumanBone::ALL {
        assert!(humanoid.contains(&json!(bone.name())), "{} is not found", bone.name());
    }
    let expressions = found["expressions"].as_array().unwrap();
    for expression in &avatar.expressions {
        assert!(expressions.contains(&json!(expression.name)), "{}", expression.name);
    }
}

#[test]
fn clips_of_a_glb_look_alike_in_three_js_and_in_our_renderer() {
    let Some(browser) = Browser::find() else { return };
    let avatar = Figure::new().avatar();
    let [body, head] = cameras();
    let mut shots = Vec::new();
    let mut wanted = Vec::new();
    for (name, clip, frame, camera) in [
        ("first", 0, 3, body),
        ("second", 1, 12, body),
        ("third", 2, 9, body),
        ("head", 1, 20, head),
    ] {
        let frames = &avatar.clips[clip];
        let frame = frame % frames.times.len();
        let seconds = frames.times[frame];
        wanted.push(&frames.poses[frame]);
        shots.push(Shot {
            name,
            camera,
            posing: PoseRequest { clip: Some((clip, seconds)), ..PoseRequest::default() },
            browser: json!({ "clip": frames.name, "time": seconds }),
        });
    }
    let found = compare(&browser, &file(&avatar, false), "figure.glb", &shots);
    let clips: Vec<&str> = found["animations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["name"].as_str().unwrap())
        .collect();
    let ours: Vec<&str> = avatar.clips.iter().map(|clip| &*clip.name).collect();
    assert_eq!(clips, ours);
    let morphs: Vec<&str> = avatar.morphs.iter().map(|morph| &*morph.name).collect();
    let found_morphs: Vec<&Value> = found["morphTargets"].as_object().unwrap().values().collect();
    assert_eq!(found_morphs, [&json!(morphs)]);
    for (pose, shot) in wanted.into_iter().zip(found["shots"].as_array().unwrap()) {
        let motions = avatar.skeleton.motions(pose).unwrap();
        for (joint, motion) in avatar.skeleton.joints().iter().zip(motions) {
            for (axis, wanted) in motion.point(joint.position).into_iter().enumerate() {
                let found = shot["joints"][&joint.name][axis].as_f64().unwrap_or(f64::NAN);
                let distance = (found - f64::from(wanted)).abs();
                assert!(distance < BONE_TOLERANCE, "{}: {found}, wanted {wanted}", joint.name);
            }
        }
    }
}
