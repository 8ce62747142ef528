//! Eyes.
pub(crate) mod eyeball;
