//! Errors and their exit codes, warnings and notes.

use std::fmt::Display;
use std::process::ExitCode;

use uvgraft_pipeline::{Event, Failure, Fault, Observer};

use crate::terminal;

/// An error that the user can fix: a file, an option, an output path.
#[derive(Debug)]
struct BadInput(anyhow::Error);

impl Display for BadInput {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:#}", self.0)
    }
}

impl std::error::Error for BadInput {}

/// Marks errors as bad input.
pub(crate) trait OrBadInput<T> {
    /// The same result, with its error marked as bad input.
    fn or_bad_input(self) -> anyhow::Result<T>;
}

impl<T, E: Into<anyhow::Error>> OrBadInput<T> for Result<T, E> {
    fn or_bad_input(self) -> anyhow::Result<T> {
        self.map_err(|error| anyhow::Error::new(BadInput(error.into())))
    }
}

/// A bad-input error with a message.
pub(crate) fn bad_input(message: impl Display) -> anyhow::Error {
    anyhow::Error::new(BadInput(anyhow::anyhow!("{message}")))
}

/// The exit code for a fault: 2 for bad input, 1 for anything else.
pub(crate) fn exit_code_of(fault: Fault) -> ExitCode {
    ExitCode::from(if fault == Fault::Input { 2 } else { 1 })
}

/// Whose fault an error is.
fn fault(error: &anyhow::Error) -> Fault {
    match error.downcast_ref::<Failure>() {
        Some(failure) => failure.fault(),
        None if error.downcast_ref::<BadInput>().is_some() => Fault::Input,
        None => Fault::Work,
    }
}

/// Prints an error and returns the exit code.
pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    print(format_args!("{error:#}"));
    exit_code_of(fault(error))
}

/// Prints an error.
pub(crate) fn print(error: impl Display) {
    terminal::message("error", error);
}

/// Prints a warning.
pub(crate) fn warn(message: impl Display) {
    terminal::message("warning", message);
}

/// Prints a note.
pub(crate) fn note(message: impl Display) {
    terminal::message("note", message);
}

/// Prints the notes and warnings of short operations.
pub(crate) struct Notes;

impl Observer for Notes {
    fn event(&self, event: Event<'_>) {
        match event {
            Event::Note(text) => note(text),
            Event::Warning(text) => warn(text),
            _ => {}
        }
    }
}
