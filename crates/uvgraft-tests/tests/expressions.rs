//! Named expressions of one head on another.

use std::sync::LazyLock;

use glam::{DVec3, Vec3};
use uvgraft::correspond::{By, FindOptions, find};
use uvgraft::{Mesh, Pair, Piece};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::face::transfer::{ContactKind, TransferError, Transferred, transfer};
use uvgraft_avatar::face::{Face, add_named};
use uvgraft_avatar::rig::{Expression, ExpressionPreset, Morph};
use uvgraft_figure::Figure;
use uvgraft_tests::real;
use uvgraft_tests::remeshed::Remeshed;

/// The figure's head with its morphs, in metres.
struct Head {
    mesh: Mesh,
    morphs: Vec<Morph>,
}

static HEAD: LazyLock<Head> = LazyLock::new(|| {
    let figure = Figure::new();
    let mut head_vertex = vec![None; figure.body.positions().len()];
    for (vertex, &body) in (0..).zip(&figure.vertex_map) {
        head_vertex[body as usize] = Some(vertex);
    }
    let on_head = |morph: &Morph| {
        let offset =
            |&(vertex, offset): &(u32, [f32; 3])| Some((head_vertex[vertex as usize]?, offset));
        Morph {
            name: morph.name.clone(),
            offsets: morph.offsets.iter().filter_map(offset).collect(),
        }
    };
    let morphs = figure.avatar().morphs.iter().map(on_head).collect();
    Head { mesh: figure.head, morphs }
});

/// The morphs of the skin; those of gaze turn eyeballs.
fn skin_morphs() -> Vec<Morph> {
    HEAD.morphs.iter().filter(|morph| !morph.name.starts_with("look")).cloned().collect()
}

fn by_surface(source: &Mesh, target: &Mesh) -> Pair {
    let mut options = FindOptions::default();
    options.by = By::Surface;
    find(source.clone(), target.clone(), &options).expect("heads are found").pair
}

fn moved(mesh: &Mesh, morph: &Morph) -> Mesh {
    let mut positions = mesh.positions().to_vec();
    morph.add(1.0, &mut positions);
    mesh.clone().with_positions(positions).expect("finite offsets")
}

fn named<'a>(morphs: &'a [Morph], name: &str) -> &'a Morph {
    morphs.iter().find(|morph| morph.name == name).expect("a morph of this name")
}

/// The mean and the greatest distance of a morph from true offsets, over what moves, in millimetres.
fn errors_mm(morph: &Morph, truth: &[DVec3]) -> [f64; 2] {
    let mut left = truth.to_vec();
    for &(vertex, offset) in &morph.offsets {
        left[vertex as usize] -= Vec3::from(offset).as_dvec3();
    }
    let moving = truth.iter().filter(|offset| offset.length() > 1e-5).count();
    let errors = left.iter().map(|left| 1e3 * left.length());
    [errors.clone().sum::<f64>() / moving as f64, errors.fold(0.0, f64::max)]
}

#[test]
fn a_head_takes_its_own_expressions_back() {
    let head = &*HEAD;
    let faces = 0..head.mesh.faces().len() as u32;
    let pieces = faces.map(|face| Piece::whole(face, face, [0, 1, 2]));
    let pair = Pair::from_pieces(head.mesh.clone(), head.mesh.clone(), pieces).expect("itself");
    let found = transfer(&pair, &head.morphs).expect("paired");
    assert_eq!(found.morphs.len(), head.morphs.len());
    for (found, morph) in found.morphs.iter().zip(&head.morphs) {
        assert_eq!(found.name, morph.name);
        let mut truth = vec![DVec3::ZERO; head.mesh.positions().len()];
        for &(vertex, offset) in &morph.offsets {
            truth[vertex as usize] = Vec3::from(offset).as_dvec3();
        }
        let [_, most] = errors_mm(found, &truth);
        // Contacts are corrected on the head's own lids and lips too: they stay almost where they are.
        let limit = if morph.name.starts_with("look") { 0.1 } else { 1.0 };
        println!("{}: {most:.4} mm", morph.name);
        assert!(most < limit, "{}: {most} mm", morph.name);
    }
}

