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
}

/// The result of work that may fail with [`Failure`].
pub type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// A failure that the user can fix.
    pub fn input(message: impl Display) -> Self {
        Self { fault: Fault::Input, message: message.to_string() }
    }

    /// A failure during the work.
    pub fn work(message: impl Display) -> Self {
        Self { fault: Fault::Work, message: message.to_string() }
    }

    pub fn cancelled() -> Self {
        Self { fault: Fault::Cancelled, message: "cancelled".to_owned() }
    }

    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        self.fault
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

/// Classifies an error by fault.
pub trait Blame<T> {
    /// The user's fault.
    fn or_input(self) -> Result<T>;
    /// A failure during the work.
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
