//! Filters and compresses pieces of rows in parallel.

use std::io::{self, Write};

use uvgraft::threads;

use super::deflate;

/// Bytes of rows in a piece, unless a row is longer.
pub(super) const PIECE: usize = 1 << 19;

/// Pieces processed at once, which bounds memory.
pub(super) const AT_ONCE: usize = 16;

/// The compressed image data of a PNG, one IDAT chunk per piece. The boundaries of pieces depend on
/// the image alone, so the bytes depend neither on how rows arrive nor on threads.
pub(super) struct Pieces {
    row_bytes: usize,
    texel_bytes: usize,
    piece_bytes: usize,
    /// Rows of an incomplete piece.
    pending: Vec<u8>,
    /// One encoder per piece in flight, with reused buffers.
    encoders: Vec<PieceEncoder>,
    checksum: Adler32,
    has_begun: bool,
}

#[derive(Default)]
struct PieceEncoder {
    filtered: Vec<u8>,
    /// Begins with the chunk; never shortened, because filling it would take time.
    buffer: Vec<u8>,
    chunk_len: usize,
    checksum: Adler32,
}

/// A compressed piece: its chunk, and the checksum of what is in it.
#[derive(Debug)]
pub(super) struct Piece {
    chunk: Box<[u8]>,
    checksum: Adler32,
}

/// Number of rows in each piece but the last.
pub(super) fn rows_in_piece(row_bytes: usize) -> usize {
    (PIECE / row_bytes).max(1)
}

impl Pieces {
    pub(super) fn new(row_bytes: usize, texel_bytes: usize) -> Self {
        Self {
            row_bytes,
            texel_bytes,
            piece_bytes: rows_in_piece(row_bytes) * row_bytes,
            pending: Vec::new(),
            encoders: Vec::new(),
            checksum: Adler32::default(),
            has_begun: false,
        }
    }

    /// Takes whole unfiltered rows.
    pub(super) fn push(&mut self, mut rows: &[u8], out: &mut dyn Write) -> io::Result<()> {
        let mut pending = std::mem::take(&mut self.pending);
        let mut completed: &[u8] = &[];
        if !pending.is_empty() {
            let (taken, rest) = rows.split_at(rows.len().min(self.piece_bytes - pending.len()));
            pending.extend_from_slice(taken);
            rows = rest;
            if pending.len() == self.piece_bytes {
                completed = &pending;
            }
        }
        let whole = rows.chunks_exact(self.piece_bytes);
        let rest = whole.remainder();
        let pieces: Vec<&[u8]> =
            Some(completed).into_iter().filter(|piece| !piece.is_empty()).chain(whole).collect();
        let is_complete = !completed.is_empty();
        for pieces in pieces.chunks(AT_ONCE) {
            self.write(pieces, out)?;
        }
        if is_complete {
            pending.clear();
        }
        pending.extend_from_slice(rest);
        self.pending = pending;
        Ok(())
    }

    /// Takes a piece that is compressed already, after whole pieces only.
    pub(super) fn push_piece(&mut self, piece: &Piece, out: &mut dyn Write) -> io::Result<()> {
        self.has_begun = true;
        self.checksum.append(piece.checksum);
        out.write_all(&piece.chunk)
    }

    /// Writes the remaining data, and the end of the stream.
    pub(super) fn finish(mut self, out: &mut dyn Write) -> io::Result<()> {
        let pending = std::mem::take(&mut self.pending);
        if !pending.is_empty() {
            self.write(&[&pending], out)?;
        }
        let mut chunk = START.to_vec();
        chunk.extend(deflate::END);
        chunk.extend(self.checksum.value().to_be_bytes());
        chunk.extend([0; 4]);
        end_chunk(&mut chunk);
        out.write_all(&chunk)
    }

    fn write(&mut self, pieces: &[&[u8]], out: &mut dyn Write) -> io::Result<()> {
        let count = self.encoders.len().max(pieces.len());
        self.encoders.resize_with(count, PieceEncoder::default);
        let (row_bytes, texel_bytes, has_begun) =
            (self.row_bytes, self.texel_bytes, self.has_begun);
        threads::for_each(self.encoders.iter_mut().zip(pieces), |index, (encoder, piece)| {
            encoder.compress(piece, row_bytes, texel_bytes, !has_begun && index == 0);
        });
        self.has_begun = true;
        for encoder in &self.encoders[..pieces.len()] {
            out.write_all(encoder.chunk())?;
            self.checksum.append(encoder.checksum);
        }
        Ok(())
    }
}

impl Piece {
    /// Compresses the rows of a piece.
    ///
    /// - `is_first`: whether the stream begins with it.
    pub(super) fn new(rows: &[u8], row_bytes: usize, texel_bytes: usize, is_first: bool) -> Self {
        let mut encoder = PieceEncoder::default();
        encoder.compress(rows, row_bytes, texel_bytes, is_first);
        Self { chunk: encoder.chunk().into(), checksum: encoder.checksum }
    }

