//! The rotations of a file: in one array, or in parts by the names of AMASS or of `smplx`.

use std::borrow::Cow;
use std::f32::consts::TAU;

use glam::Vec3;
use uvgraft_io::arrays::{ArraysError, NamedArrays, NumericArray};

use super::super::MotionError;
use super::{MAX_FRAMES, check_values, has_key};
use crate::body::{BODY, BodyKind, JointEntry};

/// Rotation vectors of all frames.
pub(super) struct Turns {
    /// `[frames][joints]`.
    pub(super) turns: Vec<[f32; 3]>,
    pub(super) joints: Vec<JointEntry>,
    /// Arrays that move a face or hands and were not read, each with its shape.
    pub(super) unused: Vec<String>,
}

/// The names of a part of the poses: AMASS's and those of the Python package `smplx`, which may
/// have an array for each side.
struct Part {
    amass: &'static str,
    others: &'static [&'static str],
    columns: usize,
}

const ROOT: Part = Part { amass: "root_orient", others: &["global_orient"], columns: 3 };
const HANDS: Part =
    Part { amass: "pose_hand", others: &["left_hand_pose", "right_hand_pose"], columns: 90 };
const JAW: Part = Part { amass: "pose_jaw", others: &["jaw_pose"], columns: 3 };
const EYES: Part = Part { amass: "pose_eye", others: &["leye_pose", "reye_pose"], columns: 6 };
/// Facial expressions, which have no joints.
const EXPRESSIONS: [&str; 2] = ["expression", "expressions"];
/// Columns of a body without its root, and of SMPL's, which has ends of hands.
const BODY_COLUMNS: usize = 63;
const SMPL_COLUMNS: usize = 69;
/// Number of joints of a body and of its jaw and eyes.
const WITH_FACE: usize = 25;

/// The arrays of a motion without the name of the dict that GVHMR keeps them in: the one in the
/// world rather than in the camera.
pub(super) fn flat(arrays: &NamedArrays) -> Cow<'_, NamedArrays> {
    const DICT: &str = "smpl_params_global.";
    if !arrays.names().any(|name| name.starts_with(DICT)) {
        return Cow::Borrowed(arrays);
    }
    let mut flat = NamedArrays::new();
    for name in arrays.names() {
        let inner = name.strip_prefix(DICT).unwrap_or(name);
        if let Some(array) = arrays.get(name) {
            flat.insert(inner, array.clone());
        } else if let Some(text) = arrays.text(name) {
            flat.insert_text(inner, text);
        }
    }
    Cow::Owned(flat)
}

impl Turns {
    pub(super) fn read(arrays: &NamedArrays) -> Result<Self, MotionError> {
        match arrays.require("poses") {
            Ok(poses) => Self::whole(arrays, poses),
            Err(ArraysError::Missing { .. }) => Self::of_parts(arrays),
            Err(error) => Err(error.into()),
        }
    }

    /// From one array.
    fn whole(arrays: &NamedArrays, poses: &NumericArray) -> Result<Self, MotionError> {
        let (frames, columns) = table(poses).ok_or_else(|| wrong_poses(poses))?;
        let joints = match columns {
            BODY_COLUMNS | 66 => BODY.to_vec(),
            72 => BodyKind::Smpl.joints(),
            156 => BodyKind::SmplH.joints(),
            165 => BodyKind::SmplX.joints(),
            _ => return Err(wrong_poses(poses)),
        };
        let mut values = rows(arrays, "poses", None, columns)?;
        if columns == BODY_COLUMNS {
            let Some(root) = ROOT.read(arrays, Some(frames))? else {
                arrays.require(ROOT.amass)?;
                return Err(wrong_poses(poses));
            };
            values = side_by_side(&[(&root, 3), (&values, BODY_COLUMNS)]).into();
        }
        let turns = values.as_chunks::<3>().0.to_vec();
        Ok(Self { turns, unused: unused(arrays, columns >= 156, columns >= 165), joints })
    }

