use uvgraft_io::arrays::NumericArray;

use super::*;

fn table(rows: usize, columns: usize) -> NumericArray {
    let values = (0..rows * columns).map(|value| value as f32 / 1000.0).collect();
    NumericArray::new_f32(vec![rows, columns], values).unwrap()
}

fn rate(rate: f64) -> NumericArray {
    NumericArray::new_f64(vec![], vec![rate]).unwrap()
}

fn motion(columns: usize) -> NamedArrays {
    let mut arrays = NamedArrays::new();
    arrays.insert("poses", table(4, columns));
    arrays.insert("trans", table(4, 3));
    arrays.insert("mocap_framerate", rate(60.0));
    arrays
}

#[test]
fn the_number_of_columns_determines_the_joints() {
    for (columns, joints, last) in [
        (66, 22, "right_wrist"),
        (72, 24, "right_hand"),
        (156, 52, "right_thumb3"),
        (165, 55, "right_thumb3"),
    ] {
        let motion = Motion::from_arrays(&motion(columns)).unwrap();
        assert_eq!((motion.frames(), motion.joint_names().len()), (4, joints));
        assert_eq!(motion.joint_names().last(), Some(last));
        assert_eq!(motion.seconds(), 0.05);
        // The third value of the second joint in the second frame.
        assert_eq!(motion.turns(1)[1][2], (columns + 5) as f32 / 1000.0);
        assert_eq!(motion.translation(2), [0.006, 0.007, 0.008]);
    }
}

#[test]
fn parts_are_put_together() {
    let mut arrays = motion(63);
    arrays.insert("root_orient", table(4, 3));
    let body = Motion::from_arrays(&arrays).unwrap();
    assert_eq!(
        (body.turns(1)[0], body.turns(1)[1]),
        ([0.003, 0.004, 0.005], [0.063, 0.064, 0.065])
    );
    let mut parts = NamedArrays::new();
    for (name, array) in [
        ("trans", table(4, 3)),
        ("mocap_frame_rate", rate(60.0)),
        ("root_orient", table(4, 3)),
        ("pose_body", table(4, 63)),
    ] {
        parts.insert(name, array);
    }
    assert_eq!(Motion::from_arrays(&parts).unwrap(), body);
    parts.insert("pose_hand", table(4, 90));
    let hands = Motion::from_arrays(&parts).unwrap();
    assert_eq!((hands.joint_names().len(), hands.turns(1)[22][0]), (52, 0.09));
    parts.insert("pose_jaw", table(4, 3));
    parts.insert("pose_eye", table(4, 6));
    let face = Motion::from_arrays(&parts).unwrap();
    assert_eq!(face.joint_names().nth(22), Some("jaw"));
    let [jaw, eye, finger] = [22, 24, 25].map(|joint| face.turns(1)[joint][0]);
    assert_eq!((jaw, eye, finger), (0.003, 0.009, 0.09));
}

#[test]
fn variants_written_by_other_tools() {
    let mut arrays = motion(165);
    let still = Motion::from_arrays(&arrays).unwrap();
    assert_eq!(
        (still.kind(), still.gender(), still.is_still()),
        (Some(BodyKind::SmplX), None, false)
    );
    let places = arrays.take("trans").unwrap();
    assert!(Motion::from_arrays(&arrays).unwrap().is_still());
    arrays.insert("transl", places);
    arrays.insert("betas", table(4, 10));
    arrays.insert("fps", rate(25.0));
    arrays.take("mocap_framerate");
    arrays.insert_text("gender", "b'FEMALE'");
    let motion = Motion::from_arrays(&arrays).unwrap();
    assert!(!motion.is_still() && motion.rate() == 25.0);
    assert_eq!(motion.gender(), Some(Gender::Female));
    // A row for each frame: all describe the same person.
    assert_eq!(motion.betas().unwrap().len(), 10);
    arrays.insert_text("surface_model_type", "smplx_locked_head");
    arrays.insert("poses", table(4, 66));
    assert_eq!(Motion::from_arrays(&arrays).unwrap().kind(), Some(BodyKind::SmplX));
    arrays.insert("poses", table(4, 156));
    arrays.insert_text("surface_model_type", "smplh");
    assert_eq!(Motion::from_arrays(&arrays).unwrap().kind(), Some(BodyKind::SmplH));
}

