//! What a request reports of its result: figures by name, line by line.

use std::borrow::Cow;
use std::fmt::{self, Display, Write as _};

use serde::Serialize;
use uvgraft::listing;

/// Lines of figures, each with a name, and possibly a text below them.
///
/// [`Display`] aligns the figures. Control characters, which may come from names in files, are shown
/// as escapes.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Report {
    #[serde(rename = "figures")]
    rows: Vec<(String, String)>,
    #[serde(skip_serializing_if = "String::is_empty")]
    below: String,
}

impl Report {
    /// Adds a line.
    pub fn row(&mut self, name: impl Into<String>, value: impl Into<String>) {
        self.rows.push((name.into(), value.into()));
    }

    /// Adds a line of text below all figures.
    pub(crate) fn below(&mut self, line: impl Display) {
        let _ = writeln!(self.below, "{line}");
    }

    /// Puts the lines of another report before those of this one.
    pub(crate) fn after(mut self, first: Self) -> Self {
        self.rows.splice(0..0, first.rows);
        self
    }

    /// The figures, each with its name.
    pub fn rows(&self) -> &[(String, String)] {
        &self.rows
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.rows {
            writeln!(f, "{name:<14} {}", inline(value))?;
        }
        let is_escaped = |character| character != '\n' && is_unsafe(character);
        f.write_str(&escaped(&self.below, is_escaped, rust_escape))
    }
}

/// A name on a line of a report: without line breaks and other control characters.
pub fn inline(name: &str) -> Cow<'_, str> {
    escaped(name, is_unsafe, rust_escape)
}

/// Whether a character may change what a terminal shows: control characters, and those that change
/// the direction of text or break lines.
pub fn is_unsafe(character: char) -> bool {
    let changes_text = matches!(
        character,
        '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{61c}'
    );
    (character.is_control() && character != '\t') || changes_text
}

/// A character as Rust escapes it, such as `\u{1b}`.
pub fn rust_escape(character: char) -> String {
    character.escape_default().to_string()
}

/// A text in which some characters are escapes.
pub fn escaped(
    text: &str,
    is_escaped: impl Fn(char) -> bool,
    escape: impl Fn(char) -> String,
) -> Cow<'_, str> {
    if !text.chars().any(&is_escaped) {
        return text.into();
    }
    let mut safe = String::with_capacity(text.len() + 8);
    for character in text.chars() {
        if is_escaped(character) {
            safe += &escape(character);
        } else {
            safe.push(character);
        }
    }
    safe.into()
}

/// A number with its digits in groups of three.
pub fn grouped(count: usize) -> String {
    listing::grouped(count as u64)
}

/// A number of bytes in megabytes.
pub(crate) fn megabytes(bytes: usize) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_in_threes() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_234_567), "1,234,567");
    }

    #[test]
    fn lines_are_aligned_and_names_cannot_break_them() {
        let mut report = Report::default();
        report.row("mesh", "a\nerror: b\u{1b}[31m");
        report.below("\nQuest: fine");
        assert_eq!(report.to_string(), "mesh           a\\nerror: b\\u{1b}[31m\n\nQuest: fine\n");
        let mut first = Report::default();
        first.row("head", "x");
        let both = report.after(first);
        assert_eq!(both.rows()[0], ("head".to_owned(), "x".to_owned()));
    }
}
