//! Everything that is printed: results to standard output, messages to standard error.
//!
//! A result that cannot be printed is an error. A message that cannot be printed changes nothing: there is
//! nowhere left to say so, and what the command does is worth more than what it tells.
//!
//! Names in files, and names of files, may contain control characters, with which a terminal can be
//! made to show something else, or to type. They are printed as escapes, such as `\u{1b}`, wherever
//! the output goes.

use std::fmt::Display;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::process::ExitCode;

use anstyle::{AnsiColor, Style};
use anyhow::Context;
use serde::Serialize;
pub(crate) use uvgraft_assembly::report::inline;
use uvgraft_assembly::report::{escaped, is_unsafe, rust_escape};

use crate::interruption::wait_if_interrupted;
use crate::{outcome, progress};

/// What a message is. Messages start with its name, in its colour if standard error shows colours: as those of
/// clap, on terminals unless `NO_COLOR` is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MessageKind {
    Error,
    Warning,
    Note,
    /// What was written.
    Wrote,
    /// A command that shows what was written.
    Look,
}

impl MessageKind {
    const fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
            Self::Wrote => "wrote",
            Self::Look => "look at it",
        }
    }

    const fn style(self) -> Style {
        let color = match self {
            Self::Error => AnsiColor::Red,
            Self::Warning => AnsiColor::Yellow,
            Self::Note => AnsiColor::Cyan,
            Self::Wrote | Self::Look => AnsiColor::Green,
        };
        color.on_default().bold()
    }
}

/// Prints the result of a command. A reader may close the pipe early, as in `uvgraft inspect x |
/// head`.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let text = escaped(text, |character| character != '\n' && is_unsafe(character), rust_escape);
    if outcome::keep_text(&text) { Ok(()) } else { to_stdout(&text) }
}

/// A document as JSON, as it is printed.
pub(crate) fn json(document: &impl Serialize) -> anyhow::Result<String> {
    let text = serde_json::to_string_pretty(document)? + "\n";
    // Strings are the only place in which they occur. All have four digits.
    let is_escaped = |character| character != '\n' && is_unsafe(character);
    Ok(escaped(&text, is_escaped, |character| format!("\\u{:04x}", u32::from(character)))
        .into_owned())
}

/// A path on a line of a result.
pub(crate) fn path(path: &Path) -> String {
    inline(&path.display().to_string()).into_owned()
}

/// A file's name without its folders, which say more than a report that is passed on should: whose computer it
/// was made on, and for which customer.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.display().to_string())
}

/// Prints a line to standard error, such as an error.
pub(crate) fn message(kind: MessageKind, text: impl Display) {
    wait_if_interrupted();
    let text = text.to_string();
    outcome::keep_message(kind, &text);
    if kind == MessageKind::Note && outcome::is_quiet() {
        return;
    }
    let (name, style) = (kind.name(), kind.style());
    to_stderr(&format!("{style}{name}:{style:#} {}\n", inline(&text)));
}

/// Prints the last message of an interrupted program.
pub(crate) fn interrupted() {
    // After a progress bar and the terminal's ^C.
    let start = if io::stderr().is_terminal() { "\n" } else { "" };
    to_stderr(&format!("{start}interrupted; unfinished outputs left unchanged\n"));
}

/// Prints what the parser of arguments answers: help and versions, which are results, or an error.
///
/// Returns the exit code.
pub(crate) fn answer(answer: &clap::Error) -> ExitCode {
    let text = answer.render().to_string();
    if has_unsafe(&text) {
        // Without colours, which are control characters too.
        let what = text.trim_start_matches("error: ").lines().next().unwrap_or_default();
        message(MessageKind::Error, what);
    } else {
        let printed = or_nobody_reads(answer.print());
        if !answer.use_stderr()
            && let Err(error) = printed
        {
            return crate::failure::report(&error);
        }
    }
    ExitCode::from(u8::try_from(answer.exit_code()).unwrap_or(2))
}

/// Whether text has characters that are printed as escapes, apart from line breaks.
pub(crate) fn has_unsafe(text: &str) -> bool {
    text.chars().any(|character| character != '\n' && is_unsafe(character))
}

/// Prints text as it is, such as a document that [`json`] made.
pub(crate) fn to_stdout(text: &str) -> anyhow::Result<()> {
    progress::suspended(|| {
        let mut out = io::stdout().lock();
        or_nobody_reads(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
    })
}

/// Closed pipes are no errors: who closed them has read enough.
fn or_nobody_reads(printed: io::Result<()>) -> anyhow::Result<()> {
    match printed {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        printed => printed.context("cannot print the result"),
    }
}

/// Prints to standard error if that is possible; styles are left out where they do not show.
fn to_stderr(text: &str) {
    let _ = progress::suspended(|| anstream::stderr().write_all(text.as_bytes()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped_and_others_are_not() {
        for safe in ["", "face.png", "gesicht \u{e4}\u{f6}\t\u{1f600} 顔"] {
            assert_eq!(inline(safe), safe);
        }
        for (name, wanted) in [
            ("a\x1b[31mb", "a\\u{1b}[31mb"),
            ("\u{9b}2J\x7f", "\\u{9b}2J\\u{7f}"),
            ("a\nerror: b\r", "a\\nerror: b\\r"),
            ("\u{202e}gnp", "\\u{202e}gnp"),
        ] {
            assert_eq!(inline(name), wanted);
        }
    }

    #[test]
    fn json_stays_json() {
        let name = "a\u{9b}\x1b\x7f\u{202e}\nb";
        let text = json(&[name]).unwrap();
        assert!(!has_unsafe(&text) && text.ends_with("]\n"), "{text:?}");
        assert_eq!(serde_json::from_str::<Vec<String>>(&text).unwrap(), [name]);
    }
}
