//! A pinhole camera, and its pose from landmarks.
//!
//! Axes are those of OpenCV: x to the right, y down, z forward. Pixel `(i, j)` covers
//! `[i, i + 1) × [j, j + 1)`, so its centre is at `+0.5`, as for texels.

use glam::{DMat3, DVec3};
use nalgebra::{SMatrix, SVector};
use uvgraft::Size;
use uvgraft::correspond::similarity::Similarity;
use uvgraft::statistics::median;

/// Focal length, as a share of a photograph's longer side, where nothing tells it: 43 mm on film,
/// between that of telephones and of portraits.
const USUAL_FOCAL: f64 = 1.2;

/// A camera without distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// From the head's space to the camera's.
    pub rotation: DMat3,
    /// Added after the rotation, in the head's unit.
    pub translation: DVec3,
    /// Focal length in pixels.
    pub focal_px: f64,
    /// Where the optical axis meets the image, in pixels.
    pub center_px: [f64; 2],
}

impl Camera {
    /// The focal length that is assumed where a photograph does not state one, in pixels.
    pub fn usual_focal_px(size: Size) -> f64 {
        USUAL_FOCAL * f64::from(size.width.max(size.height))
    }

    /// The camera that sees points of a head at landmarks: weak perspective, then perspective.
    ///
    /// - `points`: in the head's space.
    /// - `landmarks`: `[x, y, z]` of the same points in pixels, where z is a depth relative to the
    ///   others.
    /// - `focal_px`: focal length in pixels.
    ///
    /// `None` if the points determine no pose.
    pub fn of_landmarks(
        points: &[DVec3],
        landmarks: &[[f64; 3]],
        focal_px: f64,
        size: Size,
    ) -> Option<Self> {
        let pairs: Vec<[DVec3; 2]> =
            points.iter().zip(landmarks).map(|(&point, &at)| [point, at.into()]).collect();
        let weak = Similarity::robust(&pairs, true)?;
        let center_px = [f64::from(size.width) / 2.0, f64::from(size.height) / 2.0];
        // Relative depths are about a plane through the head, whose distance the scale tells.
        let mean = pairs.iter().map(|pair| pair[1]).sum::<DVec3>() / pairs.len() as f64;
        let [x, y, z] = weak.translation.to_array();
        let offset = DVec3::new(x - center_px[0], y - center_px[1], z - mean.z + focal_px);
        let mut camera =
            Self { rotation: weak.rotation, translation: offset / weak.scale, focal_px, center_px };
        // Points off the axis: the weak model moves them, perspective turns towards them.
        camera.refine(points, landmarks, &vec![1.0; points.len()]);
        Some(camera)
    }

