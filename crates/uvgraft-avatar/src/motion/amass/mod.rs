//! Motions in AMASS's format.
//!
//! # Source
//! Mahmood et al., "AMASS: Archive of Motion Capture as Surface Shapes", 2019, and its files: Z up,
//! the root's rotation vector first, hands with their mean pose included. Other tools write the
//! same with other axes up, without translations, or with some other names.

mod rate;
#[cfg(test)]
mod tests;
mod turns;

use uvgraft_io::arrays::{ArraysError, NamedArrays};

use self::turns::{Turns, rows};
use super::MotionError;
use crate::body::{BodyKind, Gender, JointEntry};

/// Upper limit of the number of frames: half an hour at 120 frames a second.
const MAX_FRAMES: usize = 216_000;

/// Most metres that a body moves away, and most radians that a joint turns: beyond, poses lose their
/// precision and avatars are invalid.
const MAX_VALUE: f32 = 1e5;
/// Upper limit of the shape coefficients that are kept.
const MAX_BETAS: usize = 1000;

/// A recorded motion of a body of the SMPL family, with rotations and translations as in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    joints: Vec<JointEntry>,
    rate: f64,
    /// Whether the rate is not that of the file.
    is_rate_assumed: bool,
    /// `[frames][joints]` rotation vectors.
    turns: Vec<[f32; 3]>,
    /// `[frames]` translations of the body, in metres.
    translations: Vec<[f32; 3]>,
    /// Whether the file has translations.
    has_translations: bool,
    betas: Option<Vec<f32>>,
    gender: Option<Gender>,
    kind: Option<BodyKind>,
    unused: Vec<String>,
}

impl Motion {
    /// Builds a motion from the arrays of a file.
    ///
    /// - `poses` `[T, C]` or `[T, C / 3, 3]`: rotation vectors in radians, the root's first. `C` is 66
    ///   (a body), 72 (SMPL), 156 (SMPL-H) or 165 (SMPL-X), or 63 (a body without its root) along
    ///   with `root_orient` `[T, 3]`. Files without `poses` have its parts: `root_orient` or
    ///   `global_orient`, `pose_body` or `body_pose` `[T, 63]` (or 69, of SMPL), and optionally
    ///   `pose_hand` `[T, 90]` or `left_hand_pose` and `right_hand_pose` `[T, 45]`, `pose_jaw` or
    ///   `jaw_pose` `[T, 3]`, and `pose_eye` `[T, 6]` or `leye_pose` and `reye_pose` `[T, 3]`.
    /// - `mocap_framerate`, `mocap_frame_rate`, `mocap_fps`, `framerate`, `frame_rate` or `fps`:
    ///   frames a second.
    /// - Optional: `trans` or `transl` `[T, 3]`, metres; `betas`, of which the first row is used if
    ///   there is one for each frame; `gender`; and `surface_model_type`.
    ///
    /// All of them may be in a dict `smpl_params_global`.
    ///
    /// # Errors
    /// [`MotionError`] for arrays that are missing or have other shapes, values that are not
    /// finite or in degrees, an invalid frame rate, or more than 216,000 frames.
    pub fn from_arrays(arrays: &NamedArrays) -> Result<Self, MotionError> {
        Self::with_rate(arrays, None)
    }

    /// The same, for files that may lack a frame rate.
    ///
    /// - `rate`: frames a second of files that state none.
    ///
    /// # Errors
    /// As [`Motion::from_arrays`].
    pub fn with_rate(arrays: &NamedArrays, rate: Option<f64>) -> Result<Self, MotionError> {
        let arrays = &*turns::flat(arrays);
        let Turns { turns, joints, unused } = Turns::read(arrays)?;
        let frames = turns.len() / joints.len();
        if !(1..=MAX_FRAMES).contains(&frames) {
            return Err(MotionError::Frames { found: frames, most: MAX_FRAMES });
        }
        turns::check_radians(&turns, &joints)?;
        let stated = rate::stated(arrays)?;
        let is_rate_assumed = stated.is_none();
        let rate = stated.or(rate).ok_or_else(|| rate::missing(arrays))?;
        let trans = ["trans", "transl"].into_iter().find(|key| has_key(arrays, key));
        let translations = match trans {
            Some(key) => rows(arrays, key, Some(frames), 3)?.as_chunks::<3>().0.to_vec(),
            None => vec![[0.0; 3]; frames],
        };
        let betas = read_betas(arrays)?;
        let gender = Gender::from_arrays(arrays);
        let kind = read_kind(arrays, joints.len());
        let has_translations = trans.is_some();
        Ok(Self {
            joints,
            rate: rate::checked(rate)?,
            is_rate_assumed,
            turns,
            translations,
            has_translations,
            betas,
            gender,
            kind,
            unused,
        })
    }

