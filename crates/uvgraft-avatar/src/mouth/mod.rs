//! A mouth for heads that are open between the lips: a cavity, upper and lower teeth
//! with gums, and a tongue.
//!
//! The heads of body models end in a loop of edges behind the lips, through which the background
//! shows. The loop is found on the mesh by geometry, and everything is fitted to it: the walls
//! continue from the lips' own vertices, so no gap opens however the lips move. All parts are built
//! in head coordinates, in millimetres of a face whose eyes are 64 mm apart, and scaled with the
//! face.
//!
//! The walls follow the lips near the rim, and skull or jaw farther in. The upper teeth follow the
//! skull, the lower teeth and the tongue the jaw: by its joint and, in morphs, by the rigid motion
//! of the chin.

mod attach;
mod cavity;
mod frame;
mod motion;
mod paint;
mod piece;
mod rim;
mod teeth;
#[cfg(test)]
mod tests;
mod tongue;

use uvgraft::{Anatomy, AnatomyError, MeshError, Texture};

use self::attach::MouthJoints;
use self::frame::Frame;
use self::motion::Jaw;
use self::piece::{Chart, Piece};
use self::rim::Rim;
use crate::Avatar;
use crate::atlas::{ChartRect, FreeSpace};

/// Why an avatar gets no mouth.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MouthError {
    /// The mesh shows no head.
    #[error(transparent)]
    Head(#[from] AnatomyError),
    /// There are no lips, or no nose or chin to attach skull and jaw to.
    #[error("the face has no {0}")]
    Landmark(&'static str),
    /// The skinning weights around nose and chin do not give the mouth any.
    #[error("cannot compute skinning weights for the mouth")]
    Weights,
    /// The lips are one closed surface.
    #[error("the mesh has no opening between the lips")]
    Closed,
    /// The mesh has teeth or a tongue of its own.
    #[error("the mesh already has a mouth: {pieces} connected components behind the lips")]
    OwnMouth {
        /// Number of connected components behind the lips.
        pieces: usize,
    },
    /// The layout is full.
    #[error(
        "no free space in the UV layout for the mouth's {what}, which needs {wanted:.3} of its \
         width"
    )]
    NoRoom {
        /// The part.
        what: &'static str,
        /// The minimum width that it needs, in UV units.
        wanted: f32,
    },
    /// The mesh with the mouth added is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// A mouth, fitted to an avatar's lips.
#[derive(Debug, Clone)]
pub struct Mouth {
    frame: Frame,
    rim: Rim,
    jaw: Jaw,
    followers: MouthJoints,
    pieces: Vec<(Piece, ChartRect)>,
}

impl Mouth {
    /// Fits a mouth behind an avatar's lips.
    ///
    /// # Errors
    /// [`MouthError`] if the avatar has no open lips or already has a mouth, or if its layout has
    /// no room. The avatar remains usable without a mouth.
    pub fn fit(avatar: &Avatar) -> Result<Self, MouthError> {
        let anatomy = Anatomy::find(&avatar.mesh)?;
        let frame = Frame::new(&anatomy)?;
        let rim = Rim::find(&avatar.mesh, &anatomy, &frame)?;
        let frame = frame.raised(rim.line(&avatar.mesh, &frame));
        let followers = MouthJoints::find(avatar, &anatomy)?;
        let jaw = Jaw::find(avatar, &anatomy)?;
        let fit = cavity::Fit::new(avatar, &rim, &frame);
        let upper = teeth::Arch::upper(&fit);
        let lower = teeth::Arch::lower(&fit);
        let built = [
            upper.piece(Chart::Upper),
            lower.piece(Chart::Lower),
            tongue::piece(&fit),
            cavity::piece(&fit),
        ];
        let mut free = FreeSpace::of(&avatar.mesh);
        let mut pieces = Vec::with_capacity(built.len());
        for piece in built {
            let chart = piece.chart;
            let place = free.place(chart.aspect(), chart.widest(), chart.narrowest());
            let (what, wanted) = (chart.name(), chart.narrowest());
            pieces.push((piece, place.ok_or(MouthError::NoRoom { what, wanted })?));
        }
        Ok(Self { frame, rim, jaw, followers, pieces })
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.pieces.iter().map(|(piece, _)| piece.faces.len()).sum()
    }

    /// Joins it to the avatar that it was fitted to. The avatar's own vertices keep their indices.
    /// Triangles of the sack that some meshes have behind their lips are removed.
    ///
    /// # Errors
    /// [`MouthError::Mesh`] if there are more vertices than a mesh may have.
    pub fn attach(&self, avatar: Avatar) -> Result<Avatar, MouthError> {
        attach::attach(self, avatar)
    }

    /// Paints it into the avatar's texture, touching only the free space that it was given.
    ///
    /// - `avatar`: the avatar; the colours of its lips continue into the mouth.
    pub fn paint(&self, avatar: &Avatar, texture: &mut Texture) {
        let lips = paint::rim_colors(avatar, &self.rim, texture);
        for (piece, place) in &self.pieces {
            paint::paint(texture, place, |at| paint::color(piece.chart, at, &lips));
        }
    }
}
