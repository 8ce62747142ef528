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
    let text = Motion::from_arrays(&NamedArrays::new()).unwrap_err().to_string();
    assert!(text.contains("mocap_framerate"), "{text}");
    let mut arrays = motion(63);
    let text = Motion::from_arrays(&arrays).unwrap_err().to_string();
    assert!(text.contains("no array `root_orient`") && text.contains("trans"), "{text}");
    arrays = NamedArrays::new();
    arrays.insert("mocap_framerate", rate(30.0));
    let text = Motion::from_arrays(&arrays).unwrap_err().to_string();
    assert!(text.contains("must have `poses`, or") && text.contains("mocap_framerate"), "{text}");
}
