//! Errors of tracked folders.

use crate::arrays::ArraysError;
use uvgraft_files::input::ReadError;
use uvgraft_image::ImageError;

/// Why the output of a head tracker was rejected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrackingError {
    /// The folder is of none of the trackers.
    #[error(
        "must be a folder of VHAP (transforms.json with `flame_param_path`), metrical-tracker \
         (checkpoint/*.frame), INSTA (transforms.json with `exp_path`) or IMavatar \
         (flame_params.json)"
    )]
    Unknown,
    /// VHAP's own output refers to images elsewhere.
    #[error(
        "the folder has VHAP's parameters ({found}) without images and cameras; export it with \
         `python vhap/export_as_nerf_dataset.py --src_folder FOLDER --tgt_folder EXPORT` and use \
         EXPORT"
    )]
    NotExported {
        /// The file of parameters.
        found: String,
    },
    /// A JSON file that is damaged, or lacks an entry.
    #[error("must be the JSON of {wanted}: {reason}")]
    Json {
        /// What the file must hold.
        wanted: &'static str,
        /// What is wrong, with line and column.
        reason: String,
    },
    /// A file of arrays that is damaged, or lacks an array.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// A value that no camera or head has.
    #[error("{frame}`{name}` must be {wanted}, got {found}")]
    Value {
        /// `frame N: `, or empty for values of the whole file.
        frame: String,
        /// Which value.
        name: &'static str,
        /// What it must be.
        wanted: String,
        /// What it is, shortened.
        found: String,
    },
    /// A path that leads elsewhere.
    #[error("frame {frame}: `{name}` must be a relative path within {within}, got `{found}`")]
    Path {
        /// Position of the frame in the file.
        frame: usize,
        /// Which path.
        name: &'static str,
        /// The folder that it may not leave.
        within: &'static str,
        /// The path, shortened.
        found: String,
    },
    /// More than any recording has.
    #[error("must have at most {most} {what}, got {found}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The limit.
        most: usize,
        /// How many there are.
        found: usize,
    },
    /// Nothing was tracked.
    #[error("must have at least one tracked frame")]
    NoFrames,
    /// The header of an image, of whose size a camera depends.
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// Why a tracked folder was not read; names the file.
pub type ReadTrackingError = ReadError<TrackingError>;

impl TrackingError {
    pub(super) fn value(
        name: &'static str,
        wanted: impl Into<String>,
        found: impl std::fmt::Display,
    ) -> Self {
        let mut found = found.to_string();
        if found.chars().count() > MAX_SHOWN {
            found = found.chars().take(MAX_SHOWN).collect::<String>() + "…";
        }
        Self::Value { frame: String::new(), name, wanted: wanted.into(), found }
    }

    /// The same error with the position of its frame.
    pub(super) fn in_frame(self, index: usize) -> Self {
        match self {
            Self::Value { name, wanted, found, .. } => {
                Self::Value { frame: format!("frame {index}: "), name, wanted, found }
            }
            error => error,
        }
    }
}

/// Characters of a value that an error shows.
const MAX_SHOWN: usize = 120;
