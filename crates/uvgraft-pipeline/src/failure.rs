//! Whose fault a failure is.

use std::error::Error;
use std::fmt::{self, Display};

/// Whose fault a failure is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The user can mend it: a file, an option, a place to write to.
    Input,
    /// It failed at work: a full disk, no memory, a bug.
    Work,
    /// The caller cancelled it: [`Observer::is_cancelled`](crate::Observer::is_cancelled).
    Cancelled,
}

/// Why something was not done. Its text names the file, what it must be, and what it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    fault: Fault,
    message: String,
}

/// What may fail, with [`Failure`].
pub type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    /// One that the user can mend.
    pub fn input(message: impl Display) -> Self {
        Self { fault: Fault::Input, message: message.to_string() }
    }

    /// One at work.
    pub fn work(message: impl Display) -> Self {
        Self { fault: Fault::Work, message: message.to_string() }
    }

    pub(crate) fn cancelled() -> Self {
        Self { fault: Fault::Cancelled, message: "cancelled".to_owned() }
    }

    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        self.fault
    }

    /// The same, with what was tried before its text.
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

/// Says whose fault an error is.
pub(crate) trait Blame<T> {
    /// The user's.
    fn or_input(self) -> Result<T>;
    /// Nobody's but the work's.
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

/// An error and what caused it.
fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}
