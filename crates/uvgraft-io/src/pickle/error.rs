//! Errors of pickles.

/// Maximum number of instructions. Files of arrays have a few thousand.
pub const MAX_INSTRUCTIONS: usize = 1 << 20;

/// Why a pickle was rejected. Positions count bytes from the start.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PickleError {
    /// It imports a Python name that is not plain data.
    #[error("refused: the pickle imports {name}, but only plain data may be loaded")]
    Refused {
        /// Module and name, shortened.
        name: String,
    },
    /// The bytes end too early.
    #[error("truncated pickle: byte {at} must be followed by {needed} bytes, got {left}")]
    Truncated {
        /// Position.
        at: usize,
        /// Bytes required.
        needed: u64,
        /// Bytes available.
        left: usize,
    },
    /// An instruction that is unknown, or not needed for plain data.
    #[error("byte {at} of the pickle: unsupported instruction 0x{found:02x}")]
    Instruction {
        /// Position.
        at: usize,
        /// The instruction.
        found: u8,
    },
    /// An instruction that does not fit the preceding ones.
    #[error("byte {at} of the pickle: {problem}")]
    Malformed {
        /// Position of the instruction.
        at: usize,
        /// What is wrong.
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
    /// Bytes follow the end.
    #[error("unexpected {count} bytes after the end of the pickle")]
    Trailing {
        /// Number of bytes.
        count: usize,
    },
}
