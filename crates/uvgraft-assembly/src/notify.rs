//! Notes and warnings to an observer, and its wish to cancel.

use std::fmt::Display;

use uvgraft_pipeline::{Event, Failure, Observer, Result};

/// What requests tell an observer.
pub(crate) trait Notify {
    /// A note on an assumption.
    fn note(&self, text: impl Display);
    /// A warning; the work continues.
    fn warn(&self, text: impl Display);
    /// Ends the work between two steps if the observer cancelled it.
    ///
    /// # Errors
    /// With [`Fault::Cancelled`](uvgraft_pipeline::Fault::Cancelled).
    fn proceed(&self) -> Result<()>;
}

impl Notify for dyn Observer + '_ {
    fn note(&self, text: impl Display) {
        self.event(Event::Note(&text.to_string()));
    }

    fn warn(&self, text: impl Display) {
        self.event(Event::Warning(&text.to_string()));
    }

    fn proceed(&self) -> Result<()> {
        if self.is_cancelled() { Err(Failure::cancelled()) } else { Ok(()) }
    }
}
