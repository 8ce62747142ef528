//! Options for playing recordings.

use std::path::PathBuf;

use uvgraft_assembly::Input;
use uvgraft_assembly::avatar::MotionOptions;
use uvgraft_avatar::motion::{GroundMode, UpAxis};

use crate::choice::choice;
use crate::heading;
use crate::number::whole_number;

#[derive(clap::Args)]
#[command(next_help_heading = heading::ANIMATION)]
pub(super) struct PlayArgs {
    /// AMASS recording to add as an animation (.npz); repeatable
    ///
    /// Recordings replace the demo figure's own animations.
    #[arg(long, value_name = "AMASS.npz")]
    motion: Vec<PathBuf>,
    /// Frame rate of the animations, 0 for that of the recording [default: 30]
    ///
    /// Also the frame rate of recordings that state none.
    #[arg(long, value_name = "N", requires = "motion", value_parser = whole_number::<u16>(0..=240), allow_negative_numbers = true)]
    fps: Option<u16>,
    /// Ground contact of the animations [default: clip]
    ///
    /// `clip` and `feet` scale the path by leg length, keep planted feet planted, and start at the
    /// origin, facing forward. `keep` leaves translations as recorded.
    #[arg(long, value_name = "GROUND", requires = "motion", value_parser = choice::<GroundMode>())]
    ground: Option<GroundMode>,
    /// Up axis of the recordings [default: detected from the motion]
    #[arg(long, value_name = "AXIS", requires = "motion", value_parser = choice::<UpAxis>())]
    #[arg(allow_hyphen_values = true)]
    up: Option<UpAxis>,
}

impl PlayArgs {
    pub(super) fn options(&self) -> MotionOptions {
        let recordings = self.motion.iter().map(Input::from).collect();
        MotionOptions { recordings, fps: self.fps, ground: self.ground, up: self.up }
    }
}
