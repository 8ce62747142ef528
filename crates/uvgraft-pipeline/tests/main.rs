//! Tests of transfers from file to file, a module for each subject.

mod batches;
mod in_memory;
mod prepared;
mod transfer;
