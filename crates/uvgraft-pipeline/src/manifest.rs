//! The manifest: a record of what each output was made from, to find out which outputs are up to
//! date.
//!
//! `.uvgraft-manifest.jsonl` in the output folder has one line of JSON for each output written: its
//! name, the fingerprint of everything it was made from, and the SHA-256 of the file. A later line
//! for a name replaces earlier ones, and malformed lines are skipped, so that several processes may
//! append to one manifest, and a killed process damages at most its last line. File times are
//! ignored: they say when a file was written, not what it contains.

use std::collections::HashMap;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

use crate::failure::{Blame, Failure, Result};
use crate::fingerprint::{Fingerprint, file_digest};
use crate::plan::Job;

/// File name of the manifest.
pub(crate) const NAME: &str = ".uvgraft-manifest.jsonl";

/// A larger manifest is ignored: this is about ten million lines.
const MAX_BYTES: u64 = 2 << 30;

/// The manifest of a folder, and the part of the fingerprint that all its outputs share.
pub(crate) struct Manifest<'a> {
    path: PathBuf,
    entries: HashMap<String, Entry>,
    /// Whether the last line was incomplete when the file was read.
    is_cut: AtomicBool,
    shared: &'a Fingerprint,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Entry {
    output: String,
    made_from: String,
    sha256: String,
}

impl<'a> Manifest<'a> {
    /// The manifest next to an output; empty if the file does not exist.
    ///
    /// - `shared`: what all outputs are made from, apart from their own source.
    pub(crate) fn beside(output: &Path, shared: &'a Fingerprint) -> Result<Self> {
        let path = output.with_file_name(NAME);
        let (mut entries, mut is_cut) = (HashMap::new(), false);
        let length = path.metadata().map_or(0, |found| found.len());
        if path.is_file() && length <= MAX_BYTES {
            let cannot_read = |failure: Failure| {
                failure.context(format_args!("cannot read the manifest {}", path.display()))
            };
            let text = std::fs::read(&path).or_input().map_err(cannot_read)?;
            is_cut = text.last().is_some_and(|&last| last != b'\n');
            for line in String::from_utf8_lossy(&text).lines() {
                if let Ok(entry) = serde_json::from_str::<Entry>(line) {
                    entries.insert(entry.output.clone(), entry);
                }
            }
        }
        Ok(Self { path, entries, is_cut: AtomicBool::new(is_cut), shared })
    }

    /// Whether the output of a job exists, is unchanged since it was written, and was made from the
    /// current inputs and options.
    pub(crate) fn is_up_to_date(&self, job: &Job) -> bool {
        let Some(entry) = self.entries.get(&name(job)) else { return false };
        // The source first: it is usually the smaller file.
        self.made_from(job).is_some_and(|made_from| made_from == entry.made_from)
            && file_digest(&job.output).is_ok_and(|digest| digest == entry.sha256)
    }

    /// The fingerprint of a job's inputs, to be computed before the job runs. `None` for pipes,
    /// which cannot be read twice.
    pub(crate) fn made_from(&self, job: &Job) -> Option<String> {
        self.shared.with_file(&job.source).ok()
    }

    /// Records that the output of a job was written.
    pub(crate) fn record(&self, job: &Job, made_from: String) -> Result<()> {
        let cannot = |failure: Failure| {
            failure.context(format_args!("cannot record {} in the manifest", job.output.display()))
        };
        let sha256 = file_digest(&job.output).or_work().map_err(cannot)?;
        let entry = Entry { output: name(job), made_from, sha256 };
        let start = if self.is_cut.swap(false, Ordering::Relaxed) { "\n" } else { "" };
        let line = format!("{start}{}\n", serde_json::to_string(&entry).or_work()?);
        // A single write, so that lines of concurrent processes stay intact.
        let mut options = OpenOptions::new();
        let file = options.append(true).create(true).open(&self.path);
        file.and_then(|mut file| file.write_all(line.as_bytes())).or_work().map_err(cannot)
    }
}

/// An output's name within its folder.
fn name(job: &Job) -> String {
    job.output.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
