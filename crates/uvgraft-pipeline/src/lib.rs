//! Transfers from file to file.
//!
//! A [`Transfer`] says which files are read, how, and which are written; [`Transfer::run`] does it. Bases are decoded,
//! filled and encoded in bands of rows, so that a large one never is in memory whole where that can be helped; several
//! textures are carried at once within a bound on memory; and outputs that are up to date are left out if asked, by
//! fingerprints of all that they are made from.
//!
//! Outputs are checked before any work is done, written beside their place and renamed into it. An [`Observer`] follows
//! what happens and may cancel it. A [`Failure`] tells whose fault it is.
//!
//! ```no_run
//! use uvgraft_pipeline::{Inputs, Onto, Transfer};
//!
//! let inputs = Inputs::Textures {
//!     sources: vec!["faces/".into()],
//!     onto: Some(Onto::Image("body.png".into())),
//!     values: Default::default(),
//! };
//! let done = Transfer::new("head_to_body.uvpair", inputs, "bodies/").run(&())?;
//! println!("{} textures were carried", done.written);
//! # Ok::<(), uvgraft_pipeline::Failure>(())
//! ```

mod base;
mod batch;
mod blending;
mod failure;
mod fingerprint;
mod length;
mod manifest;
mod material;
mod non_finite;
mod observer;
mod onto;
mod outputs;
mod plan;
mod region;
mod run;
mod stream;
mod transfer;
mod worker;

pub use blending::{Blending, KnownTexels, left_out};
pub use failure::{Failure, Fault, Result};
pub use length::{Length, Unit};
pub use material::{Role, Values};
pub use non_finite::without_non_finite;
pub use observer::{Event, Observer};
pub use onto::Onto;
pub use outputs::Outputs;
pub use region::{Grow, Region, RegionPart};
pub use transfer::{Existing, Inputs, MaterialMap, Transfer, Transferred};
