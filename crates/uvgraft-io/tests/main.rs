//! Tests of the readers and writers, a module for each subject.

mod array_hostile;
mod array_samples;
mod correspondence_tables;
mod obj_real_files;
