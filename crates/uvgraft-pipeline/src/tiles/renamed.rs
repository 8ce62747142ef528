//! Events of a transfer between temporary files, with the names that users know.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::failure::Failure;
use crate::observer::{Event, Observer};

/// Passes events on, with other names for files.
pub(super) struct Renamed<'a> {
    pub(super) observer: &'a dyn Observer,
    /// Temporary files and what they are called.
    pub(super) names: Vec<(PathBuf, PathBuf)>,
}

impl Renamed<'_> {
    fn text(&self, text: &str) -> String {
        self.names.iter().fold(text.to_owned(), |text, (from, to)| {
            text.replace(&from.display().to_string(), &to.display().to_string())
        })
    }

    fn path<'p>(&'p self, path: &'p Path) -> &'p Path {
        self.names.iter().find(|(from, _)| from == path).map_or(path, |(_, to)| to)
    }

    pub(super) fn failure(&self, failure: &Failure) -> Failure {
        failure.reworded(|text| self.text(text))
    }
}

impl Observer for Renamed<'_> {
    fn event(&self, event: Event<'_>) {
        match event {
            Event::Note(text) => self.observer.event(Event::Note(&self.text(text))),
            Event::Warning(text) => self.observer.event(Event::Warning(&self.text(text))),
            Event::TextureStarted { source } => {
                self.observer.event(Event::TextureStarted { source: self.path(source) });
            }
            Event::TextureEnded { source, output, result, duration } => {
                let failure = result.err().map(|failure| self.failure(failure));
                self.observer.event(Event::TextureEnded {
                    source: self.path(source),
                    output: self.path(output),
                    result: match &failure {
                        Some(failure) => Err(failure),
                        None => result,
                    },
                    duration,
                });
            }
            Event::FitProgress { source, progress } => {
                let source = self.path(source);
                self.observer.event(Event::FitProgress { source, progress });
            }
            Event::TextureReport { source, output, notes, warnings, result } => {
                let texts = |texts: &[String]| -> Vec<String> {
                    texts.iter().map(|text| self.text(text)).collect()
                };
                let failure = result.err().map(|failure| self.failure(failure));
                self.observer.event(Event::TextureReport {
                    source: self.path(source),
                    output: self.path(output),
                    notes: &texts(notes),
                    warnings: &texts(warnings),
                    result: match &failure {
                        Some(failure) => Err(failure),
                        None => Ok(result.ok().flatten()),
                    },
                });
            }
            other => self.observer.event(other),
        }
    }

    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }

    fn now(&self) -> Option<Duration> {
        self.observer.now()
    }
}
