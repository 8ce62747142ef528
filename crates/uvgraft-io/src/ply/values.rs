//! The values after a PLY header, one after the other.

use super::PlyError;
use super::header::{Element, Encoding, Header, Property};
use crate::numpy::Dtype;
use crate::obj::shown;

/// A position in the values.
pub(super) struct Values<'a> {
    rest: &'a [u8],
    encoding: Encoding,
    /// Number of the current line; of text only.
    line: usize,
}

/// The place of a row, for messages.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    pub element: &'a Element,
    pub row: u64,
}

impl Row<'_> {
    pub(super) fn error(self, problem: impl Into<String>) -> PlyError {
        PlyError::Value {
            element: self.element.name.clone(),
            row: self.row,
            problem: problem.into(),
        }
    }

    fn truncated(self) -> PlyError {
        PlyError::Truncated { element: self.element.name.clone(), row: self.row }
    }
}

impl<'a> Values<'a> {
    pub(super) fn new(header: &Header, body: &'a [u8]) -> Self {
        Self { rest: body, encoding: header.encoding, line: header.lines + 1 }
    }

    /// Checks that the rows of an element fit into the rest of the file at all; returns their
    /// number, which may then size an allocation.
    pub(super) fn rows(&self, element: &Element) -> Result<usize, PlyError> {
        let text = self.encoding == Encoding::Ascii;
        let least = |property: &Property| match (text, property.list) {
            // A digit and a blank.
            (true, _) => 2,
            // A list may be empty.
            (false, list) => list.unwrap_or(property.scalar).width as u64,
        };
        let row: u64 = element.properties.iter().map(least).sum();
        let left = self.rest.len() as u64;
        // The last value of a text needs no blank.
        let needed = element.count.saturating_mul(row).saturating_sub(u64::from(text));
        if needed > left {
            let (element, count) = (element.name.clone(), element.count);
            return Err(PlyError::Claim { element, count, needed, left });
        }
        Ok(if row == 0 { 0 } else { element.count as usize })
    }

    /// The next value.
    pub(super) fn number(&mut self, scalar: Dtype, row: Row<'_>) -> Result<f64, PlyError> {
        let big_endian = match self.encoding {
            Encoding::Ascii => return self.word(scalar, row),
            Encoding::LittleEndian => false,
            Encoding::BigEndian => true,
        };
        let (word, rest) =
            self.rest.split_at_checked(scalar.width).ok_or_else(|| row.truncated())?;
        self.rest = rest;
        Ok(Dtype { big_endian, ..scalar }.number(word))
    }

    /// The values of a property: one, or those of a list, in `into`, which is cleared first.
    pub(super) fn property(
        &mut self,
        property: &Property,
        row: Row<'_>,
        into: &mut Vec<f64>,
    ) -> Result<(), PlyError> {
        into.clear();
        let count = match property.list {
            None => 1.0,
            Some(scalar) => self.number(scalar, row)?,
        };
        if count < 0.0 {
            let name = &property.name;
            return Err(row.error(format!("`{name}` must have 0 or more items, got {count}")));
        }
        // Not allocated in advance: each item takes at least a byte of the file.
        for _ in 0..count as u64 {
            into.push(self.number(property.scalar, row)?);
        }
        Ok(())
    }

    fn word(&mut self, scalar: Dtype, row: Row<'_>) -> Result<f64, PlyError> {
        self.skip_blanks();
        let length = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(length);
        self.rest = rest;
        if word.is_empty() {
            return Err(row.truncated());
        }
        let value: Option<f64> = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        value.filter(|value| !scalar.is_integer() || value.fract() == 0.0).ok_or_else(|| {
            let wanted = if scalar.is_integer() { "an integer" } else { "a number" };
            row.error(format!("must be {wanted}, got `{}` on line {}", shown(word), self.line))
        })
    }

    fn skip_blanks(&mut self) {
        while let [byte, rest @ ..] = self.rest
            && byte.is_ascii_whitespace()
        {
            // CR LF counts once; a text with CR alone has no further lines to count from.
            self.line += usize::from(*byte == b'\n');
            self.rest = rest;
        }
    }

    /// Checks that no text is left. Bytes after the rows of a binary file are ignored, as by other
    /// readers.
    pub(super) fn finish(mut self) -> Result<(), PlyError> {
        if self.encoding == Encoding::Ascii {
            self.skip_blanks();
            if !self.rest.is_empty() {
                return Err(PlyError::Surplus { line: self.line });
            }
        }
        Ok(())
    }
}
