//! How a head is turned, by the average face.
//!
//! A head of another shape than the person's cannot tell a nod from a longer nose: where only it is
//! compared with a photograph, the pose takes up what the shape lacks. The average face is as wrong
//! for a single person, but for people as a whole it is right, and it has the depths that the network
//! knows. How much it is to be believed depends on how badly the head itself explains the photograph.

use glam::{DMat3, DQuat, DVec3};
use uvgraft::correspond::similarity::Similarity;

use crate::camera::Camera;
use crate::head_landmarks::HeadLandmark;
use crate::landmarks::regions::{LEFT_BROW, NOSE_TIP, RIGHT_BROW};

/// Whether expressions hardly move a landmark: those from the tip of the nose upwards, but for brows.
/// A smile raises cheeks and draws the mouth back, as a nod does.
fn is_rigid(index: usize, average: &[DVec3]) -> bool {
    average[index].y >= average[NOSE_TIP].y
        && !LEFT_BROW.contains(&index)
        && !RIGHT_BROW.contains(&index)
}

/// The turn from a head's axes to those of the average face; `None` if its landmarks have none.
///
/// - `points`: the landmarks in the head's space.
/// - `average`: the landmarks of the average face.
pub(crate) fn of_head(
    points: &[DVec3],
    landmarks: &[HeadLandmark],
    average: &[DVec3],
) -> Option<DMat3> {
    const CERTAIN: f64 = 0.3;
    let is_used = |&index: &usize| landmarks[index].certainty > CERTAIN && is_rigid(index, average);
    let pairs: Vec<[DVec3; 2]> =
        (0..points.len()).filter(is_used).map(|index| [points[index], average[index]]).collect();
    Some(Similarity::robust(&pairs, true)?.rotation)
}

/// The turn from the axes of the average face to those of a photograph's camera.
///
/// - `landmarks`: `[x, y, z]` in pixels.
/// - `camera`: where the face is, and the focal length.
pub(crate) fn of_photograph(
    average: &[DVec3],
    landmarks: &[[f64; 3]],
    camera: &Camera,
) -> Option<DMat3> {
    let pairs: Vec<[DVec3; 2]> = (0..average.len())
        .filter(|&index| is_rigid(index, average))
        .map(|index| [average[index], landmarks[index].into()])
        .collect();
    let turn = Similarity::robust(&pairs, true)?.rotation;
    // Landmarks are found as if the camera looked at the face.
    let middle = pairs.iter().map(|pair| pair[1]).sum::<DVec3>() / pairs.len() as f64;
    let [x, y] = camera.center_px;
    let sight = DVec3::new(middle.x - x, middle.y - y, camera.focal_px).normalize();
    Some(DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, sight)) * turn)
}

/// How much the average face is to be believed, 0 to 1.
///
/// - `mismatch`: median distance of the photograph's landmarks from those of the head at rest, in eye
///   distances: 0.002 for a photograph of this very head, 0.005 of one that is painted otherwise, and
///   0.01 and more of another one.
pub(crate) fn belief(mismatch: f64) -> f64 {
    const OTHERS: f64 = 0.008;
    1.0 / (1.0 + (OTHERS / mismatch.max(1e-6)).powi(6))
}
