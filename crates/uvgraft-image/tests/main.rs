//! Tests of images, a module for each subject.

mod bands;
mod color_spaces;
mod hostile;
mod jpegs;
mod metadata;
mod own_format;
mod png_rows;
mod round_trip;
mod samples;
mod tiff_file;
mod tiff_kinds;
