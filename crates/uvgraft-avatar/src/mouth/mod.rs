//! A mouth for heads that are open between the lips: a cavity, upper and lower teeth with gums, and a tongue.
//!
//! Body models end in a loop of edges behind the lips, and what is behind the head shows through it. The loop is
//! found on the mesh by geometry, and everything is fitted to it: walls go on from the lips' own
//! vertices, so that nothing opens whatever lips do. All of it lies in the head's coordinates, in millimetres of a
//! face whose eyes are 64 mm apart, and is scaled with the face.
//!
//! Walls follow the lips near the rim and skull or jaw farther in; upper teeth follow the skull, lower teeth and
//! tongue the jaw, by its joint and, in morphs, by the rigid motion that the chin shows.

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

use self::attach::Followers;
use self::frame::Frame;
use self::motion::Jaw;
use self::piece::{Chart, Piece};
use self::rim::Rim;
use crate::Avatar;
use crate::atlas::{FreeSpace, Place};

/// Why an avatar gets no mouth.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MouthError {
    /// The mesh shows no head.
    #[error(transparent)]
    Head(#[from] AnatomyError),
    /// No lips, or nothing that the jaw could be told by.
    #[error("the face has no {0}")]
    Landmark(&'static str),
    /// Lips that are one closed sheet.
    #[error("the mesh has no opening between the lips")]
    Closed,
    /// There are teeth or a tongue.
    #[error("the mesh already has a mouth: {pieces} pieces behind the lips")]
    OwnMouth {
        /// How many pieces.
        pieces: usize,
    },
    /// The layout is full.
    #[error(
        "no free space in the UV layout for the mouth's {what}, which needs {wanted:.3} of its \
         width"
    )]
    NoRoom {
        /// Which part.
        what: &'static str,
        /// The least that it takes, in UV units.
        wanted: f32,
    },
    /// Numbers that are beyond the mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// A mouth, fitted to one avatar's lips.
#[derive(Debug, Clone)]
pub struct Mouth {
    frame: Frame,
    rim: Rim,
    jaw: Jaw,
    followers: Followers,
    pieces: Vec<(Piece, Place)>,
}

impl Mouth {
    /// Fits a mouth behind an avatar's lips.
    ///
    /// # Errors
    /// [`MouthError`] where the avatar has no open lips, or no room in its layout. The avatar is as good without a
    /// mouth as it was.
    pub fn fit(avatar: &Avatar) -> Result<Self, MouthError> {
        let anatomy = Anatomy::find(&avatar.mesh)?;
        let frame = Frame::new(&anatomy)?;
        let rim = Rim::find(&avatar.mesh, &anatomy, &frame)?;
        let frame = frame.raised(rim.line(&avatar.mesh, &frame));
        let followers = Followers::find(avatar, &anatomy)?;
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

    /// How many triangles it has.
    pub fn triangles(&self) -> usize {
        self.pieces.iter().map(|(piece, _)| piece.faces.len()).sum()
    }

    /// Joins it to the avatar that it was fitted to. The avatar's own vertices keep their numbers; the sack that
    /// some meshes have behind their lips loses its triangles.
    ///
    /// # Errors
    /// [`MouthError::Mesh`] if there are more vertices than a mesh takes.
    pub fn attach(&self, avatar: Avatar) -> Result<Avatar, MouthError> {
        attach::attach(self, avatar)
    }

    /// Paints it into the avatar's texture: in the free space that it was given, and nowhere else.
    ///
    /// - `avatar`: the avatar, whose lips say what the mouth begins with.
    pub fn paint(&self, avatar: &Avatar, texture: &mut Texture) {
        let lips = paint::rim_colors(avatar, &self.rim, texture);
        for (piece, place) in &self.pieces {
            paint::paint(texture, place, |at| paint::color(piece.chart, at, &lips));
        }
    }
}
