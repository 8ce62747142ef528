//! The directory of a TIFF's first image: its tags and their values.
//!
//! # Source
//! TIFF 6.0, section 2; BigTIFF.

use std::io::{Read, Seek, SeekFrom};

use super::tags::kind;
use super::{FORMAT, damaged};
use crate::ImageError;
use crate::header::MAX_ICC_BYTES;

/// Limit of a tag's value: more than any profile, and than the places of 4 million strips or tiles.
const MAX_VALUE_BYTES: u64 = 2 * MAX_ICC_BYTES as u64;

/// Limit of a directory, which BigTIFF does not have. As many as in other TIFFs.
const MAX_ENTRIES: u64 = u16::MAX as u64;

/// A directory, whose values are read on demand.
pub(super) struct Directory<R> {
    reader: R,
    order: ByteOrder,
    is_big: bool,
    entries: Vec<Entry>,
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    tag: u16,
    kind: u16,
    count: u64,
    /// The value, or its place if it is longer than the field.
    field: [u8; 8],
}

/// The order of bytes in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    /// A number of up to 8 bytes.
    pub(super) fn number(self, bytes: &[u8]) -> u64 {
        let append = |number, &byte: &u8| number << 8 | u64::from(byte);
        match self {
            Self::Little => bytes.iter().rev().fold(0, append),
            Self::Big => bytes.iter().fold(0, append),
        }
    }
}

impl<R: Read + Seek> Directory<R> {
    /// Reads the header and the first directory of a file.
    pub(super) fn first(mut reader: R) -> Result<Self, ImageError> {
        let start: [u8; 4] = read_array(&mut reader)?;
        let (order, version) = match start {
            [b'I', b'I', version, 0] => (ByteOrder::Little, version),
            [b'M', b'M', 0, version] => (ByteOrder::Big, version),
            _ => return Err(damaged("it does not start as a TIFF")),
        };
        let is_big = version == 43;
        let at = if is_big {
            let [offset_bytes, _] = [read_array::<2>(&mut reader)?, read_array::<2>(&mut reader)?];
            if order.number(&offset_bytes) != 8 {
                return Err(damaged("offsets must have 8 bytes"));
            }
            order.number(&read_array::<8>(&mut reader)?)
        } else {
            order.number(&read_array::<4>(&mut reader)?)
        };
        let mut directory = Self { reader, order, is_big, entries: Vec::new() };
        directory.go_to(at)?;
        Ok(directory)
    }

    /// Replaces the entries by those of the directory at an offset.
    pub(super) fn go_to(&mut self, at: u64) -> Result<(), ImageError> {
        let (count_bytes, entry_bytes) = if self.is_big { (8, 20) } else { (2, 12) };
        let count = self.order.number(&self.read(at, count_bytes)?);
        if count == 0 || count > MAX_ENTRIES {
            let reason = format!("a directory must have 1 to {MAX_ENTRIES} entries, got {count}");
            return Err(damaged(reason));
        }
        let bytes = self.read(at.saturating_add(count_bytes), count * entry_bytes)?;
        let field_bytes = self.field_bytes();
        let entry = |bytes: &[u8]| {
            let (tag, kind) = (self.order.number(&bytes[..2]), self.order.number(&bytes[2..4]));
            let mut field = [0; 8];
            field[..field_bytes].copy_from_slice(&bytes[4 + field_bytes..]);
            let count = self.order.number(&bytes[4..4 + field_bytes]);
            Entry { tag: tag as u16, kind: kind as u16, count, field }
        };
        self.entries = bytes.chunks_exact(entry_bytes as usize).map(entry).collect();
        Ok(())
    }

    pub(super) fn order(&self) -> ByteOrder {
        self.order
    }

    /// Bytes of a count, an offset and a field of an entry.
    fn field_bytes(&self) -> usize {
        if self.is_big { 8 } else { 4 }
    }

    /// The type and the bytes of a tag's values.
    fn value(&mut self, tag: u16) -> Result<Option<(u16, Vec<u8>)>, ImageError> {
        let Some(&Entry { kind, count, field, .. }) =
            self.entries.iter().find(|entry| entry.tag == tag)
        else {
            return Ok(None);
        };
        let each = bytes_of(kind).ok_or_else(|| damaged(format!("tag {tag} has type {kind}")))?;
        let length = count.saturating_mul(each);
        if length > MAX_VALUE_BYTES {
            let reason =
                format!("tag {tag} must have at most {MAX_VALUE_BYTES} bytes, got {length}");
            return Err(damaged(reason));
        }
        let field = &field[..self.field_bytes()];
        let bytes = match field.get(..length as usize) {
            Some(value) => value.to_vec(),
            None => self.read(self.order.number(field), length)?,
        };
        Ok(Some((kind, bytes)))
    }

