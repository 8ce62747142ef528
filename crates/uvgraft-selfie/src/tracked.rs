//! A fit from what others have tracked: cameras and posed heads of frames, in a world of their own.

use glam::DVec3;
use uvgraft::correspond::similarity::Similarity;
use uvgraft::statistics::median;

use crate::camera::Camera;
use crate::fit::{Fit, FittedPhoto};
use crate::head::Head;

/// A photograph whose camera and head are known.
#[derive(Debug, Clone)]
pub struct TrackedPhoto {
    /// In the tracker's world.
    pub camera: Camera,
    /// `[vertices]`: the head as the photograph shows it, in the tracker's world.
    pub posed: Vec<DVec3>,
    /// Its landmarks, `[x, y, z]` in pixels, if they were found.
    pub landmarks: Option<Vec<[f64; 3]>>,
}

impl Fit {
    /// A fit of known cameras and heads, brought into the space of the head.
    ///
    /// - `shaped`: `[vertices]` of the head with the shape that the photographs share, without
    ///   expression, where the head's mesh is.
    ///
    /// `None` if a posed head lies on a line.
    ///
    /// # Panics
    /// If there are not as many positions as vertices, or landmarks as the head has.
    pub fn from_tracked(
        head: &Head,
        shaped: Vec<DVec3>,
        photos: Vec<TrackedPhoto>,
    ) -> Option<Self> {
        assert_eq!(shaped.len(), head.mesh.positions().len(), "vertices of the shape");
        let fitted = photos.into_iter().map(|photo| {
            assert_eq!(photo.posed.len(), shaped.len(), "vertices of a posed head");
            // The skull decides: most of it moves with neither jaw nor neck.
            let pairs: Vec<[DVec3; 2]> =
                photo.posed.iter().zip(&shaped).map(|(&from, &to)| [from, to]).collect();
            let head_from_world = Similarity::robust(&pairs, true)?;
            let moved = |at: DVec3| {
                head_from_world.rotation * at * head_from_world.scale + head_from_world.translation
            };
            let posed: Vec<DVec3> = photo.posed.into_iter().map(moved).collect();
            let camera = in_space(&photo.camera, &head_from_world);
            let projected =
                || head.points_of(&head.landmarks, &posed).into_iter().map(|at| camera.project(at));
            let landmarks = photo.landmarks.unwrap_or_else(|| projected().collect());
            assert_eq!(landmarks.len(), head.landmarks.len(), "landmarks of a photograph");
            let distances = projected()
                .zip(&landmarks)
                .map(|(at, seen)| (at[0] - seen[0]).hypot(at[1] - seen[1]));
            let residual_px = median(distances)?;
            Some(FittedPhoto { camera, posed, landmarks, residual_px })
        });
        let photos = fitted.collect::<Option<Vec<FittedPhoto>>>()?;
        Some(Self { shaped, photos })
    }
}

/// The camera that sees a world as it was before it was moved.
fn in_space(camera: &Camera, moved: &Similarity) -> Camera {
    // The world is p = Rᵀ(q - t) / s, so that C p + c is in proportion to C Rᵀ q + (s c - C Rᵀ t).
    let rotation = camera.rotation * moved.rotation.transpose();
    let translation = camera.translation * moved.scale - rotation * moved.translation;
    Camera { rotation, translation, ..*camera }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    #[test]
    fn a_moved_world_looks_the_same() {
        let camera = Camera {
            rotation: DMat3::from_rotation_x(3.0) * DMat3::from_rotation_y(0.2),
            translation: DVec3::new(0.1, -0.2, 2.0),
            focal_px: 900.0,
            center_px: [310.0, 250.0],
        };
        let moved = Similarity {
            scale: 0.25,
            rotation: DMat3::from_rotation_z(0.7),
            translation: DVec3::new(0.3, 1.5, -0.4),
        };
        let inside = in_space(&camera, &moved);
        for point in [DVec3::ZERO, DVec3::new(0.1, 0.2, -0.1), DVec3::new(-0.3, 0.1, 0.2)] {
            let there = moved.rotation * point * moved.scale + moved.translation;
            let ([x, y, z], [u, v, w]) = (camera.project(point), inside.project(there));
            assert!((x - u).abs() < 1e-9 && (y - v).abs() < 1e-9 && (z * 0.25 - w).abs() < 1e-9);
        }
    }
}
