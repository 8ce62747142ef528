//! Lists in messages, which files may make long, and large numbers.

use std::fmt::Display;

/// Most items that a message lists.
const MOST: usize = 10;

/// Items separated by commas, of which ten are listed: `a, b and 3 more`.
pub fn listed<T: Display>(items: impl IntoIterator<Item = T>) -> String {
    let mut items = items.into_iter();
    let shown: Vec<String> = items.by_ref().take(MOST).map(|item| item.to_string()).collect();
    let shown = shown.join(", ");
    match items.count() {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// A number with its digits in groups of three: `1,234`.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_items_are_listed() {
        assert_eq!(listed(["a", "b"]), "a, b");
        assert_eq!(listed(0..10), "0, 1, 2, 3, 4, 5, 6, 7, 8, 9");
        assert_eq!(listed(0..200), "0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and 190 more");
        assert_eq!(listed([0; 0]), "");
    }
}
