//! The landmarks of photographs on a head's mesh: the head is drawn from several sides, a network
//! finds landmarks in the pictures, and these are cast back onto the mesh.

use glam::{DMat3, DVec3};
use uvgraft::surface_index::SurfacePoint;
use uvgraft::threads::map_indices;

use crate::camera::Camera;
use crate::drawing::{Drawing, SIZE, View};
use crate::head::LandmarkDetector;
use crate::landmarks::regions::{FACE_OVAL, LEFT_BROW, LIPS_INNER, LIPS_OUTER, RIGHT_BROW};
use crate::pixels::Pixels;

/// Sides of the head that are drawn: turned to the left and up, in degrees.
const SIDES: [[f64; 2]; 9] = [
    [-45.0, 0.0],
    [-30.0, 0.0],
    [-15.0, 0.0],
    [0.0, 0.0],
    [15.0, 0.0],
    [30.0, 0.0],
    [45.0, 0.0],
    [0.0, 12.0],
    [0.0, -12.0],
];

/// Distance of the camera from the eyes, and focal length as a share of the drawing's side: a head
/// is about 4.5 eye distances high, and fills two thirds.
const DISTANCE: f64 = 16.0;
const FOCAL: f64 = 2.1;

/// A landmark on the head's mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadLandmark {
    /// Its place.
    pub at: SurfacePoint,
    /// How sure the place is, from 0 to 1.
    pub certainty: f64,
}

/// Why landmarks were not found on a mesh.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HeadLandmarkError {
    /// In too few of the drawings.
    #[error(
        "no face was found in drawings of the head: must be in at least {needed} of {drawn}, was in \
         {found}"
    )]
    NotFound {
        /// Number of drawings with a face.
        found: usize,
        /// Number of drawings.
        drawn: usize,
        /// Number that are needed.
        needed: usize,
    },
}

/// Landmarks that say less about the surface. Brows are where a person has them, wherever they are
/// drawn on the head; and the edge of the face is where the surface turns away, which is another
/// place from every side.
const LESS_CERTAIN: [(&[usize], f64); 3] =
    [(&LEFT_BROW, 0.05), (&RIGHT_BROW, 0.05), (&FACE_OVAL, 0.4)];

/// Landmarks with the inner edges of the lips, which touch in a closed mouth, a share of the way
/// towards the outer edges: the surface of which lip they belong to must not depend on a hair's
/// breadth.
pub(crate) fn steadied(landmarks: &[DVec3]) -> Vec<DVec3> {
    const SHARE: f64 = 0.35;
    let mut steady = landmarks.to_vec();
    for (inner, outer) in LIPS_INNER.into_iter().zip(LIPS_OUTER) {
        if let (Some(&from), Some(&to)) = (landmarks.get(inner), landmarks.get(outer)) {
            steady[inner] = from + (to - from) * SHARE;
        }
    }
    steady
}

/// How sure a landmark is whose places on the drawings differ, and whose mean is off the surface;
/// both in eye distances.
fn certainty(spread: f64, off_surface: f64) -> f64 {
    let fade = |value: f64, full: f64, none: f64| ((none - value) / (none - full)).clamp(0.0, 1.0);
    fade(spread, 0.04, 0.15) * fade(off_surface, 0.04, 0.15)
}

/// A landmark cast onto the mesh from one side, and its weight.
type Cast = Option<(DVec3, f64)>;

/// For each landmark the weighted mean of its places, their total weight and spread.
fn means(sides: &[Vec<Cast>], count: usize) -> Vec<(DVec3, f64, f64)> {
    let of_landmark = |index: usize| {
        let casts = || sides.iter().filter_map(|side| side[index]);
        let total: f64 = casts().map(|(_, weight)| weight).sum();
        if total <= 0.0 {
            return (DVec3::ZERO, 0.0, 0.0);
        }
        let mean = casts().map(|(point, weight)| point * weight).sum::<DVec3>() / total;
        let squares = casts().map(|(point, weight)| point.distance_squared(mean) * weight);
        (mean, total, (squares.sum::<f64>() / total).sqrt())
    };
    (0..count).map(of_landmark).collect()
}

/// Finds the landmarks of photographs on a head.
///
/// - `mirror_partners`: for each landmark, that of the other side of the face; itself on the midline.
/// - `detect`: finds the landmarks in a picture, `[x, y, z]` in pixels each; as many as `mirror_partners`.
pub(crate) fn landmarks(
    drawing: &Drawing<'_>,
    mirror_partners: &[usize],
    detect: &LandmarkDetector,
) -> Result<Vec<HeadLandmark>, HeadLandmarkError> {
    const NEEDED: usize = 3;
    let found: Vec<Vec<Cast>> = map_indices(SIDES.len(), |side| {
        let view = at_side(drawing, SIDES[side]);
        let landmarks =
            detect(&view.drawn()).filter(|found| found.len() == mirror_partners.len())?;
        let landmarks: Vec<DVec3> = landmarks.into_iter().map(DVec3::from).collect();
        Some(cast(drawing, &view, &steadied(&landmarks)))
    })
    .into_iter()
    .flatten()
    .collect();
    if found.len() < NEEDED {
        let (found, drawn) = (found.len(), SIDES.len());
        return Err(HeadLandmarkError::NotFound { found, drawn, needed: NEEDED });
    }
    let means = means(&found, mirror_partners.len());
    let frame = drawing.anatomy().frame();
    let mirrored = |point: DVec3| {
        let [x, y, z] = frame.local(point.to_array());
        DVec3::from(frame.world([-x, y, z]))
    };
    let landmarks =
        means.iter().zip(mirror_partners).map(|(&(point, weight, spread), &mirror_partner)| {
            // Both sides together are twice as sure, and neither is drawn to one side.
            let (of_partner, partner_weight, partner_spread) = means[mirror_partner];
            let total = (weight + partner_weight).max(f64::MIN_POSITIVE);
            let point = (point * weight + mirrored(of_partner) * partner_weight) / total;
            let spread = (spread * weight + partner_spread * partner_weight) / total / frame.unit;
            let reach = 0.5 * frame.unit;
            let (at, distance) = drawing
                .nearest(point, reach)
                .filter(|_| total > 1e-9)
                .unwrap_or((SurfacePoint { face: 0, weights: [1.0, 0.0, 0.0] }, f64::INFINITY));
            HeadLandmark { at, certainty: certainty(spread, distance / frame.unit) }
        });
    let mut landmarks: Vec<HeadLandmark> = landmarks.collect();
    for (indices, share) in LESS_CERTAIN {
        for &index in indices {
            if let Some(landmark) = landmarks.get_mut(index) {
                landmark.certainty *= share;
            }
        }
    }
    Ok(landmarks)
}