    /// Bytes that it occupies.
    pub(super) fn bytes(&self) -> usize {
        self.chunk.len()
    }
}

impl PieceEncoder {
    fn compress(&mut self, rows: &[u8], row_bytes: usize, texel_bytes: usize, is_first: bool) {
        self.filtered.resize(rows.len() / row_bytes * (row_bytes + 1), 0);
        let filtered = self.filtered.chunks_exact_mut(row_bytes + 1);
        for (filtered, row) in filtered.zip(rows.chunks_exact(row_bytes)) {
            filter(row, texel_bytes, filtered);
        }
        self.checksum = Adler32::of(&self.filtered);
        self.buffer.resize(self.buffer.len().max(START.len() + ZLIB.len()), 0);
        self.buffer[..START.len()].copy_from_slice(START);
        let mut end = START.len();
        if is_first {
            self.buffer[end..end + ZLIB.len()].copy_from_slice(&ZLIB);
            end += ZLIB.len();
        }
        end = deflate::compress(&self.filtered, end, &mut self.buffer);
        self.buffer.resize(self.buffer.len().max(end + 4), 0);
        self.chunk_len = end + 4;
        end_chunk(&mut self.buffer[..end + 4]);
    }

    fn chunk(&self) -> &[u8] {
        &self.buffer[..self.chunk_len]
    }
}

/// The filter Sub, which uses no other row: differences from the previous texel.
fn filter(row: &[u8], texel_bytes: usize, filtered: &mut [u8]) {
    const SUB: u8 = 1;
    let (first, rest) = filtered.split_at_mut(1 + texel_bytes);
    first[0] = SUB;
    first[1..].copy_from_slice(&row[..texel_bytes]);
    for ((to, value), before) in rest.iter_mut().zip(&row[texel_bytes..]).zip(row) {
        *to = value.wrapping_sub(*before);
    }
}

/// Space for the length of a chunk, and its type.
const START: &[u8; 8] = b"\0\0\0\0IDAT";

/// RFC 1950: deflate, a window of 32 KB, and check bits that make it divisible by 31.
pub(super) const ZLIB: [u8; 2] = [0x78, 0x01];

/// Fills in the length and the checksum, the last four bytes.
fn end_chunk(chunk: &mut [u8]) {
    let end = chunk.len() - 4;
    // At most 1.5 times a row of 256 KB, or a piece.
    let length = (end - START.len()) as u32;
    chunk[..4].copy_from_slice(&length.to_be_bytes());
    let checksum = crc32fast::hash(&chunk[4..end]);
    chunk[end..].copy_from_slice(&checksum.to_be_bytes());
}

/// The checksum of RFC 1950, section 8.2, of concatenated parts.
#[derive(Debug, Clone, Copy)]
struct Adler32 {
    sum: u32,
    sum_of_sums: u32,
    len: u64,
}

impl Default for Adler32 {
    fn default() -> Self {
        Self { sum: 1, sum_of_sums: 0, len: 0 }
    }
}

impl Adler32 {
    const MODULUS: u64 = 65_521;

    fn of(data: &[u8]) -> Self {
        let value = simd_adler32::adler32(&data);
        Self { sum: value & 0xffff, sum_of_sums: value >> 16, len: data.len() as u64 }
    }

    /// Each of the sums over `next` started at 1 instead of at this sum.
    fn append(&mut self, next: Self) {
        let before = u64::from(self.sum) + Self::MODULUS - 1;
        let sum_of_sums = u64::from(self.sum_of_sums)
            + u64::from(next.sum_of_sums)
            + before % Self::MODULUS * (next.len % Self::MODULUS);
        self.sum = ((before + u64::from(next.sum)) % Self::MODULUS) as u32;
        self.sum_of_sums = (sum_of_sums % Self::MODULUS) as u32;
        self.len += next.len;
    }

    fn value(self) -> u32 {
        self.sum_of_sums << 16 | self.sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_of_parts_make_that_of_the_whole() {
        let mut random = fastrand::Rng::with_seed(6);
        let data: Vec<u8> = (0..300_000).map(|_| random.u8(128..)).collect();
        for cut in [0, 1, 65_520, 65_521, 65_522, 299_999, 300_000] {
            let mut whole = Adler32::default();
            whole.append(Adler32::of(&data[..cut]));
            whole.append(Adler32::of(&data[cut..]));
            assert_eq!(whole.value(), Adler32::of(&data).value());
        }
        // RFC 1950's definition, by hand: 1 + 97 = 98, 98 + 98 = 196; 98, 98 + 196 = 294.
        assert_eq!(Adler32::of(b"ab").value(), 294 << 16 | 196);
    }
}
