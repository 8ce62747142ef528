//! Options for mouth and eyes.

use uvgraft::Choice;
use uvgraft_assembly::avatar::{EyeStyle, MouthStyle};

use crate::choice::choice;
use crate::heading;

#[derive(clap::Args)]
#[command(next_help_heading = heading::FEATURES)]
pub(super) struct FeatureArgs {
    /// Interior of the mouth
    #[arg(long, value_name = "MOUTH", value_parser = choice::<MouthStyle>())]
    #[arg(default_value = MouthStyle::Fitted.name())]
    pub(super) mouth: MouthStyle,
    /// Appearance of the eyes
    ///
    /// Either way, each eye gets a UV island of its own in the texture.
    #[arg(long, value_name = "EYES", value_parser = choice::<EyeStyle>())]
    #[arg(default_value = EyeStyle::Keep.name())]
    pub(super) eyes: EyeStyle,
}
