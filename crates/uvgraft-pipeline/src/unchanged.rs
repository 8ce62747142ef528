//! Segments of results that no texture of a batch changes: encoded once, and used for all of them.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use uvgraft::{BaseConversion, TexelFormat};
use uvgraft_image::{Segment, Segments};

use crate::base::Base;

/// The least limit in bytes, for bases of one colour: they occupy no memory, and their segments
/// compress well.
const MIN_LIMIT: u64 = 4 << 20;

/// What the bytes of an unchanged segment depend on, apart from its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct SegmentKind {
    /// The format of the base: that of a colour depends on the source.
    pub(crate) base: TexelFormat,
    pub(crate) conversion: BaseConversion,
    pub(crate) segments: Segments,
}

/// The segments of one kind, from top to bottom; those that no texture has needed yet are empty.
pub(crate) type Cells = Arc<[OnceLock<Segment>]>;

/// Encoded segments of one base.
pub(crate) struct Unchanged {
    by_kind: Mutex<HashMap<SegmentKind, Cells>>,
    /// Bytes that segments may occupy, and do.
    limit: u64,
    bytes: AtomicU64,
}

impl Unchanged {
    /// Nothing yet. No more is kept than half of what the base occupies; beyond, segments are encoded
    /// for each texture.
    pub(crate) fn of_base(base: &Base) -> Self {
        Self::new((base.bytes() / 2).max(MIN_LIMIT))
    }

    fn new(limit: u64) -> Self {
        Self { by_kind: Mutex::default(), limit, bytes: AtomicU64::new(0) }
    }

    /// Most bytes that they will occupy.
    pub(crate) fn limit(&self) -> u64 {
        self.limit
    }

    /// The segments of a kind, `count` in an image.
    pub(crate) fn of(&self, kind: SegmentKind, count: usize) -> Cells {
        let mut by_kind = self.by_kind.lock().unwrap_or_else(PoisonError::into_inner);
        by_kind.entry(kind).or_insert_with(|| (0..count).map(|_| OnceLock::new()).collect()).clone()
    }

    /// Keeps a segment if there is room; returns it if there is none, or if another thread was
    /// faster.
    ///
    /// - `cell`: that of the segment, from [`Unchanged::of`].
    pub(crate) fn keep(&self, cell: &OnceLock<Segment>, segment: Segment) -> Option<Segment> {
        let bytes = segment.bytes() as u64;
        let before = self.bytes.fetch_add(bytes, Ordering::Relaxed);
        let left =
            if before + bytes > self.limit { Some(segment) } else { cell.set(segment).err() };
        if left.is_some() {
            self.bytes.fetch_sub(bytes, Ordering::Relaxed);
        }
        left
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Depth, Encoding, Size, Texture};
    use uvgraft_image::{Format, TextureSpec, WriteOptions};

    use super::*;

    #[test]
    fn no_more_is_kept_than_there_is_room_for() {
        let size = Size::new(300, 40);
        let filled = Texture::filled(size, Channels::Grey, Encoding::Srgb, Depth::U8, &[0.5]);
        let rows = filled.unwrap();
        let spec = TextureSpec::from(&rows);
        let segments = Segments::new(Format::PNG, spec, &WriteOptions::default()).unwrap();
        let segment = || segments.encode(0, &rows).unwrap();
        let room = segment().bytes() as u64;
        let unchanged = Unchanged::new(2 * room + 1);
        let cells: Vec<OnceLock<Segment>> = (0..3).map(|_| OnceLock::new()).collect();
        assert!(unchanged.keep(&cells[0], segment()).is_none());
        // Another thread was faster.
        assert!(unchanged.keep(&cells[0], segment()).is_some());
        assert!(unchanged.keep(&cells[1], segment()).is_none());
        assert!(unchanged.keep(&cells[2], segment()).is_some());
        assert!(cells[1].get().is_some() && cells[2].get().is_none());
        assert_eq!(unchanged.bytes.into_inner(), 2 * room);
    }
}