fn at_side<'a>(drawing: &'a Drawing<'_>, [yaw, pitch]: [f64; 2]) -> View<'a> {
    let frame = drawing.anatomy().frame();
    let [left, up, forward] = frame.axes.map(DVec3::from);
    // Looking at the face, the person's left is to the right.
    let front = DMat3::from_cols(left, -up, -forward).transpose();
    let turn =
        DMat3::from_rotation_x(pitch.to_radians()) * DMat3::from_rotation_y(yaw.to_radians());
    let rotation = turn * front;
    let away = DVec3::new(0.0, 0.0, DISTANCE * frame.unit);
    let [width, height] = [SIZE.width, SIZE.height].map(f64::from);
    drawing.seen_by(Camera {
        rotation,
        translation: away - rotation * middle(drawing),
        focal_px: FOCAL * width,
        center_px: [width / 2.0, height / 2.0],
    })
}

/// The middle of the face: half an eye distance below the eyes.
fn middle(drawing: &Drawing<'_>) -> DVec3 {
    DVec3::from(drawing.anatomy().frame().world([0.0, -0.5, 0.0]))
}

/// The landmarks as they are found when a head is drawn in the place of that in a photograph.
///
/// - `camera`: of the photograph.
/// - `known`: from all sides; they stay where the drawing shows none.
pub(crate) fn in_photograph(
    drawing: &Drawing<'_>,
    camera: &Camera,
    photo: &Pixels<'_>,
    known: &[HeadLandmark],
    detect: &LandmarkDetector,
) -> Option<Vec<HeadLandmark>> {
    /// The weight of a landmark that is only known from other sides. Origin not recorded.
    const UNSEEN: f64 = 0.2;
    let unit = drawing.anatomy().frame().unit;
    let [x, y, depth] = camera.project(middle(drawing));
    if depth.is_nan() || depth <= 0.0 {
        return None;
    }
    // The same picture, enlarged and moved so that the head fills it.
    let [width, height] = [SIZE.width, SIZE.height].map(f64::from);
    let zoom = FOCAL * width / DISTANCE / (camera.scale(depth) * unit);
    let view = drawing.seen_by(Camera {
        focal_px: camera.focal_px * zoom,
        center_px: [
            width / 2.0 + (camera.center_px[0] - x) * zoom,
            height / 2.0 + (camera.center_px[1] - y) * zoom,
        ],
        ..*camera
    });
    let picture = view.drawn_in(|px| {
        let at = [x + (px[0] - width / 2.0) / zoom, y + (px[1] - height / 2.0) / zoom];
        photo.mean(at, 1.0 / zoom)
    });
    let found = detect(&picture).filter(|found| found.len() == known.len())?;
    let found: Vec<DVec3> = found.into_iter().map(DVec3::from).collect();
    let casts = cast(drawing, &view, &steadied(&found));
    let landmarks = casts.into_iter().zip(known).enumerate().map(|(at, (cast, known))| {
        // Which of two lips that touch a single drawing hits is a matter of luck.
        if LIPS_INNER.contains(&at) {
            return *known;
        }
        let unseen = HeadLandmark { certainty: known.certainty * UNSEEN, ..*known };
        let Some((point, weight)) = cast.filter(|(_, weight)| *weight > 1e-4) else {
            return unseen;
        };
        match drawing.nearest(point, 0.2 * unit) {
            Some((at, _)) => {
                let certainty = known.certainty * (0.3 + 0.7 * weight.min(1.0));
                HeadLandmark { at, certainty }
            }
            None => unseen,
        }
    });
    Some(landmarks.collect())
}

/// Casts landmarks of a drawing onto the mesh.
fn cast(drawing: &Drawing<'_>, view: &View<'_>, landmarks: &[DVec3]) -> Vec<Cast> {
    let eye = view.camera().eye();
    let mesh = drawing.mesh();
    let cast = |&DVec3 { x, y, .. }: &DVec3| {
        let at = view.place([x, y])?;
        let corners = mesh.faces()[at.face as usize].map(|vertex| vertex as usize);
        let position = |vertex: usize| glam::Vec3::from(mesh.positions()[vertex]).as_dvec3();
        let point: DVec3 = (0..3).map(|k| position(corners[k]) * at.weights[k]).sum();
        let facing = (eye - point).normalize().dot(drawing.normal(&at));
        // Landmarks of the lids that fell onto the ball behind say little.
        let weight = if drawing.is_skin(at.face) { 1.0 } else { 1e-3 };
        Some((point, weight * facing.max(0.0).powi(3)))
    };
    landmarks.iter().map(cast).collect()
}
