//! Failures, and whose fault they are.

use std::error::Error;
use std::fmt::{self, Display};

/// Who has to fix a failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The user: a file, an option, an output path.
    Input,
    /// The system or the program: a full disk, no memory, a bug.
    Work,
    /// The caller cancelled the work: [`Observer::is_cancelled`](crate::Observer::is_cancelled).
    Cancelled,
}

/// Why something failed. The message names the file, what was required, and what was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    fault: Fault,
    message: String,
    /// Whether the message names options in backticks.
    names_options: bool,
    /// The end of the message, in others' words.
    found: String,
}

/// The result of work that may fail with [`Failure`].
pub type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// A failure that the user can fix.
    pub fn input(message: impl Display) -> Self {
        Self::new(Fault::Input, message)
    }

    /// As [`Failure::input`], for a message that names options in backticks as fields are called,
    /// such as `source_mask`: see [`spelled`]. Backticks in other messages are around names
    /// of what is in files.
    pub fn option(message: impl Display) -> Self {
        Self { names_options: true, ..Self::input(message) }
    }

    /// Ends the message with what was found, in words of others: backticks in them are around names of what is in
    /// files, also if the message [names options](Failure::option).
    #[must_use]
    pub fn found(self, found: impl Display) -> Self {
        Self { found: format!("{}{found}", self.found), ..self }
    }

    /// A failure during the work.
    pub fn work(message: impl Display) -> Self {
        Self::new(Fault::Work, message)
    }

    /// The caller cancelled the work.
    pub fn cancelled() -> Self {
        Self::new(Fault::Cancelled, "cancelled")
    }

    fn new(fault: Fault, message: impl Display) -> Self {
        Self { fault, message: message.to_string(), names_options: false, found: String::new() }
    }

    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        self.fault
    }

    /// The message, with the names of options that it has in backticks spelled in another way: see [`spelled`].
    pub fn spelled(&self, spell: impl Fn(&str) -> Option<String>) -> String {
        if self.names_options {
            spelled(&self.message, spell) + &self.found
        } else {
            self.to_string()
        }
    }

    /// The same failure in other words.
    pub(crate) fn reworded(&self, reword: impl Fn(&str) -> String) -> Self {
        Self { message: reword(&self.message), found: reword(&self.found), ..self.clone() }
    }

    /// Prepends what was attempted to the message.
    #[must_use]
    pub fn context(self, what: impl Display) -> Self {
        Self { message: format!("{what}: {}", self.message), ..self }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        f.write_str(&self.found)
    }
}

impl Error for Failure {}

/// Classifies an error by fault; the message has those of its sources too.
pub trait Blame<T> {
    /// The user's fault.
    ///
    /// # Errors
    /// [`Fault::Input`], if it is one.
    fn or_input(self) -> Result<T>;

    /// A failure during the work.
    ///
    /// # Errors
    /// [`Fault::Work`], if it is one.
    fn or_work(self) -> Result<T>;
}

impl<T, E: Error> Blame<T> for std::result::Result<T, E> {
    fn or_input(self) -> Result<T> {
        self.map_err(|error| Failure::input(chain(&error)))
    }

    fn or_work(self) -> Result<T> {
        self.map_err(|error| Failure::work(chain(&error)))
    }
}

/// Adds to a failure what was attempted.
pub trait Context<T> {
    /// Prepends what was attempted to the message: see [`Failure::context`].
    ///
    /// # Errors
    /// The failure, if it is one.
    fn context(self, what: impl Display) -> Result<T>;
}

impl<T> Context<T> for Result<T> {
    fn context(self, what: impl Display) -> Result<T> {
        self.map_err(|failure| failure.context(what))
    }
}

/// A message with the names of options that it has in backticks spelled in another way, for a door
/// to which they are known by other names.
///
/// - `message`: a note or a warning; failures have [`Failure::spelled`].
/// - `spell`: the spelling of what is between backticks; `None` leaves it and them as they are.
pub fn spelled(message: &str, spell: impl Fn(&str) -> Option<String>) -> String {
    let mut text = String::with_capacity(message.len());
    let mut rest = message;
    while let Some((before, after)) = rest.split_once('`') {
        text += before;
        let spelling = after.split_once('`').and_then(|(name, end)| Some((spell(name)?, end)));
        match spelling {
            Some((spelling, end)) => {
                text += &spelling;
                rest = end;
            }
            None => {
                text.push('`');
                rest = after;
            }
        }
    }
    text + rest
}

/// The message of an error with those of its sources.
fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_known_names_are_spelled_in_another_way() {
        let spell = |name: &str| (name == "a_b").then(|| "--a-b".to_owned());
        for (message, wanted) in [
            ("", ""),
            ("`a_b`", "--a-b"),
            ("use `a_b` 3, `c` or `a_b`", "use --a-b 3, `c` or --a-b"),
            ("by `x y --a_b` and `a_b`", "by `x y --a_b` and --a-b"),
            ("a`b: `a_b`, `a_b", "a`b: --a-b, `a_b"),
            ("``a_b``", "`--a-b`"),
        ] {
            assert_eq!(spelled(message, spell), wanted);
        }
    }

    #[test]
    fn only_own_words_name_options() {
        let spell = |name: &str| (name == "size").then(|| "--size".to_owned());
        let failure = Failure::option("`size` must be 1").context("a.png").found(", got `size`");
        assert_eq!(failure.fault(), Fault::Input);
        assert_eq!(failure.to_string(), "a.png: `size` must be 1, got `size`");
        assert_eq!(failure.spelled(spell), "a.png: --size must be 1, got `size`");
        let louder = failure.reworded(str::to_uppercase);
        assert_eq!(
            louder.spelled(|name| Some(name.to_lowercase())),
            "A.PNG: size MUST BE 1, GOT `SIZE`"
        );
        let of_file = Failure::input("no group `size`");
        assert_eq!(of_file.spelled(spell), "no group `size`");
    }
}
