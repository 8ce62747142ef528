//! Feet on the ground, for bodies of all kinds and shapes: no body floats, sinks, or slides while
//! the recorded person stood, and none jumps at the start of a clip.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its bodies has failed")]

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyKind, BodyModel, Shape, Shaped};
use uvgraft_avatar::motion::{ClipOptions, GroundMode, Motion, Performer, Retarget, UpAxis};
use uvgraft_avatar::rig::{Clip, HumanBone};
use uvgraft_figure::Figure;
use uvgraft_figure::motion::as_amass;
use uvgraft_io::arrays::{NamedArrays, NumericArray};
use uvgraft_tests::walkers;

/// Largest distance of feet from the ground.
const NEAR_M: f32 = 0.01;
/// Largest motion of a standing foot between frames: the person's own foot moves by up to 2 mm, and
/// at either end of a step it rolls over points that lie elsewhere on another foot.
const SLIDE_M: f32 = 0.006;

fn avatar(shaped: &Shaped<'_>, layout: &Mesh) -> Avatar {
    shaped.avatar(layout.clone()).unwrap().standing().unwrap()
}

fn person<'m>(model: &'m BodyModel, seed: u32) -> Shaped<'m> {
    model.shaped(&Shape { betas: walkers::betas(seed), ..Shape::default() }).unwrap()
}

fn vertices_of(avatar: &Avatar, bones: [HumanBone; 2]) -> Vec<usize> {
    let own = bones.map(|bone| avatar.skeleton.human(bone).unwrap() as u16);
    let of = |&vertex: &usize| own.contains(&avatar.skin.of(vertex)[0].0);
    (0..avatar.mesh.positions().len()).filter(of).collect()
}

const FEET: [[HumanBone; 2]; 2] =
    [[HumanBone::LeftFoot, HumanBone::LeftToes], [HumanBone::RightFoot, HumanBone::RightToes]];

/// Positions of all vertices in all frames.
fn played(avatar: &Avatar, clip: &Clip) -> Vec<Vec<Vec3>> {
    let posed = |pose| avatar.posed(pose, &[]).unwrap().into_iter().map(Vec3::from).collect();
    clip.poses.iter().map(posed).collect()
}

fn lowest(positions: &[Vec3], vertices: &[usize]) -> usize {
    *vertices.iter().min_by(|&&a, &&b| positions[a].y.total_cmp(&positions[b].y)).unwrap()
}

/// Largest errors of feet while the recorded person's foot stands: distance from the ground, motion
/// between frames, and depth below the ground.
struct Errors {
    off_m: f32,
    slide_m: f32,
    sunk_m: f32,
    stood: usize,
}

/// - `reference`: the person, with feet on y = 0.
fn compare(reference: (&Avatar, &Clip), body: (&Avatar, &Clip)) -> Errors {
    let (person, own) = (played(reference.0, reference.1), played(body.0, body.1));
    let mut found = Errors { off_m: 0.0, slide_m: 0.0, sunk_m: 0.0, stood: 0 };
    for bones in FEET {
        let of_person = vertices_of(reference.0, bones);
        let of_body = vertices_of(body.0, bones);
        for frame in 0..own.len() - 1 {
            let low = own[frame][lowest(&own[frame], &of_body)].y;
            found.sunk_m = found.sunk_m.max(-low);
            let under = lowest(&person[frame], &of_person);
            let step =
                |frames: &[Vec<Vec3>]| (frames[frame + 1][under] - frames[frame][under]).length();
            if person[frame][under].y < 0.005 && step(&person) < 0.002 {
                found.stood += 1;
                found.off_m = found.off_m.max(low.abs());
                found.slide_m = found.slide_m.max(step(&own));
            }
        }
    }
    found
}

fn clip_of(motion: &Motion, avatar: &Avatar, options: ClipOptions<'_>) -> (Clip, Retarget) {
    let soles = avatar.soles();
    let options = ClipOptions { fps: None, soles: soles.as_ref(), ..options };
    motion.clip(&avatar.skeleton, "clip", &options).unwrap()
}

