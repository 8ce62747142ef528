//! Whose fault a failure is, and the one place that prints it.

use std::fmt::Display;
use std::process::ExitCode;

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

/// 2 for bad input, 1 for anything else.
pub(crate) fn exit_code(error: &anyhow::Error) -> u8 {
    if error.downcast_ref::<BadInput>().is_some() { 2 } else { 1 }
}

/// Prints an error and gives the program's exit code.
#[expect(clippy::print_stderr, reason = "the one place that prints errors")]
pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    wait_if_interrupted();
    eprintln!("error: {error:#}");
    ExitCode::from(exit_code(error))
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
