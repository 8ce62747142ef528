//! Inflates the pieces of our own PNGs in parallel.
//!
//! Such a piece is one IDAT chunk of whole blocks, which ends at a whole byte and refers to nothing
//! before it. No file says so; so each chunk is inflated by itself, and the first that is anything
//! else ends the pieces: from there on the stream is inflated in order.

use std::io::{self, BufRead, Read, Seek, SeekFrom};

use fdeflate::Decompressor;
use uvgraft::threads;

use super::deflate;
use super::image_data::{Chunk, from_io};
use super::pieces::{AT_ONCE, ZLIB, rows_in_piece};
use crate::ImageError;

/// A few pieces that are inflated, and what comes after them.
pub(super) struct PieceReader {
    /// Bytes of a filtered row, and of the rows in a piece.
    row: usize,
    piece: usize,
    /// Where the current chunk starts.
    at: u64,
    slots: Vec<Slot>,
    /// Number of slots that hold rows, the one that rows are taken from, and the bytes taken of it.
    sound: usize,
    current: usize,
    taken: usize,
    /// The bytes before the first slot's; empty at the beginning of the stream.
    before: Vec<u8>,
    has_ended: bool,
}

/// A piece, with buffers that are used again.
#[derive(Default)]
struct Slot {
    /// Where its chunk starts.
    at: u64,
    /// A stream of this piece alone, and where the chunk's data are in it.
    stream: Vec<u8>,
    from: usize,
    /// As stored.
    checksum: [u8; 4],
    rows: Vec<u8>,
    len: usize,
    is_sound: bool,
}

/// With fewer threads, transfers take no less time: two are busy with other rows meanwhile (4 % longer
/// from file to file).
const FEWEST_THREADS: usize = 4;

/// Room for what a chunk may hold more than its piece should.
const ROOM: usize = 64;

/// What a piece ends with: the lengths of an empty stored block.
const ALIGNED: [u8; 4] = [0, 0, 0xff, 0xff];

/// A checksum of a stream, which is not looked at: chunks have their own.
const ADLER: [u8; 4] = [0; 4];

impl PieceReader {
    /// - `at`: where the first IDAT chunk starts.
    /// - `row`: bytes of a filtered row.
    pub(super) fn new(at: u64, row: usize) -> Self {
        Self {
            row,
            piece: rows_in_piece(row - 1) * row,
            at,
            slots: Vec::new(),
            sound: 0,
            current: 0,
            taken: 0,
            before: Vec::new(),
            has_ended: threads::count() < FEWEST_THREADS,
        }
    }

    /// Whether there are rows to take; inflates further pieces if there are any.
    ///
    /// - `source`, `chunk`: at the first chunk that is not inflated, before and after.
    /// - `left`: the bytes of the image that are not inflated, before and after.
    pub(super) fn has_rows(
        &mut self,
        source: &mut (impl BufRead + Seek),
        chunk: &mut Chunk,
        left: &mut u64,
    ) -> Result<bool, ImageError> {
        if self.current == self.sound && !self.has_ended {
            self.inflate(source, chunk, left)?;
        }
        Ok(self.current < self.sound)
    }

    /// The next rows, which there must be: `most`, or as many as their piece has.
    pub(super) fn rows(&mut self, most: usize) -> &[u8] {
        let slot = &self.slots[self.current];
        let end = slot.len.min(self.taken + most * self.row);
        let rows = &slot.rows[self.taken..end];
        self.taken = end;
        if end == slot.len {
            self.current += 1;
            self.taken = 0;
        }
        rows
    }

    /// The bytes of the image before the first chunk that is not inflated, as far as a stream can
    /// refer to them; empty at its beginning.
    pub(super) fn before(&self) -> &[u8] {
        self.slots[..self.sound].last().map_or(&self.before, Slot::end)
    }

    fn inflate(
        &mut self,
        source: &mut (impl BufRead + Seek),
        chunk: &mut Chunk,
        left: &mut u64,
    ) -> Result<(), ImageError> {
        if let Some(last) = self.slots[..self.sound].last() {
            self.before.clear();
            self.before.extend(last.end());
        }
        let (mut count, mut rest) = (0, *left);
        while count < threads::count().min(AT_ONCE) && rest > 0 && chunk.is_data() {
            let len = usize::try_from(rest).map_or(self.piece, |rest| rest.min(self.piece));
            if chunk.left as usize > ZLIB.len() + deflate::most(len) {
                break;
            }
            self.slots.resize_with(self.slots.len().max(count + 1), Slot::default);
            let slot = &mut self.slots[count];
            (slot.at, slot.len) = (self.at, len);
            let begins = self.before.is_empty() && count == 0;
            slot.read(source, chunk.left, begins).map_err(from_io)?;
            count += 1;
            rest -= len as u64;
            self.at += Chunk::AROUND + u64::from(chunk.left);
            *chunk = Chunk::start(source)?;
            if !slot.is_aligned() {
                break;
            }
        }
        threads::for_each(self.slots[..count].iter_mut(), |_, slot| slot.inflate());
        (self.sound, self.current) = (0, 0);
        for slot in self.slots[..count].iter().take_while(|slot| slot.is_sound) {
            self.sound += 1;
            *left -= slot.len as u64;
        }
        if self.sound < count {
            // Anything else, perhaps damaged: what it is turns out in order.
            self.at = self.slots[self.sound].at;
            source.seek(SeekFrom::Start(self.at)).map_err(from_io)?;
            *chunk = Chunk::start(source)?;
        }
        self.has_ended = self.sound < count || count == 0;
        Ok(())
    }
}

impl Slot {
    /// Reads the data of a chunk and its checksum.
    ///
    /// - `begins`: whether the stream begins with it.
    fn read(&mut self, source: &mut impl BufRead, len: u32, begins: bool) -> io::Result<()> {
        self.stream.clear();
        if !begins {
            self.stream.extend(ZLIB);
        }
        self.from = self.stream.len();
        if source.by_ref().take(len.into()).read_to_end(&mut self.stream)? < len as usize {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        source.read_exact(&mut self.checksum)
    }

    /// Most chunks of others are known by their end.
    fn is_aligned(&self) -> bool {
        self.stream.ends_with(&ALIGNED)
    }

    fn inflate(&mut self) {
        self.is_sound = self.is_aligned() && self.checksum() == self.checksum;
        if !self.is_sound {
            return;
        }
        // A stream can end here only after a whole block.
        self.stream.extend(deflate::END);
        self.stream.extend(ADLER);
        if self.rows.len() < self.len + ROOM {
            self.rows.resize(self.len + ROOM, 0);
        }
        let mut inflater = Decompressor::new();
        inflater.ignore_adler32();
        let ends = inflater.read(&self.stream, &mut self.rows[..self.len + ROOM], 0, true);
        self.is_sound =
            inflater.is_done() && ends.is_ok_and(|ends| ends == (self.stream.len(), self.len));
    }

    fn checksum(&self) -> [u8; 4] {
        let mut checksum = Chunk::checksum(*b"IDAT");
        checksum.update(&self.stream[self.from..]);
        checksum.finalize().to_be_bytes()
    }

    /// The last rows, as far as a stream can refer to them.
    fn end(&self) -> &[u8] {
        &self.rows[self.len.saturating_sub(super::image_data::LOOKBACK)..self.len]
    }
}
