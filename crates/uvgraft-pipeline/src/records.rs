//! Which outputs of a batch are up to date.

use crate::failure::Result;
use crate::fingerprint::Fingerprint;
use crate::manifest::Manifest;
use crate::plan::Job;

/// The manifest of a batch's folder, and the part of the fingerprint that its outputs share.
pub(crate) struct Records {
    pub(crate) manifest: Manifest,
    /// What all outputs are made from, apart from their own source.
    pub(crate) shared: Fingerprint,
}

impl Records {
    /// Whether the output of a job exists, is unchanged since it was written, and was made from the
    /// current inputs and options.
    pub(crate) fn is_up_to_date(&self, job: &Job) -> bool {
        self.manifest.is_made_from(&job.output, || self.made_from(job))
    }

    /// The fingerprint of a job's inputs, to be computed before the job runs. `None` for pipes,
    /// which cannot be read twice.
    pub(crate) fn made_from(&self, job: &Job) -> Option<String> {
        self.shared.with_file(&job.source).ok()
    }

    /// Records that the output of a job was written.
    pub(crate) fn record(&self, job: &Job, made_from: &str) -> Result<()> {
        self.manifest.record(&job.output, made_from)
    }
}
