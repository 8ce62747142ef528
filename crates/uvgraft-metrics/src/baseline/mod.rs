//! Earlier methods of texture transfer, reimplemented for comparison. Nothing else uses them.

pub mod affine;
pub mod grid;
mod median;
