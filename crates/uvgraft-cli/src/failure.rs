//! Whose fault a failure is, and the one place that prints it.

use std::fmt::Display;
use std::process::ExitCode;

use uvgraft_pipeline::{Event, Failure, Fault, Observer};

use crate::interruption::wait_if_interrupted;

/// An error that the user can mend: a file, an option, a place to write to.
#[derive(Debug)]
struct BadInput(anyhow::Error);

impl Display for BadInput {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:#}", self.0)
    }
}

impl std::error::Error for BadInput {}

/// Marks errors as the input's fault.
pub(crate) trait OrBadInput<T> {
    /// The same result, its error marked.
    fn or_bad_input(self) -> anyhow::Result<T>;
}

impl<T, E: Into<anyhow::Error>> OrBadInput<T> for Result<T, E> {
    fn or_bad_input(self) -> anyhow::Result<T> {
        self.map_err(|error| anyhow::Error::new(BadInput(error.into())))
    }
}

/// An error that is the input's fault, from a message.
pub(crate) fn bad_input(message: impl Display) -> anyhow::Error {
    anyhow::Error::new(BadInput(anyhow::anyhow!("{message}")))
}

/// The program's exit code for a fault: 2 for bad input, 1 for anything else.
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

/// Prints an error and gives the program's exit code.
pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    print(format_args!("{error:#}"));
    exit_code_of(fault(error))
}

/// Prints an error.
#[expect(clippy::print_stderr, reason = "the one place that prints errors")]
pub(crate) fn print(error: impl Display) {
    wait_if_interrupted();
    eprintln!("error: {error}");
}

/// Prints something that the user should know although the work goes on.
#[expect(clippy::print_stderr, reason = "the one place that prints warnings")]
pub(crate) fn warn(message: impl Display) {
    wait_if_interrupted();
    eprintln!("warning: {message}");
}

/// Prints what was taken for granted.
#[expect(clippy::print_stderr, reason = "the one place that prints notes")]
pub(crate) fn note(message: impl Display) {
    wait_if_interrupted();
    eprintln!("note: {message}");
}

/// Prints the notes and warnings of work that takes no time.
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
