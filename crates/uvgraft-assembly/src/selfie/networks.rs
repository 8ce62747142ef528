//! The imported networks, prepared for photographs and for drawings of heads.

use uvgraft::Texture;
use uvgraft_pipeline::{Blame, Failure, Result};
use uvgraft_selfie::face_networks;
use uvgraft_selfie::landmarks::FaceNetworks;

use super::request::Networks;
use crate::weights;

/// The networks that find faces and landmarks.
///
/// # Errors
/// As bad input if they were not imported, with the commands that do so.
pub(super) fn load(networks: &Networks) -> Result<FaceNetworks> {
    let models = match networks {
        Networks::Imported => weights::face_models()?,
        Networks::File(file) => Some(face_networks::read(file).or_input()?),
    };
    let Some(models) = models else {
        return Err(Failure::input(
            "the networks that find faces are not part of uvgraft; to import them, run `npm pack \
             @mediapipe/face_mesh@0.4.1657299874` and `uvgraft weights import \
             mediapipe-face_mesh-0.4.1657299874.tgz`",
        ));
    };
    FaceNetworks::new(&models).or_input()
}

/// Landmarks in the drawing of a head.
pub(super) fn of_drawing(networks: &FaceNetworks, drawing: &Texture) -> Option<Vec<[f64; 3]>> {
    /// Drawings look less like faces than photographs do.
    const LEAST_SCORE: f64 = 0.5;
    let face = networks.detect(drawing).into_iter().next()?;
    let found = networks.steady_landmarks(drawing, &face);
    (found.score >= LEAST_SCORE).then_some(found.points)
}
