//! Tests of transfers from file to file, a module for each subject.

mod batches;
mod prepared;
mod transfer;
