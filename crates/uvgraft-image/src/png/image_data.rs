//! The image data of a PNG: inflated from its IDAT chunks, with a window of a few rows.

use std::io::{self, BufRead, Seek, SeekFrom};

use crc32fast::Hasher;
use fdeflate::{DecompressionError, Decompressor};

use super::FORMAT;
use super::piece_reader::PieceReader;
use super::pieces::ZLIB;
use crate::ImageError;

/// How far back deflate refers.
pub(super) const LOOKBACK: usize = 1 << 15;

/// Bytes of rows inflated at once, unless eight rows are longer: fits a second-level cache.
const WINDOW: usize = 1 << 18;
const AT_LEAST: usize = 8;

/// Filtered rows in order.
pub(super) struct ImageData<R> {
    source: R,
    chunk: Chunk,
    /// What the stream begins with, if that is our own, and whether it is over.
    pieces: PieceReader,
    is_in_order: bool,
    inflater: Decompressor,
    buffer: Vec<u8>,
    /// The part of the buffer that was returned, and that which is filled.
    taken: usize,
    filled: usize,
    /// Bytes of the image that are not inflated.
    left: u64,
    /// Bytes of a filtered row.
    row: usize,
}

/// The current chunk.
pub(super) struct Chunk {
    kind: [u8; 4],
    pub(super) left: u32,
    checksum: Hasher,
}

impl<R: BufRead + Seek> ImageData<R> {
    /// - `start`: where the first IDAT chunk is.
    /// - `row`: bytes of a filtered row.
    pub(super) fn new(
        mut source: R,
        start: u64,
        row: usize,
        height: u32,
    ) -> Result<Self, ImageError> {
        source.seek(SeekFrom::Start(start)).map_err(from_io)?;
        let chunk = Chunk::start(&mut source)?;
        let left = row as u64 * u64::from(height);
        let mut inflater = Decompressor::new();
        // Chunks have checksums of their own, and other readers ignore this one, too.
        inflater.ignore_adler32();
        let most = LOOKBACK + WINDOW.max(AT_LEAST * row);
        let buffer = vec![0; left.min(most as u64) as usize];
        Ok(Self {
            source,
            chunk,
            pieces: PieceReader::new(start, row),
            is_in_order: false,
            inflater,
            buffer,
            taken: 0,
            filled: 0,
            left,
            row,
        })
    }

    /// The next rows: `most`, or as many as fit into the window. No more than the image has may be
    /// asked for.
    pub(super) fn rows(&mut self, most: usize) -> Result<&[u8], ImageError> {
        if !self.is_in_order {
            if self.pieces.has_rows(&mut self.source, &mut self.chunk, &mut self.left)? {
                return Ok(self.pieces.rows(most));
            }
            self.go_on_in_order()?;
        }
        self.rows_in_order(most)
    }

    /// Ends the pieces.
    fn go_on_in_order(&mut self) -> Result<(), ImageError> {
        self.is_in_order = true;
        let before = self.pieces.before();
        self.buffer[..before.len()].copy_from_slice(before);
        (self.taken, self.filled) = (before.len(), before.len());
        if !before.is_empty() {
            // The pieces had the header of the stream.
            let _ =
                self.inflater.read(&ZLIB, &mut [], 0, false).map_err(|error| corrupt(&error))?;
        }
        Ok(())
    }

    fn rows_in_order(&mut self, most: usize) -> Result<&[u8], ImageError> {
        let at_once = (WINDOW / self.row).max(AT_LEAST);
        let wanted = most.min(at_once) * self.row;
        if self.taken + wanted > self.buffer.len() {
            let kept = self.taken.min(self.filled.saturating_sub(LOOKBACK));
            self.buffer.copy_within(kept..self.filled, 0);
            self.taken -= kept;
            self.filled -= kept;
        }
        while self.filled - self.taken < wanted {
            self.inflate()?;
        }
        let rows = self.taken..self.taken + wanted;
        self.taken = rows.end;
        Ok(&self.buffer[rows])
    }

