//! The open body through the program, from the wheel that `scripts/fetch-test-data.sh open-body` fetches to avatars.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use uvgraft::Channels;
use uvgraft_figure::Figure;
use uvgraft_gltf::scene::Scene;
use uvgraft_tests::downloads;

use crate::bench::Bench;

/// Expressions that only ARKit has names for, one of each part of the face.
const OF_ARKIT: [&str; 5] =
    ["eyeBlinkLeft", "browInnerUp", "cheekPuff", "mouthSmileRight", "tongueOut"];

/// Adds `open_body.npz` to a folder; `None` if the wheel was not fetched.
fn import(bench: &Bench) -> Option<()> {
    let wheel = downloads::open_body_wheel()?;
    bench.run_args(&["body", "import", wheel.to_str().unwrap(), "-o", "open_body.npz"]);
    assert!(bench.exists("open_body.npz"));
    Some(())
}

#[test]
fn an_avatar_of_the_open_body_has_all_expressions_and_its_terms() {
    let bench = Bench::new();
    if import(&bench).is_none() {
        return;
    }
    bench.paint("face.png", (256, 256), Channels::Rgb, &[200, 150, 120]);
    bench.succeed("body skin open_body.npz --tone 0.4 --size 512 -o skin.png");
    bench.succeed("pair open_body.npz#head open_body.npz -o head.uvpair");
    for (name, terms) in [("me.glb", ""), ("me.vrm", " --author Me --license only-author")] {
        bench.succeed(&format!(
            "avatar head.uvpair face.png --onto skin.png --body open_body.npz --size 512 \
             --shape gender=1,weight=0.7,height=1.9{terms} -o {name}"
        ));
        let scene = Scene::load(bench.path(name)).unwrap();
        let expressions = scene.expressions();
        for wanted in OF_ARKIT {
            assert!(expressions.contains(&wanted), "{name}: {wanted} of {expressions:?}");
        }
        let bytes = bench.bytes(name);
        for wanted in ["MakeHuman", "CC0", "Apache License"] {
            let quoted = bytes.windows(wanted.len()).any(|bytes| bytes == wanted.as_bytes());
            assert!(quoted, "{name} does not say {wanted}");
        }
    }
    bench.assert_valid(&["me.glb", "me.vrm"]);
    bench.assert_no_litter();
}

#[test]
fn its_expressions_go_to_another_body() {
    let bench = Bench::of_figure(&Figure::new(), 256);
    if import(&bench).is_none() {
        return;
    }
    let avatar = "avatar demo.uvpair face.png --onto base.png --body demo --size 256";
    bench.succeed(&format!("{avatar} -o plain.glb"));
    bench.succeed(&format!("{avatar} --expressions open_body.npz -o me.glb"));
    let [plain, scene] = ["plain.glb", "me.glb"].map(|name| Scene::load(bench.path(name)).unwrap());
    let [before, after] = [&plain, &scene].map(Scene::expressions);
    assert_eq!(after.len(), before.len() + 52, "{after:?}");
    for wanted in OF_ARKIT {
        assert!(after.contains(&wanted) && !before.contains(&wanted), "{wanted} of {after:?}");
    }
    bench.assert_valid(&["me.glb"]);
    // A closed eye looks closed: the picture of the eye changes, the other eye's does not.
    let render = "render me.glb --camera head --zoom 2 --azimuth 0 --pose stand --size 200x200";
    bench.succeed(&format!("{render} -o open.png"));
    bench.succeed(&format!("{render} --expression eyeBlinkLeft=1 -o shut.png"));
    let [open, shut] = ["open.png", "shut.png"].map(|name| bench.texture(name));
    let change = |from: u32| -> f32 {
        let texels = (0..200).flat_map(|y| (from..from + 100).map(move |x| (x, y)));
        texels.map(|(x, y)| (open.get(x, y, 2) - shut.get(x, y, 2)).abs()).sum()
    };
    let [right, left] = [0, 100].map(change);
    assert!(left > 20.0 && right < 0.05 * left, "{left} {right}");
}