#[test]
fn invalid_motions_are_refused() {
    let refused = |change: &dyn Fn(&mut NamedArrays)| {
        let mut arrays = motion(156);
        change(&mut arrays);
        Motion::from_arrays(&arrays).unwrap_err().to_string()
    };
    let nan = |columns: usize| {
        let mut values = vec![0.0; 4 * columns];
        values[2 * columns + 1] = f32::NAN;
        NumericArray::new_f32(vec![4, columns], values).unwrap()
    };
    let text = refused(&|arrays| arrays.insert("poses", nan(156)));
    assert_eq!(text, "`poses` must be finite, got NaN in frame 2, value 1");
    let text = refused(&|arrays| arrays.insert("trans", nan(3)));
    assert_eq!(text, "`trans` must be finite, got NaN in frame 2, value 1");
    let far = |columns: usize| {
        let mut values = vec![0.0; 4 * columns];
        values[columns] = -3e38;
        NumericArray::new_f32(vec![4, columns], values).unwrap()
    };
    for (key, columns) in [("poses", 156), ("trans", 3)] {
        let text = refused(&|arrays| arrays.insert(key, far(columns)));
        let wanted = "must be from -100000 to 100000, got -3";
        assert!(text.starts_with(&format!("`{key}` {wanted}")), "{text}");
        assert!(text.ends_with("in frame 1, value 0"), "{text}");
    }
    let text = refused(&|arrays| arrays.insert("trans", table(5, 3)));
    assert_eq!(text, "`trans` must have shape [4, 3], got [5, 3]");
    let text = refused(&|arrays| arrays.insert("poses", table(4, 75)));
    assert!(text.contains("[4, 75]") && text.contains("156 (SMPL-H)"), "{text}");
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        let text = refused(&|arrays| arrays.insert("mocap_framerate", rate(bad)));
        assert!(text.ends_with(&format!("frames per second, got {bad}")), "{text}");
    }
    let text = refused(&|arrays| arrays.insert("mocap_framerate", table(2, 1)));
    assert!(text.contains("must have shape [1], got [2, 1]"), "{text}");
    let text = refused(&|arrays| {
        let betas = vec![0.0, f32::NAN, 0.0, 0.0];
        arrays.insert("betas", NumericArray::new_f32(vec![4], betas).unwrap());
    });
    assert_eq!(text, "`betas` must be finite, got NaN in frame 0, value 1");
    let text = refused(&|arrays| {
        arrays.insert("poses", NumericArray::new_f32(vec![0, 156], vec![]).unwrap());
    });
    assert_eq!(text, "must have 1 to 216000 frames, got 0");
    let text = refused(&|arrays| arrays.insert("poses", table(MAX_FRAMES + 1, 66)));
    assert_eq!(text, "must have 1 to 216000 frames, got 216001");
    let text = refused(&|arrays| drop(arrays.take("mocap_framerate")));
    assert!(text.contains("no frame rate") && text.ends_with("got `poses`, `trans`"), "{text}");
    let text = refused(&|arrays| arrays.insert_text("mocap_framerate", "fast"));
    assert!(text.contains("`mocap_framerate` cannot be used: it is a string"), "{text}");
    let mut arrays = motion(63);
    let text = Motion::from_arrays(&arrays).unwrap_err().to_string();
    assert!(text.contains("no array `root_orient`") && text.contains("trans"), "{text}");
    arrays = NamedArrays::new();
    arrays.insert("mocap_framerate", rate(30.0));
    let text = Motion::from_arrays(&arrays).unwrap_err().to_string();
    assert!(text.contains("must have `poses`, or") && text.contains("mocap_framerate"), "{text}");
    let text = refused(&|arrays| arrays.insert("poses", table(4, 24 * 9)));
    assert!(text.ends_with("not matrices, got [4, 216]"), "{text}");
    let text = refused(&|arrays| {
        arrays.insert("poses", NumericArray::new_f32(vec![4, 22, 3, 3], vec![0.0; 792]).unwrap());
    });
    assert!(text.contains("not matrices"), "{text}");
}

#[test]
fn rates_have_many_names_and_may_be_given() {
    let with = |change: &dyn Fn(&mut NamedArrays), given| {
        let mut arrays = motion(66);
        arrays.take("mocap_framerate");
        change(&mut arrays);
        Motion::with_rate(&arrays, given).map(|motion| (motion.rate(), motion.is_rate_assumed()))
    };
    assert_eq!(with(&|_| {}, Some(24.0)), Ok((24.0, true)));
    for name in ["mocap_frame_rate", "fps", "mocap_fps", "framerate", "frame_rate"] {
        assert_eq!(with(&|arrays| arrays.insert(name, rate(50.0)), Some(24.0)), Ok((50.0, false)));
    }
    assert_eq!(with(&|arrays| arrays.insert_text("fps", " 29.97 "), None), Ok((29.97, false)));
    // What the file states is not corrected in silence.
    assert!(with(&|arrays| arrays.insert("fps", rate(0.0)), Some(24.0)).is_err());
    assert!(with(&|_| {}, None).is_err() && with(&|_| {}, Some(0.0)).is_err());
}

