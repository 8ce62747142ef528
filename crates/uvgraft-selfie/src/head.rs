//! A head prepared for photographs: its anatomy, its parts, and the landmarks on it.

use std::fmt;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use uvgraft::surface_field::SurfaceField;
use uvgraft::{Anatomy, AnatomyError, Mesh, Texture};

use crate::average_pose;
use crate::camera::Camera;
use crate::components::Components;
use crate::drawing::{Drawing, plain};
use crate::head_landmarks::{self, HeadLandmark, HeadLandmarkError};
use crate::landmarks::CanonicalFace;
use crate::model_space::ModelSpace;
use crate::pixels::Pixels;

/// Why a mesh is not a head for photographs.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeadError {
    /// The mesh has no head.
    #[error(transparent)]
    Anatomy(#[from] AnatomyError),
    /// Its face is not one that landmarks are found on.
    #[error(transparent)]
    Landmarks(#[from] HeadLandmarkError),
}

/// Finds the landmarks of a face in a picture: `[x, y, z]` in pixels, always as many; `None` if there
/// is no face.
pub type LandmarkDetector = dyn Fn(&Texture) -> Option<Vec<[f64; 3]>> + Send + Sync;

/// A detector in a type that can be printed.
#[derive(Clone)]
struct Detector(Arc<LandmarkDetector>);

impl fmt::Debug for Detector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Detector")
    }
}

/// A head's mesh with what photographs need to know of it.
#[derive(Debug)]
pub struct Head {
    pub(crate) mesh: Mesh,
    pub(crate) anatomy: Anatomy,
    pub(crate) components: Components,
    pub(crate) landmarks: Vec<HeadLandmark>,
    /// The landmarks of the average face, in centimetres: x to its left, y up, z forwards.
    pub(crate) canonical: Vec<DVec3>,
    /// The turn from the head's axes to those of the average face; `None` if its landmarks have none.
    pub(crate) to_canonical: Option<DMat3>,
    pub(crate) field: SurfaceField,
    pub(crate) model: Option<ModelSpace>,
    texture: Option<Texture>,
    detector: Detector,
}

impl Head {
    /// Prepares a head, a bust or a whole body.
    ///
    /// - `texture`: what the head usually looks like, in its layout; landmarks are found better on it
    ///   than on bare surface.
    /// - `canonical`: the face whose vertices are the landmarks.
    /// - `detect`: finds as many landmarks as `canonical` has, in drawings of the head.
    ///
    /// # Errors
    /// [`HeadError`] if the mesh has no head, or no face is found in drawings of it.
    pub fn new(
        mesh: Mesh,
        texture: Option<&Texture>,
        canonical: &CanonicalFace,
        detect: Arc<LandmarkDetector>,
    ) -> Result<Self, HeadError> {
        let anatomy = Anatomy::find(&mesh)?;
        let components = Components::new(&mesh, &anatomy);
        let texture = texture.map(plain);
        let drawing = Drawing::new(&mesh, &anatomy, &components, texture.as_ref());
        let landmarks = head_landmarks::landmarks(&drawing, &canonical.mirror_partners, &*detect)?;
        let canonical: Vec<DVec3> = canonical.positions.iter().map(|&at| DVec3::from(at)).collect();
        let positions: Vec<DVec3> = mesh.positions().iter().map(wide).collect();
        let points = points_of(&mesh, &landmarks, &positions);
        let to_canonical = average_pose::of_head(&points, &landmarks, &canonical);
        let field = SurfaceField::new(&mesh, anatomy.frame().unit);
        Ok(Self {
            mesh,
            anatomy,
            components,
            landmarks,
            canonical,
            to_canonical,
            field,
            model: None,
            texture,
            detector: Detector(detect),
        })
    }

    /// The head with the shapes and expressions of its model, which photographs are then fitted with.
    ///
    /// # Panics
    /// If a displacement has another number of vertices than the mesh.
    #[must_use]
    pub fn with_model(mut self, model: ModelSpace) -> Self {
        let vertices = self.mesh.positions().len();
        let mut all = model.shapes.iter().chain(&model.expressions);
        assert!(all.all(|by| by.len() == vertices), "vertices of a model's displacements");
        self.model = Some(model);
        self
    }

    /// The mesh, at rest.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Its landmarks and areas by shape.
    pub fn anatomy(&self) -> &Anatomy {
        &self.anatomy
    }

    /// The landmarks of photographs on it, in the network's order.
    pub fn landmarks(&self) -> &[HeadLandmark] {
        &self.landmarks
    }

    /// The distance between the eyes, in the mesh's unit.
    pub fn unit(&self) -> f64 {
        self.anatomy.frame().unit
    }

    /// The vertices' positions.
    pub(crate) fn positions(&self) -> Vec<DVec3> {
        self.mesh.positions().iter().map(wide).collect()
    }

    /// The head as it is drawn for networks.
    pub(crate) fn drawing(&self) -> Drawing<'_> {
        Drawing::new(&self.mesh, &self.anatomy, &self.components, self.texture.as_ref())
    }

    /// The landmarks as they are found when the head is drawn in the place of that in a photograph;
    /// `None` if no face is found in the drawing.
    ///
    /// Networks put landmarks at slightly other places from every side and in every light; those of
    /// a drawing with the same are those of the photograph.
    pub(crate) fn landmarks_in(
        &self,
        drawing: &Drawing<'_>,
        camera: &Camera,
        photo: &Pixels<'_>,
    ) -> Option<Vec<HeadLandmark>> {
        let detect = &*self.detector.0;
        head_landmarks::in_photograph(drawing, camera, photo, &self.landmarks, detect)
    }

    /// Where landmarks are on the head with vertices at other positions.
    pub(crate) fn points_of(&self, landmarks: &[HeadLandmark], positions: &[DVec3]) -> Vec<DVec3> {
        points_of(&self.mesh, landmarks, positions)
    }
}

fn wide(position: &[f32; 3]) -> DVec3 {
    glam::Vec3::from(*position).as_dvec3()
}

fn points_of(mesh: &Mesh, landmarks: &[HeadLandmark], positions: &[DVec3]) -> Vec<DVec3> {
    let point = |landmark: &HeadLandmark| {
        let corners = mesh.faces()[landmark.at.face as usize];
        (0..3).map(|k| positions[corners[k] as usize] * landmark.at.weights[k]).sum()
    };
    landmarks.iter().map(point).collect()
}
