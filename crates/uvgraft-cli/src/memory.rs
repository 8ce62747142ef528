//! The bound on memory of commands that hold whole pictures: what they need is estimated from headers, and
//! refused before any work.

use uvgraft::Depth;
use uvgraft_files::input::Input;
use uvgraft_image::Header;
use uvgraft_pipeline::{check_memory, decoded_bytes, parse_memory};

use crate::heading;

/// The option of such commands.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = heading::LIMITS)]
pub(crate) struct MemoryOption {
    /// Bound on memory, such as 500M or 12G; what could exceed it is refused
    #[arg(long, value_name = "SIZE", value_parser = parse_memory, allow_negative_numbers = true)]
    // Enough for two textures of 8192² in any format, and less than the machines of most people have.
    #[arg(default_value = "6G")]
    memory: u64,
}

impl MemoryOption {
    /// Refuses work that could exceed the bound.
    ///
    /// - `work`: such as "the comparison".
    /// - `needed`: the bytes that it takes at most.
    pub(crate) fn check(self, work: &str, needed: u64) -> anyhow::Result<()> {
        Ok(check_memory(work, self.memory, needed)?)
    }
}

/// What reading an image as colours takes at most for a while, and then for good, in bytes.
pub(crate) fn of_colors(image: &Input, header: &Header) -> (u64, u64) {
    let decoded = decoded_bytes(Some(image), header);
    let texels = header.size.texels() as u64;
    if is_of_levels(header) {
        (decoded, texels * header.channels.count() as u64)
    } else {
        // As floats, with alpha until it is composited.
        (decoded + texels * 16, texels * 12)
    }
}

/// Whether colours stay as they are stored; see [`Colors`](uvgraft_metrics::Colors).
pub(crate) fn is_of_levels(header: &Header) -> bool {
    header.depth == Depth::U8 && !header.channels.has_alpha()
}
