//! Errors and their exit codes, warnings and notes.

use std::fmt::Display;
use std::process::ExitCode;
use std::sync::OnceLock;

use uvgraft_pipeline::{Event, Failure, Fault, Observer, spelled};

use crate::progress;
use crate::terminal::{self, MessageKind};

/// The options of the command that runs: what libraries call each, and how it is spelled.
static OPTIONS: OnceLock<Vec<(String, String)>> = OnceLock::new();

/// Has messages spell the names of options that libraries have in backticks, such as `source_mask`,
/// as options: `--source-mask`.
///
/// - `options`: those of the command that runs.
pub(crate) fn spell_options(options: impl IntoIterator<Item = (String, String)>) {
    // Once in a process.
    let _ = OPTIONS.set(options.into_iter().collect());
}

/// The spelling of what libraries call an option; `None` if it is not one of the command that runs.
fn as_option(name: &str) -> Option<String> {
    let options = OPTIONS.get().map_or(&[][..], Vec::as_slice);
    let (_, spelled) = options.iter().find(|(known, _)| known == name)?;
    // A switch of the library is an option with one value here.
    let value = if name == "match_skin" { " skin" } else { "" };
    Some(format!("{spelled}{value}"))
}

/// A message of a library, with the names of options as they are spelled.
fn with_options(message: &str) -> String {
    spelled(message, as_option)
}

/// The message of a failure, with the names of options as they are spelled.
pub(crate) fn message(failure: &Failure) -> String {
    failure.spelled(as_option)
}

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

/// The failure of a library that an error is, perhaps in a context.
fn of_library(error: &anyhow::Error) -> Option<&Failure> {
    match error.downcast_ref::<BadInput>() {
        Some(BadInput(error)) => of_library(error),
        None => error.downcast_ref(),
    }
}

/// The message of an error, with the names of options as they are spelled.
fn message_of(error: &anyhow::Error) -> String {
    let text = format!("{error:#}");
    let in_context = of_library(error)
        .and_then(|failure| Some((text.strip_suffix(&failure.to_string())?, message(failure))));
    match in_context {
        Some((context, message)) => format!("{context}{message}"),
        None => text,
    }
}

/// Prints an error and returns the exit code.
pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    print(message_of(error));
    exit_code_of(fault(error))
}

/// Prints an error.
pub(crate) fn print(error: impl Display) {
    terminal::message(MessageKind::Error, error);
}

/// Prints a warning, with the names of options as they are spelled.
pub(crate) fn warn(message: impl Display) {
    terminal::message(MessageKind::Warning, with_options(&message.to_string()));
}

/// Prints a note, with the names of options as they are spelled.
pub(crate) fn note(message: impl Display) {
    terminal::message(MessageKind::Note, with_options(&message.to_string()));
}

/// Prints the notes and warnings of short operations.
pub(crate) struct Notes;

impl Observer for Notes {
    fn event(&self, event: Event<'_>) {
        match event {
            Event::Note(text) => note(text),
            Event::Warning(text) => warn(text),
            Event::Step(name) => progress::step(name),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_spelled_as_such_and_names_in_files_are_not() {
        // The only test of the process that sets them.
        let named = |name: &str, spelled: &str| (name.to_owned(), spelled.to_owned());
        let options =
            [("source_mask", "--source-mask"), ("skin", "--skin"), ("match_skin", "--match")];
        spell_options(options.map(|(name, spelled)| named(name, spelled)));
        let failure = Failure::option("`match_skin` needs `tone`");
        assert_eq!(message(&failure), "--match skin needs `tone`");
        let failure = Failure::option("`source_mask` and `skin` need `other`").context("a.png");
        let wanted = "a.png: --source-mask and --skin need `other`";
        assert_eq!(message(&failure), wanted);
        let marked = Err::<(), _>(failure).or_bad_input().unwrap_err();
        assert_eq!(message_of(&marked), wanted);
        let failure = Failure::option("`skin` must be a mask").found("; the file has `skin`");
        let in_context = anyhow::Error::new(failure).context("b.npz");
        assert_eq!(message_of(&in_context), "b.npz: --skin must be a mask; the file has `skin`");
        let of_file = Failure::input("masks.pkl: no group `skin`");
        assert_eq!(message(&of_file), "masks.pkl: no group `skin`");
        assert_eq!(message_of(&of_file.into()), "masks.pkl: no group `skin`");
    }
}