    fn inflate(&mut self) -> Result<(), ImageError> {
        while self.chunk.is_data() && self.chunk.left == 0 {
            self.chunk = self.chunk.next(&mut self.source)?;
        }
        let is_data = self.chunk.is_data();
        let input = if is_data { self.chunk.part(&mut self.source)? } else { &[] };
        let left = usize::try_from(self.left).unwrap_or(usize::MAX);
        let end = self.buffer.len().min(self.filled.saturating_add(left));
        let (used, made) = self
            .inflater
            .read(input, &mut self.buffer[..end], self.filled, false)
            .map_err(|error| corrupt(&error))?;
        self.chunk.checksum.update(&input[..used]);
        self.chunk.left -= used as u32;
        self.source.consume(used);
        self.filled += made;
        self.left -= made as u64;
        if made == 0 && (self.inflater.is_done() || !is_data) {
            self.finish()?;
            return Err(if self.inflater.is_done() {
                ImageError::damaged(FORMAT, "IDAT chunks have too few rows")
            } else {
                corrupt(&DecompressionError::InsufficientInput)
            });
        }
        Ok(())
    }

    /// Verifies the rest of the file.
    pub(super) fn finish(&mut self) -> Result<(), ImageError> {
        let Self { source, chunk, .. } = self;
        while chunk.is_data() {
            while chunk.left > 0 {
                let part = chunk.part(source)?;
                let len = part.len();
                chunk.checksum.update(part);
                chunk.left -= len as u32;
                source.consume(len);
            }
            *chunk = chunk.next(source)?;
        }
        while chunk.kind != *b"IEND" {
            const CHECKSUM: i64 = 4;
            source.seek_relative(i64::from(chunk.left) + CHECKSUM).map_err(from_io)?;
            *chunk = Chunk::start(source)?;
        }
        if chunk.left > 0 {
            return Err(ImageError::damaged(FORMAT, "the IEND chunk is not empty"));
        }
        chunk.verify(source)
    }
}

impl Chunk {
    /// Bytes of a chunk besides its data.
    pub(super) const AROUND: u64 = 12;

    pub(super) fn start(source: &mut impl BufRead) -> Result<Self, ImageError> {
        let mut start = [0; 8];
        source.read_exact(&mut start).map_err(from_io)?;
        let [l0, l1, l2, l3, kind @ ..] = start;
        let left = u32::from_be_bytes([l0, l1, l2, l3]);
        Ok(Self { kind, left, checksum: Self::checksum(kind) })
    }

    /// The checksum of the type, to which that of the data is added.
    pub(super) fn checksum(kind: [u8; 4]) -> Hasher {
        let mut checksum = Hasher::new();
        checksum.update(&kind);
        checksum
    }

    pub(super) fn is_data(&self) -> bool {
        self.kind == *b"IDAT"
    }

    /// What is buffered of the chunk, at least a byte.
    fn part<'a>(&self, source: &'a mut impl BufRead) -> Result<&'a [u8], ImageError> {
        let part = source.fill_buf().map_err(from_io)?;
        if part.is_empty() {
            return Err(from_io(io::ErrorKind::UnexpectedEof.into()));
        }
        Ok(&part[..part.len().min(self.left as usize)])
    }

    /// Ends this chunk, of which nothing is left, and starts the next one.
    fn next(&self, source: &mut impl BufRead) -> Result<Self, ImageError> {
        self.verify(source)?;
        Self::start(source)
    }

    fn verify(&self, source: &mut impl BufRead) -> Result<(), ImageError> {
        let mut stored = [0; 4];
        source.read_exact(&mut stored).map_err(from_io)?;
        let (stored, found) = (u32::from_be_bytes(stored), self.checksum.clone().finalize());
        if stored == found {
            return Ok(());
        }
        let kind = String::from_utf8_lossy(&self.kind);
        let reason = format_args!("CRC of an {kind} chunk is {found:08x}, should be {stored:08x}");
        Err(ImageError::damaged(FORMAT, reason))
    }
}

#[expect(clippy::needless_pass_by_value, reason = "for `map_err`")]
pub(super) fn from_io(error: io::Error) -> ImageError {
    ImageError::from_io(FORMAT, &error)
}

fn corrupt(error: &DecompressionError) -> ImageError {
    ImageError::damaged(FORMAT, format_args!("corrupt deflate stream: {error:?}"))
}
