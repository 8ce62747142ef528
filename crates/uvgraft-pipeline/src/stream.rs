//! The streaming pipeline: decode the rows of a base, composite, encode.

use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread;

use uvgraft::layout_match::LayoutProbe;
use uvgraft::{Overlay, Texture};
use uvgraft_image::WriteError;

use crate::base::Bands;
use crate::failure::{Blame, Failure, Result};
use crate::observer::Observer;
use crate::spawn::{self, spawn_with};
use crate::target::{Encoded, Sink};

/// Bytes of decoded rows that may be queued while the source is prepared. With most of a base queued
/// a transfer took just as long, but 10 to 20 MB and some thousand page faults more.
const AHEAD: usize = 8 << 20;

/// Approximate size of a band in bytes: enough rows for every thread of a pool, few enough for the
/// caches.
const BAND: usize = 2 << 20;

/// Number of rows in a band of a base.
pub(crate) fn rows_in_band(row_bytes: usize) -> u32 {
    (BAND / row_bytes).max(1).next_multiple_of(16) as u32
}

/// Shows a band of the base to a probe, unless it has seen all of it.
fn look(probe: &mut Option<LayoutProbe<'_>>, first_row: u32, band: &Texture) {
    if let Some(probe) = probe {
        probe.look(first_row, band);
    }
}

/// Decodes, composites and encodes band after band.
///
/// - `probe`: looks at the base.
///
/// # Errors
/// Those of reading, compositing or writing.
pub(crate) fn run(
    mut bands: Bands<'_>,
    rows: u32,
    overlay: &Overlay,
    probe: &mut Option<LayoutProbe<'_>>,
    mut sink: Sink<'_>,
    observer: &dyn Observer,
) -> Result<std::result::Result<Encoded, WriteError>> {
    let mut first = 0;
    while let Some(band) = bands.next(rows)? {
        observer.check()?;
        let height = band.size().height;
        look(probe, first, &band);
        let band = overlay.lay(first, band).or_work()?;
        first += height;
        if let Err(error) = sink.push(&band) {
            return Ok(Err(error));
        }
        bands.recycle(band);
    }
    Ok(sink.finish())
}

/// The bands of a base, decoded ahead on a separate thread.
pub(crate) struct Ahead {
    bands: Receiver<Result<Texture>>,
    used: std::sync::mpsc::Sender<Texture>,
}

impl Ahead {
    /// Starts decoding; returns the bands if there is no thread for it.
    pub(crate) fn start<'scope>(
        scope: &'scope thread::Scope<'scope, '_>,
        bands: Bands<'scope>,
        rows: u32,
        row_bytes: usize,
    ) -> std::result::Result<Self, Bands<'scope>> {
        let most = AHEAD / (rows as usize * row_bytes);
        let (sender, receiver) = sync_channel(most.max(2));
        let (used, returned) = channel();
        spawn_with(scope, bands, move |mut bands| decode(&mut bands, rows, &sender, &returned))?;
        Ok(Self { bands: receiver, used })
    }

    /// Composites on this thread and encodes on another, or here if there is none.
    ///
    /// - `probe`: looks at the base.
    ///
    /// # Errors
    /// Those of reading, compositing or writing.
    pub(crate) fn run<'scope>(
        self,
        scope: &'scope thread::Scope<'scope, '_>,
        overlay: &Overlay,
        probe: &mut Option<LayoutProbe<'_>>,
        sink: Sink<'scope>,
        observer: &dyn Observer,
    ) -> Result<std::result::Result<Encoded, WriteError>> {
        let Self { bands, used } = self;
        let (sender, receiver) = sync_channel(2);
        let state = (sink, receiver, used);
        let writing = spawn_with(scope, state, |(sink, bands, used)| encode(sink, &bands, &used));
        let (writing, mut here) = match writing {
            Ok(writing) => (Some(writing), None),
            Err((sink, _, used)) => (None, Some((sink, used))),
        };
        let mut first = 0;
        for band in bands {
            spawn::point();
            observer.check()?;
            let band = band?;
            let height = band.size().height;
            look(probe, first, &band);
            let band = overlay.lay(first, band).or_work()?;
            first += height;
            if let Some((sink, used)) = &mut here {
                if let Err(error) = sink.push(&band) {
                    return Ok(Err(error));
                }
                let _ = used.send(band);
            } else if sender.send(band).is_err() {
                // The encoder failed, and returns its error below.
                break;
            }
        }
        drop(sender);
        match (writing.map(thread::ScopedJoinHandle::join), here) {
            (Some(Ok(Some(written))), _) => Ok(written),
            (Some(Err(panic)), _) => std::panic::resume_unwind(panic),
            (None, Some((sink, _))) => Ok(sink.finish()),
            (Some(Ok(None)) | None, _) => Err(Failure::work("the encoder did not start")),
        }
    }
}

fn decode(
    bands: &mut Bands<'_>,
    rows: u32,
    sender: &SyncSender<Result<Texture>>,
    returned: &Receiver<Texture>,
) {
    while let Some(band) = bands.next(rows).transpose() {
        spawn::point();
        let failed = band.is_err();
        if sender.send(band).is_err() || failed {
            return;
        }
        returned.try_iter().for_each(|band| bands.recycle(band));
    }
}

fn encode(
    mut sink: Sink<'_>,
    bands: &Receiver<Texture>,
    used: &std::sync::mpsc::Sender<Texture>,
) -> std::result::Result<Encoded, WriteError> {
    for band in bands {
        spawn::point();
        sink.push(&band)?;
        // Fails harmlessly once everything is decoded and buffers are no longer reused.
        let _ = used.send(band);
    }
    sink.finish()
}
