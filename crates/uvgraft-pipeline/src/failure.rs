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

    /// A failure during the work.
    pub fn work(message: impl Display) -> Self {
        Self::new(Fault::Work, message)
    }

    /// The caller cancelled the work.
    pub fn cancelled() -> Self {
        Self::new(Fault::Cancelled, "cancelled")
    }

    fn new(fault: Fault, message: impl Display) -> Self {
        Self { fault, message: message.to_string(), names_options: false }
    }

    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        self.fault
    }

    /// Whether the message names options in backticks: [`Failure::option`].
    pub fn names_options(&self) -> bool {
        self.names_options
    }

    /// The same fault with another message.
    pub(crate) fn with_message(self, message: String) -> Self {
        Self { message, ..self }
    }

    /// Prepends what was attempted to the message.
    #[must_use]
    pub fn context(self, what: impl Display) -> Self {
        Self { message: format!("{what}: {}", self.message), ..self }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
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

/// A message with the names of options that it has in backticks spelled in another way, for a door
/// to which they are known by other names.
///
/// - `message`: a note, a warning, or the message of a failure that [names
///   options](Failure::names_options).
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
    fn what_names_options_stays_so() {
        let failure = Failure::option("`size` must be 1").context("a.png");
        assert_eq!((failure.fault(), failure.names_options()), (Fault::Input, true));
        assert!(failure.clone().with_message(String::new()).names_options());
        assert!(!Failure::input("no group `size`").names_options());
    }
}
