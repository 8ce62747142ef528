//! A line of JSON for each texture, for programs that follow a batch.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;
use uvgraft_pipeline::{Event, Inputs, Outputs, Transfer};

use crate::failure::{OrBadInput, bad_input, message};
use crate::files::OrCannotWrite;

/// A file of rows, created with the first of them.
pub(super) struct Rows {
    path: PathBuf,
    file: Option<File>,
}

/// A row. All have the same keys, so that they form a table.
#[derive(Serialize)]
struct Row {
    source: String,
    output: String,
    status: &'static str,
    error: Option<String>,
    boundary_delta_e: Option<f64>,
    ms: Option<f64>,
    bytes: Option<u64>,
}

impl Rows {
    /// Checks that the file can be written.
    pub(super) fn new(path: &Path, transfer: &Transfer) -> anyhow::Result<Self> {
        // Rows are appended to what exists, which must never be an image or a pair.
        if path.extension().is_none_or(|extension| extension != "jsonl") {
            let path = path.display();
            return Err(bad_input(format!("--report must be a .jsonl file, got {path}")));
        }
        let list = match &transfer.inputs {
            Inputs::Listed { list, .. } => list.path(),
            _ => None,
        };
        Outputs::new(list).check(path).or_bad_input()?;
        Ok(Self { path: path.to_path_buf(), file: None })
    }

    /// Appends the row of a texture that is done.
    pub(super) fn add(&mut self, event: &Event<'_>) -> anyhow::Result<()> {
        let Some(row) = Row::of(event) else { return Ok(()) };
        let line = serde_json::to_string(&row)? + "\n";
        self.append(&line).or_cannot_write(&self.path)
    }

    fn append(&mut self, line: &str) -> std::io::Result<()> {
        if self.file.is_none() {
            self.file = Some(OpenOptions::new().append(true).create(true).open(&self.path)?);
        }
        // A single write, so that lines of several processes stay intact.
        self.file.as_mut().map_or(Ok(()), |file| file.write_all(line.as_bytes()))
    }
}

impl Row {
    fn of(event: &Event<'_>) -> Option<Self> {
        match *event {
            Event::TextureUpToDate { source, output } => {
                Some(Self::new(source, output, "up to date"))
            }
            Event::TextureEnded { source, output, result, duration } => {
                let mut row = Self::new(source, output, "written");
                row.ms = duration.map(milliseconds);
                match result {
                    Ok(figures) => {
                        row.boundary_delta_e = figures.boundary_delta_e;
                        row.bytes = Some(figures.bytes);
                    }
                    Err(failure) => {
                        row.status = "failed";
                        row.error = Some(message(failure));
                    }
                }
                Some(row)
            }
            _ => None,
        }
    }

    fn new(source: &Path, output: &Path, status: &'static str) -> Self {
        // Every name must give a row, also those that are not UTF-8.
        let [source, output] = [source, output].map(|path| path.to_string_lossy().into_owned());
        let (error, boundary_delta_e, ms, bytes) = (None, None, None, None);
        Self { source, output, status, error, boundary_delta_e, ms, bytes }
    }
}

/// To a tenth.
fn milliseconds(duration: Duration) -> f64 {
    (duration.as_secs_f64() * 1e4).round() / 10.0
}
