use std::f32::consts::FRAC_PI_2;

use uvgraft_io::arrays::{NamedArrays, NumericArray};

use super::*;
use crate::rig::Joint;

/// A motion of one frame: rotations of some of the body's joints, and the translation, Z up.
fn motion(turns: &[(&str, [f32; 3])], place: [f32; 3]) -> Motion {
    frames(turns, &[place])
}

/// The same with several frames that differ in their translations.
fn frames(turns: &[(&str, [f32; 3])], places: &[[f32; 3]]) -> Motion {
    let mut poses = vec![0.0; 66];
    for (name, turn) in turns {
        let joint = crate::body::BODY.iter().position(|entry| entry.0 == *name).unwrap();
        poses[3 * joint..][..3].copy_from_slice(turn);
    }
    let mut arrays = NamedArrays::new();
    let (count, poses) = (places.len(), poses.repeat(places.len()));
    arrays.insert("poses", NumericArray::new_f32(vec![count, 66], poses).unwrap());
    let places = places.as_flattened().to_vec();
    arrays.insert("trans", NumericArray::new_f32(vec![count, 3], places).unwrap());
    arrays.insert("mocap_framerate", NumericArray::new_f64(vec![], vec![30.0]).unwrap());
    Motion::from_arrays(&arrays).unwrap()
}

