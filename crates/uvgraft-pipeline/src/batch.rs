//! Runs several textures in parallel, bounded by the number of threads and by memory.

use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use uvgraft::{Averaging, Depth, Encoding, TexelFormat};
use uvgraft_io::image;

use crate::base::bytes_of;
use crate::carry::{Done, Outcome};
use crate::failure::{Blame, Failure, Fault, Result};
use crate::observer::{Event, Observer, OutputFigures};
use crate::plan::Job;
use crate::records::Records;
use crate::shared::Shared;
use crate::transfer::Transferred;
use crate::unchanged::Unchanged;
use crate::worker::TransferWorker;

/// Processes all textures. Messages are reported in the order of the textures.
pub(crate) fn run(
    worker: &TransferWorker<'_>,
    jobs: &[Job],
    records: Option<&Records>,
) -> Result<Transferred> {
    let threads = rayon::current_num_threads();
    let at_once = worker.transfer.jobs.map_or(threads, usize::from).min(jobs.len());
    let mut report = Report::new(jobs, records, worker.observer);
    if at_once <= 1 {
        for (index, job) in jobs.iter().enumerate() {
            if worker.observer.is_cancelled() {
                break;
            }
            let made_from = records.and_then(|records| records.made_from(job));
            report.begin(job);
            let start = Instant::now();
            let outcome = worker.carry(job, true);
            report.add(index, Finished { outcome, made_from, duration: start.elapsed() });
        }
        return report.finish();
    }

    // At least one byte remains: a single texture is always processed.
    let unchanged = worker.shared.unchanged.as_ref().map_or(0, Unchanged::limit);
    let common = worker.shared.base.bytes() + unchanged;
    let memory = Memory::new(worker.transfer.memory.saturating_sub(common).max(1));
    let next = Mutex::new(0);
    let report = Mutex::new(report);
    let work = || -> Result<()> {
        // Each texture is processed by one thread, unless there are more threads than textures: the
        // textures alone keep all threads busy.
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads((threads / at_once).max(1))
            .use_current_thread()
            .build()
            .or_work()
            .map_err(|failure| failure.context("cannot start threads"))?;
        loop {
            let mut next = lock(&next);
            let index = *next;
            let Some(job) = jobs.get(index) else { return Ok(()) };
            if worker.observer.is_cancelled() {
                return Ok(());
            }
            *next += 1;
            // Waiting for memory blocks the other threads, so that large textures get their turn.
            let reserved = memory.take(bytes_needed(job, worker));
            drop(next);
            let made_from = records.and_then(|records| records.made_from(job));
            lock(&report).begin(job);
            let start = Instant::now();
            let outcome = pool.install(|| worker.carry(job, false));
            let duration = start.elapsed();
            drop(reserved);
            lock(&report).add(index, Finished { outcome, made_from, duration });
        }
    };
    thread::scope(|scope| {
        let workers: Vec<_> = (0..at_once).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| match worker.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    })?;
    report.into_inner().unwrap_or_else(PoisonError::into_inner).finish()
}

/// Approximate upper bound of the bytes needed for a texture. Unreadable files need hardly any,
/// since they fail early.
fn bytes_needed(job: &Job, worker: &TransferWorker<'_>) -> u64 {
    /// Bands of rows, and the queue to the encoder.
    const BANDS: u64 = 24 << 20;
    let Shared { options, base, .. } = worker.shared;
    // A pipe can be read only once.
    if !job.source.metadata().is_ok_and(|found| found.is_file()) {
        return BANDS;
    }
    let Ok(header) = image::read_header(&job.source) else { return BANDS };
    let target = base.size().texels() as u64;
    let depth = base.depth().unwrap_or(header.depth).max(header.depth);
    let value = if depth > Depth::U8 || options.averaging == Averaging::Light { 4 } else { 1 };
    let format =
        TexelFormat { channels: header.channels, depth: header.depth, encoding: Encoding::Srgb };
    // Once as decoded and once as processed: with the channels of both, as floats if the formats
    // differ.
    let source = bytes_of(header.size, format) + header.size.texels() as u64 * 4 * value;
    // The solver keeps at most five float textures on either side; formats other than PNG
    // and JPEG are collected before encoding.
    let values = header.size.texels() as u64 + target;
    let fit = if options.fit.is_some() { values * 4 * 4 * 5 } else { 0 };
    let format = image::Format::from_path(&job.output);
    let is_streamed = matches!(format, Some(image::Format::Png | image::Format::Jpeg));
    let gathered = if is_streamed { 0 } else { 2 * target * 4 * value };
    BANDS + source + fit + gathered
}

