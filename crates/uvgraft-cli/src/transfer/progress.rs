//! Progress of a transfer: bars on standard error if that is a terminal, warnings and errors there,
//! and summaries of fits on standard output.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use uvgraft_pipeline::{Event, Observer, Shard};

use crate::failure::{self, note, warn};
use crate::fitting::{FitBar, FitSummary};
use crate::progress;
use crate::terminal;
use crate::transfer::rows::Rows;

/// Outputs that are named one by one; of more, the folder is.
const MAX_NAMED: usize = 4;

/// Prints the progress of a transfer.
pub(super) struct Progress {
    start: Instant,
    state: Mutex<State>,
}

struct State {
    textures: ProgressBar,
    fits: HashMap<PathBuf, FitBar>,
    rows: Option<Rows>,
    shard: Option<Shard>,
    /// The first outputs that were written, in order of completion.
    written: Vec<PathBuf>,
    /// Whether rows or summaries could not be written, although the textures could.
    is_silenced: bool,
}

impl Progress {
    /// - `rows`: where each texture is recorded, if anywhere.
    pub(super) fn new(rows: Option<Rows>, shard: Option<Shard>) -> Self {
        let (textures, fits) = (ProgressBar::hidden(), HashMap::new());
        let state = State { textures, fits, rows, shard, written: Vec::new(), is_silenced: false };
        Self { start: Instant::now(), state: Mutex::new(state) }
    }

    /// Whether something of what was to be printed on the way could not be written. The reason was printed.
    pub(super) fn is_silenced(&self) -> bool {
        self.state().is_silenced
    }

    /// The first outputs that were written, in order.
    pub(super) fn written(&self) -> Vec<PathBuf> {
        let mut written = self.state().written.clone();
        written.sort_unstable();
        written
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn show(&mut self, event: Event<'_>) {
        if let Some(Err(error)) = self.rows.as_mut().map(|rows| rows.add(&event)) {
            // Further rows would leave a gap.
            self.rows = None;
            self.is_silenced = true;
            self.textures.suspend(|| warn(format!("{error:#}; no more lines are written")));
        }
        match event {
            Event::Note(text) => note(text),
            Event::Warning(text) => self.textures.suspend(|| warn(text)),
            Event::Planned { textures: 0, .. } => {
                if let Some(shard) = self.shard {
                    self.print(&format!("no textures in shard {shard}\n"));
                }
            }
            Event::Planned { textures, up_to_date: Some(count) } => {
                self.print(&format!("{count} of {textures} up to date\n"));
            }
            Event::BatchStarted { textures } if textures > 1 => {
                let template = "{bar:32} {pos}/{len} {eta:>4} {wide_msg}";
                self.textures = progress::bar(textures as u64, template);
            }
            Event::TextureStarted { source } => {
                let source = source.display().to_string();
                self.textures.set_message(terminal::inline(&source).into_owned());
            }
            Event::FitProgress { source, progress } => {
                self.fits.entry(source.to_path_buf()).or_default().show(progress);
            }
            Event::TextureEnded { output, result, .. } => {
                self.textures.inc(1);
                if result.is_ok() && self.written.len() < MAX_NAMED {
                    self.written.push(output.to_path_buf());
                }
            }
            Event::TextureReport { source, output, notes, warnings, result } => {
                if let Some(bar) = self.fits.remove(source) {
                    bar.finish();
                }
                let result = result.map(|fit| fit.map(FitSummary::from));
                // A handle of the same bar.
                self.textures.clone().suspend(|| {
                    notes.iter().for_each(note);
                    self.report(output, warnings, result);
                });
            }
            Event::BatchEnded { textures, written } => {
                self.textures.finish_and_clear();
                if written < textures && textures > 1 {
                    warn(format!("{written} of {textures} textures transferred"));
                }
            }
            _ => {}
        }
    }

    fn report(
        &mut self,
        output: &Path,
        warnings: &[String],
        result: Result<Option<FitSummary>, &uvgraft_pipeline::Failure>,
    ) {
        warnings.iter().for_each(warn);
        match result {
            Ok(Some(fit)) => self.print(&format!("{}: {fit}\n", terminal::path(output))),
            Ok(None) => {}
            Err(failure) => failure::print(failure::message(failure)),
        }
    }

    /// Prints to standard output. What cannot be printed does not stop the transfer.
    fn print(&mut self, text: &str) {
        if let Err(error) = terminal::print(text) {
            // One message is enough.
            if !std::mem::replace(&mut self.is_silenced, true) {
                failure::report(&error);
            }
        }
    }
}

impl Observer for Progress {
    fn event(&self, event: Event<'_>) {
        self.state().show(event);
    }

    fn now(&self) -> Option<Duration> {
        Some(self.start.elapsed())
    }
}
