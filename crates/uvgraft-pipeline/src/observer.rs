//! Progress events for callers, and cancellation.

use std::fmt::Display;
use std::path::Path;
use std::time::Duration;

use uvgraft::{FitProgress, FitSummary};

use crate::failure::{Failure, Result};

/// Observes the work. Methods may be called from several threads at once; the defaults ignore all
/// events and never cancel.
pub trait Observer: Sync {
    /// Receives an event.
    fn event(&self, event: Event<'_>) {
        let _ = event;
    }

    /// Whether to cancel the work. Queried before each texture and between bands of rows; outputs
    /// not yet written then stay unchanged, and no temporary files remain.
    fn is_cancelled(&self) -> bool {
        false
    }

    /// The time since some moment, for [`Event::TextureEnded`]. No other clock is read: not every
    /// system has one.
    fn now(&self) -> Option<Duration> {
        None
    }
}

/// An observer that ignores everything.
impl Observer for () {}

impl dyn Observer + '_ {
    /// Passes on a note.
    pub fn note(&self, text: impl Display) {
        self.event(Event::Note(&text.to_string()));
    }

    /// Passes on a warning.
    pub fn warn(&self, text: impl Display) {
        self.event(Event::Warning(&text.to_string()));
    }

    /// Names the step that begins, unless the caller cancelled the work before it.
    ///
    /// # Errors
    /// As `check`.
    pub fn begin(&self, step: &str) -> Result<()> {
        self.check()?;
        self.event(Event::Step(step));
        Ok(())
    }

    /// Ends the work between two steps if the caller cancelled it.
    ///
    /// # Errors
    /// [`Failure::cancelled`], if it was.
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Failure::cancelled()) } else { Ok(()) }
    }
}

/// Figures on an output.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OutputFigures {
    /// Length of the file in bytes.
    pub bytes: u64,
    /// As [`TransferredTexture::boundary_delta_e`](crate::TransferredTexture::boundary_delta_e).
    pub boundary_delta_e: Option<f64>,
}

/// An event.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A note on an assumption, such as a mesh unit.
    Note(&'a str),
    /// A warning; the work continues.
    Warning(&'a str),
    /// A step of work that may take seconds begins, such as "fitting the head".
    Step(&'a str),
    /// A texture is skipped, since its output is up to date.
    TextureUpToDate {
        /// Its file.
        source: &'a Path,
        /// The output file.
        output: &'a Path,
    },
    /// The work is planned.
    Planned {
        /// Number of textures requested.
        textures: usize,
        /// Number of textures skipped as up to date; [`Existing::KeepUpToDate`](crate::Existing).
        up_to_date: Option<usize>,
    },
    /// A batch starts: textures with a common base.
    BatchStarted {
        /// Number of textures in the batch.
        textures: usize,
    },
    /// A texture starts.
    TextureStarted {
        /// Its file.
        source: &'a Path,
    },
    /// A step of a texture's fit is complete.
    FitProgress {
        /// Its file.
        source: &'a Path,
        /// Progress of the fit.
        progress: FitProgress,
    },
    /// A texture ended, in the order of completion.
    TextureEnded {
        /// Its file.
        source: &'a Path,
        /// The output file, written or not.
        output: &'a Path,
        /// Figures on the output.
        result: std::result::Result<OutputFigures, &'a Failure>,
        /// How long it took by the observer's clock, without waiting for memory.
        duration: Option<Duration>,
    },
    /// The outcome of a texture, in the order of the textures.
    TextureReport {
        /// Its file.
        source: &'a Path,
        /// The output file, written or not.
        output: &'a Path,
        /// Notes on automatic decisions, such as excluding a collar.
        notes: &'a [String],
        /// Warnings.
        warnings: &'a [String],
        /// Summary of the fit, if the texture was fitted.
        result: std::result::Result<Option<&'a FitSummary>, &'a Failure>,
    },
    /// A batch ended.
    BatchEnded {
        /// Number of textures in the batch.
        textures: usize,
        /// Number of textures written.
        written: usize,
    },
}
