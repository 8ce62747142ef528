//! Reading of flatbuffers with every offset checked against the buffer.
//!
//! A table starts with a signed offset back to its vtable, which has 16 bits for each field: where
//! in the table the field is, or 0 if it has its default. Strings, vectors and other tables are
//! stored as unsigned offsets from where the offset itself is.
//!
//! # Source
//! The page "FlatBuffers internals" of the FlatBuffers documentation.

use super::TfliteError;

/// A buffer, whose root table is the first thing in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Buffer<'b> {
    bytes: &'b [u8],
}

/// A table of a buffer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Table<'b> {
    buffer: Buffer<'b>,
    at: usize,
    vtable: &'b [u8],
}

impl<'b> Buffer<'b> {
    pub(super) const fn new(bytes: &'b [u8]) -> Self {
        Self { bytes }
    }

    pub(super) fn root(self) -> Result<Table<'b>, TfliteError> {
        self.table(self.follow(0)?)
    }

    fn slice(self, at: usize, length: usize) -> Result<&'b [u8], TfliteError> {
        let end = at.checked_add(length);
        end.and_then(|end| self.bytes.get(at..end)).ok_or(TfliteError::Offset { at })
    }

    fn array<const N: usize>(self, at: usize) -> Result<[u8; N], TfliteError> {
        self.slice(at, N)?.first_chunk().copied().ok_or(TfliteError::Offset { at })
    }

    /// The place that the offset stored at a place refers to.
    fn follow(self, at: usize) -> Result<usize, TfliteError> {
        let offset = u32::from_le_bytes(self.array(at)?) as usize;
        at.checked_add(offset).ok_or(TfliteError::Offset { at })
    }

    fn table(self, at: usize) -> Result<Table<'b>, TfliteError> {
        let back = i64::from(i32::from_le_bytes(self.array(at)?));
        let start = usize::try_from(at as i64 - back).map_err(|_| TfliteError::Offset { at })?;
        let length = usize::from(u16::from_le_bytes(self.array(start)?));
        Ok(Table { buffer: self, at, vtable: self.slice(start, length)? })
    }

    /// The elements of a vector as bytes.
    fn vector(self, at: usize, element: usize) -> Result<(usize, &'b [u8]), TfliteError> {
        let start = self.follow(at)?;
        let count = u32::from_le_bytes(self.array(start)?) as usize;
        let bytes = count.checked_mul(element).ok_or(TfliteError::Offset { at: start })?;
        // `array` has found four bytes at `start`, so this does not overflow.
        Ok((start + 4, self.slice(start + 4, bytes)?))
    }
}

impl<'b> Table<'b> {
    /// Where a field is; `None` if it has its default.
    fn place(self, field: usize) -> Option<usize> {
        // The length of the vtable and that of the table come first.
        let entry = self.vtable.get(4 + 2 * field..)?.first_chunk()?;
        let offset = usize::from(u16::from_le_bytes(*entry));
        if offset == 0 { None } else { self.at.checked_add(offset) }
    }

    fn bytes<const N: usize>(self, field: usize) -> Result<Option<[u8; N]>, TfliteError> {
        self.place(field).map(|at| self.buffer.array(at)).transpose()
    }

    pub(super) fn u8(self, field: usize) -> Result<u8, TfliteError> {
        Ok(self.bytes(field)?.map_or(0, u8::from_le_bytes))
    }

    pub(super) fn i32(self, field: usize, default: i32) -> Result<i32, TfliteError> {
        Ok(self.bytes(field)?.map_or(default, i32::from_le_bytes))
    }

    pub(super) fn u32(self, field: usize) -> Result<u32, TfliteError> {
        Ok(self.bytes(field)?.map_or(0, u32::from_le_bytes))
    }

    pub(super) fn table(self, field: usize) -> Result<Option<Self>, TfliteError> {
        let Some(at) = self.place(field) else { return Ok(None) };
        self.buffer.table(self.buffer.follow(at)?).map(Some)
    }

    /// A vector of bytes; empty if there is none.
    pub(super) fn byte_vector(self, field: usize) -> Result<&'b [u8], TfliteError> {
        let Some(at) = self.place(field) else { return Ok(&[]) };
        Ok(self.buffer.vector(at, 1)?.1)
    }

    /// A vector of at most `most` integers; empty if there is none. Without the limit, many tables
    /// could share one long vector, and reading them would multiply it.
    pub(super) fn i32_vector(self, field: usize, most: usize) -> Result<Vec<i32>, TfliteError> {
        let Some(at) = self.place(field) else { return Ok(Vec::new()) };
        let (start, bytes) = self.buffer.vector(at, 4)?;
        if bytes.len() / 4 > most {
            return Err(TfliteError::Length { at: start, found: bytes.len() / 4, most });
        }
        Ok(bytes.as_chunks::<4>().0.iter().map(|&word| i32::from_le_bytes(word)).collect())
    }

    /// A vector of tables; empty if there is none.
    pub(super) fn tables(self, field: usize) -> Result<Vec<Self>, TfliteError> {
        let Some(at) = self.place(field) else { return Ok(Vec::new()) };
        let (start, bytes) = self.buffer.vector(at, 4)?;
        let places = (0..bytes.len() / 4).map(|index| start + 4 * index);
        places.map(|at| self.buffer.table(self.buffer.follow(at)?)).collect()
    }
}
