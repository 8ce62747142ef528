//! Faces in a photograph, and the landmarks of each.
//!
//! [`FaceNetworks::detect`] finds faces, [`FaceNetworks::landmarks`] and
//! [`FaceNetworks::steady_landmarks`] the 468 landmarks of one, and [`FaceNetworks::find`] does both and refuses photographs that are of no use. Positions are in pixels
//! of the photograph: x to the right, y down, and pixel `(i, j)` has its centre at `(i + 0.5, j + 0.5)`.
//!
//! Photographs may have any depth and any channels. Transparent pixels are laid over grey, and linear
//! values are encoded as sRGB, which the networks were trained with.

mod canonical;
mod detector;
mod drawing;
mod iris;
mod jaw;
mod mesh;
mod photo_pyramid;
pub mod refusal;
pub mod regions;
mod search;

use crate::face_networks::FaceModels;
use uvgraft::Texture;

pub use canonical::CanonicalFace;
pub use iris::Iris;
pub use refusal::{FaceChoice, FaceError};

use crate::network::{Network, NetworkError};
use photo_pyramid::PhotoPyramid;
use regions::{CHIN, FOREHEAD, LEFT_EYE_OUTER, LEFT_SIDE, RIGHT_EYE_OUTER, RIGHT_SIDE};
use search::{Confirmed, Searcher};

/// The networks that find faces and landmarks, ready to run.
#[derive(Debug, Clone)]
pub struct FaceNetworks {
    detector: Network,
    mesh: Network,
    iris: Option<Network>,
    canonical: CanonicalFace,
}

/// A face that the detector found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundFace {
    /// How certain it is, `0.0..=1.0`.
    pub score: f64,
    /// Centre of its box, in pixels.
    pub center: [f64; 2],
    /// Width and height of its box, in pixels: from the brows to the chin, and from ear to ear.
    pub box_size: [f64; 2],
    /// Rotation of the box, in radians, clockwise as one sees it.
    pub angle: f64,
    /// In pixels: the right eye (on the left of the picture), the left eye, the tip of the nose, the
    /// mouth, the right and the left ear.
    pub keypoints: [[f64; 2]; 6],
}

/// The landmarks of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceLandmarks {
    /// 468 points: x and y in pixels; z in the same unit, away from the camera, relative to the head's
    /// middle. [`regions`] says which is which, and [`CanonicalFace`] connects them.
    pub points: Vec<[f64; 3]>,
    /// How certain the network is that it sees a face, `0.0..=1.0`.
    pub score: f64,
    /// The right and the left eye, if the iris network was imported.
    pub irises: Option<[Iris; 2]>,
    /// The part of the face in which neighbouring pixels have the same colour, `0.0..=1.0`: hardly any
    /// in a photograph, most of it in a drawing.
    pub flat_part: f64,
    /// How much the colour changes where the jaw ends, on both sides, as a share of the skin's
    /// brightness: a lot in a photograph, hardly at all in a texture of a head.
    pub outline: f64,
}

impl FoundFace {
    /// The longer side of the box, in pixels.
    pub const fn size(&self) -> f64 {
        self.box_size[0].max(self.box_size[1])
    }

    /// The angle of the line from the right to the left eye, in radians, clockwise as one sees it; 0
    /// for an upright face.
    pub fn eye_angle(&self) -> f64 {
        let [right, left, ..] = self.keypoints;
        (left[1] - right[1]).atan2(left[0] - right[0])
    }
}

impl FaceLandmarks {
    /// Whether it is a face in a texture of a head, which looks flattened out, rather than in a
    /// photograph.
    pub fn is_in_texture(&self) -> bool {
        /// Textures of bodies and heads in three layouts had at most 0.11. Photographs of seven people
        /// had at least 0.37, and at least 0.36 if darkened, brightened, blurred or with less contrast.
        const LEAST_OUTLINE: f64 = 0.2;
        self.outline < LEAST_OUTLINE
    }

    /// How far the face is turned, in radians: 0 from the front, positive towards the right of the
    /// picture. An estimate from the network's depth, which is flatter than that of a real face.
    pub fn yaw(&self) -> f64 {
        let (right, left) = (self.points[RIGHT_SIDE], self.points[LEFT_SIDE]);
        (left[2] - right[2]).atan2((left[0] - right[0]).hypot(left[1] - right[1]))
    }

