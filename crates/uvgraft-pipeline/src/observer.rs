//! What a caller is told while work goes on, and how it stops that.

use std::path::Path;

use uvgraft::{FitProgress, FitSummary};

use crate::failure::Failure;

/// Follows work. Its methods may be called from several threads at once; by default nothing is followed and nothing
/// cancelled.
pub trait Observer: Sync {
    /// Something happened.
    fn event(&self, event: Event<'_>) {
        let _ = event;
    }

    /// Whether work is to stop. Asked before each texture and between bands of rows; what is not written then is
    /// left as it was, and nothing lies beside it.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Follows nothing.
impl Observer for () {}

/// What happens.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Event<'a> {
    /// Something that was taken for granted, such as a unit.
    Note(&'a str),
    /// Something that the user should know although the work goes on.
    Warning(&'a str),
    /// What there is to do is known.
    Planned {
        /// Textures that were asked for.
        textures: usize,
        /// Those of them that are left out for being up to date; [`Existing::KeepUpToDate`](crate::Existing).
        up_to_date: Option<usize>,
    },
    /// Work on some textures begins: those that are laid over one base.
    BatchStarted {
        /// How many they are.
        textures: usize,
    },
    /// Work on a texture begins.
    TextureStarted {
        /// Its file.
        source: &'a Path,
    },
    /// A step of a texture's fit is done.
    FitProgress {
        /// Its file.
        source: &'a Path,
        /// How far it is.
        progress: FitProgress,
    },
    /// The work on a texture ended, whichever it is.
    TextureEnded,
    /// How the work on a texture ended: in the order of the textures.
    TextureReport {
        /// Its file.
        source: &'a Path,
        /// The file that was written, or was to be.
        output: &'a Path,
        /// What was done that nobody asked for, such as leaving out a collar.
        notes: &'a [String],
        /// What the user should know.
        warnings: &'a [String],
        /// How its fit went, if it was fitted.
        result: Result<Option<&'a FitSummary>, &'a Failure>,
    },
    /// All that there is to do with the textures of a batch is done.
    BatchEnded {
        /// How many they were.
        textures: usize,
        /// How many of them were written.
        written: usize,
    },
}
