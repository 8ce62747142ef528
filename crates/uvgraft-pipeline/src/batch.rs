//! Runs several textures in parallel, bounded by the number of threads and by memory.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use uvgraft::threads;

use crate::failure::{Failure, Fault, Result};
use crate::memory;
use crate::observer::{Event, Observer, OutputFigures};
use crate::plan::Job;
use crate::records::{Provenance, Records};
use crate::shared::Shared;
use crate::spawn;
use crate::texture_transfer::{Done, Outcome};
use crate::transfer::Transferred;
use crate::worker::TransferWorker;

/// Processes all textures. Messages are reported in the order of the textures.
pub(crate) fn run(
    worker: &TransferWorker<'_>,
    jobs: &[Job],
    records: Option<&Records>,
) -> Result<Transferred> {
    let threads = threads::count();
    let at_once = worker.transfer.jobs.map_or(threads, usize::from).min(jobs.len());
    let Shared { options, base, unchanged, .. } = worker.shared;
    let memory = worker.transfer.budget(base, unchanged.as_ref());
    let needed = |job: &Job| memory::needed(job, base.size(), base.depth(), options);
    if at_once <= 1 {
        // Without a bound, whatever is alone is granted.
        let is_bound = worker.transfer.memory.is_some();
        let take = |job: &Job| memory.take(if is_bound { needed(job) } else { 0 });
        return run_in_turn(worker, jobs, records, take);
    }
    let next = Mutex::new(0);
    let report = Mutex::new(Report::new(jobs, records, worker.observer));
    let work = || -> Result<()> {
        // Each texture is processed by one thread, unless there are more threads than textures: the
        // textures alone keep all threads busy.
        let pool = spawn::pool((threads / at_once).max(1))?;
        loop {
            spawn::point();
            let mut next = lock(&next);
            let index = *next;
            let Some(job) = jobs.get(index) else { return Ok(()) };
            if worker.observer.is_cancelled() {
                return Ok(());
            }
            *next += 1;
            // Waiting for memory blocks the other threads, so that large textures get their turn.
            let reserved = memory.take(needed(job));
            drop(next);
            let provenance = records.and_then(|records| records.provenance(job));
            lock(&report).begin(job);
            let start = worker.observer.now();
            let outcome = match reserved {
                Ok(_reserved) => pool.install(|| worker.transfer(job, false)),
                Err(failure) => Outcome::from(failure),
            };
            let duration = since(start, worker.observer);
            lock(&report).add(index, Finished { outcome, provenance, duration });
        }
    };
    thread::scope(|scope| {
        // As many as the system has threads for.
        let workers: Vec<_> = (0..at_once).map_while(|_| spawn::start(scope, work)).collect();
        if workers.is_empty() {
            return work();
        }
        workers.into_iter().try_for_each(|worker| match worker.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    })?;
    report.into_inner().unwrap_or_else(PoisonError::into_inner).finish()
}

/// Processes the textures one after the other, each with all threads.
///
/// - `take`: reserves the memory that a texture needs.
fn run_in_turn<Reserved>(
    worker: &TransferWorker<'_>,
    jobs: &[Job],
    records: Option<&Records>,
    take: impl Fn(&Job) -> Result<Reserved>,
) -> Result<Transferred> {
    let mut report = Report::new(jobs, records, worker.observer);
    for (index, job) in jobs.iter().enumerate() {
        if worker.observer.is_cancelled() {
            break;
        }
        let provenance = records.and_then(|records| records.provenance(job));
        report.begin(job);
        let start = worker.observer.now();
        let outcome = match take(job) {
            Ok(_reserved) => worker.transfer(job, true),
            Err(failure) => Outcome::from(failure),
        };
        let duration = since(start, worker.observer);
        report.add(index, Finished { outcome, provenance, duration });
    }
    report.finish()
}

/// A texture that is done, successfully or not.
struct Finished {
    outcome: Outcome,
    /// What to record for a written output.
    provenance: Option<Provenance>,
    duration: Option<Duration>,
}

fn since(start: Option<Duration>, observer: &dyn Observer) -> Option<Duration> {
    Some(observer.now()?.saturating_sub(start?))
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
        self.observer.event(Event::TextureStarted { source: job.source.name() });
    }

    fn add(&mut self, index: usize, finished: Finished) {
        let Finished { mut outcome, provenance, duration } = finished;
        let job @ Job { source, output } = &self.jobs[index];
        if let (Some(records), Some(provenance), Ok(_)) =
            (self.records, provenance, &outcome.result)
            && let Err(failure) = records.record(job, &provenance)
        {
            outcome.log.warnings.push(failure.to_string());
        }
        let result = outcome
            .result
            .as_ref()
            .map(|&Done { bytes, boundary_delta_e, .. }| OutputFigures { bytes, boundary_delta_e });
        let source = source.name();
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
                    source: source.name(),
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
