//! Cameras and the shape of a head from the landmarks of photographs.
//!
//! Cameras come first, from landmarks on the head at rest as they are found when it is drawn in the
//! place of that in the photograph, and stay: adjusting them to the shape and the shape to them in
//! turn, both drift, since a nod and a shorter face look alike. Each landmark then has a place that
//! all photographs together put it at: along the image plane as seen, along the line of sight as far
//! as depths can be believed. The head's surface is bent to these places, smoothly (see
//! [`SurfaceField`](uvgraft::surface_field)), and everything loose in it moves along. What a single
//! photograph shows beyond the common shape is its expression.
//!
//! A head with a model gets the shape and the expressions that its model has first, in turn with the
//! cameras, and is bent only by what these leave.

use glam::{DMat3, DQuat, DVec3};
use uvgraft::Size;
use uvgraft::easing::smoothstep_f64;
use uvgraft::statistics::median;
use uvgraft::surface_field::{FieldValue, Smoothness};

use crate::average_pose;
use crate::camera::Camera;
use crate::drawing::Drawing;
use crate::expression;
use crate::head::Head;
use crate::head_landmarks::{HeadLandmark, steadied};
use crate::landmarks::regions::NOSE_TIP;
use crate::model_space::{ModelSpace, OfLandmarks, Sighting};
use crate::normals::normals;
use crate::pixels::Pixels;

/// The landmarks of one photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoLandmarks {
    /// `[x, y, z]` in pixels; z is relative, and smaller is nearer to the viewer.
    pub points: Vec<[f64; 3]>,
    /// Size of the photograph.
    pub size: Size,
    /// Focal length in pixels, if known.
    pub focal_px: Option<f64>,
}

/// A photograph's camera, and the head as the photograph shows it.
#[derive(Debug, Clone)]
pub struct FittedPhoto {
    /// The camera, in the head's space.
    pub camera: Camera,
    /// `[vertices]`: the head with the expression of this photograph.
    pub posed: Vec<DVec3>,
    /// Its landmarks, as given.
    pub landmarks: Vec<[f64; 3]>,
    /// Median distance of the landmarks from those of `posed`, in pixels.
    pub residual_px: f64,
}

/// The result of fitting a head to photographs.
#[derive(Debug, Clone)]
pub struct Fit {
    /// `[vertices]`: the shape that the photographs share.
    pub shaped: Vec<DVec3>,
    /// The photographs, in the given order.
    pub photos: Vec<FittedPhoto>,
}

impl PhotoLandmarks {
    /// With landmarks where heads have them too: see [`steadied`].
    fn steadied(&self) -> Self {
        let points: Vec<DVec3> = self.points.iter().map(|&at| at.into()).collect();
        let points = steadied(&points).into_iter().map(|at| at.to_array()).collect();
        Self { points, ..self.clone() }
    }
}

/// Takes the expression out of places of landmarks.
fn neutralise(head: &Head, places: &mut [FieldValue]) {
    let frame = head.anatomy.frame();
    let axes = DMat3::from_cols_array_2d(&frame.axes);
    let local: Vec<DVec3> = places
        .iter()
        .map(|place| axes.transpose() * DVec3::from(place.value) / frame.unit)
        .collect();
    let weights: Vec<f64> = head.landmarks.iter().map(|landmark| landmark.certainty).collect();
    let neutral = expression::removed(&head.canonical, &local, &weights);
    for (place, neutral) in places.iter_mut().zip(neutral) {
        place.value = (axes * neutral * frame.unit).to_array();
    }
}

/// How far relative depths are believed, as a weight beside 1 for what is seen in the image: the
/// network guesses them. Origin not recorded.
const DEPTH_TRUST: f64 = 0.1;

/// How far a place is held where the head has it, beside 1 for what is seen in the image: a little,
/// and along the line of sight more. Origin not recorded.
const REST: f64 = 0.02;
const REST_DEPTH: f64 = 0.15;

/// Smoothness of the shape and of an expression, in eye distances. Origin not recorded.
const SHAPE: Smoothness = Smoothness { bending: 0.2, membrane: 0.1 };
const EXPRESSION: Smoothness = Smoothness { bending: 0.08, membrane: 0.06 };