#[test]
fn a_remeshed_twin_moves_as_the_head_does() {
    let head = &*HEAD;
    let twin = Remeshed::new(&head.mesh).turned().decimated(&head.mesh, 0.6, 2);
    let morphs = skin_morphs();
    let target = twin.mesh(&head.mesh);
    // As it is, and twice as large with Z up.
    let turned = |[x, y, z]: [f32; 3]| [2.0 * x, -2.0 * z, 2.0 * y];
    let back = |[x, y, z]: [f32; 3]| [0.5 * x, 0.5 * z, -0.5 * y];
    let placed = target.positions().iter().map(|&at| turned(at)).collect();
    let other = target.clone().with_positions(placed).expect("finite");
    for (target, is_turned) in [(target, false), (other, true)] {
        let found = transfer(&by_surface(&head.mesh, &target), &morphs).expect("paired");
        let rest = twin.places(&head.mesh);
        for (mut found, morph) in found.morphs.into_iter().zip(&morphs) {
            if is_turned {
                found.offsets.iter_mut().for_each(|(_, offset)| *offset = back(*offset));
            }
            let truth: Vec<DVec3> = twin
                .places(&moved(&head.mesh, morph))
                .iter()
                .zip(&rest)
                .map(|(a, b)| *a - *b)
                .collect();
            let most_moved = truth.iter().map(|offset| 1e3 * offset.length()).fold(0.0, f64::max);
            let [mean, most] = errors_mm(&found, &truth);
            println!("{}: {mean:.3} mm, at most {most:.3} of {most_moved:.1}", morph.name);
            assert!(mean < 0.5, "{}: {mean} mm", morph.name);
            assert!(most < 0.5 * most_moved, "{}: {most} mm of {most_moved}", morph.name);
            // Behind the ears nothing moves: exactly, where the surfaces lie over each other as they are.
            let behind = found.offsets.iter().filter(|&&(v, _)| rest[v as usize].z < -0.02);
            assert!(is_turned || behind.count() == 0, "{}", morph.name);
        }
    }
}

#[test]
fn eyeballs_turn_and_keep_their_shape() {
    let head = &*HEAD;
    let target = Remeshed::new(&head.mesh).divided().mesh(&head.mesh);
    let found = transfer(&by_surface(&head.mesh, &target), &head.morphs).expect("paired");
    for name in ["lookUp", "lookLeft"] {
        let shown = moved(&target, named(&found.morphs, name));
        let mut turned = 0;
        for [a, b, _] in target.faces() {
            let length = |mesh: &Mesh| {
                let [a, b] = [a, b].map(|&v| Vec3::from(mesh.positions()[v as usize]));
                a.distance(b)
            };
            let (before, after) = (length(&target), length(&shown));
            turned +=
                usize::from(target.positions()[*a as usize] != shown.positions()[*a as usize]);
            assert!((before - after).abs() < 2e-6, "{name}: {before} {after}");
        }
        assert!(turned > 100, "{name}: {turned}");
    }
    // Blinks leave them alone.
    let ball = named(&found.morphs, "lookUp");
    let blink = named(&found.morphs, "blink_left");
    let is_ball = |v: &u32| ball.offsets.iter().any(|(other, _)| other == v);
    assert!(!blink.offsets.iter().any(|(v, _)| is_ball(v)));
}

#[test]
fn morphs_that_do_not_fit_are_refused_and_those_of_nothing_reported() {
    let head = &*HEAD;
    let target = Remeshed::new(&head.mesh).decimated(&head.mesh, 0.5, 1).mesh(&head.mesh);
    let pair = by_surface(&head.mesh, &target);
    let broken = Morph { name: "far".to_owned(), offsets: vec![(u32::MAX, [1.0; 3])] };
    let error = transfer(&pair, &[broken]).expect_err("no such vertex");
    assert!(error.to_string().starts_with("morph `far` moves vertex 4294967295"), "{error}");
    let empty = Morph { name: "none".to_owned(), offsets: Vec::new() };
    let error = transfer(&pair, std::slice::from_ref(&empty)).expect_err("nothing moves");
    assert!(matches!(error, TransferError::Deform(_)));
    let found = transfer(&pair, &[named(&head.morphs, "smile").clone(), empty]).expect("one moves");
    assert_eq!(found.unmoved, ["none"]);
    assert_eq!(found.morphs.len(), 1);
}

/// The figure's expressions on a real head.
fn on_real(file: &str) -> Option<(Mesh, Transferred)> {
    let mesh = uvgraft_io::obj::read(real::folder()?.join(file)).expect("a sound mesh");
    let mut morphs = skin_morphs();
    for morph in &mut morphs {
        morph.name = match morph.name.as_str() {
            "blink_left" => "eyeBlinkLeft".to_owned(),
            "blink_right" => "eyeBlinkRight".to_owned(),
            "jaw_open" => "jawOpen".to_owned(),
            _ => continue,
        };
    }
    // The jaw and back: lips close again.
    let mut close = named(&morphs, "jawOpen").clone();
    close.name = "mouthClose".to_owned();
    close.offsets.iter_mut().for_each(|(_, offset)| *offset = offset.map(|d| -0.9 * d));
    morphs.push(close);
    let found = transfer(&by_surface(&HEAD.mesh, &mesh), &morphs).expect("paired");
    Some((mesh, found))
}

