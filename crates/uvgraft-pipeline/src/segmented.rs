//! Composites over a base in memory, and encodes segments that stay unchanged only once.

use std::ops::Range;
use std::result::Result as StdResult;
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};
use std::thread;

use uvgraft::{Overlay, TexelFormat, Texture, threads};
use uvgraft_image::{Segment, Segments, WriteError};

use crate::base::Base;
use crate::failure::{Blame, Failure, Result};
use crate::observer::Observer;
use crate::spawn::{self, spawn_with};
use crate::stream::rows_in_band;
use crate::target::{Encoded, Sink};
use crate::unchanged::{SegmentKind, Unchanged};

/// A base in memory, a texture to lay over it, and what previous results have in common with this
/// one.
pub(crate) struct Segmented<'a> {
    pub(crate) base: &'a Base,
    /// A format returned by [`Base::under`].
    pub(crate) format: TexelFormat,
    pub(crate) overlay: &'a Overlay,
    pub(crate) unchanged: &'a Unchanged,
    pub(crate) segments: Segments,
}

/// Adjacent segments, all of which change or none.
struct Group {
    segments: Range<u32>,
    changes: bool,
}

/// What is written next.
enum Part<'a> {
    /// Rows to be encoded.
    Rows(Texture),
    Kept(&'a Segment),
    Encoded(Segment),
}

impl Segmented<'_> {
    /// Composites and encodes segment by segment.
    ///
    /// - `alone`: whether to encode on another thread meanwhile.
    ///
    /// # Errors
    /// Those of compositing or writing.
    pub(crate) fn run(
        &self,
        sink: Sink<'_>,
        alone: bool,
        observer: &dyn Observer,
    ) -> Result<StdResult<Encoded, WriteError>> {
        let kind = SegmentKind {
            base: self.format,
            conversion: self.overlay.conversion(),
            segments: self.segments,
        };
        let known = self.unchanged.of(kind, self.count() as usize);
        let (used, spare) = channel();
        if !alone {
            return self.run_here(sink, &known, (&used, &spare), observer);
        }
        thread::scope(|scope| {
            let (sender, receiver) = sync_channel(2);
            let encode = |(mut sink, parts, used): (Sink<'_>, Receiver<Part<'_>>, Sender<_>)| {
                for part in parts {
                    spawn::point();
                    // Fails harmlessly once no more bands are needed.
                    let _ = used.send(sink.write(part)?);
                }
                sink.finish()
            };
            let writing = match spawn_with(scope, (sink, receiver, used), encode) {
                Ok(writing) => writing,
                Err((sink, _, used)) => {
                    return self.run_here(sink, &known, (&used, &spare), observer);
                }
            };
            // If the writer failed, it returns its error below.
            let write = |part| sender.send(part).map_err(drop);
            let encoded = self.make(&known, observer, || spare.try_recv().ok().flatten(), write);
            drop(sender);
            let written = writing.join();
            let written = written.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            let written = written.ok_or_else(|| Failure::work("the encoder did not start"))?;
            encoded.map(|_| written)
        })
    }

    /// Composites and encodes on this thread.
    ///
    /// - `used`, `spare`: where bands go after use, and come from.
    fn run_here(
        &self,
        mut sink: Sink<'_>,
        known: &[OnceLock<Segment>],
        (used, spare): (&Sender<Option<Texture>>, &Receiver<Option<Texture>>),
        observer: &dyn Observer,
    ) -> Result<StdResult<Encoded, WriteError>> {
        let write = |part| {
            sink.write(part).map(|band| {
                let _ = used.send(band);
            })
        };
        let pushed = self.make(known, observer, || spare.try_recv().ok().flatten(), write)?;
        Ok(pushed.and_then(|()| sink.finish()))
    }

    /// Passes all parts of the result to `write`, from top to bottom, until it fails.
    fn make<'k, E>(
        &self,
        known: &'k [OnceLock<Segment>],
        observer: &dyn Observer,
        mut spare: impl FnMut() -> Option<Texture>,
        mut write: impl FnMut(Part<'k>) -> StdResult<(), E>,
    ) -> Result<StdResult<(), E>> {
        let mut next = 0;
        while next < self.count() {
            spawn::point();
            observer.check()?;
            let group = self.group(next);
            next = group.segments.end;
            if group.changes {
                let rows = self.rows(group.segments);
                let band = self.base.rows(rows.clone(), self.format, spare())?;
                let band = self.overlay.lay(rows.start, band).or_work()?;
                if let Err(error) = write(Part::Rows(band)) {
                    return Ok(Err(error));
                }
                continue;
            }
            let indices = group.segments.start as usize..group.segments.end as usize;
            let known = &known[indices.clone()];
            // Without waiting for other threads that encode the same segments, and may wait for
            // some of ours.
            let encoded = threads::map_indices(known.len(), |at| match known[at].get() {
                Some(segment) => Ok(Part::Kept(segment)),
                None => self.encode((indices.start + at) as u32, &known[at]),
            });
            for part in encoded {
                if let Err(error) = write(part?) {
                    return Ok(Err(error));
                }
            }
        }
        Ok(Ok(()))
    }

    /// Encodes a segment that does not change, and keeps it.
    fn encode<'k>(&self, index: u32, cell: &'k OnceLock<Segment>) -> Result<Part<'k>> {
        let rows = self.base.rows(self.rows(index..index + 1), self.format, None)?;
        let rows = self.overlay.conversion().apply(rows);
        let segment = self.segments.encode(index, &rows).or_work()?;
        let left = self.unchanged.keep(cell, segment);
        Ok(match (left, cell.get()) {
            (None, Some(segment)) => Part::Kept(segment),
            (Some(segment), _) => Part::Encoded(segment),
            (None, None) => unreachable!("kept just now"),
        })
    }

    /// The group that starts with a segment: as many as all threads need.
    fn group(&self, first: u32) -> Group {
        let changes = |index: u32| self.overlay.changes(self.rows(index..index + 1));
        let (rows, row_bytes) = (self.segments.rows(), self.base.row_bytes(self.format));
        let most = if threads::count() > 1 { (rows_in_band(row_bytes) / rows).max(1) } else { 1 };
        let of_first = changes(first);
        let last = (first + most).min(self.count());
        let end = (first + 1..last).find(|&index| changes(index) != of_first).unwrap_or(last);
        Group { segments: first..end, changes: of_first }
    }

    fn rows(&self, segments: Range<u32>) -> Range<u32> {
        let rows = self.segments.rows();
        segments.start * rows..(segments.end * rows).min(self.base.size().height)
    }

    /// Number of segments.
    fn count(&self) -> u32 {
        self.base.size().height.div_ceil(self.segments.rows())
    }
}

impl Sink<'_> {
    /// Writes a part, and returns its band for reuse.
    fn write(&mut self, part: Part<'_>) -> StdResult<Option<Texture>, WriteError> {
        match part {
            Part::Rows(band) => self.push(&band).map(|()| Some(band)),
            Part::Kept(segment) => self.push_segment(segment).map(|()| None),
            Part::Encoded(segment) => self.push_segment(&segment).map(|()| None),
        }
    }
}