/// A memory budget shared by all textures.
struct Memory {
    limit: u64,
    used: Mutex<u64>,
    freed: Condvar,
}

/// A share of the budget, returned on drop.
struct Reservation<'a> {
    memory: &'a Memory,
    bytes: u64,
}

impl Memory {
    fn new(limit: u64) -> Self {
        Self { limit, used: Mutex::new(0), freed: Condvar::new() }
    }

    /// Waits for a share of the budget. A request beyond the whole budget is granted alone.
    fn take(&self, bytes: u64) -> Reservation<'_> {
        let bytes = bytes.min(self.limit);
        let fits = |used: &mut u64| *used > 0 && *used + bytes > self.limit;
        let used = self.freed.wait_while(lock(&self.used), fits);
        *used.unwrap_or_else(PoisonError::into_inner) += bytes;
        Reservation { memory: self, bytes }
    }
}

impl Drop for Reservation<'_> {
    fn drop(&mut self) {
        *lock(&self.memory.used) -= self.bytes;
        self.memory.freed.notify_all();
    }
}

/// A texture that is done, successfully or not.
struct Finished {
    outcome: Outcome,
    /// Fingerprint to record for a written output.
    made_from: Option<String>,
    duration: Duration,
}

/// Collects the outcomes of textures and reports them in order.
struct Report<'a> {
    jobs: &'a [Job],
    records: Option<&'a Records>,
    observer: &'a dyn Observer,
    waiting: BTreeMap<usize, Outcome>,
    reported: usize,
    done: Transferred,
}

impl<'a> Report<'a> {
    fn new(jobs: &'a [Job], records: Option<&'a Records>, observer: &'a dyn Observer) -> Self {
        observer.event(Event::BatchStarted { textures: jobs.len() });
        let (waiting, done) = (BTreeMap::new(), Transferred::default());
        Self { jobs, records, observer, waiting, reported: 0, done }
    }

    fn begin(&self, job: &Job) {
        self.observer.event(Event::TextureStarted { source: &job.source });
    }

    fn add(&mut self, index: usize, finished: Finished) {
        let Finished { mut outcome, made_from, duration } = finished;
        let job @ Job { source, output } = &self.jobs[index];
        if let (Some(records), Some(made_from), Ok(_)) = (self.records, made_from, &outcome.result)
            && let Err(failure) = records.record(job, &made_from)
        {
            outcome.log.warnings.push(failure.to_string());
        }
        let result = outcome
            .result
            .as_ref()
            .map(|&Done { bytes, boundary_delta_e, .. }| OutputFigures { bytes, boundary_delta_e });
        self.observer.event(Event::TextureEnded { source, output, result, duration });
        self.waiting.insert(index, outcome);
        while let Some(Outcome { result, log }) = self.waiting.remove(&self.reported) {
            let Job { source, output } = &self.jobs[self.reported];
            self.reported += 1;
            // A cancellation is reported once, at the end.
            let is_shown = !matches!(&result, Err(failure) if failure.fault() == Fault::Cancelled);
            if is_shown {
                let result = result.as_ref().map(|done| done.fit.as_ref());
                let (notes, warnings) = (&log.notes[..], &log.warnings[..]);
                self.observer.event(Event::TextureReport {
                    source,
                    output,
                    notes,
                    warnings,
                    result,
                });
            }
            match result {
                Ok(_) => self.done.written += 1,
                Err(failure) => self.done.failures.push(failure),
            }
        }
    }

    fn finish(self) -> Result<Transferred> {
        let (textures, written) = (self.jobs.len(), self.done.written);
        self.observer.event(Event::BatchEnded { textures, written });
        let mut failures = self.done.failures.iter();
        // Only textures remain at this point.
        let some_left = self.reported < self.jobs.len();
        if some_left || failures.any(|failure| failure.fault() == Fault::Cancelled) {
            return Err(Failure::cancelled());
        }
        Ok(self.done)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
