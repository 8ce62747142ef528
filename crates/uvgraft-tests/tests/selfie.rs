//! Photographs of the built-in figure become textures like its own. The truth is known, and the
//! photographs are made by a renderer of the tests' own.
//!
//! `examples/selfie_report.rs` prints these figures for more cases, with pictures.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::LazyLock;

use uvgraft::{Size, Texture};
use uvgraft_selfie::landmarks::FaceNetworks;
use uvgraft_selfie::{Head, PhotoLandmarks, Relight, TextureOptions};
use uvgraft_tests::photographed::{
    Judgement, Photograph, Reconstruction, Shot, Subject, landmark_error_mm, landmarks, networks,
    prepared, views,
};

/// That of the photographs' faces, or detail would be judged that they lack.
const TEXTURE: Size = Size::square(512);

static NETWORKS: LazyLock<Option<FaceNetworks>> = LazyLock::new(networks);

static FIGURE: LazyLock<Subject> = LazyLock::new(|| Subject::figure(TEXTURE));

/// The figure's head; `None`, with a message, if the networks have not been fetched.
static HEAD: LazyLock<Option<Head>> = LazyLock::new(|| {
    Some(prepared(FIGURE.head.clone(), Some(&FIGURE.texture), NETWORKS.as_ref()?).unwrap())
});

struct Made {
    photographs: Vec<Photograph>,
    reconstruction: Reconstruction,
    judged: Judgement,
    /// The largest error of a pose.
    pose_degrees: f64,
}

/// Photographs a subject and reconstructs it.
fn made(subject: &Subject, shots: &[Shot], relight: Relight) -> Option<Made> {
    let (networks, head) = (NETWORKS.as_ref()?, HEAD.as_ref()?);
    let photographs: Vec<Photograph> = shots.iter().map(|shot| shot.take(subject)).collect();
    let pictures: Vec<Texture> =
        photographs.iter().map(|photograph| photograph.picture.clone()).collect();
    let found = |photograph: &Photograph| {
        landmarks(networks, &photograph.picture, Some(photograph.camera.focal_px)).unwrap()
    };
    let found: Vec<PhotoLandmarks> = photographs.iter().map(found).collect();
    let mut options = TextureOptions::default();
    (options.size, options.relight) = (TEXTURE, relight);
    let made = Reconstruction::new(head, &pictures, &found, &options);
    let judged = made.judged(subject, &photographs);
    let errors = made.pose_errors(&photographs);
    let pose_degrees = errors.iter().map(|error| error.length()).fold(0.0, f64::max);
    Some(Made { photographs, reconstruction: made, judged, pose_degrees })
}

#[test]
fn one_photograph_tells_the_texture_and_the_pose() {
    for shot in [Shot::PORTRAIT, Shot::PORTRAIT.turned(20.0, 0.0, 0.0)] {
        let Some(made) = made(&FIGURE, &[shot], Relight::Off) else { return };
        let judged = made.judged;
        assert!(judged.psnr_db >= 30.0 && judged.coverage > 0.5, "{judged:?}");
        assert!(judged.foreign() <= 0.002, "{judged:?}");
        assert!(made.pose_degrees <= 1.5, "{}°", made.pose_degrees);
    }
}

#[test]
fn nine_photographs_tell_more() {
    let Some(made) = made(&FIGURE, &Shot::PORTRAIT.nine(), Relight::Off) else { return };
    let judged = made.judged;
    assert!(judged.psnr_db >= 33.0 && judged.coverage > 0.7, "{judged:?}");
    assert!(judged.foreign() <= 0.002, "{judged:?}");
    assert!(made.pose_degrees <= 1.5, "{}°", made.pose_degrees);
}

#[test]
fn hair_glasses_and_cloth_are_not_skin() {
    for subject in Subject::dressed(TEXTURE) {
        let shot = Shot::PORTRAIT.turned(-6.0, 4.0, 0.0);
        let Some(made) = made(&subject, &[shot], Relight::Off) else { return };
        assert!(made.judged.foreign() <= 0.002, "{}: {:?}", subject.name, made.judged);
        assert!(made.judged.coverage > 0.4, "{}: {:?}", subject.name, made.judged);
    }
}

#[test]
fn landmarks_are_found_again_on_the_result() {
    let shot = Shot::PORTRAIT;
    let Some(made) = made(&FIGURE, &[shot], Relight::Off) else { return };
    let (networks, head) = (NETWORKS.as_ref().unwrap(), HEAD.as_ref().unwrap());
    let subject = made.reconstruction.subject(head, "result");
    for shot in views() {
        let photograph = shot.take(&subject);
        let found = landmarks(networks, &photograph.picture, None).unwrap();
        let visible = made.reconstruction.visible_landmarks(head, &photograph);
        let images = visible.iter().map(|&(_, index)| {
            let [x, y, _] = found.points[index];
            [x, y]
        });
        let points = visible.iter().map(|&(point, _)| point);
        let error = landmark_error_mm(&photograph, points, images);
        assert!(error <= 1.5, "{error} mm at {}°", shot.angles[0]);
    }
}

#[test]
fn threads_do_not_show() {
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let made = pool.install(|| made(&FIGURE, &[Shot::PORTRAIT], Relight::Soft))?;
        let pictures = made.photographs.into_iter().map(|photograph| photograph.picture);
        let result = made.reconstruction.result;
        Some((pictures.collect::<Vec<_>>(), result.texture, result.known))
    };
    let one = with_threads(1);
    assert!(one == with_threads(3));
}