#[test]
fn names_of_smplx_and_rows_of_vectors_are_read() {
    let mut arrays = motion(66);
    let wanted = Motion::from_arrays(&arrays).unwrap();
    let reshaped = |array: &NumericArray, joints: usize| {
        NumericArray::new_f32(vec![4, joints, 3], array.f32s().into_owned()).unwrap()
    };
    arrays.insert("poses", reshaped(&table(4, 66), 22));
    assert_eq!(Motion::from_arrays(&arrays).unwrap(), wanted);
    let mut parts = motion(63);
    let body = parts.take("poses").unwrap();
    parts.insert("body_pose", reshaped(&body, 21));
    parts.insert("global_orient", reshaped(&table(4, 3), 1));
    let named = Motion::from_arrays(&parts).unwrap();
    assert_eq!(
        (named.turns(1)[0], named.turns(1)[1]),
        ([0.003, 0.004, 0.005], [0.063, 0.064, 0.065])
    );
    assert_eq!(named.joint_names().len(), 22);
    // The same in a dict, beside the same in the axes of a camera.
    let mut nested = NamedArrays::new();
    for key in ["body_pose", "global_orient", "trans"] {
        nested.insert(format!("smpl_params_global.{key}"), parts.get(key).unwrap().clone());
        nested.insert(format!("smpl_params_incam.{key}"), table(4, 63));
    }
    assert_eq!(Motion::with_rate(&nested, Some(60.0)).unwrap().turns(1), named.turns(1));
    parts.insert("body_pose", table(4, 69));
    let smpl = Motion::from_arrays(&parts).unwrap();
    assert_eq!(
        (smpl.joint_names().last(), smpl.kind()),
        (Some("right_hand"), Some(BodyKind::Smpl))
    );
    // A jaw without hands, hands without a jaw, and both; ends of hands give way to fingers.
    parts.insert("jaw_pose", table(4, 3));
    let face = Motion::from_arrays(&parts).unwrap();
    assert_eq!((face.joint_names().len(), face.turns(1)[22][0]), (25, 0.003));
    assert!(face.unused().is_empty());
    for side in ["left", "right"] {
        parts.insert(format!("{side}_hand_pose"), reshaped(&table(4, 45), 15));
    }
    let all = Motion::from_arrays(&parts).unwrap();
    assert_eq!(
        (all.joint_names().len(), all.turns(1)[25][0], all.turns(1)[40][0]),
        (55, 0.045, 0.045)
    );
    parts.take("jaw_pose");
    assert_eq!(Motion::from_arrays(&parts).unwrap().joint_names().len(), 52);
}

#[test]
fn what_is_not_read_is_reported() {
    let mut arrays = motion(66);
    let reported = |arrays: &NamedArrays| Motion::from_arrays(arrays).unwrap().unused().join(", ");
    arrays.insert("expressions", table(4, 10));
    assert_eq!(reported(&arrays), "expressions [4, 10]");
    arrays.insert("expressions", NumericArray::new_f32(vec![4, 10], vec![0.0; 40]).unwrap());
    arrays.insert("dmpls", table(4, 8));
    arrays.insert("pose_jaw", table(4, 3));
    arrays.insert("left_hand_pose", table(4, 6));
    assert_eq!(reported(&arrays), "left_hand_pose [4, 6], pose_jaw [4, 3]");
    // Parts that `poses` contains.
    arrays.insert("poses", table(4, 165));
    assert_eq!(reported(&arrays), "");
    arrays.insert("poses", table(4, 156));
    assert_eq!(reported(&arrays), "pose_jaw [4, 3]");
    let mut parts = motion(63);
    let body = parts.take("poses").unwrap();
    parts.insert("pose_body", body);
    parts.insert("root_orient", table(4, 3));
    // Coefficients of principal components.
    parts.insert("left_hand_pose", table(4, 12));
    parts.insert("right_hand_pose", table(4, 12));
    parts.insert("expression", table(4, 50));
    assert_eq!(
        reported(&parts),
        "expression [4, 50], left_hand_pose [4, 12], right_hand_pose [4, 12]"
    );
}

#[test]
fn degrees_are_refused_and_full_turns_are_not() {
    const FRAMES: usize = 40;
    let read = |root: &dyn Fn(usize) -> f32, joint: &dyn Fn(usize, usize) -> f32| {
        let mut poses = vec![0.0; FRAMES * 66];
        for frame in 0..FRAMES {
            poses[frame * 66 + 1] = root(frame);
            (1..22).for_each(|at| poses[frame * 66 + 3 * at] = joint(frame, at));
        }
        let mut arrays = NamedArrays::new();
        arrays.insert("poses", NumericArray::new_f32(vec![FRAMES, 66], poses).unwrap());
        Motion::with_rate(&arrays, Some(30.0)).map_err(|error| error.to_string())
    };
    let knees = |frame: usize, at: usize| if at == 4 { frame as f32 } else { 0.0 };
    let refused = read(&|_| 0.0, &knees).unwrap_err();
    assert_eq!(
        refused,
        "rotations must be in radians, got 39.0 for `left_knee` in frame 39, as in degrees"
    );
    // A T-pose whose arms are lowered.
    let arms = |_: usize, at: usize| if at == 16 || at == 17 { 70.0 } else { 0.0 };
    assert!(read(&|_| 0.0, &arms).unwrap_err().contains("got 70.0 for `left_shoulder`"));
    // The root alone, as from Z up.
    assert!(read(&|_| 90.0, &|_, _| 0.2).unwrap_err().contains("got 90.0 for `pelvis`"));
    // Spinning without being wrapped, a wrist beyond a full turn for a frame, and usual poses.
    read(&|frame| frame as f32, &|_, _| 0.5).unwrap();
    read(&|_| 0.0, &|frame, at| if frame == 3 && at == 20 { 6.5 } else { 1.0 }).unwrap();
    read(&|_| 3.1, &|_, _| -3.1).unwrap();
}
