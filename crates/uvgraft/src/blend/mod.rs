//! Bringing what was carried and what it is laid over together, so that no border shows.
//!
//! [`skin`] tells which colours of a body's texture are skin, and [`statistics`] gives one set of
//! colours the mean and the spread of another.

pub mod skin;
pub mod statistics;