    /// Number of frames.
    pub const fn frames(&self) -> usize {
        self.translations.len()
    }

    /// Frames a second.
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// Whether the file states no frame rate, so that it is the one that was given.
    pub const fn is_rate_assumed(&self) -> bool {
        self.is_rate_assumed
    }

    /// Arrays of the face and the hands that move something but are not part of the motion, each
    /// with its shape.
    pub fn unused(&self) -> &[String] {
        &self.unused
    }

    /// Duration from the first frame to the last, in seconds.
    pub fn seconds(&self) -> f64 {
        (self.frames() - 1) as f64 / self.rate
    }

    /// The names of its joints, in the order of the file.
    pub fn joint_names(&self) -> impl ExactSizeIterator<Item = &'static str> {
        self.joints.iter().map(|&(name, _, _)| name)
    }

    /// Shape coefficients of the performer, if the file has them.
    pub fn betas(&self) -> Option<&[f32]> {
        self.betas.as_deref()
    }

    /// The gender of the body model that the shape belongs to.
    pub const fn gender(&self) -> Option<Gender> {
        self.gender
    }

    /// The kind of body model that the shape belongs to, if the file states it or its
    /// joints imply it.
    pub const fn kind(&self) -> Option<BodyKind> {
        self.kind
    }

    /// Whether the body stays in place: the file has no translations, or only zeros.
    pub fn is_still(&self) -> bool {
        !self.has_translations || self.translations.iter().all(|shift| *shift == [0.0; 3])
    }

    pub(super) fn joints(&self) -> &[JointEntry] {
        &self.joints
    }

    /// The rotation vectors of a frame.
    pub(super) fn turns(&self, frame: usize) -> &[[f32; 3]] {
        &self.turns[frame * self.joints.len()..][..self.joints.len()]
    }

    /// The translation in a frame.
    pub(super) fn translation(&self, frame: usize) -> [f32; 3] {
        self.translations[frame]
    }
}

/// Whether a file has the array, readable or not.
fn has_key(arrays: &NamedArrays, key: &str) -> bool {
    !matches!(arrays.require(key), Err(ArraysError::Missing { .. }))
}

/// The performer's shape coefficients: a vector, or a row for each frame, of which the
/// first is used.
fn read_betas(arrays: &NamedArrays) -> Result<Option<Vec<f32>>, MotionError> {
    let Some(array) = arrays.get("betas") else { return Ok(None) };
    let row = array.shape().last().copied().unwrap_or(1);
    let betas: Vec<f32> = array.f32s().iter().copied().take(row.min(MAX_BETAS)).collect();
    check_values("betas", &betas, betas.len().max(1))?;
    Ok((!betas.is_empty()).then_some(betas))
}

/// Checks that the values of a table are those of a body.
fn check_values(key: &'static str, values: &[f32], columns: usize) -> Result<(), MotionError> {
    let at = |at: usize| (at / columns, at % columns, values[at]);
    if let Some((frame, column, found)) = values.iter().position(|it| !it.is_finite()).map(at) {
        return Err(MotionError::NotFinite { key, frame, column, found });
    }
    if let Some((frame, column, found)) = values.iter().position(|it| it.abs() > MAX_VALUE).map(at)
    {
        return Err(MotionError::TooLarge { key, frame, column, found, most: MAX_VALUE });
    }
    Ok(())
}

/// The kind of the performer's model: the one that the file names, or the one with this
/// number of joints.
fn read_kind(arrays: &NamedArrays, joints: usize) -> Option<BodyKind> {
    let named = arrays.text("surface_model_type").and_then(|text| {
        let text = text.to_lowercase();
        // Also matches `smplx_locked_head`; longer names come before their prefixes.
        [("smplx", BodyKind::SmplX), ("smplh", BodyKind::SmplH), ("smpl", BodyKind::Smpl)]
            .into_iter()
            .find(|(name, _)| text.contains(name))
    });
    named.map(|(_, kind)| kind).or_else(|| BodyKind::with_joints(joints))
}
