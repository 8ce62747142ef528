//! Markdown tables, aligned to be readable as text.

use std::fmt::Write as _;

/// Alignment of a column.
#[derive(Clone, Copy)]
pub(crate) enum Align {
    Left,
    Centre,
    Right,
}

/// A table whose first row is the header. Columns are aligned as given, further ones to the right,
/// as for numbers.
pub(crate) fn table(rows: &[Vec<String>], aligns: &[Align]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|k| width(k).unwrap_or(0).max(3)).collect();
    let align = |column: usize| aligns.get(column).copied().unwrap_or(Align::Right);
    let mut text = String::new();
    for (index, row) in rows.iter().enumerate() {
        for ((k, cell), width) in row.iter().enumerate().zip(&widths) {
            let _ = match align(k) {
                Align::Left => write!(text, "| {cell:<width$} "),
                Align::Centre => write!(text, "| {cell:^width$} "),
                Align::Right => write!(text, "| {cell:>width$} "),
            };
        }
        text.push_str("|\n");
        if index == 0 {
            for (k, width) in widths.iter().enumerate() {
                let _ = match align(k) {
                    Align::Left => write!(text, "|:{}-", "-".repeat(*width)),
                    Align::Centre => write!(text, "|:{}:", "-".repeat(*width)),
                    Align::Right => write!(text, "|-{}:", "-".repeat(*width)),
                };
            }
            text.push_str("|\n");
        }
    }
    text
}
