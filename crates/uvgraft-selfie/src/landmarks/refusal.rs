//! Which photographs are refused, and why.

use super::{FaceLandmarks, FoundFace};

/// A face must be at least so many pixels across: texture from a smaller one is a blur, and its
/// landmarks are off by more than a hundredth of it.
pub const LEAST_SIZE: f64 = 64.0;

/// Least score of the landmark network in its second crop. It was above 0.99 for every face that a
/// texture could be made of, down to 19 pixels.
pub const LEAST_SCORE: f64 = 0.9;

/// Most of a face may not be flat. It was at most 0.01 in photographs, also in grey ones and in JPEGs of
/// quality 30, and at least 0.6 in drawings with areas of one colour, also as such JPEGs. Both networks
/// are as certain of drawings as of photographs.
pub const MOST_FLAT: f64 = 0.3;

/// A face may be turned by at most so many degrees to a side, as [`FaceLandmarks::yaw`] measures it:
/// beyond, half of it is not seen, and the network makes the other half up. The network flattens depth,
/// so this is further than it sounds; a face from the side is usually not found at all.
pub const MOST_TURNED: f64 = 40.0;

/// Which face of a photograph is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FaceChoice {
    /// The only one; more are refused.
    #[default]
    Only,
    /// The largest one.
    Largest,
    /// By number from 1, the largest first.
    Number(usize),
}

/// Why a photograph was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaceError {
    /// No face was found.
    #[error("no face found; the photograph must show one from the front")]
    None,
    /// Several faces were found and none was chosen.
    #[error(
        "the photograph must show one face, got {count}; choose one by its number, 1 is the largest"
    )]
    Several {
        /// How many.
        count: usize,
    },
    /// The chosen face does not exist.
    #[error("the number of a face must be 1 to {count}, got {number}")]
    Number {
        /// What was chosen.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// The face is too small.
    #[error("the face must be at least {LEAST_SIZE} pixels wide, got {found:.0}")]
    TooSmall {
        /// Its size in pixels.
        found: f64,
    },
    /// The landmark network does not recognise a face: the back of a head, or something that
    /// hides it.
    #[error(
        "the face is not recognisable: its score must be at least {LEAST_SCORE}, got {found:.2}; it may \
         be hidden or turned away"
    )]
    Unclear {
        /// Its score.
        found: f64,
    },
    /// The face is drawn.
    #[error(
        "must be a photograph, got a drawing: {:.0} % of the face has areas of a single colour",
        flat_part * 100.0
    )]
    Drawing {
        /// The flat part of the face, `0.0..=1.0`.
        flat_part: f64,
    },
    /// The face is seen from the side.
    #[error("the face must be turned by at most {MOST_TURNED}° to the side, got {degrees:.0}°")]
    Turned {
        /// How far.
        degrees: f64,
    },
}

/// The index of the face that is meant, of those found, the largest of which comes first.
///
/// # Errors
/// [`FaceError`] if there is none, if there are several without a choice, or if it is too small.
pub fn choose(faces: &[FoundFace], choice: FaceChoice) -> Result<usize, FaceError> {
    let count = faces.len();
    let index = match choice {
        _ if count == 0 => return Err(FaceError::None),
        FaceChoice::Only if count > 1 => return Err(FaceError::Several { count }),
        FaceChoice::Only | FaceChoice::Largest => 0,
        FaceChoice::Number(number) => number
            .checked_sub(1)
            .filter(|&index| index < count)
            .ok_or(FaceError::Number { number, count })?,
    };
    let found = faces[index].size();
    if found < LEAST_SIZE {
        return Err(FaceError::TooSmall { found });
    }
    Ok(index)
}

/// Refuses landmarks that cannot be relied on.
///
/// # Errors
/// [`FaceError::Unclear`], [`FaceError::Drawing`], [`FaceError::Turned`]
pub fn check(landmarks: &FaceLandmarks) -> Result<(), FaceError> {
    if landmarks.score.is_nan() || landmarks.score < LEAST_SCORE {
        return Err(FaceError::Unclear { found: landmarks.score });
    }
    if landmarks.flat_part > MOST_FLAT {
        return Err(FaceError::Drawing { flat_part: landmarks.flat_part });
    }
    let degrees = landmarks.yaw().to_degrees().abs();
    if degrees > MOST_TURNED {
        return Err(FaceError::Turned { degrees });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(size: f64) -> FoundFace {
        FoundFace {
            score: 0.9,
            center: [100.0; 2],
            box_size: [size; 2],
            angle: 0.0,
            keypoints: [[0.0; 2]; 6],
        }
    }

    #[test]
    fn one_large_face_is_meant_unless_another_is_chosen() {
        let (one, many) = ([face(90.0)], [face(90.0), face(80.0), face(40.0)]);
        let size = |faces: &[FoundFace], choice| {
            choose(faces, choice)
                .map(|index| faces[index].size())
                .map_err(|error| error.to_string())
        };
        assert_eq!(size(&one, FaceChoice::Only), Ok(90.0));
        assert_eq!(size(&many, FaceChoice::Largest), Ok(90.0));
        assert_eq!(size(&many, FaceChoice::Number(2)), Ok(80.0));
        let refused = |faces: &[FoundFace], choice| size(faces, choice).unwrap_err();
        assert!(refused(&[], FaceChoice::Largest).contains("no face found"));
        assert!(refused(&many, FaceChoice::Only).contains("must show one face, got 3"));
        assert!(refused(&many, FaceChoice::Number(4)).contains("must be 1 to 3, got 4"));
        assert!(refused(&many, FaceChoice::Number(0)).contains("must be 1 to 3, got 0"));
        assert!(refused(&many, FaceChoice::Number(3)).contains("at least 64 pixels wide, got 40"));
    }
}