/// A humanoid on the ground without a chest. Its arms are level, or hang down by 45°.
fn humanoid(hanging: bool) -> Skeleton {
    use HumanBone as B;
    type Entry = (&'static str, Option<usize>, [f32; 3], Option<HumanBone>);
    let reach = |length: f32| {
        let down = if hanging { length / 2_f32.sqrt() } else { 0.0 };
        [0.2 + if hanging { down } else { length }, 1.4 - down, 0.0]
    };
    let joints: [Entry; 12] = [
        ("root", None, [0.0; 3], None),
        ("hips", Some(0), [0.0, 0.9, 0.0], Some(B::Hips)),
        ("spine", Some(1), [0.0, 1.0, 0.0], Some(B::Spine)),
        ("shoulder", Some(2), [0.1, 1.4, 0.0], Some(B::LeftShoulder)),
        ("upper arm", Some(3), reach(0.0), Some(B::LeftUpperArm)),
        ("lower arm", Some(4), reach(0.3), Some(B::LeftLowerArm)),
        ("hand", Some(5), reach(0.6), Some(B::LeftHand)),
        ("tail", Some(1), [0.0, 0.9, -0.1], None),
        ("left thigh", Some(1), [0.1, 0.85, 0.0], Some(B::LeftUpperLeg)),
        ("left shin", Some(8), [0.1, 0.46, 0.0], Some(B::LeftLowerLeg)),
        ("left foot", Some(9), [0.1, 0.07, 0.0], Some(B::LeftFoot)),
        ("right thigh", Some(1), [-0.1, 0.85, 0.0], Some(B::RightUpperLeg)),
    ];
    let joint = |(name, parent, position, human): Entry| Joint {
        name: name.to_owned(),
        parent,
        position,
        human,
    };
    Skeleton::new(joints.map(joint).to_vec()).unwrap()
}

/// Position of a joint of the skeleton in the first frame.
fn place(skeleton: &Skeleton, clip: &Clip, name: &str) -> Vec3 {
    let joint = skeleton.find(name).unwrap();
    let motions = skeleton.motions(&clip.poses[0]).unwrap();
    motions[joint].point(skeleton.joints()[joint].position).into()
}

fn close(found: Vec3, wanted: Vec3) {
    assert!(found.abs_diff_eq(wanted, 1e-5), "{found} {wanted}");
}

/// Rotates the family's rest pose, Y up, into a person standing in a world with Z up.
const STANDS: (&str, [f32; 3]) = ("pelvis", [FRAC_PI_2, 0.0, 0.0]);

#[test]
fn a_person_standing_in_a_recording_stands_on_the_ground() {
    let skeleton = humanoid(false);
    // The pelvis is 0.9 above the ground: it is 3 cm in front of the origin, which is
    // below y = 0.23.
    let motion = motion(&[STANDS], [0.0, 0.23, 0.87]);
    let (clip, report) = motion.clip(&skeleton, "c", &ClipOptions::default()).unwrap();
    assert!((report.scale - 1.0).abs() < 1e-6 && report.arms_deg == 0.0, "{report:?}");
    assert_eq!(report.still, ["root", "tail"]);
    assert!(report.missing.contains(&"spine2") && report.missing.contains(&"head"));
    for joint in ["hips", "hand", "left foot"] {
        let rest = skeleton.joints()[skeleton.find(joint).unwrap()].position;
        close(place(&skeleton, &clip, joint), rest.into());
    }
}

#[test]
fn rotations_of_missing_joints_are_passed_on() {
    let skeleton = humanoid(false);
    let quarter = [0.0, 0.0, FRAC_PI_2];
    let turns = [STANDS, ("spine2", quarter)];
    let (clip, _) =
        motion(&turns, [0.0, 0.23, 0.87]).clip(&skeleton, "c", &ClipOptions::default()).unwrap();
    // There is no chest, so the shoulder takes over its rotation, and the arm points up.
    close(place(&skeleton, &clip, "upper arm"), Vec3::new(0.1, 1.5, 0.0));
    close(place(&skeleton, &clip, "hand"), Vec3::new(0.1, 2.1, 0.0));
}

#[test]
fn hanging_arms_are_lifted() {
    let skeleton = humanoid(true);
    let turned = motion(&[STANDS, ("left_elbow", [0.0, 0.0, FRAC_PI_2])], [0.0, 0.23, 0.87]);
    let (clip, report) = turned.clip(&skeleton, "c", &ClipOptions::default()).unwrap();
    assert!((report.arms_deg - 45.0).abs() < 0.01, "{}", report.arms_deg);
    // The upper arm is level, and the lower arm bends up from it.
    close(place(&skeleton, &clip, "lower arm"), Vec3::new(0.5, 1.4, 0.0));
    close(place(&skeleton, &clip, "hand"), Vec3::new(0.5, 1.7, 0.0));
}

#[test]
fn paths_scale_with_the_legs_unless_they_are_kept() {
    let skeleton = humanoid(false);
    let mut tall = skeleton.joints().to_vec();
    for joint in &mut tall {
        joint.position = (Vec3::from(joint.position) * 2.0).into();
    }
    let tall = Skeleton::new(tall).unwrap();
    let places = [[0.3, -0.77, 0.87], [0.3, -1.27, 0.97]];
    let motion = frames(&[STANDS], &places);
    let hips = |options: &ClipOptions<'_>| {
        let (clip, report) = motion.clip(&tall, "c", options).unwrap();
        let rest = hips_at_rest(&tall);
        (clip.poses.iter().map(|pose| rest + Vec3::from(pose.translation)).collect(), report)
    };
    // As recorded: (0, -0.23, 0.03) plus the translation with Z up, converted to Y up.
    let (kept, report): (Vec<Vec3>, _) = hips(&ClipOptions::default());
    assert_eq!((report.scale, report.grounding), (1.0, None));
    close(kept[0], Vec3::new(0.3, 0.9, 1.0));
    close(kept[1], Vec3::new(0.3, 1.0, 1.5));
    // From the rest position, scaled by two. The skeleton has only one foot, so heights
    // are only scaled.
    let feet = ClipOptions { ground: GroundMode::Feet, ..ClipOptions::default() };
    let (scaled, report) = hips(&feet);
    assert!((report.scale - 2.0).abs() < 1e-6);
    close(scaled[0], Vec3::new(0.0, 1.8, 0.0));
    close(scaled[1], Vec3::new(0.0, 2.0, 1.0));
    // If the performer is known, that person's leg length is used.
    let performer = Some(Performer { skeleton: &tall, soles: None });
    let (own, report) = hips(&ClipOptions { ground: GroundMode::Clip, performer, ..feet });
    assert!((report.scale - 1.0).abs() < 1e-6);
    close(own[1] - own[0], Vec3::new(0.0, 0.1, 0.5));
}

#[test]
fn clips_begin_facing_the_front() {
    let skeleton = humanoid(false);
    let turned = Quat::from_rotation_z(2.0) * Quat::from_rotation_x(FRAC_PI_2);
    let motion = frames(
        &[("pelvis", turned.to_scaled_axis().into())],
        &[[0.0, 0.0, 0.87], [2.0_f32.sin(), -2.0_f32.cos(), 0.87]],
    );
    let options = ClipOptions { ground: GroundMode::Feet, ..ClipOptions::default() };
    let (clip, report) = motion.clip(&skeleton, "c", &options).unwrap();
    assert!((report.turned_deg + 2.0_f32.to_degrees()).abs() < 0.1, "{}", report.turned_deg);
    // One metre ahead is along +Z.
    let way = Vec3::from(clip.poses[1].translation) - Vec3::from(clip.poses[0].translation);
    close(way, Vec3::Z * report.scale);
    close(
        place(&skeleton, &clip, "hips"),
        Vec3::new(0.0, 0.9, 0.0) * Vec3::new(1.0, report.scale, 1.0),
    );
}