#[test]
fn lids_meet_and_lips_close_on_real_heads() {
    for file in ["flame_head_template.obj", "smplx_addon.obj"] {
        let Some((mesh, found)) = on_real(file) else { return };
        assert_eq!(found.unmeasured, None);
        let face = Face::find(&mesh).expect("a face");
        let measure = |names: &[&str]| {
            let mut positions = mesh.positions().to_vec();
            names.iter().for_each(|name| named(&found.morphs, name).add(1.0, &mut positions));
            face.measure(&positions)
        };
        let rest = measure(&[]);
        let [left, right] = [measure(&["eyeBlinkLeft"]), measure(&["eyeBlinkRight"])];
        println!("{file}: {rest:?}\n{left:?}\n{right:?}\n{:?}", found.contacts);
        assert!(left.lid_gap[0].abs() < 2e-4 && right.lid_gap[1].abs() < 2e-4, "{file}");
        // The other eye stays open.
        assert!(left.lid_gap[1] > 0.97 * rest.lid_gap[1], "{file}");
        assert!(right.lid_gap[0] > 0.97 * rest.lid_gap[0], "{file}");
        let opened = measure(&["jawOpen"]).lip_opening - rest.lip_opening;
        let closed = measure(&["jawOpen", "mouthClose"]).lip_opening - rest.lip_opening;
        assert!(opened > 0.008, "{file}: {opened}");
        // Lips that are less than 0.5 mm apart count as closed; these of the source are not quite.
        assert!(closed.abs() < 7e-4, "{file}: {closed}");
        let kinds = [ContactKind::LeftLids, ContactKind::RightLids];
        assert!(kinds.iter().all(|kind| found.contacts.iter().any(|at| at.kind == *kind)));
        for contact in &found.contacts {
            assert!(contact.after.abs() < 4e-4, "{file}: {contact:?}");
        }
        // Symmetric faces stay symmetric.
        for name in ["smile", "jawOpen", "brows_up"] {
            let shown = measure(&[name]);
            let changes = [0, 1].map(|side| {
                [
                    shown.corner_height[side] - rest.corner_height[side],
                    shown.outer_brow_height[side] - rest.outer_brow_height[side],
                    shown.lid_gap[side] - rest.lid_gap[side],
                ]
            });
            for k in 0..3 {
                let [left, right] = changes.map(|side| side[k]);
                assert!((left - right).abs() < 1e-3, "{file} {name}: {left} {right}");
            }
        }
    }
}

/// The figure with ARKit's names for what its morphs do, and no expressions.
fn arkit_figure() -> (Avatar, Vec<Morph>) {
    let mut avatar = Figure::new().avatar();
    let mut morphs = std::mem::take(&mut avatar.morphs);
    avatar.expressions.clear();
    for morph in &mut morphs {
        morph.name = match morph.name.as_str() {
            "jaw_open" => "jawOpen",
            "blink_left" => "eyeBlinkLeft",
            "blink_right" => "eyeBlinkRight",
            "lips_round" => "mouthPucker",
            "brows_up" => "browInnerUp",
            other => other,
        }
        .to_owned();
    }
    let mut funnel =
        morphs.iter().find(|morph| morph.name == "mouthPucker").expect("renamed").clone();
    funnel.name = "mouthFunnel".to_owned();
    morphs.push(funnel);
    (avatar, morphs)
}

#[test]
fn named_morphs_become_expressions_and_presets() {
    let (mut avatar, morphs) = arkit_figure();
    let count = morphs.len();
    let added = add_named(&mut avatar, morphs.clone());
    assert_eq!((added.named, added.taken.len()), (count, 0));
    use ExpressionPreset::{Aa, Blink, BlinkLeft, BlinkRight, Oh, Ou, Sad};
    assert_eq!(added.presets, [Sad, Aa, Ou, Oh, BlinkLeft, BlinkRight, Blink]);
    avatar.check().expect("sound");
    let names: Vec<&str> = avatar.expressions.iter().map(|e| e.name.as_str()).collect();
    assert!(["jawOpen", "blink", "aa"].iter().all(|name| names.contains(name)), "{names:?}");
    let blink = avatar.expressions.iter().find(|e| e.preset == Some(Blink)).expect("a blink");
    assert!(blink.morphs.iter().all(|&(_, weight)| weight == 1.0));
    // As far as it should: 0.38 of the mouth's width.
    let face = Face::find(&avatar.mesh).expect("a face");
    let aa = avatar.expressions.iter().find(|e| e.preset == Some(Aa)).expect("an open mouth");
    let mut positions = avatar.mesh.positions().to_vec();
    aa.morphs.iter().for_each(|&(morph, weight)| avatar.morphs[morph].add(weight, &mut positions));
    let [rest, shown] = [avatar.mesh.positions(), &positions].map(|at| face.measure(at));
    let opening = (shown.lip_opening - rest.lip_opening) / rest.mouth_width;
    assert!((0.2..0.42).contains(&opening), "{opening}");
    // A second time all names are taken, and no preset is missing.
    let again = add_named(&mut avatar, morphs);
    assert_eq!((again.named, again.taken.len(), again.presets.len()), (0, count, 0));
}

#[test]
fn presets_of_the_avatar_stay() {
    let (mut avatar, morphs) = arkit_figure();
    let own = Expression::preset(ExpressionPreset::Aa, Vec::new());
    avatar.expressions.push(own.clone());
    let added = add_named(&mut avatar, morphs);
    assert!(!added.presets.contains(&ExpressionPreset::Aa));
    assert_eq!(avatar.expressions[0], own);
}
