//! Landmarks and areas of a human head, detected from geometry alone.
//!
//! [`Anatomy::find`] takes a head, a bust or a whole body in any unit and orientation. It
//! needs no vertex indices and no training data: eyeballs (or the mesh's symmetry and the
//! profile of a face, of the whole or of the skin alone) give a coordinate frame, a depth map of the face gives the landmarks,
//! and areas are functions of position, normal and component in that frame.

mod areas;
mod body;
mod eyes;
mod frame;
mod landmarks;
mod points;
mod profile;
mod relief;
mod search;
mod symmetry;
#[cfg(test)]
mod tests;

pub use self::frame::HeadFrame;

use glam::DVec3;

use self::areas::Areas;
use self::landmarks::Face;
use self::points::Points;
use self::search::Head;
use crate::mesh::Mesh;

/// A landmark of the head. Left and right are the person's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Landmark {
    /// Centre of the left eyeball.
    LeftEye,
    /// Centre of the right eyeball.
    RightEye,
    /// Foremost point of the nose (pronasale).
    NoseTip,
    /// Where the nose meets the upper lip (subnasale).
    NoseBase,
    /// Centre of the line between the lips (stomion).
    Mouth,
    /// Left end of the line between the lips.
    LeftMouthCorner,
    /// Right end of the line between the lips.
    RightMouthCorner,
    /// Foremost point of the chin (pogonion).
    Chin,
    /// Between the brows (glabella).
    BrowCenter,
    /// Highest point of the head on the midline (vertex).
    Crown,
    /// Outermost point of the left ear.
    LeftEar,
    /// Outermost point of the right ear.
    RightEar,
    /// Hollow of the neck between the collar bones, or the neck's lowest point if the mesh ends
    /// above them.
    NeckBase,
}

impl Landmark {
    /// What it is called in messages.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::LeftEye => "left eye",
            Self::RightEye => "right eye",
            Self::NoseTip => "tip of the nose",
            Self::NoseBase => "base of the nose",
            Self::Mouth => "mouth",
            Self::LeftMouthCorner => "left corner of the mouth",
            Self::RightMouthCorner => "right corner of the mouth",
            Self::Chin => "chin",
            Self::BrowCenter => "point between the brows",
            Self::Crown => "crown",
            Self::LeftEar => "left ear",
            Self::RightEar => "right ear",
            Self::NeckBase => "base of the neck",
        }
    }
}

/// An area of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Area {
    /// Plain skin next to the nose, above the line of beard and moustache.
    Cheeks,
    /// Between brows and hairline.
    Forehead,
    /// Bridge and tip of the nose, without the nostrils.
    Nose,
    /// Chin and lower jaw.
    Jaw,
    /// Both lips.
    Lips,
    /// Everything behind the lips: cavity, teeth, tongue.
    MouthInterior,
    /// Eyeballs and the inside of the lids.
    Eyes,
    /// Lids and the skin around them.
    EyeSockets,
    /// A band above the eyes.
    Brows,
    /// Both ears.
    Ears,
    /// Where hair usually grows, nape and behind the ears included.
    Scalp,
    /// From the line of the jaw down to the collar bones.
    Neck,
    /// Upper chest and front of the shoulders; only on meshes that extend below the neck.
    Chest,
    /// Hands, from the wrists; whole bodies only.
    Hands,
    /// Feet, from the ankles down; whole bodies only.
    Feet,
}

impl Area {
    /// All areas, in order of declaration.
    pub const ALL: [Self; 15] = [
        Self::Cheeks,
        Self::Forehead,
        Self::Nose,
        Self::Jaw,
        Self::Lips,
        Self::MouthInterior,
        Self::Eyes,
        Self::EyeSockets,
        Self::Brows,
        Self::Ears,
        Self::Scalp,
        Self::Neck,
        Self::Chest,
        Self::Hands,
        Self::Feet,
    ];
}

