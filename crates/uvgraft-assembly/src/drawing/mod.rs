//! Pictures composed of panels, captions, lines and dots, for reports and contact sheets.

mod canvas;
mod font;
mod sheet;

pub use self::canvas::{Canvas, Lines, Pen};
pub use self::sheet::{Rgb, Sheet, check_name, write};
