//! Shards: parts of a batch that separate processes transfer.

use std::fmt::{self, Display};

use sha2::{Digest, Sha256};

use crate::failure::{Failure, Result};

/// One of several parts of a batch.
///
/// A texture belongs to the shard whose index is the first 8 bytes of the SHA-256 of its output's
/// name, as a big-endian number, modulo the number of shards. The name is the path within the
/// output folder in UTF-8, with `/` between its parts. Which other textures there are does not
/// matter, and the rule stays the same across versions and systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shard {
    index: u32,
    count: u32,
}

impl Shard {
    /// Shard number `index` of `count`, from 0.
    ///
    /// # Errors
    /// As bad input unless `index` is less than `count`.
    pub fn new(index: u32, count: u32) -> Result<Self> {
        if index < count {
            return Ok(Self { index, count });
        }
        Err(Failure::input(match count.checked_sub(1) {
            None => "the number of shards must be at least 1, got 0".to_owned(),
            Some(0) => format!("the only shard of 1 is number 0, got {index}"),
            Some(last) => format!("the shards of {count} are numbers 0 to {last}, got {index}"),
        }))
    }

    /// Parses `INDEX/COUNT`, such as `0/64`.
    ///
    /// # Errors
    /// As bad input, if the text is something else or [`Shard::new`] refuses the numbers.
    pub fn parse(text: &str) -> Result<Self> {
        let number = |text: &str| text.parse::<u32>().ok();
        match text.split_once('/').map(|(index, count)| (number(index), number(count))) {
            Some((Some(index), Some(count))) => Self::new(index, count),
            _ => Err(Failure::input(format!(
                "a shard must be two whole numbers such as 0/64, got {text:?}"
            ))),
        }
    }

    /// Its number, from 0.
    pub const fn index(self) -> u32 {
        self.index
    }

    /// The number of shards.
    pub const fn count(self) -> u32 {
        self.count
    }

    /// Whether an output belongs to it.
    ///
    /// - `name`: the output's path within the output folder, with `/` between its parts.
    pub fn has(self, name: &str) -> bool {
        let [start, ..] = *Sha256::digest(name.as_bytes()).as_chunks().0 else { return false };
        u64::from_be_bytes(start) % u64::from(self.count) == u64::from(self.index)
    }
}

impl Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A change here would make every cluster repeat its work:
    /// `int.from_bytes(hashlib.sha256(b"0001.png").digest()[:8], "big") % 64` in Python.
    #[test]
    fn membership_is_pinned() {
        for (name, index) in PINNED {
            let found: Vec<u32> = (0..64)
                .filter(|&index| Shard::new(index, 64).is_ok_and(|shard| shard.has(name)))
                .collect();
            assert_eq!(found, [index], "{name}");
        }
    }

    const PINNED: [(&str, u32); 3] = [("0001.png", 10), ("a/0001.png", 15), ("ä.png", 61)];

    #[test]
    fn shards_are_of_even_size() {
        let mut sizes = [0; 7];
        for name in 0..7000 {
            let has = |index: &u32| Shard { index: *index, count: 7 }.has(&format!("{name}.png"));
            sizes[(0..7).find(has).unwrap() as usize] += 1;
        }
        // The standard deviation is 29.
        assert!(sizes.iter().all(|size| (850..1150).contains(size)), "{sizes:?}");
    }

    #[test]
    fn numbers_are_checked() {
        assert_eq!(Shard::parse("3/4").unwrap(), Shard { index: 3, count: 4 });
        for (text, wanted) in [
            ("4/4", "the shards of 4 are numbers 0 to 3, got 4"),
            ("1/1", "the only shard of 1 is number 0, got 1"),
            ("0/0", "must be at least 1, got 0"),
            ("a/b", "must be two whole numbers such as 0/64, got \"a/b\""),
            ("3", "such as 0/64"),
            ("-1/4", "such as 0/64"),
            ("1/4/2", "such as 0/64"),
            ("", "such as 0/64"),
        ] {
            let failure = Shard::parse(text).unwrap_err().to_string();
            assert!(failure.contains(wanted), "{text}: {failure}");
        }
    }
}
