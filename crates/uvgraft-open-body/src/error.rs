//! Why an import failed.

use uvgraft_avatar::body::BodyError;

use crate::wheel::{NAME, SHA256};

/// Why the body was not imported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// Another file.
    #[error("not {NAME}: its SHA-256 must be {SHA256}, got {found}")]
    Checksum {
        /// Of the file.
        found: String,
    },
    /// The archive is damaged.
    #[error("cannot unpack {NAME}: {0}")]
    Archive(String),
    /// A file of the archive is missing.
    #[error("{NAME} must contain {0}")]
    Missing(
        /// Its path.
        String,
    ),
    /// A file of the archive has unexpected content.
    #[error("{NAME}: {file}: {problem}")]
    Content {
        /// Its path.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// The parts do not make a body.
    #[error("{NAME}: {0}")]
    Body(#[from] BodyError),
}

impl ImportError {
    pub(crate) fn content(file: &str, problem: impl std::fmt::Display) -> Self {
        Self::Content { file: file.to_owned(), problem: problem.to_string() }
    }
}
