//! UDIM tiles: unit squares of UV space, each with a texture of its own.

use std::fmt;
use std::str::FromStr;

/// A UDIM tile, named by its number: 1001 + column + 10 × row. Columns are 0 to 9, to the right; rows
/// start at 0 and count upwards. Numbers have four digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tile {
    number: u16,
}

/// Why a text is not the number of a tile.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("UDIM tile number must be from {} to {}, got {found}", Tile::FIRST, Tile::LAST)]
pub struct TileError {
    /// The text.
    pub found: String,
}

impl Tile {
    /// The unit square.
    pub const FIRST: Self = Self { number: 1001 };
    /// The last one whose number has four digits.
    pub const LAST: Self = Self { number: 9999 };

    /// The tile of a column and a row; `None` if the column is not one of 0 to 9, or the row is
    /// negative or beyond four digits.
    pub fn at(column: i32, row: i32) -> Option<Self> {
        if !(0..10).contains(&column) || !(0..900).contains(&row) {
            return None;
        }
        let number = u16::try_from(1001 + column + 10 * row).ok()?;
        (number <= Self::LAST.number).then_some(Self { number })
    }

    /// Its UDIM number, from 1001 to 9999.
    pub const fn number(self) -> u16 {
        self.number
    }

    /// Its column, 0 to 9: `u` is from there to one more.
    pub const fn column(self) -> u16 {
        (self.number - 1001) % 10
    }

    /// Its row from 0 upwards: with the origin of `v` at the bottom, `v` is from there to one more.
    pub const fn row(self) -> u16 {
        (self.number - 1001) / 10
    }
}

impl fmt::Display for Tile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.number)
    }
}

impl FromStr for Tile {
    type Err = TileError;

    fn from_str(text: &str) -> Result<Self, TileError> {
        let is_number = text.len() == 4 && text.bytes().all(|digit| digit.is_ascii_digit());
        let number = text.parse().ok().filter(|_| is_number);
        number
            .filter(|number| (Self::FIRST.number..=Self::LAST.number).contains(number))
            .map(|number| Self { number })
            .ok_or_else(|| TileError { found: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_columns_and_rows() {
        for (column, row, number) in
            [(0, 0, "1001"), (2, 0, "1003"), (9, 0, "1010"), (0, 1, "1011"), (8, 899, "9999")]
        {
            let tile = Tile::at(column, row).unwrap();
            assert_eq!(tile.to_string(), number);
            assert_eq!(number.parse(), Ok(tile));
            assert_eq!((i32::from(tile.column()), i32::from(tile.row())), (column, row));
        }
        for (column, row) in [(-1, 0), (10, 0), (0, -1), (9, 899), (0, i32::MAX)] {
            assert_eq!(Tile::at(column, row), None, "{column} {row}");
        }
        for bad in ["", "1000", "0999", "999", "10001", "+1001", " 1001", "100l"] {
            let error = bad.parse::<Tile>().unwrap_err().to_string();
            assert!(error.ends_with(&format!("from 1001 to 9999, got {bad}")), "{error}");
        }
    }
}