    /// From an array for each part.
    fn of_parts(arrays: &NamedArrays) -> Result<Self, MotionError> {
        let body_key = ["pose_body", "body_pose"].into_iter().find(|key| has_key(arrays, key));
        let (Some(body_key), Some(root)) = (body_key, ROOT.read(arrays, None)?) else {
            return Err(MotionError::Missing {
                wanted: "`poses`, or `root_orient` and `pose_body`, or `global_orient` and \
                         `body_pose`",
                found: arrays.listed(),
            });
        };
        let frames = Some(root.len() / 3);
        let has_ends =
            table(arrays.require(body_key)?).is_some_and(|(_, columns)| columns == SMPL_COLUMNS);
        let columns = if has_ends { SMPL_COLUMNS } else { BODY_COLUMNS };
        let body = rows(arrays, body_key, frames, columns)?;
        let [jaw, eyes, hands] =
            [JAW.read(arrays, frames)?, EYES.read(arrays, frames)?, HANDS.read(arrays, frames)?];
        let (has_face, has_hands) = (jaw.is_some() || eyes.is_some(), hands.is_some());
        let joints = match (has_face, has_hands) {
            (false, false) if has_ends => BodyKind::Smpl.joints(),
            (false, false) => BODY.to_vec(),
            (true, false) => BodyKind::SmplX.joints()[..WITH_FACE].to_vec(),
            (false, true) => BodyKind::SmplH.joints(),
            (true, true) => BodyKind::SmplX.joints(),
        };
        // Ends of hands are joints of bodies without fingers and faces only.
        let body: Cow<'_, [f32]> = if has_ends && joints.len() != BodyKind::Smpl.joint_count() {
            body.chunks_exact(columns).flat_map(|row| &row[..BODY_COLUMNS]).copied().collect()
        } else {
            body
        };
        let body_columns = body.len() / (root.len() / 3).max(1);
        let at_rest = |columns: usize| Cow::Owned(vec![0.0; root.len() / 3 * columns]);
        let mut parts = vec![(root.clone(), 3), (body, body_columns)];
        if has_face {
            parts.push((jaw.unwrap_or_else(|| at_rest(3)), 3));
            parts.push((eyes.unwrap_or_else(|| at_rest(6)), 6));
        }
        parts.extend(hands.map(|hands| (hands, 90)));
        let parts: Vec<(&[f32], usize)> =
            parts.iter().map(|(values, columns)| (&**values, *columns)).collect();
        let turns = side_by_side(&parts).as_chunks::<3>().0.to_vec();
        Ok(Self { turns, joints, unused: unused(arrays, has_hands, has_face) })
    }
}

impl Part {
    /// The part, if the file has it in a form that can be read.
    ///
    /// Coefficients of hands' principal components, of which there are fewer, are not.
    fn read<'a>(
        &self,
        arrays: &'a NamedArrays,
        frames: Option<usize>,
    ) -> Result<Option<Cow<'a, [f32]>>, MotionError> {
        if has_key(arrays, self.amass) {
            return rows(arrays, self.amass, frames, self.columns).map(Some);
        }
        let columns = self.columns / self.others.len();
        let fits =
            |key: &&str| arrays.get(key).and_then(table).is_some_and(|(_, found)| found == columns);
        if !self.others.iter().all(fits) {
            return Ok(None);
        }
        let sides = self.others.iter().map(|&key| rows(arrays, key, frames, columns));
        let sides = sides.collect::<Result<Vec<_>, _>>()?;
        if let [one] = &*sides {
            return Ok(Some(one.clone()));
        }
        let first = sides.first().map_or(0, |side| side.len());
        if sides.iter().any(|side| side.len() != first) {
            return Ok(None);
        }
        let sides: Vec<(&[f32], usize)> = sides.iter().map(|side| (&**side, columns)).collect();
        Ok(Some(side_by_side(&sides).into()))
    }

    fn keys(&self) -> impl Iterator<Item = &'static str> {
        [self.amass].into_iter().chain(self.others.iter().copied())
    }
}