    /// How far the face is tilted, in radians: 0 from the front, positive downwards.
    pub fn pitch(&self) -> f64 {
        let (top, bottom) = (self.points[FOREHEAD], self.points[CHIN]);
        (bottom[2] - top[2]).atan2((bottom[0] - top[0]).hypot(bottom[1] - top[1]))
    }

    /// How far the face leans, in radians: 0 upright, clockwise as one sees it.
    pub fn roll(&self) -> f64 {
        let (right, left) = (self.points[RIGHT_EYE_OUTER], self.points[LEFT_EYE_OUTER]);
        (left[1] - right[1]).atan2(left[0] - right[0])
    }
}

impl FaceNetworks {
    /// Prepares the networks.
    ///
    /// # Errors
    /// [`NetworkError`] if they are not the networks that they should be.
    pub fn new(models: &FaceModels) -> Result<Self, NetworkError> {
        let detector = Network::new(&models.detection)?;
        detector::check(&detector)?;
        let mesh = Network::new(&models.landmark)?;
        mesh::check(&mesh)?;
        let iris = models.iris.as_ref().map(Network::new).transpose()?;
        iris.as_ref().map(iris::check).transpose()?;
        Ok(Self { detector, mesh, iris, canonical: CanonicalFace::new(&models.canonical) })
    }

    /// The face whose vertices are the landmarks.
    pub const fn canonical(&self) -> &CanonicalFace {
        &self.canonical
    }

    /// All faces in a photograph, the largest first.
    pub fn detect(&self, photograph: &Texture) -> Vec<FoundFace> {
        let confirmed = self.search(&PhotoPyramid::new(photograph));
        confirmed.into_iter().map(|confirmed| confirmed.face).collect()
    }

    /// The landmarks of a face, whatever its score, as MediaPipe finds them: in a single crop.
    pub fn landmarks(&self, photograph: &Texture, face: &FoundFace) -> FaceLandmarks {
        let picture = PhotoPyramid::new(photograph);
        let (points, score) = mesh::find(&self.mesh, &picture, face);
        self.complete(&picture, face, points, score)
    }

    /// The landmarks of a face, whatever its score, as the mean over several crops: steadier, for ten
    /// times the work.
    pub fn steady_landmarks(&self, photograph: &Texture, face: &FoundFace) -> FaceLandmarks {
        let picture = PhotoPyramid::new(photograph);
        let (points, score) = mesh::find(&self.mesh, &picture, face);
        let points = self.averaged(&picture, &points);
        self.complete(&picture, face, points, score)
    }

    /// The landmarks of the face that is meant, as [`FaceNetworks::steady_landmarks`].
    ///
    /// # Errors
    /// [`FaceError`] if there is no such face, or if it is too small, unclear, drawn or seen from the
    /// side.
    pub fn find(
        &self,
        photograph: &Texture,
        choice: FaceChoice,
    ) -> Result<FaceLandmarks, FaceError> {
        let picture = PhotoPyramid::new(photograph);
        let mut confirmed = self.search(&picture);
        let faces: Vec<FoundFace> = confirmed.iter().map(|confirmed| confirmed.face).collect();
        let Confirmed { face, points, score } =
            confirmed.swap_remove(refusal::choose(&faces, choice)?);
        let points = self.averaged(&picture, &points);
        let landmarks = self.complete(&picture, &face, points, score);
        refusal::check(&landmarks)?;
        Ok(landmarks)
    }

    fn search(&self, picture: &PhotoPyramid<'_>) -> Vec<Confirmed> {
        Searcher { detector: &self.detector, mesh: &self.mesh, picture }.search()
    }

    fn averaged(&self, picture: &PhotoPyramid<'_>, points: &[[f64; 3]]) -> Vec<[f64; 3]> {
        mesh::averaged(&self.mesh, picture, points, &self.canonical.mirror_partners)
    }

    fn complete(
        &self,
        picture: &PhotoPyramid<'_>,
        face: &FoundFace,
        points: Vec<[f64; 3]>,
        score: f64,
    ) -> FaceLandmarks {
        let irises = self.iris.as_ref().map(|network| iris::find(network, picture, &points));
        let flat_part = drawing::flat_part(picture, face);
        let outline = jaw::outline(picture, &points);
        FaceLandmarks { points, score, irises, flat_part, outline }
    }
}
