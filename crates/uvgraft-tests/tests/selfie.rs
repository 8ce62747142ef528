//! Photographs of the built-in figure become textures like its own. The truth is known, and the
//! photographs are made by a renderer of the tests' own.
//!
//! `examples/selfie_report.rs` prints these figures for more cases, with pictures.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::LazyLock;

use glam::DVec3;
use uvgraft::{Size, Texture};
use uvgraft_selfie::landmarks::FaceNetworks;
use uvgraft_selfie::{Fit, Head, ModelSpace, PhotoLandmarks, Pixels, Relight, TextureOptions};
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

struct Rebuilt {
    photographs: Vec<Photograph>,
    reconstruction: Reconstruction,
    judged: Judgement,
    /// The largest error of a pose.
    pose_degrees: f64,
}

/// Photographs a subject and reconstructs it.
fn rebuilt(subject: &Subject, shots: &[Shot], relight: Relight) -> Option<Rebuilt> {
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
    let rebuilt = Reconstruction::new(head, &pictures, &found, &options);
    let judged = rebuilt.judged(subject, &photographs);
    let errors = rebuilt.pose_errors(&photographs);
    let pose_degrees = errors.iter().map(|error| error.length()).fold(0.0, f64::max);
    Some(Rebuilt { photographs, reconstruction: rebuilt, judged, pose_degrees })
}

#[test]
fn one_photograph_tells_the_texture_and_the_pose() {
    for shot in [Shot::PORTRAIT, Shot::PORTRAIT.turned(20.0, 0.0, 0.0)] {
        let Some(rebuilt) = rebuilt(&FIGURE, &[shot], Relight::Off) else { return };
        let judged = rebuilt.judged;
        assert!(judged.psnr_db >= 30.0 && judged.coverage > 0.5, "{judged:?}");
        assert!(judged.foreign() <= 0.002, "{judged:?}");
        assert!(rebuilt.pose_degrees <= 1.5, "{}°", rebuilt.pose_degrees);
    }
}

#[test]
fn nine_photographs_tell_more() {
    let Some(rebuilt) = rebuilt(&FIGURE, &Shot::PORTRAIT.nine(), Relight::Off) else {
        return;
    };
    let judged = rebuilt.judged;
    assert!(judged.psnr_db >= 33.0 && judged.coverage > 0.7, "{judged:?}");
    assert!(judged.foreign() <= 0.002, "{judged:?}");
    assert!(rebuilt.pose_degrees <= 1.5, "{}°", rebuilt.pose_degrees);
}

#[test]
fn hair_glasses_and_cloth_are_not_skin() {
    for subject in Subject::dressed(TEXTURE) {
        let shot = Shot::PORTRAIT.turned(-6.0, 4.0, 0.0);
        let Some(rebuilt) = rebuilt(&subject, &[shot], Relight::Off) else { return };
        assert!(rebuilt.judged.foreign() <= 0.002, "{}: {:?}", subject.name, rebuilt.judged);
        assert!(rebuilt.judged.coverage > 0.4, "{}: {:?}", subject.name, rebuilt.judged);
    }
}

#[test]
fn landmarks_are_found_again_on_the_result() {
    let shot = Shot::PORTRAIT;
    let Some(rebuilt) = rebuilt(&FIGURE, &[shot], Relight::Off) else { return };
    let (networks, head) = (NETWORKS.as_ref().unwrap(), HEAD.as_ref().unwrap());
    let subject = rebuilt.reconstruction.subject(head, "result");
    for shot in views() {
        let photograph = shot.take(&subject);
        let found = landmarks(networks, &photograph.picture, None).unwrap();
        let visible = rebuilt.reconstruction.visible_landmarks(head, &photograph);
        let images = visible.iter().map(|&(_, index)| {
            let [x, y, _] = found.points[index];
            [x, y]
        });
        let points = visible.iter().map(|&(point, _)| point);
        let error = landmark_error_mm(&photograph, points, images);
        assert!(error <= 1.5, "{error} mm at {}°", shot.angles[0]);
    }
}

/// A head's model with two shapes and an expression, in standard deviations.
fn model(head: &Head) -> ModelSpace {
    let frame = head.anatomy().frame();
    let axes = frame.axes.map(DVec3::from);
    let field = |by: &dyn Fn(DVec3) -> DVec3| -> Vec<DVec3> {
        let of = |at: &[f32; 3]| {
            let local = by(DVec3::from(frame.local(at.map(f64::from)))) * frame.unit;
            axes[0] * local.x + axes[1] * local.y + axes[2] * local.z
        };
        head.mesh().positions().iter().map(of).collect()
    };
    let near = |at: DVec3, x: f64, y: f64, reach: f64| {
        (-((at.x - x).powi(2) + (at.y - y).powi(2)) / (reach * reach)).exp()
    };
    ModelSpace {
        shapes: vec![
            field(&|at| DVec3::X * 0.05 * at.x * near(at, 0.0, -1.0, 1.5)),
            field(&|at| DVec3::NEG_Y * 0.1 * near(at, 0.0, -1.6, 0.8)),
        ],
        expressions: vec![field(&|at| {
            let corners = [-0.4, 0.4].map(|x| near(at, x, -1.15, 0.3) * x.signum());
            let [right, left] = corners.map(|by| DVec3::new(0.1 * by, 0.08 * by.abs(), 0.0));
            right + left
        })],
    }
}

#[test]
fn a_model_tells_shape_and_expression_apart() {
    let (Some(networks), Some(plain)) = (NETWORKS.as_ref(), HEAD.as_ref()) else { return };
    let space = model(plain);
    let (wide, long, smile) = (1.5, -1.2, 1.0);
    let rest: Vec<DVec3> =
        plain.mesh().positions().iter().map(|at| DVec3::from(at.map(f64::from))).collect();
    let shaped: Vec<DVec3> = (0..rest.len())
        .map(|at| rest[at] + space.shapes[0][at] * wide + space.shapes[1][at] * long)
        .collect();
    let posed = (0..rest.len()).map(|at| shaped[at] + space.expressions[0][at] * smile);
    let posed = posed.map(|at| at.as_vec3().to_array()).collect();
    let mut subject = FIGURE.clone();
    subject.head = subject.head.with_positions(posed).unwrap();
    let photograph = Shot::PORTRAIT.take(&subject);
    let found = landmarks(networks, &photograph.picture, Some(photograph.camera.focal_px)).unwrap();
    let error = |head: &Head| {
        let pixels = [Pixels::whole(&photograph.picture)];
        let fit = Fit::new(head, std::slice::from_ref(&found), &pixels).unwrap();
        let errors = (0..rest.len()).filter(|&at| space.expressions[0][at].length() > 1e-3);
        let errors: Vec<f64> = errors.map(|at| fit.shaped[at].distance(shaped[at])).collect();
        1000.0 * errors.iter().sum::<f64>() / errors.len() as f64
    };
    let head = prepared(FIGURE.head.clone(), Some(&FIGURE.texture), networks).unwrap();
    let (without, with) = (error(plain), error(&head.with_model(space.clone())));
    assert!(with < 0.6 * without, "{with} mm with the model, {without} mm without");
}

#[test]
fn threads_do_not_show() {
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let rebuilt = pool.install(|| rebuilt(&FIGURE, &[Shot::PORTRAIT], Relight::Soft))?;
        let pictures = rebuilt.photographs.into_iter().map(|photograph| photograph.picture);
        let result = rebuilt.reconstruction.result;
        Some((pictures.collect::<Vec<_>>(), result.texture, result.known))
    };
    let one = with_threads(1);
    assert!(one == with_threads(3));
}
