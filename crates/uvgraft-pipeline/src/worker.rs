//! Transfers the textures of a batch.

use std::panic::{AssertUnwindSafe, catch_unwind};

use uvgraft::Texture;
use uvgraft_files::input::Input;

use crate::failure::{Failure, Result};
use crate::observer::Observer;
use crate::plan::Job;
use crate::shared::Shared;
use crate::source::Source;
use crate::spawn::text_of;
use crate::target::Target;
use crate::texture_transfer::{Analysis, Call, Outcome};
use crate::transfer::Transfer;

/// Transfers textures, with the state that they share.
pub(crate) struct TransferWorker<'a> {
    pub(crate) transfer: &'a Transfer,
    pub(crate) shared: &'a Shared,
    pub(crate) observer: &'a dyn Observer,
    /// The first texture to be transferred, if there is one, and its analysis.
    pub(crate) first: (Option<&'a Input>, Analysis),
}

impl TransferWorker<'_> {
    /// Transfers a texture.
    ///
    /// - `alone`: see [`Call::alone`].
    pub(crate) fn transfer(&self, job: &Job, alone: bool) -> Outcome {
        let (first, analysis) = &self.first;
        let transfer = || {
            self.shared.transfer(&Call {
                source: Source::from(&job.source),
                target: Target::File(&job.output),
                alone,
                analysis: (*first == Some(&job.source)).then_some(analysis),
                observer: self.observer,
            })
        };
        // A panic would be a bug, and should not cost the other textures.
        catch_unwind(AssertUnwindSafe(transfer)).unwrap_or_else(|panic| {
            let (source, text) = (&job.source, text_of(&*panic));
            Outcome::from(Failure::work(format!("{source}: internal error: {text}")))
        })
    }

    /// The coverage mask without what is excluded from the first texture.
    pub(crate) fn mask(&self) -> Result<Texture> {
        match self.first.1.found().and_then(|found| found.mask.clone()) {
            Some(mask) => Ok(mask),
            None => self.shared.mask(),
        }
    }
}
