//! Scans the bytes of a pickle and the encodings of instruction arguments.

use std::borrow::Cow;

use super::error::PickleError;
use crate::obj::shown;

/// The position of the scanner.
pub(super) struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Start of the current instruction, for messages.
    pub(super) instruction: usize,
}

impl<'a> Scan<'a> {
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, instruction: 0 }
    }

    pub(super) fn next_instruction(&mut self) -> Result<u8, PickleError> {
        self.instruction = self.at;
        self.byte()
    }

    pub(super) const fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    pub(super) fn malformed(&self, problem: impl Into<String>) -> PickleError {
        PickleError::Malformed { at: self.instruction, problem: problem.into() }
    }

    /// A number of bytes, if available.
    pub(super) fn take(&mut self, count: u64) -> Result<&'a [u8], PickleError> {
        let rest = &self.bytes[self.at..];
        let taken = usize::try_from(count).ok().and_then(|count| rest.get(..count));
        let taken =
            taken.ok_or(PickleError::Truncated { at: self.at, needed: count, left: rest.len() })?;
        self.at += taken.len();
        Ok(taken)
    }

    pub(super) fn byte(&mut self) -> Result<u8, PickleError> {
        Ok(self.unsigned(1)? as u8)
    }

    /// A little-endian unsigned number of `width` bytes, at most eight.
    pub(super) fn unsigned(&mut self, width: u64) -> Result<u64, PickleError> {
        let bytes = self.take(width)?;
        Ok(bytes.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }

    /// Bytes prefixed by their count, which is `width` bytes wide.
    pub(super) fn counted(&mut self, width: u64) -> Result<&'a [u8], PickleError> {
        let count = self.unsigned(width)?;
        self.take(count)
    }

    pub(super) fn counted_text(&mut self, width: u64) -> Result<Cow<'a, str>, PickleError> {
        let bytes = self.counted(width)?;
        let text = std::str::from_utf8(bytes);
        text.map(Cow::Borrowed).map_err(|_| self.malformed("string is not UTF-8"))
    }

    /// A little-endian signed number of any width that fits 64 bits.
    pub(super) fn signed(&mut self, width: u64) -> Result<i64, PickleError> {
        let bytes = self.take(width)?;
        let negative = bytes.last().is_some_and(|&last| last >= 0x80);
        let filler = if negative { 0xff } else { 0 };
        let (low, high) = bytes.split_at(bytes.len().min(8));
        let mut word = [filler; 8];
        word[..low.len()].copy_from_slice(low);
        let number = i64::from_le_bytes(word);
        if high.iter().any(|&byte| byte != filler) || (number < 0) != negative {
            return Err(self.malformed("integer does not fit 64 bits"));
        }
        Ok(number)
    }

    /// Bytes up to the next line feed.
    pub(super) fn line(&mut self) -> Result<&'a [u8], PickleError> {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|&byte| byte == b'\n').ok_or(PickleError::Truncated {
            at: self.at,
            needed: rest.len() as u64 + 1,
            left: rest.len(),
        })?;
        self.at += end + 1;
        Ok(&rest[..end])
    }

    pub(super) fn text_line(&mut self) -> Result<&'a str, PickleError> {
        let line = self.line()?;
        std::str::from_utf8(line).map_err(|_| self.malformed("name is not UTF-8"))
    }

    /// A decimal number; Python 2 ends long ones in `L`.
    pub(super) fn number_line<T: std::str::FromStr>(&mut self) -> Result<T, PickleError> {
        let line = self.line()?;
        self.number(line)
    }

    pub(super) fn number<T: std::str::FromStr>(&self, line: &[u8]) -> Result<T, PickleError> {
        let digits = std::str::from_utf8(line.strip_suffix(b"L").unwrap_or(line));
        let number = digits.ok().and_then(|digits| digits.parse().ok());
        number.ok_or_else(|| self.malformed(format!("must be a number, got `{}`", shown(line))))
    }

    /// A line of text with `\u` or `\U` escapes for characters beyond Latin-1.
    pub(super) fn escaped_text_line(&mut self) -> Result<String, PickleError> {
        let mut rest = self.line()?;
        let mut text = String::new();
        while let Some((&byte, after)) = rest.split_first() {
            let digits = match rest {
                [b'\\', b'u', ..] => 4,
                [b'\\', b'U', ..] => 8,
                _ => {
                    text.push(char::from(byte));
                    rest = after;
                    continue;
                }
            };
            let code = rest.get(2..2 + digits).and_then(hexadecimal);
            let character = code.and_then(char::from_u32);
            text.push(character.ok_or_else(|| self.malformed("invalid escape in a string"))?);
            rest = &rest[2 + digits..];
        }
        Ok(text)
    }

    /// A line with a quoted byte string, as Python 2 prints it.
    pub(super) fn quoted_line(&mut self) -> Result<Vec<u8>, PickleError> {
        let line = self.line()?;
        let mut rest = match line {
            [b'\'', inner @ .., b'\''] | [b'"', inner @ .., b'"'] => inner,
            _ => return Err(self.malformed("string without quotes")),
        };
        let mut bytes = Vec::with_capacity(rest.len());
        while let Some((&byte, after)) = rest.split_first() {
            let (byte, used) = match (byte, after) {
                (b'\\', [b'x', ..]) => {
                    let code = after.get(1..3).and_then(hexadecimal);
                    let code = code.ok_or_else(|| self.malformed("invalid escape in a string"))?;
                    (code as u8, 4)
                }
                (b'\\', [b'n', ..]) => (b'\n', 2),
                (b'\\', [b'r', ..]) => (b'\r', 2),
                (b'\\', [b't', ..]) => (b'\t', 2),
                (b'\\', [quoted @ (b'\\' | b'\'' | b'"'), ..]) => (*quoted, 2),
                (b'\\', _) => return Err(self.malformed("invalid escape in a string")),
                _ => (byte, 1),
            };
            bytes.push(byte);
            rest = &rest[used..];
        }
        Ok(bytes)
    }
}

fn hexadecimal(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |code, &digit| Some(code << 4 | char::from(digit).to_digit(16)?))
}