/// A clip of the figure performed by a person of a model, feet on the ground.
fn of_somebody(shaped: &Shaped<'_>, layout: &Mesh, name: &str) -> (Avatar, Clip) {
    let figure = Figure::new().avatar();
    let clip = figure.clips.iter().find(|clip| clip.name == name).unwrap();
    let clip = walkers::forwards(clip);
    let arrays = as_amass(&figure.skeleton, &clip);
    let mut motion = NamedArrays::new();
    let table = |columns: usize, values| {
        NumericArray::new_f32(vec![arrays.frames, columns], values).unwrap()
    };
    motion.insert("poses", table(156, arrays.poses.clone()));
    motion.insert("trans", table(3, arrays.trans.clone()));
    let rate = NumericArray::new_f64(vec![], vec![30.0]).unwrap();
    motion.insert("mocap_framerate", rate);
    let avatar = avatar(shaped, layout);
    let motion = Motion::from_arrays(&motion).unwrap();
    let options = ClipOptions { ground: GroundMode::Feet, ..ClipOptions::default() };
    let clip = clip_of(&motion, &avatar, options).0;
    (avatar, clip)
}

#[test]
fn nobody_floats_sinks_slides_or_jumps() {
    let layout = Figure::new().body;
    for kind in [BodyKind::Smpl, BodyKind::SmplH, BodyKind::SmplX] {
        let model = BodyModel::from_arrays(&walkers::model(kind)).unwrap();
        for (name, seeds) in [("walk", [1, 2]), ("walk", [5, 6]), ("wave", [3, 4])] {
            let someone = person(&model, seeds[0]);
            let (theirs, done) = of_somebody(&someone, &layout, name);
            // Recorded elsewhere, on a ground 7 cm high, facing sideways.
            let moved = (Vec3::new(1.2, 0.07, -0.8), 1.7);
            let arrays = walkers::recorded(&someone, &theirs, &done, moved, true);
            let motion = Motion::from_arrays(&arrays).unwrap();
            let body = avatar(&person(&model, seeds[1]), &layout);
            let soles = someone.soles();
            let known = Performer { skeleton: someone.skeleton(), soles: soles.as_ref() };
            for (ground, performer) in [
                (GroundMode::Clip, Some(known)),
                (GroundMode::Feet, None),
                (GroundMode::Keep, Some(known)),
            ] {
                let options = ClipOptions { ground, performer, ..ClipOptions::default() };
                let (clip, report) = clip_of(&motion, &body, options);
                let found = compare((&theirs, &done), (&body, &clip));
                let first = Vec3::from(clip.poses[0].translation);
                let case = format!("{} {name} {seeds:?} {ground:?}", kind.name());
                println!(
                    "{case}: {} frames, off {:.4}, slide {:.4}, sunk {:.4}, jump {first}, {report:?}",
                    found.stood, found.off_m, found.slide_m, found.sunk_m
                );
                assert!(found.stood > done.poses.len() / 3, "{case}: {}", found.stood);
                assert_eq!((report.up, report.up_is_certain), (UpAxis::Z, true), "{case}");
                if ground == GroundMode::Keep {
                    assert!(first.length() > 0.5, "{case}");
                    continue;
                }
                assert!(found.off_m < NEAR_M, "{case}: {} m off the ground", found.off_m);
                assert!(found.sunk_m < NEAR_M, "{case}: {} m below it", found.sunk_m);
                assert!(found.slide_m < SLIDE_M, "{case}: slides by {} m", found.slide_m);
                let level = Vec3 { y: 0.0, ..first };
                assert!(level.length() < 1e-3 && first.y.abs() < 0.06, "{case}: jumps by {first}");
                let grounding = report.grounding.unwrap();
                if ground == GroundMode::Clip {
                    let height = grounding.ground_m.unwrap();
                    assert!((height - 0.07).abs() < 0.01, "{case}: ground at {height}");
                    assert!((report.turned_deg + 1.7_f32.to_degrees()).abs() < 6.0, "{case}");
                }
            }
        }
    }
}

