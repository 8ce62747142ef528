//! Pictures composed of panels, captions, lines and dots, for reports and contact sheets.

mod canvas;
mod font;
mod picture;

pub use self::canvas::{Canvas, Lines, Pen};
pub use self::picture::{Picture, Rgb, check_name, write};