/// The weight of a landmark, in square eye distances: about the area that each of 468 stands for.
const LANDMARK: f64 = 0.02;

impl Fit {
    /// Fits a head to photographs.
    ///
    /// - `pixels`: of each photograph, around the head.
    ///
    /// `None` if the landmarks of a photograph determine no pose, or the shape no equations.
    ///
    /// # Panics
    /// If there are not as many pixels as photographs, or a photograph has another number of landmarks
    /// than the head.
    pub fn new(head: &Head, photos: &[PhotoLandmarks], pixels: &[Pixels<'_>]) -> Option<Self> {
        assert_eq!(photos.len(), pixels.len(), "photographs");
        let rest = head.positions();
        let drawing = head.drawing();
        let mut views = photos
            .iter()
            .zip(pixels)
            .map(|(photo, pixels)| View::new((head, &drawing), &rest, photo, pixels))
            .collect::<Option<Vec<View>>>()?;
        let mismatches = views.iter().map(|view| view.mismatch(head, &rest));
        let belief = average_pose::belief(median(mismatches).unwrap_or(f64::NAN));
        for (view, pixels) in views.iter_mut().zip(pixels) {
            view.believe_average((head, &drawing), &rest, pixels, belief);
        }
        let hold = held_still(head);
        let (shaped, expressive) = match &head.model {
            Some(model) => {
                let (shaped, expressive) = by_model(head, model, &rest, &mut views)?;
                // What the model has no shape for.
                let places = self::places(head, &views, &expressive);
                let bent = bent(head, &shaped, SHAPE, &hold, &places)?;
                let expressive = expressive.into_iter().map(|posed| {
                    let moved = posed.iter().zip(&bent).zip(&shaped);
                    moved.map(|((&posed, &bent), &shaped)| posed + (bent - shaped)).collect()
                });
                let expressive = expressive.collect();
                (bent, expressive)
            }
            None => {
                let mut places = self::places(head, &views, &vec![rest.clone(); views.len()]);
                neutralise(head, &mut places);
                let shaped = bent(head, &rest, SHAPE, &hold, &places)?;
                let expressive = vec![shaped.clone(); views.len()];
                (shaped, expressive)
            }
        };
        let fitted = views.iter().zip(photos).zip(expressive).map(|((view, given), from)| {
            let of_view = std::slice::from_ref(view);
            let mut places = self::places(head, of_view, std::slice::from_ref(&from));
            for (place, landmark) in places.iter_mut().zip(&view.landmarks) {
                place.at = landmark.at;
            }
            let posed = bent(head, &from, EXPRESSION, &hold, &places)?;
            let residual_px = view.residual(head, &posed);
            Some(FittedPhoto {
                camera: view.camera,
                posed,
                landmarks: given.points.clone(),
                residual_px,
            })
        });
        let photos = fitted.collect::<Option<Vec<FittedPhoto>>>()?;
        Some(Self { shaped, photos })
    }
}

/// The shape that a head's model has for photographs, and the head with the expression of each. Of a
/// shape that is known so well the pose can be adjusted to it, in turn.
fn by_model(
    head: &Head,
    model: &ModelSpace,
    rest: &[DVec3],
    views: &mut [View],
) -> Option<(Vec<DVec3>, Vec<Vec<DVec3>>)> {
    const ROUNDS: usize = 12;
    let sightings = |view: &View| view.sightings(head, rest);
    let seen = |view: &View| (model.of_landmarks(head, &view.landmarks), sightings(view));
    let mut photographs: Vec<(OfLandmarks, Vec<Sighting>)> = views.iter().map(seen).collect();
    let mut shaped = rest.to_vec();
    let mut expressive = vec![rest.to_vec(); views.len()];
    for _ in 0..ROUNDS {
        let found = OfLandmarks::fitted(&photographs, head.unit())?;
        shaped = ModelSpace::moved(&model.shapes, &found.shape, rest);
        for (posed, by) in expressive.iter_mut().zip(&found.expressions) {
            *posed = ModelSpace::moved(&model.expressions, by, &shaped);
        }
        for ((view, posed), (_, seen)) in views.iter_mut().zip(&expressive).zip(&mut photographs) {
            view.refine(head, posed);
            *seen = sightings(view);
        }
    }
    Some((shaped, expressive))
}

/// A photograph while the head is fitted to it.
struct View {
    photo: PhotoLandmarks,
    camera: Camera,
    /// Where its landmarks are on the head, seen from its side.
    landmarks: Vec<HeadLandmark>,
}

impl View {
    fn new(
        (head, drawing): (&Head, &Drawing<'_>),
        rest: &[DVec3],
        photo: &PhotoLandmarks,
        pixels: &Pixels<'_>,
    ) -> Option<Self> {
        /// How often the head is drawn from the side that the last drawing told, at most.
        const DRAWINGS: usize = 4;
        /// A turn, in radians, after which another drawing tells nothing new.
        const SETTLED: f64 = 0.004;
        /// How far the average face is believed if the head is evidently not the photographed one.
        /// Origin not recorded.
        const OTHERS: f64 = 0.97;
        assert_eq!(photo.points.len(), head.landmarks.len(), "landmarks of a photograph");
        let photo = photo.steadied();
        let used: Vec<usize> =
            (0..photo.points.len()).filter(|&k| head.landmarks[k].certainty > 0.1).collect();
        let points = head.points_of(&head.landmarks, rest);
        let points: Vec<DVec3> = used.iter().map(|&index| points[index]).collect();
        let seen: Vec<[f64; 3]> = used.iter().map(|&index| photo.points[index]).collect();
        let focal = photo.focal_px.unwrap_or_else(|| Camera::usual_focal_px(photo.size));
        let camera = Camera::of_landmarks(&points, &seen, focal, photo.size)?;
        let mut view = Self { photo, camera, landmarks: head.landmarks.clone() };
        for _ in 0..DRAWINGS {
            let Some(landmarks) = head.landmarks_in(drawing, &view.camera, pixels) else { break };
            let before = view.camera.rotation;
            view.landmarks = landmarks;
            view.refine(head, rest);
            let turn = DQuat::from_mat3(&(view.camera.rotation * before.transpose()));
            // Of what the average face will decide this need not be settled.
            let belief = average_pose::belief(view.mismatch(head, rest));
            if turn.to_axis_angle().1 < SETTLED || belief > OTHERS {
                break;
            }
        }
        Some(view)
    }

    /// Turns the camera towards where the average face has it.
    ///
    /// - `belief`: how far, from 0 to 1.
    fn believe_average(
        &mut self,
        (head, drawing): (&Head, &Drawing<'_>),
        rest: &[DVec3],
        pixels: &Pixels<'_>,
        belief: f64,
    ) {
        /// Share from which the head's landmarks are found again from the new side. Origin not
        /// recorded.
        const MUCH: f64 = 0.1;
        let average =
            average_pose::of_photograph(&head.canonical, &self.photo.points, &self.camera);
        let (Some(of_average), Some(of_head)) = (average, head.to_canonical) else { return };
        let (own, other) = (self.camera.rotation, of_average * of_head);
        let rotation = DQuat::from_mat3(&own).slerp(DQuat::from_mat3(&other), belief);
        self.turn(head, rest, DMat3::from_quat(rotation));
        if belief > MUCH
            && let Some(landmarks) = head.landmarks_in(drawing, &self.camera, pixels)
        {
            self.landmarks = landmarks;
            self.turn(head, rest, self.camera.rotation);
        }
    }

    /// The median distance of the landmarks from those of the head at rest, in eye distances.
    fn mismatch(&self, head: &Head, rest: &[DVec3]) -> f64 {
        let nose = head.points_of(&self.landmarks[NOSE_TIP..=NOSE_TIP], rest)[0];
        let unit_px = self.camera.scale(self.camera.view(nose).z) * head.unit();
        self.residual(head, rest) / unit_px
    }

    /// Turns the camera, and moves it to where the landmarks are then seen.
    fn turn(&mut self, head: &Head, positions: &[DVec3], rotation: DMat3) {
        let points = head.points_of(&self.landmarks, positions);
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        let at = self.camera.view(middle);
        self.camera.rotation = rotation;
        self.camera.translation = at - rotation * middle;
        self.camera.shift(&points, &self.photo.points, &self.certain());
    }

    /// How much each landmark counts for the camera. Whatever is known well enough counts alike, or
    /// one side of a face would outweigh the other.
    fn certain(&self) -> Vec<f64> {
        self.landmarks.iter().map(|landmark| (10.0 * landmark.certainty).min(1.0)).collect()
    }

    /// Adjusts the camera to a shape.
    fn refine(&mut self, head: &Head, positions: &[DVec3]) {
        let points = head.points_of(&self.landmarks, positions);
        self.camera.refine(&points, &self.photo.points, &self.certain());
    }

    /// For each landmark how well the camera sees it, 0 to 1: networks guess what is turned away.
    fn facing(&self, head: &Head, positions: &[DVec3]) -> Vec<f64> {
        let narrow: Vec<[f32; 3]> = positions.iter().map(|at| at.as_vec3().to_array()).collect();
        let normals = normals(&narrow, head.mesh.faces());
        let points = head.points_of(&self.landmarks, positions);
        let directions = head.points_of(&self.landmarks, &normals);
        let eye = self.camera.eye();
        let facing = |(point, normal): (DVec3, DVec3)| {
            let cosine = (eye - point).normalize().dot(normal.normalize_or_zero());
            0.05 + 0.95 * smoothstep_f64(-0.1, 0.4, cosine)
        };
        points.into_iter().zip(directions).map(facing).collect()
    }

    /// The distance of each landmark along the optical axis: the network's relative depths, scaled
    /// and moved to agree with where the landmarks are now.
    fn depths(&self, points: &[DVec3]) -> Vec<f64> {
        let (camera, seen) = (&self.camera, &self.photo.points);
        let now: Vec<f64> = points.iter().map(|&point| camera.view(point).z).collect();
        let weights = || self.landmarks.iter().map(|landmark| landmark.certainty);
        let total = weights().sum::<f64>().max(f64::MIN_POSITIVE);
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            values.zip(weights()).map(|(value, weight)| value * weight).sum::<f64>() / total
        };
        let mean_now = mean(&mut now.iter().copied());
        let mean_seen = mean(&mut seen.iter().map(|point| point[2]));
        // A pixel of depth is a pixel of width at the head's distance.
        let per_pixel = 1.0 / camera.scale(mean_now);
        seen.iter().map(|point| mean_now + (point[2] - mean_seen) * per_pixel).collect()
    }

    /// What the photograph tells of each landmark, beside where it is on the head so far.
    fn sightings(&self, head: &Head, from: &[DVec3]) -> Vec<Sighting> {
        let points = head.points_of(&self.landmarks, from);
        let depths = self.depths(&points);
        let facing = self.facing(head, from);
        let sighting = |(index, landmark): (usize, &HeadLandmark)| {
            let [x, y, _] = self.photo.points[index];
            let seen = self.camera.unproject([x, y], depths[index]);
            let along = outer((seen - self.camera.eye()).normalize());
            let weight = facing[index] * landmark.certainty;
            // Fully across the line of sight, and little along it.
            let certainty = (DMat3::IDENTITY - along * (1.0 - DEPTH_TRUST)) * weight;
            Sighting { moved: seen - points[index], certainty, along, weight }
        };
        self.landmarks.iter().enumerate().map(sighting).collect()
    }

    /// The median distance of the landmarks from those of the fitted head, in pixels.
    fn residual(&self, head: &Head, posed: &[DVec3]) -> f64 {
        let points = head.points_of(&self.landmarks, posed);
        let certain = points.iter().zip(&self.photo.points).zip(&self.landmarks);
        let certain = certain.filter(|(_, landmark)| landmark.certainty > 0.3);
        let distance = |((&point, seen), _): ((&DVec3, &[f64; 3]), &HeadLandmark)| {
            let [x, y, _] = self.camera.project(point);
            (x - seen[0]).hypot(y - seen[1])
        };
        median(certain.map(distance)).unwrap_or(f64::NAN)
    }
}

/// Where photographs put landmarks, as displacements from where they are.
///
/// - `from`: `[photographs][vertices]`, the head in each so far; depths are relative to it.
fn places(head: &Head, views: &[View], from: &[Vec<DVec3>]) -> Vec<FieldValue> {
    let unit = head.unit();
    let seen: Vec<Vec<Sighting>> =
        views.iter().zip(from).map(|(view, from)| view.sightings(head, from)).collect();
    let place = |(index, landmark): (usize, &HeadLandmark)| {
        // Least squares: `(REST + Σ Cᵢ) x = Σ Cᵢ mᵢ`, with the certainty `Cᵢ` of each photograph.
        let mut matrix = DMat3::from_diagonal(DVec3::splat(REST));
        let mut right = DVec3::ZERO;
        let mut total = 0.0;
        for sightings in &seen {
            let Sighting { moved, certainty, along, weight } = sightings[index];
            matrix += certainty + along * (REST_DEPTH / views.len() as f64);
            right += certainty * moved;
            total += weight;
        }
        let value = matrix.inverse() * right;
        let weight = LANDMARK * unit * unit * total.min(1.0);
        FieldValue { at: landmark.at, value: value.to_array(), weight }
    };
    head.landmarks.iter().enumerate().map(place).collect()
}

fn outer(direction: DVec3) -> DMat3 {
    DMat3::from_cols(direction * direction.x, direction * direction.y, direction * direction.z)
}

/// For each vertex how much it is held at rest: not in the face, fully away from the head.
fn held_still(head: &Head) -> Vec<f64> {
    let frame = head.anatomy.frame();
    let areas = head.field.areas();
    let hold = |(position, area): (&[f32; 3], f64)| {
        let [x, y, z] = frame.local(position.map(f64::from));
        // The crown is some 2 eye distances above the eyes, the hollow of the neck 4 below.
        let below = smoothstep_f64(2.4, 4.0, -y);
        let away = smoothstep_f64(3.0, 4.5, DVec3::new(x, y, z).length());
        // The skull's shape is hardly seen; it follows the face, but not beyond measure.
        0.01 * area + 10.0 * area * below.max(away)
    };
    head.mesh.positions().iter().zip(areas).map(hold).collect()
}

/// The head with its surface bent so that landmarks come to their places.
fn bent(
    head: &Head,
    from: &[DVec3],
    smoothness: Smoothness,
    hold: &[f64],
    places: &[FieldValue],
) -> Option<Vec<DVec3>> {
    let unit = head.unit();
    let smoothness =
        Smoothness { bending: smoothness.bending * unit, membrane: smoothness.membrane * unit };
    let held: Vec<(f64, [f64; 3])> = hold.iter().map(|&weight| (weight, [0.0; 3])).collect();
    let moves = head.field.solve(smoothness, &held, places)?;
    let mut moved: Vec<DVec3> =
        from.iter().zip(&moves).map(|(&from, &by)| from + DVec3::from(by)).collect();
    move_loose_parts(head, from, &mut moved);
    Some(moved)
}

/// Moves what lies loose in the head, such as eyeballs and teeth, rigidly with the skin around it.
fn move_loose_parts(head: &Head, from: &[DVec3], moved: &mut [DVec3]) {
    /// Number of vertices of the skin that decide.
    const NEAREST: usize = 60;
    let skin = &head.components.vertices[head.components.skin as usize];
    let mut moves = Vec::new();
    for (number, vertices) in head.components.vertices.iter().enumerate() {
        if number as u32 == head.components.skin || vertices.is_empty() {
            continue;
        }
        let center =
            vertices.iter().map(|&at| from[at as usize]).sum::<DVec3>() / vertices.len() as f64;
        let mut near: Vec<(f64, u32)> =
            skin.iter().map(|&at| (from[at as usize].distance_squared(center), at)).collect();
        let count = NEAREST.min(near.len());
        if count == 0 {
            continue;
        }
        near.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0));
        let shift = |&(_, at): &(f64, u32)| moved[at as usize] - from[at as usize];
        moves.push((number, near[..count].iter().map(shift).sum::<DVec3>() / count as f64));
    }
    for (number, shift) in moves {
        for &vertex in &head.components.vertices[number] {
            moved[vertex as usize] = from[vertex as usize] + shift;
        }
    }
}