/// Why no head was detected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnatomyError {
    /// Too few distinct points, or all of them coincide.
    #[error("a head must have at least {needed} distinct points that span a volume, got {found}")]
    TooCoarse {
        /// Number of distinct points or non-degenerate triangles, whichever is less.
        found: usize,
        /// Least number required.
        needed: usize,
    },
    /// The mesh has neither a pair of eyeballs nor a symmetry plane.
    #[error(
        "mesh has neither a pair of eyeballs nor a symmetry plane: at best {:.0} % of it is \
         symmetric, must be at least {:.0} %", found * 100.0, needed * 100.0
    )]
    NoSymmetry {
        /// Fraction of points that have a mirror image, `0.0..=1.0`.
        found: f64,
        /// Least fraction accepted.
        needed: f64,
    },
    /// The mesh is symmetric, but no part of its outline matches the profile of a face.
    #[error("mesh has no face: {reason}")]
    NoFace {
        /// What is missing.
        reason: &'static str,
    },
}

/// A component of a mesh that is a sphere, or a cap of one: usually an eyeball.
#[derive(Debug, Clone)]
pub(crate) struct Ball {
    pub center: DVec3,
    pub radius: f64,
    pub faces: Vec<u32>,
}

/// The components of a mesh that are spheres and small; most points first.
pub(crate) fn balls(mesh: &Mesh) -> Vec<Ball> {
    let Ok(points) = Points::new(mesh) else { return Vec::new() };
    let found = eyes::balls(&points);
    let mut balls: Vec<Ball> = found
        .iter()
        .map(|ball| Ball {
            center: ball.sphere.center,
            radius: ball.sphere.radius,
            faces: Vec::new(),
        })
        .collect();
    for (face, &[vertex, ..]) in (0..).zip(mesh.faces()) {
        let component = points.component_of(vertex);
        if let Some(ball) = found.iter().position(|ball| ball.component == component) {
            balls[ball].faces.push(face);
        }
    }
    balls
}

/// The landmarks and areas of a mesh's head.
#[derive(Debug, Clone)]
pub struct Anatomy {
    frame: HeadFrame,
    landmarks: [Option<[f64; 3]>; 13],
    areas: Vec<Vec<f32>>,
    is_skin: Vec<bool>,
}

impl Anatomy {
    /// Detects the head of a mesh: a head alone, a bust or a body, with or without eyeballs, hair
    /// and clothes, in any unit and orientation. Vertices at the same position are merged.
    ///
    /// The result depends on shape alone, not on the order of vertices, UVs or names of parts.
    ///
    /// # Errors
    /// [`AnatomyError`] if the mesh is too coarse or no face is detected.
    pub fn find(mesh: &Mesh) -> Result<Self, AnatomyError> {
        let points = Points::new(mesh)?;
        let Head { frame, eyes, relief } = search::head(&points)?;
        let face = Face::new(&points, &frame, &eyes, &relief);
        let areas = Areas { points: &points, face: &face, relief: &relief };
        let areas = areas.all().into_iter().map(|area| points.to_vertices(&area)).collect();
        let is_skin = (0..mesh.positions().len() as u32)
            .map(|vertex| points.component_of(vertex) == face.eyes.skin)
            .collect();
        let landmarks =
            face.landmarks().map(|point| point.map(|local| frame.world(local.to_array())));
        Ok(Self { frame, landmarks, areas, is_skin })
    }

    /// The head's coordinate frame.
    pub fn frame(&self) -> &HeadFrame {
        &self.frame
    }

    /// The position of a landmark in the mesh's space; `None` if the mesh lacks it.
    pub fn point(&self, landmark: Landmark) -> Option<[f64; 3]> {
        self.landmarks[landmark as usize]
    }

    /// `[vertices]`: whether each vertex is connected with the skin of the face.
    pub(crate) fn skin(&self) -> &[bool] {
        &self.is_skin
    }

    /// `[vertices]`: each vertex's weight for an area, `0.0..=1.0`, soft at the area's edges.
    /// All zero if the mesh lacks the area.
    pub fn area(&self, area: Area) -> &[f32] {
        &self.areas[area as usize]
    }
}
