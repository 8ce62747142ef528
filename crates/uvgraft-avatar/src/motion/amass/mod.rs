//! Motions in AMASS's format.
//!
//! # Source
//! Mahmood et al., "AMASS: Archive of Motion Capture as Surface Shapes", 2019, and its files: Z up,
//! the root's rotation vector first, hands with their mean pose included. Other tools write the
//! same with Y up, without translations, or with some other names.

#[cfg(test)]
mod tests;

use std::borrow::Cow;

use uvgraft_io::arrays::{ArraysError, NamedArrays, NumericArray};

use super::MotionError;
use crate::body::{BODY, BodyKind, Gender, JointEntry};

/// Upper limit of the number of frames: half an hour at 120 frames a second.
const MAX_FRAMES: usize = 216_000;

/// Most metres that a body moves away, and most radians that a joint turns: beyond, poses lose their
/// precision and avatars are invalid.
const MAX_VALUE: f32 = 1e5;
/// Upper limit of the frame rate, in frames a second.
const MAX_RATE: f64 = 10_000.0;
/// Upper limit of the shape coefficients that are kept.
const MAX_BETAS: usize = 1000;

/// A recorded motion of a body of the SMPL family, with rotations and translations as in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    joints: Vec<JointEntry>,
    rate: f64,
    /// `[frames][joints]` rotation vectors.
    turns: Vec<[f32; 3]>,
    /// `[frames]` translations of the body, in metres.
    translations: Vec<[f32; 3]>,
    /// Whether the file has translations.
    has_translations: bool,
    betas: Option<Vec<f32>>,
    gender: Option<Gender>,
    kind: Option<BodyKind>,
}

