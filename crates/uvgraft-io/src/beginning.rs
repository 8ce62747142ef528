//! How foreign files begin.

use uvgraft_files::input;
use uvgraft_image::Format;

/// As [`input::beginning`], for readers of anything but images, which images are given to by mistake: names
/// their format.
pub fn beginning(start: &[u8]) -> String {
    let is_image = Format::detect(start);
    let kind = is_image.map_or_else(String::new, |format| format!(", as {format} images do"));
    input::beginning(start) + &kind
}
