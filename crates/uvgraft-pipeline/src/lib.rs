//! Transfers from file to file.
//!
//! A [`Transfer`] states which files are read, how, and which are written; [`Transfer::run`]
//! executes it. What is read may also be in memory: every input is an [`Input`], into which paths
//! convert. Bases are decoded, filled and encoded in bands of rows, so that a large base need
//! not be in memory as a whole; several textures are processed in parallel within a memory limit;
//! and outputs that are up to date can be skipped, based on fingerprints of everything they are
//! made from.
//!
//! Outputs are checked before any work starts, written to temporary files next to their targets and
//! renamed into place. An [`Observer`] follows the progress and may cancel it. A [`Failure`] states
//! whose fault it is.
//!
//! ```no_run
//! use uvgraft_pipeline::{BaseSource, Inputs, Transfer};
//!
//! let inputs = Inputs::textures(["faces/"], BaseSource::image("body.png"));
//! let done = Transfer::new("head_to_body.uvpair", inputs, "bodies/").run(&())?;
//! println!("{} textures transferred", done.written);
//! # Ok::<(), uvgraft_pipeline::Failure>(())
//! ```

#![forbid(unsafe_code)]

mod base;
pub mod base_color;
mod base_source;
mod batch;
mod blend_settings;
mod blending;
mod dependencies;
mod failure;
mod fingerprint;
mod growth;
mod isolated;
mod layout_checks;
mod length;
mod link;
mod manifest;
mod masks;
mod material;
mod memory;
mod non_finite;
mod observer;
mod outputs;
mod plan;
mod prepared;
mod records;
mod region;
mod run;
#[cfg(test)]
mod schedule_tests;
mod segmented;
mod shard;
mod shared;
mod source;
mod spawn;
mod stream;
mod target;
mod texture_list;
mod texture_transfer;
mod tiles;
mod toning;
mod transfer;
mod unchanged;
mod worker;

pub use base_source::BaseSource;
pub use blend_settings::{BlendMode, BlendSettings, ToneSide};
pub use blending::{Blending, KnownTexels, exclusion_note};
pub use failure::{Blame, Context, Failure, Fault, Result, spelled};
pub use growth::{Grown, grown};
pub use layout_checks::{CheckedPair, LayoutChecks};
pub use length::{Length, Unit};
pub use manifest::Manifest;
pub use material::{Role, Values};
pub use memory::{check_memory, decoded_bytes, memory_taken, parse_memory};
pub use non_finite::without_non_finite;
pub use observer::{Event, Observer, OutputFigures};
pub use outputs::Outputs;
pub use plan::images_in;
pub use prepared::{PreparedTransfer, TransferredTexture};
pub use region::{Grow, Region, RegionPart};
pub use shard::Shard;
pub use texture_list::TextureList;
pub use toning::{toned, toning};
pub use transfer::{Correspondence, Existing, Inputs, MaterialMap, Transfer, Transferred};
pub use uvgraft_files::input::Input;