impl Motion {
    /// Builds a motion from the arrays of a file.
    ///
    /// - `poses` `[T, C]`: rotation vectors in radians, the root's first. `C` is 66 (a body), 72
    ///   (SMPL), 156 (SMPL-H) or 165 (SMPL-X), or 63 (a body without its root) along with
    ///   `root_orient` `[T, 3]`. Files without `poses` have its parts: `root_orient`, `pose_body`
    ///   `[T, 63]`, and optionally `pose_hand` `[T, 90]`, `pose_jaw` `[T, 3]` and `pose_eye`
    ///   `[T, 6]`.
    /// - `mocap_framerate`, `mocap_frame_rate` or `fps`: frames a second.
    /// - Optional: `trans` or `transl` `[T, 3]`, metres; `betas`, of which the first row is used if
    ///   there is one for each frame; `gender`; and `surface_model_type`.
    ///
    /// # Errors
    /// [`MotionError`] for arrays that are missing or have other shapes, values that are not
    /// finite, an invalid frame rate, or more than 216,000 frames.
    pub fn from_arrays(arrays: &NamedArrays) -> Result<Self, MotionError> {
        let rate = read_rate(arrays)?;
        let (turns, joints) = read_turns(arrays)?;
        let frames = turns.len() / joints.len();
        if !(1..=MAX_FRAMES).contains(&frames) {
            return Err(MotionError::Frames { found: frames, most: MAX_FRAMES });
        }
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
            joints: joints.to_vec(),
            rate,
            turns,
            translations,
            has_translations,
            betas,
            gender,
            kind,
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

fn read_rate(arrays: &NamedArrays) -> Result<f64, MotionError> {
    let names = ["mocap_framerate", "mocap_frame_rate", "fps"];
    let rate = names.into_iter().find_map(|name| Some((name, arrays.get(name)?)));
    let wanted = "`mocap_framerate`, `mocap_frame_rate` or `fps`";
    let (key, rate) = rate.ok_or_else(|| missing(arrays, wanted))?;
    let found = match rate.f64s().as_ref() {
        &[rate] => rate,
        _ => {
            let (found, wanted) = (rate.shape().to_vec(), "[1]".to_owned());
            return Err(MotionError::Shape { key, found, wanted });
        }
    };
    if found.is_finite() && found > 0.0 && found <= MAX_RATE {
        Ok(found)
    } else {
        Err(MotionError::Rate { found, most: MAX_RATE })
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

/// Rotation vectors of all frames, and the joints they belong to.
fn read_turns(arrays: &NamedArrays) -> Result<(Vec<[f32; 3]>, Vec<JointEntry>), MotionError> {
    let points = |values: &[f32]| values.as_chunks::<3>().0.to_vec();
    let poses = match arrays.require("poses") {
        Ok(poses) => poses,
        Err(ArraysError::Missing { .. }) => return read_parts(arrays),
        Err(error) => return Err(error.into()),
    };
    let &[frames, columns] = poses.shape() else {
        return Err(wrong_poses(poses));
    };
    let joints = match columns {
        63 | 66 => BODY.to_vec(),
        72 => BodyKind::Smpl.joints(),
        156 => BodyKind::SmplH.joints(),
        165 => BodyKind::SmplX.joints(),
        _ => return Err(wrong_poses(poses)),
    };
    let values = rows(arrays, "poses", None, columns)?;
    if columns != 63 {
        return Ok((points(&values), joints));
    }
    let roots = rows(arrays, "root_orient", Some(frames), 3)?;
    Ok((points(&side_by_side(&[(&roots, 3), (&values, 63)])), joints))
}

fn wrong_poses(poses: &NumericArray) -> MotionError {
    MotionError::Shape {
        key: "poses",
        found: poses.shape().to_vec(),
        wanted:
            "[frames, C] with C = 66, 72 (SMPL), 156 (SMPL-H) or 165 (SMPL-X), or C = 63 along \
                 with `root_orient`"
                .to_owned(),
    }
}

/// The same for a file with the parts of the poses.
fn read_parts(arrays: &NamedArrays) -> Result<(Vec<[f32; 3]>, Vec<JointEntry>), MotionError> {
    if arrays.get("root_orient").is_none() || arrays.get("pose_body").is_none() {
        return Err(missing(arrays, "`poses`, or `root_orient` and `pose_body`"));
    }
    let roots = rows(arrays, "root_orient", None, 3)?;
    let frames = Some(roots.len() / 3);
    let body = rows(arrays, "pose_body", frames, 63)?;
    let optional = |key, columns| match arrays.get(key) {
        Some(_) => rows(arrays, key, frames, columns).map(Some),
        None => Ok(None),
    };
    let [jaw, eyes, hands] =
        [optional("pose_jaw", 3)?, optional("pose_eye", 6)?, optional("pose_hand", 90)?];
    let (parts, joints): (Vec<(&[f32], usize)>, _) = match (&jaw, &eyes, &hands) {
        (Some(jaw), Some(eyes), Some(hands)) => (
            vec![(&roots, 3), (&body, 63), (jaw, 3), (eyes, 6), (hands, 90)],
            BodyKind::SmplX.joints(),
        ),
        (_, _, Some(hands)) => {
            (vec![(&roots, 3), (&body, 63), (hands, 90)], BodyKind::SmplH.joints())
        }
        _ => (vec![(&roots, 3), (&body, 63)], BODY.to_vec()),
    };
    Ok((side_by_side(&parts).as_chunks::<3>().0.to_vec(), joints))
}

/// Concatenates the columns of tables with equal numbers of rows; each comes with its
/// number of columns.
fn side_by_side(parts: &[(&[f32], usize)]) -> Vec<f32> {
    let rows = parts.first().map_or(0, |(values, columns)| values.len() / columns);
    let row =
        |row: usize| parts.iter().flat_map(move |(v, columns)| &v[row * columns..][..*columns]);
    (0..rows).flat_map(row).copied().collect()
}

/// A table of finite numbers with `columns` columns, and `frames` rows if that is known.
fn rows<'a>(
    arrays: &'a NamedArrays,
    key: &'static str,
    frames: Option<usize>,
    columns: usize,
) -> Result<Cow<'a, [f32]>, MotionError> {
    let array = arrays.require(key)?;
    let fits = match array.shape() {
        &[rows, found] => found == columns && frames.is_none_or(|frames| rows == frames),
        _ => false,
    };
    if !fits {
        let frames = frames.map_or("frames".to_owned(), |frames| frames.to_string());
        let wanted = format!("[{frames}, {columns}]");
        return Err(MotionError::Shape { key, found: array.shape().to_vec(), wanted });
    }
    // Checked before the conversion, so that no file makes it allocate more than a motion can need.
    let found = array.shape()[0];
    if found > MAX_FRAMES {
        return Err(MotionError::Frames { found, most: MAX_FRAMES });
    }
    let values = array.f32s();
    check_values(key, &values, columns)?;
    Ok(values)
}

fn missing(arrays: &NamedArrays, wanted: &'static str) -> MotionError {
    const MAX: usize = 40;
    let found = arrays.names().take(MAX).collect::<Vec<_>>().join(", ");
    MotionError::Missing { wanted, found }
}
