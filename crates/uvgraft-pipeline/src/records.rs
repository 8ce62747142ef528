//! Which outputs of a batch are up to date.

use crate::failure::{Failure, Result};
use crate::fingerprint::{Fingerprint, Seen};
use crate::manifest::Manifest;
use crate::plan::Job;

/// The manifest of a batch's folder, and the part of the fingerprint that its outputs share.
pub(crate) struct Records {
    pub(crate) manifest: Manifest,
    /// What all outputs are made from, apart from their own source.
    pub(crate) shared: Fingerprint,
    /// The files of which it is the fingerprint.
    pub(crate) seen: Seen,
}

/// What an output is made from, computed before it is made.
pub(crate) struct Provenance {
    fingerprint: String,
    source: Seen,
}

impl Records {
    /// Whether the output of a job exists, is unchanged since it was written, and was made from the
    /// current inputs and options.
    pub(crate) fn is_up_to_date(&self, job: &Job) -> bool {
        self.manifest.matches(&job.output, || self.shared.with_input(&job.source).ok())
    }

    /// What the output of a job is made from, to be found before the job runs. `None` for pipes,
    /// which cannot be read twice.
    pub(crate) fn provenance(&self, job: &Job) -> Option<Provenance> {
        let source = Seen::before([&job.source]);
        let fingerprint = self.shared.with_input(&job.source).ok()?;
        Some(Provenance { fingerprint, source })
    }

    /// Records that the output of a job was written, unless it may be made from something else.
    pub(crate) fn record(&self, job: &Job, provenance: &Provenance) -> Result<()> {
        if let Some(changed) = provenance.source.changed().or(self.seen.changed()) {
            let (output, changed) = (job.output.display(), changed.display());
            return Err(Failure::input(format!(
                "{output}: {changed} changed while it was used; the output will be made anew"
            )));
        }
        self.manifest.record(&job.output, &provenance.fingerprint)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use uvgraft_files::input::Input;

    use super::*;

    #[test]
    fn a_file_replaced_meanwhile_vouches_for_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let [source, base, output, other] =
            ["source", "base", "output", "other"].map(|name| folder.path().join(name));
        for path in [&source, &base, &output] {
            fs::write(path, "the same").unwrap();
        }
        let job = Job { source: Input::from(&source), output };
        let records = |base| Records {
            manifest: Manifest::open(folder.path(), None).unwrap(),
            shared: Fingerprint::new(),
            seen: Seen::before([&Input::from(base)]),
        };
        // Replaced by another file, which is replaced by one with the content from before.
        for replaced in [&source, &base] {
            let records = records(&base);
            let provenance = records.provenance(&job).unwrap();
            fs::write(&other, "something else").unwrap();
            fs::rename(&other, replaced).unwrap();
            fs::write(&other, "the same").unwrap();
            fs::rename(&other, replaced).unwrap();
            let refused = records.record(&job, &provenance).unwrap_err();
            let wanted = format!("{} changed while it was used", replaced.display());
            assert!(refused.to_string().contains(&wanted), "{refused}");
            assert!(!records.is_up_to_date(&job));
        }
        let records = records(&base);
        let provenance = records.provenance(&job).unwrap();
        records.record(&job, &provenance).unwrap();
        assert!(records.is_up_to_date(&job));
        // Neither the clock nor the length says that the output was changed.
        let times = fs::metadata(&job.output).unwrap().modified().unwrap();
        fs::write(&job.output, "the SAME").unwrap();
        let file = fs::File::options().write(true).open(&job.output).unwrap();
        file.set_modified(times).unwrap();
        assert!(!records.is_up_to_date(&job));
        fs::write(&job.output, "the same").unwrap();
        file.set_modified(std::time::UNIX_EPOCH).unwrap();
        assert!(records.is_up_to_date(&job));
    }
}