    /// Unsigned integers; `None` without the tag or without values.
    pub(super) fn numbers(&mut self, tag: u16) -> Result<Option<Vec<u64>>, ImageError> {
        let Some((kind, bytes)) = self.value(tag)? else { return Ok(None) };
        if !is_unsigned(kind) {
            return Err(damaged(format!("tag {tag} must be unsigned integers, got type {kind}")));
        }
        let each = bytes_of(kind).unwrap_or(1) as usize;
        let numbers = bytes.chunks_exact(each).map(|bytes| self.order.number(bytes)).collect();
        Ok(Some(numbers).filter(|numbers: &Vec<_>| !numbers.is_empty()))
    }

    /// As [`Self::numbers`], of 16 bits.
    pub(super) fn shorts(&mut self, tag: u16) -> Result<Option<Vec<u16>>, ImageError> {
        let short = |number| {
            let reason = || damaged(format!("tag {tag} must be at most 65535, got {number}"));
            u16::try_from(number).map_err(|_| reason())
        };
        let numbers = self.numbers(tag)?;
        numbers.map(|numbers| numbers.into_iter().map(short).collect()).transpose()
    }

    /// The first of [`Self::numbers`].
    pub(super) fn number(&mut self, tag: u16) -> Result<Option<u64>, ImageError> {
        Ok(self.numbers(tag)?.and_then(|numbers| numbers.first().copied()))
    }

    /// The first of [`Self::shorts`].
    pub(super) fn short(&mut self, tag: u16) -> Result<Option<u16>, ImageError> {
        Ok(self.shorts(tag)?.and_then(|numbers| numbers.first().copied()))
    }

    /// Numbers that may be fractions.
    pub(super) fn fractions(&mut self, tag: u16) -> Result<Option<Vec<f64>>, ImageError> {
        match self.value(tag)? {
            Some((kind::RATIONAL, bytes)) => {
                let (halves, _) = bytes.as_chunks::<4>();
                let number = |bytes: &[u8; 4]| self.order.number(bytes) as f64;
                Ok(Some(halves.as_chunks().0.iter().map(|[a, b]| number(a) / number(b)).collect()))
            }
            Some(_) => {
                let numbers = self.numbers(tag)?;
                Ok(numbers.map(|numbers| numbers.into_iter().map(|number| number as f64).collect()))
            }
            None => Ok(None),
        }
    }

    /// A value of any bytes.
    pub(super) fn bytes(&mut self, tag: u16) -> Result<Option<Vec<u8>>, ImageError> {
        match self.value(tag)? {
            Some((kind::BYTE | kind::UNDEFINED, bytes)) => Ok(Some(bytes)),
            Some((kind, _)) => Err(damaged(format!("tag {tag} must be bytes, got type {kind}"))),
            None => Ok(None),
        }
    }

    /// Bytes of the file. The memory grows with what is really there.
    fn read(&mut self, at: u64, length: u64) -> Result<Vec<u8>, ImageError> {
        let io = |error| ImageError::from_io(FORMAT, &error);
        self.reader.seek(SeekFrom::Start(at)).map_err(io)?;
        let mut bytes = Vec::new();
        self.reader.by_ref().take(length).read_to_end(&mut bytes).map_err(io)?;
        if bytes.len() as u64 != length {
            return Err(ImageError::Truncated { format: FORMAT });
        }
        Ok(bytes)
    }
}

fn read_array<const N: usize>(reader: &mut impl Read) -> Result<[u8; N], ImageError> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes).map_err(|error| ImageError::from_io(FORMAT, &error))?;
    Ok(bytes)
}

/// Bytes of a value of a type; `None` if TIFF has no such type.
fn bytes_of(kind: u16) -> Option<u64> {
    /// Of the types from 0 on.
    const BYTES: [u64; 19] = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8];
    BYTES.get(usize::from(kind)).copied().filter(|&bytes| bytes > 0)
}

fn is_unsigned(kind: u16) -> bool {
    use kind::{BYTE, IFD, IFD8, LONG, LONG8, SHORT};
    [BYTE, SHORT, LONG, LONG8, IFD, IFD8].contains(&kind)
}
