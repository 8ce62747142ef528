//! What is read and written: [`input`] reads files, or bytes that stand for one, whole and within a limit;
//! [`output`] leaves either the old or the new file, never a partial one, and removes what killed processes
//! left. [`checksum`] tells files from others.

#![forbid(unsafe_code)]

pub mod checksum;
pub mod input;
pub mod output;
