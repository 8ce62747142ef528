//! Expressions of synthetic body models do what they are named after, and little else.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyModel, ExpressionReport, Shape};
use uvgraft_avatar::face::{Face, Measures};
use uvgraft_avatar::rig::ExpressionPreset as Preset;
use uvgraft_tests::made_up::{self, Entanglement, MadeUp};

/// One millimetre, in metres.
const MM: f32 = 1e-3;
/// Largest side effect of an expression, as a share of its own effect.
const OTHERS: f32 = 0.2;
/// Largest deviation between left and mirrored right.
const MIRROR_M: f32 = 1.0 * MM;

/// A body with expressions, and the face that measures it.
struct Performer {
    avatar: Avatar,
    face: Face,
    reported: ExpressionReport,
}

impl Performer {
    fn new(made: &MadeUp, shape: &Shape) -> Self {
        let model = BodyModel::from_arrays(&made.arrays).unwrap();
        let shaped = model.shaped(shape).unwrap();
        let mut avatar = shaped.avatar(made.mesh.clone()).unwrap();
        let reported = shaped.add_expressions(&mut avatar).unwrap();
        avatar.check().unwrap();
        let face = Face::find(&avatar.mesh).unwrap();
        Self { avatar, face, reported }
    }

    fn has(&self, preset: Preset) -> bool {
        self.avatar.expressions.iter().any(|expression| expression.preset == Some(preset))
    }

    /// Vertex positions with an expression at full weight.
    fn shown(&self, preset: Preset) -> Vec<[f32; 3]> {
        let mut expressions = self.avatar.expressions.iter();
        let expression = expressions.find(|expression| expression.preset == Some(preset)).unwrap();
        let mut positions = self.avatar.mesh.positions().to_vec();
        for &(morph, weight) in &expression.morphs {
            self.avatar.morphs[morph].add(weight, &mut positions);
        }
        positions
    }

    /// Changes of the measures by an expression.
    fn change(&self, preset: Preset) -> Change {
        let before = self.face.measure(self.avatar.mesh.positions());
        Change::between(&before, &self.face.measure(&self.shown(preset)))
    }
}

/// Differences between measures, in metres.
#[derive(Debug)]
struct Change {
    lids: [f32; 2],
    opening: f32,
    width: f32,
    depth: f32,
    corners: [f32; 2],
    inner_brows: [f32; 2],
    outer_brows: [f32; 2],
}

impl Change {
    fn between(before: &Measures, after: &Measures) -> Self {
        let both = |a: [f32; 2], b: [f32; 2]| [a[0] - b[0], a[1] - b[1]];
        Self {
            lids: both(after.lid_gap, before.lid_gap),
            opening: after.lip_opening - before.lip_opening,
            width: after.mouth_width - before.mouth_width,
            depth: after.lip_depth - before.lip_depth,
            corners: both(after.corner_height, before.corner_height),
            inner_brows: both(after.inner_brow_height, before.inner_brow_height),
            outer_brows: both(after.outer_brow_height, before.outer_brow_height),
        }
    }

    fn of_mouth(&self) -> f32 {
        let [a, b] = self.corners;
        [self.opening, self.width, a, b].into_iter().map(f32::abs).fold(0.0, f32::max)
    }

    fn of_brows(&self) -> f32 {
        let all = self.inner_brows.into_iter().chain(self.outer_brows);
        all.map(f32::abs).fold(0.0, f32::max)
    }

    fn of_lids(&self) -> f32 {
        self.lids[0].abs().max(self.lids[1].abs())
    }
}

/// Models capable of all expressions: different mixtures, with noise and with few components, in
/// two shapes.
fn able() -> Vec<(String, Performer)> {
    let shapes =
        [Shape::default(), Shape { betas: vec![1.5, -2.0, 1.0, -1.0, 2.0], ..Shape::default() }];
    let mixes = [
        Entanglement::default(),
        Entanglement { seed: 2, noise: 5e-5, ..Entanglement::default() },
        Entanglement { seed: 3, components: 20, ..Entanglement::default() },
    ];
    let mut people = Vec::new();
    for mix in &mixes {
        for (name, made) in [("SMPL-X", made_up::smplx(mix)), ("FLAME", made_up::flame(mix))] {
            let Some(made) = made else { return Vec::new() };
            for shape in &shapes {
                let name = format!("{name} {} {:?}", mix.seed, shape.betas);
                people.push((name, Performer::new(&made, shape)));
            }
        }
    }
    people
}

