//! Everything that is printed: results to standard output, messages to standard error.
//!
//! Names in files, and names of files, may contain control characters, with which a terminal can be
//! made to show something else, or to type. They are printed as escapes, such as `\u{1b}`, wherever
//! the output goes.

use std::borrow::Cow;
use std::fmt::{Display, Write as _};
use std::io::{self, Write as _};
use std::path::Path;

use anyhow::Context;
use serde::Serialize;

use crate::interruption::wait_if_interrupted;

/// Prints the result of a command. A reader may close the pipe early, as in `uvgraft inspect x |
/// head`.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let text = escaped(text, |character| character != '\n' && is_unsafe(character), rust_escape);
    to_stdout(&text)
}

/// Prints the result of a command as JSON.
pub(crate) fn print_json(document: &impl Serialize) -> anyhow::Result<()> {
    to_stdout(&json(document)?)
}

/// A document as JSON, as it is printed.
pub(crate) fn json(document: &impl Serialize) -> anyhow::Result<String> {
    let text = serde_json::to_string_pretty(document)? + "\n";
    // Strings are the only place in which they occur. All have four digits.
    let is_escaped = |character| character != '\n' && is_unsafe(character);
    Ok(escaped(&text, is_escaped, |character| format!("\\u{:04x}", u32::from(character)))
        .into_owned())
}

/// A name on a line of a result: without line breaks.
pub(crate) fn inline(name: &str) -> Cow<'_, str> {
    escaped(name, is_unsafe, rust_escape)
}

/// A path on a line of a result.
pub(crate) fn path(path: &Path) -> String {
    inline(&path.display().to_string()).into_owned()
}

/// Prints a line to standard error, such as an error.
///
/// - `kind`: what it starts with.
#[expect(clippy::print_stderr, reason = "the one place that prints messages")]
pub(crate) fn message(kind: &str, text: impl Display) {
    wait_if_interrupted();
    eprintln!("{kind}: {}", inline(&text.to_string()));
}

/// Whether text has characters that are printed as escapes, apart from line breaks.
pub(crate) fn has_unsafe(text: &str) -> bool {
    text.chars().any(|character| character != '\n' && is_unsafe(character))
}

fn to_stdout(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result.context("cannot print the result"),
    }
}

/// Whether a character may change what a terminal shows: control characters, and those that change
/// the direction of text or break lines.
fn is_unsafe(character: char) -> bool {
    let changes_text = matches!(
        character,
        '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{61c}'
    );
    (character.is_control() && character != '\t') || changes_text
}

fn rust_escape(character: char) -> String {
    character.escape_default().to_string()
}

fn escaped(
    text: &str,
    is_escaped: impl Fn(char) -> bool,
    escape: impl Fn(char) -> String,
) -> Cow<'_, str> {
    if !text.chars().any(&is_escaped) {
        return text.into();
    }
    let mut safe = String::with_capacity(text.len() + 8);
    for character in text.chars() {
        let _ = if is_escaped(character) {
            safe.write_str(&escape(character))
        } else {
            safe.write_char(character)
        };
    }
    safe.into()
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