/// Arrays that move something, but were not read.
fn unused(arrays: &NamedArrays, has_hands: bool, has_face: bool) -> Vec<String> {
    let hands = HANDS.keys().filter(|_| !has_hands);
    let face = JAW.keys().chain(EYES.keys()).filter(|_| !has_face);
    let moving = |key: &'static str| {
        let array = arrays.get(key)?;
        let moves = array.f32s().iter().any(|&value| value != 0.0);
        moves.then(|| format!("{key} {:?}", array.shape()))
    };
    EXPRESSIONS.into_iter().chain(hands).chain(face).filter_map(moving).collect()
}

/// Rejects rotations in degrees.
///
/// Rotation vectors of up to a half turn say everything. Some tools do not wrap them: a joint may
/// exceed a full turn for some frames, and the root of a body that spins may do for long, but it
/// starts within one. In degrees, the knees and shoulders of a body that stands or walks are
/// beyond 6.28 in a tenth of all values or more.
pub(super) fn check_radians(turns: &[[f32; 3]], joints: &[JointEntry]) -> Result<(), MotionError> {
    const MOST_BEYOND: f32 = 0.02;
    let lengths = turns.iter().map(|&turn| Vec3::from(turn).length());
    let mut beyond = 0;
    let mut largest = (0, 0.0);
    let mut largest_root = (0, 0.0_f32);
    for (at, length) in lengths.enumerate() {
        let is_root = at % joints.len() == 0;
        let largest = if is_root { &mut largest_root } else { &mut largest };
        if length > largest.1 {
            *largest = (at, length);
        }
        beyond += usize::from(!is_root && length > TAU);
    }
    let others = turns.len() - turns.len() / joints.len();
    let first_root = Vec3::from(turns[0]).length();
    let (at, found) = if beyond as f32 > MOST_BEYOND * others as f32 {
        largest
    } else if first_root > TAU {
        largest_root
    } else {
        return Ok(());
    };
    let (frame, joint) = (at / joints.len(), joints[at % joints.len()].0);
    Err(MotionError::Degrees { found, frame, joint })
}

fn wrong_poses(poses: &NumericArray) -> MotionError {
    let found = poses.shape().to_vec();
    let columns: usize = found.iter().skip(1).product();
    let are_matrices =
        found.ends_with(&[3, 3]) || [22, 24, 52, 55].iter().any(|joints| joints * 9 == columns);
    MotionError::Shape {
        key: "poses",
        found,
        wanted: format!(
            "[frames, C] with C = 66, 72 (SMPL), 156 (SMPL-H) or 165 (SMPL-X), or C = 63 along \
             with `root_orient`{}",
            if are_matrices { "; rotations must be rotation vectors, not matrices" } else { "" }
        ),
    }
}

/// Rows and columns of a table, whose columns may be rows of three.
fn table(array: &NumericArray) -> Option<(usize, usize)> {
    match *array.shape() {
        [rows, columns] => Some((rows, columns)),
        [rows, joints, 3] => Some((rows, joints.checked_mul(3)?)),
        _ => None,
    }
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
pub(super) fn rows<'a>(
    arrays: &'a NamedArrays,
    key: &'static str,
    frames: Option<usize>,
    columns: usize,
) -> Result<Cow<'a, [f32]>, MotionError> {
    let array = arrays.require(key)?;
    let fits = table(array)
        .filter(|&(rows, found)| found == columns && frames.is_none_or(|frames| rows == frames));
    let Some((found, _)) = fits else {
        let frames = frames.map_or("frames".to_owned(), |frames| frames.to_string());
        let wanted = format!("[{frames}, {columns}]");
        return Err(MotionError::Shape { key, found: array.shape().to_vec(), wanted });
    };
    // Checked before the conversion, so that no file makes it allocate more than a motion can need.
    if found > MAX_FRAMES {
        return Err(MotionError::Frames { found, most: MAX_FRAMES });
    }
    let values = array.f32s();
    check_values(key, &values, columns)?;
    Ok(values)
}
