//! Tests of the readers and writers, a module for each subject. `abandoned_outputs` is a program of its own, since
//! a process abandons its outputs only once.

mod array_hostile;
mod array_samples;
mod correspondence_tables;
mod image_bands;
mod image_color_spaces;
mod image_hostile;
mod image_jpegs;
mod image_metadata;
mod image_round_trip;
mod image_samples;
mod obj_real_files;
mod png_rows;
mod tiff_file;
mod tiff_kinds;
