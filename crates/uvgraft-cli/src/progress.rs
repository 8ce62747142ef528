//! Progress bars on standard error, shown only if that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar of `count` steps with the given template.
pub(crate) fn bar(count: u64, template: &str) -> ProgressBar {
    let bar = ProgressBar::new(count);
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
