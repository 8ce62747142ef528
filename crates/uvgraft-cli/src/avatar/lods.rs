//! Options for coarser levels of detail.

use uvgraft_assembly::avatar::{LevelOptions, LevelStorage};
use uvgraft_gltf::preset::MAX_LEVELS;

use crate::choice::choice;
use crate::heading;
use crate::number::whole_number;

#[derive(clap::Args)]
#[command(next_help_heading = heading::LODS)]
pub(super) struct LodArgs {
    /// Number of additional levels, each with about half the triangles of the one before
    #[arg(long, value_name = "N", value_parser = whole_number::<u8>(1..=MAX_LEVELS as u64), allow_negative_numbers = true)]
    lods: Option<u8>,
    /// How to store the levels [default: files]
    #[arg(long, value_name = "STORAGE", value_parser = choice::<LevelStorage>(), requires = "lods")]
    lods_as: Option<LevelStorage>,
}

impl LodArgs {
    pub(super) fn options(&self) -> LevelOptions {
        let storage = self.lods_as.unwrap_or(LevelStorage::Files);
        LevelOptions { count: self.lods.unwrap_or(0), storage }
    }
}