    /// A point in the camera's space.
    pub fn view(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// Where a point appears, in pixels, and its distance along the optical axis. Points behind the
    /// camera have a distance of at most 0.
    pub fn project(&self, point: DVec3) -> [f64; 3] {
        let at = self.view(point);
        let scale = self.focal_px / at.z;
        [self.center_px[0] + at.x * scale, self.center_px[1] + at.y * scale, at.z]
    }

    /// The point that appears at a pixel at a distance along the optical axis.
    pub fn unproject(&self, px: [f64; 2], depth: f64) -> DVec3 {
        let x = (px[0] - self.center_px[0]) / self.focal_px;
        let y = (px[1] - self.center_px[1]) / self.focal_px;
        let at = DVec3::new(x, y, 1.0) * depth;
        self.rotation.transpose() * (at - self.translation)
    }

    /// The camera's position in the head's space.
    pub fn eye(&self) -> DVec3 {
        -(self.rotation.transpose() * self.translation)
    }

    /// Pixels per unit of the head at a distance.
    pub fn scale(&self, depth: f64) -> f64 {
        self.focal_px / depth
    }

    /// Adjusts the pose to landmarks by Gauss–Newton steps with Huber's weights, which leave
    /// landmarks that expressions move where they are. Depths have no say: what networks tell of
    /// them differs from real faces by more than a tilt of the head changes the image.
    ///
    /// - `landmarks`: as in [`Camera::of_landmarks`].
    /// - `weights`: how much each counts.
    pub fn refine(&mut self, points: &[DVec3], landmarks: &[[f64; 3]], weights: &[f64]) {
        self.adjust(points, landmarks, weights, true);
    }

    /// As [`Camera::refine`], without turning.
    pub fn shift(&mut self, points: &[DVec3], landmarks: &[[f64; 3]], weights: &[f64]) {
        self.adjust(points, landmarks, weights, false);
    }

    fn adjust(&mut self, points: &[DVec3], landmarks: &[[f64; 3]], weights: &[f64], turns: bool) {
        const STEPS: usize = 20;
        const SETTLED: f64 = 1e-9;
        for _ in 0..STEPS {
            let Some(step) = self.step(points, landmarks, weights, turns) else { return };
            let turn = DVec3::new(step[0], step[1], step[2]);
            let rotation = DMat3::from_axis_angle(turn.normalize_or(DVec3::X), turn.length());
            let next = Self {
                rotation: rotation * self.rotation,
                translation: self.translation + DVec3::new(step[3], step[4], step[5]),
                ..*self
            };
            if !(next.translation.is_finite() && next.translation.z > 0.0) {
                return;
            }
            *self = next;
            if step.norm() < SETTLED {
                return;
            }
        }
    }

    /// A step of the rotation vector and the translation.
    fn step(
        &self,
        points: &[DVec3],
        landmarks: &[[f64; 3]],
        weights: &[f64],
        turns: bool,
    ) -> Option<SVector<f64, 6>> {
        let residuals: Vec<[f64; 2]> = points
            .iter()
            .zip(landmarks)
            .map(|(&point, landmark)| {
                let [x, y, _] = self.project(point);
                [landmark[0] - x, landmark[1] - y]
            })
            .collect();
        let mut sizes: Vec<f64> = residuals.iter().map(|[x, y]| x.hypot(*y)).collect();
        let limit = (1.5 * median(sizes.iter().copied())?).max(1e-6);
        sizes.iter_mut().for_each(|size| *size = (limit / size.max(1e-12)).min(1.0));
        let mut normal = SMatrix::<f64, 6, 6>::identity() * 1e-12;
        let mut right = SVector::<f64, 6>::zeros();
        for (((&point, residual), &weight), huber) in
            points.iter().zip(residuals).zip(weights).zip(sizes)
        {
            let turned = self.rotation * point;
            let at = turned + self.translation;
            if at.z <= 0.0 {
                continue;
            }
            let f = self.focal_px / at.z;
            // Image coordinates by the point in the camera's space, and that by the pose.
            let by_point =
                [DVec3::new(f, 0.0, -f * at.x / at.z), DVec3::new(0.0, f, -f * at.y / at.z)];
            for (by_point, error) in by_point.into_iter().zip(residual) {
                // A small turn `ω` moves the point by `ω × r`, and `g · (ω × r) = ω · (r × g)`.
                let by_turn = turned.cross(by_point);
                let row = SVector::<f64, 6>::from_column_slice(&[
                    by_turn.x, by_turn.y, by_turn.z, by_point.x, by_point.y, by_point.z,
                ]);
                normal += row * row.transpose() * (weight * huber);
                right += row * (error * weight * huber);
            }
        }
        if turns {
            return Some(normal.cholesky()?.solve(&right));
        }
        let shift = normal.fixed_view::<3, 3>(3, 3).into_owned().cholesky()?;
        let shift = shift.solve(&right.fixed_rows::<3>(3).into_owned());
        Some(SVector::from([0.0, 0.0, 0.0, shift[0], shift[1], shift[2]]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> Vec<DVec3> {
        let mut random = fastrand::Rng::with_seed(1);
        let mut value = || random.f64() - 0.5;
        (0..60).map(|_| DVec3::new(value(), value(), 0.6 * value())).collect()
    }

    fn truth() -> Camera {
        let rotation =
            DMat3::from_rotation_x(3.0) * DMat3::from_rotation_y(0.4) * DMat3::from_rotation_z(0.1);
        Camera {
            rotation,
            translation: DVec3::new(0.3, -0.2, 3.0),
            focal_px: 900.0,
            center_px: [320.0, 240.0],
        }
    }

    #[test]
    fn a_pose_is_found_from_images_of_points() {
        let (points, truth) = (cloud(), truth());
        let landmarks: Vec<[f64; 3]> = points
            .iter()
            .map(|&point| {
                let [x, y, z] = truth.project(point);
                [x, y, (z - 3.0) * truth.scale(3.0)]
            })
            .collect();
        let found = Camera::of_landmarks(&points, &landmarks, 900.0, Size::new(640, 480)).unwrap();
        for (a, b) in found.rotation.to_cols_array().into_iter().zip(truth.rotation.to_cols_array())
        {
            assert!((a - b).abs() < 1e-6);
        }
        assert!(found.translation.distance(truth.translation) < 1e-5);
    }

    #[test]
    fn a_few_landmarks_that_moved_do_not_turn_the_head() {
        let (points, truth) = (cloud(), truth());
        let mut images: Vec<[f64; 3]> = points
            .iter()
            .map(|&point| truth.project(point))
            .map(|[x, y, z]| [x, y, (z - 3.0) * truth.scale(3.0)])
            .collect();
        images[..8].iter_mut().for_each(|image| image[1] += 30.0);
        let mut found = Camera { translation: truth.translation + 0.05, ..truth };
        found.refine(&points, &images, &[1.0; 60]);
        let turn = (found.rotation * truth.rotation.transpose()).col(0).angle_between(DVec3::X);
        assert!(turn.to_degrees() < 1.0, "{turn}");
    }

    #[test]
    fn a_pixel_and_a_depth_are_a_point() {
        let camera = truth();
        let point = DVec3::new(0.1, -0.2, 0.3);
        let [x, y, depth] = camera.project(point);
        assert!(camera.unproject([x, y], depth).distance(point) < 1e-12);
        assert!(camera.view(camera.eye()).length() < 1e-12);
    }
}