#[test]
fn recordings_of_other_tools_stand_too() {
    let layout = Figure::new().body;
    let model = BodyModel::from_arrays(&walkers::model(BodyKind::SmplH)).unwrap();
    let someone = person(&model, 1);
    let (theirs, done) = of_somebody(&someone, &layout, "walk");
    let body = avatar(&person(&model, 2), &layout);
    let soles = someone.soles();
    let known = Performer { skeleton: someone.skeleton(), soles: soles.as_ref() };
    let options =
        ClipOptions { ground: GroundMode::Clip, performer: Some(known), ..ClipOptions::default() };
    let moved = (Vec3::new(-2.0, 0.0, 3.0), -0.9);
    let z_up = walkers::recorded(&someone, &theirs, &done, moved, true);
    let (wanted, _) = clip_of(&Motion::from_arrays(&z_up).unwrap(), &body, options);
    // Y up is detected, and gives the same result.
    let y_up = walkers::recorded(&someone, &theirs, &done, moved, false);
    let (clip, report) = clip_of(&Motion::from_arrays(&y_up).unwrap(), &body, options);
    assert_eq!((report.up, report.up_is_certain), (UpAxis::Y, true));
    for (a, b) in played(&body, &clip).iter().zip(played(&body, &wanted)) {
        let apart = a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(apart < 2e-3, "{apart}");
    }
    // Lower frame rates.
    for fps in [15.0, 12.0, 10.0] {
        let motion = Motion::from_arrays(&z_up).unwrap();
        let soles = body.soles();
        let options = ClipOptions { fps: Some(fps), soles: soles.as_ref(), ..options };
        let (clip, _) = motion.clip(&body.skeleton, "few", &options).unwrap();
        let lowest = |positions: &Vec<Vec3>| positions.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        for positions in played(&body, &clip) {
            assert!(lowest(&positions).abs() < NEAR_M, "{fps}: {}", lowest(&positions));
        }
    }
    // Without translations the body stays in place, its feet on the ground.
    let mut in_place = z_up;
    in_place.take("trans");
    let (clip, report) = clip_of(&Motion::from_arrays(&in_place).unwrap(), &body, options);
    assert!(report.in_place);
    for (positions, pose) in played(&body, &clip).iter().zip(&clip.poses) {
        let lowest = positions.iter().map(|place| place.y).fold(f32::MAX, f32::min);
        assert!(lowest.abs() < NEAR_M, "{lowest}");
        assert!(pose.translation[0].abs() < 1e-4 && pose.translation[2].abs() < 1e-4);
    }
}

#[test]
fn the_figure_walks_on_the_ground_too() {
    let layout = Figure::new().body;
    let model = BodyModel::from_arrays(&walkers::model(BodyKind::SmplX)).unwrap();
    let someone = person(&model, 9);
    let (theirs, done) = of_somebody(&someone, &layout, "walk");
    let arrays =
        walkers::recorded(&someone, &theirs, &done, (Vec3::new(0.0, -0.1, 0.0), 0.0), true);
    let motion = Motion::from_arrays(&arrays).unwrap();
    let figure = Figure::new().avatar().standing().unwrap();
    let options = ClipOptions { ground: GroundMode::Feet, ..ClipOptions::default() };
    let (clip, report) = clip_of(&motion, &figure, options);
    let found = compare((&theirs, &done), (&figure, &clip));
    let Errors { off_m, slide_m, sunk_m, stood } = found;
    println!("figure: {stood} frames, off {off_m}, slide {slide_m}, sunk {sunk_m}, {report:?}");
    assert!(off_m < NEAR_M && sunk_m < NEAR_M && slide_m < SLIDE_M);
}
