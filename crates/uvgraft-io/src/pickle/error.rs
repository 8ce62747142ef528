//! Why a pickle was refused.

/// As many instructions as a pickle may have. Files of arrays have some thousands.
pub const MOST_INSTRUCTIONS: usize = 1 << 20;

/// Why a pickle was refused. Places count bytes from the start.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PickleError {
    /// It asks for something of Python that is not plain data.
    #[error("refused: the pickle imports {name}, but only plain data may be loaded")]
    Refused {
        /// Module and name, shortened.
        name: String,
    },
    /// The bytes end too early.
    #[error("truncated pickle: byte {at} must be followed by {needed} bytes, got {left}")]
    Truncated {
        /// Where.
        at: usize,
        /// How many bytes must follow.
        needed: u64,
        /// How many follow.
        left: usize,
    },
    /// An instruction that does not exist, or that plain data does not need.
    #[error("byte {at} of the pickle: unsupported instruction 0x{found:02x}")]
    Instruction {
        /// Where.
        at: usize,
        /// Which.
        found: u8,
    },
    /// An instruction that does not fit what came before it.
    #[error("byte {at} of the pickle: {problem}")]
    Malformed {
        /// Where the instruction starts.
        at: usize,
        /// What was found, and what was wanted.
        problem: String,
    },
    /// More work than any file of arrays takes.
    #[error("pickle must have at most {most} {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The limit.
        most: usize,
    },
    /// Something follows the end.
    #[error("unexpected {count} bytes after the end of the pickle")]
    Trailing {
        /// How many bytes.
        count: usize,
    },
}