#[test]
fn expressions_do_what_they_are_named_after() {
    for (name, person) in able() {
        assert!(person.reported.shortfalls.is_empty(), "{name}: {:?}", person.reported);
        let gap = person.face.measure(person.avatar.mesh.positions()).lid_gap;
        for (side, preset) in [(0, Preset::BlinkLeft), (1, Preset::BlinkRight)] {
            let change = person.change(preset);
            let closed = -change.lids[side];
            assert!((closed - gap[side]).abs() < 0.1 * gap[side], "{name} {preset:?}: {change:?}");
            let others = change.lids[1 - side].abs().max(change.of_mouth()).max(change.of_brows());
            assert!(others < OTHERS * closed, "{name} {preset:?}: {change:?}");
        }
        for (preset, opening, wider) in [
            (Preset::Aa, 14.0, 0.0),
            (Preset::Ih, 5.0, 2.0),
            (Preset::Ee, 2.0, 5.0),
            (Preset::Ou, 2.0, -8.0),
            (Preset::Oh, 8.0, -4.0),
        ] {
            let change = person.change(preset);
            assert!(change.opening > opening * MM, "{name} {preset:?}: {change:?}");
            assert!(change.width * wider >= wider * wider * MM, "{name} {preset:?}: {change:?}");
            let others = change.of_lids().max(change.of_brows());
            assert!(others < OTHERS * change.of_mouth(), "{name} {preset:?}: {change:?}");
        }
        assert!(person.change(Preset::Ou).depth > 3.0 * MM, "{name}");
        for (preset, corners) in [(Preset::Happy, 4.0), (Preset::Relaxed, 2.0), (Preset::Sad, -3.0)]
        {
            let change = person.change(preset);
            let far = change.corners.iter().all(|corner| corner * corners > corners * corners * MM);
            assert!(far, "{name} {preset:?}: {change:?}");
            let mut others = change.of_lids().max(change.opening.abs());
            if preset != Preset::Sad {
                others = others.max(change.of_brows());
            }
            assert!(others < OTHERS * change.of_mouth(), "{name} {preset:?}: {change:?}");
        }
        for (preset, brows) in [(Preset::Angry, -3.0), (Preset::Sad, 3.0), (Preset::Surprised, 4.0)]
        {
            let change = person.change(preset);
            let far = change.inner_brows.iter().all(|brow| brow * brows > brows * brows * MM);
            assert!(far, "{name} {preset:?}: {change:?}");
        }
        let change = person.change(Preset::Surprised);
        assert!(
            change.lids.iter().all(|&lid| lid > MM) && change.opening > 5.0 * MM,
            "{name}: {change:?}"
        );
    }
}

#[test]
fn left_and_right_are_mirror_images() {
    for (name, person) in able() {
        let rest = person.avatar.mesh.positions();
        for (preset, other) in [
            (Preset::BlinkLeft, Preset::BlinkRight),
            (Preset::Happy, Preset::Happy),
            (Preset::Aa, Preset::Aa),
            (Preset::Surprised, Preset::Surprised),
        ] {
            let (one, other) = (person.shown(preset), person.shown(other));
            let mut worst = 0.0_f32;
            // Templates are symmetric to a few micrometres; shapes need not be.
            for vertex in (0..rest.len()).filter(|&vertex| one[vertex] != rest[vertex]).step_by(5) {
                let [x, y, z] = rest[vertex];
                let mirrored = (0..rest.len()).find(|&at| {
                    let [p, q, r] = rest[at];
                    (p + x).abs() + (q - y).abs() + (r - z).abs() < 2e-5
                });
                let Some(mirrored) = mirrored else { continue };
                let a: Vec<f32> = (0..3).map(|k| one[vertex][k] - rest[vertex][k]).collect();
                let b: Vec<f32> = (0..3).map(|k| other[mirrored][k] - rest[mirrored][k]).collect();
                worst = worst.max((a[0] + b[0]).hypot(a[1] - b[1]).hypot(a[2] - b[2]));
            }
            assert!(worst < MIRROR_M, "{name} {preset:?}: {worst} m");
        }
    }
}

#[test]
fn impossible_expressions_are_reported_and_left_out() {
    let without = vec!["blink", "squint", "eyes"];
    let mix = Entanglement { seed: 4, without, ..Entanglement::default() };
    for made in [made_up::smplx(&mix), made_up::flame(&mix)].into_iter().flatten() {
        let person = Performer::new(&made, &Shape::default());
        for preset in [Preset::BlinkLeft, Preset::BlinkRight] {
            assert!(!person.has(preset));
            let reported = person
                .reported
                .shortfalls
                .iter()
                .find(|reported| reported.preset == preset)
                .unwrap();
            assert!(reported.is_left_out);
        }
        assert!(!person.has(Preset::Blink));
        assert!(person.has(Preset::Happy) && person.has(Preset::Aa));
    }
}

#[test]
fn all_of_vrms_presets_are_there() {
    let Some(made) = made_up::smplx(&Entanglement::default()) else { return };
    let person = Performer::new(&made, &Shape::default());
    assert_eq!((person.avatar.morphs.len(), person.avatar.expressions.len()), (16, 18));
    // Eyes rotate about their centres: up is up, and the person's left is +X.
    let pupil = |positions: &[[f32; 3]]| {
        let foremost = person.avatar.mesh.positions().iter().enumerate();
        let eye =
            foremost.filter(|(_, p)| p[0] > 0.02 && (p[1] - 0.3245).abs() < 0.004 && p[0] < 0.045);
        let (vertex, _) = eye.max_by(|a, b| a.1[2].total_cmp(&b.1[2])).unwrap();
        positions[vertex]
    };
    let rest = pupil(person.avatar.mesh.positions());
    let moved = |preset, axis: usize| pupil(&person.shown(preset))[axis] - rest[axis];
    assert!(moved(Preset::LookUp, 1) > 2.0 * MM && moved(Preset::LookDown, 1) < -2.0 * MM);
    assert!(moved(Preset::LookLeft, 0) > 2.0 * MM && moved(Preset::LookRight, 0) < -2.0 * MM);
}
