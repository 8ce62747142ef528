//! Several textures at once, within bounds: as many as there are threads, and as fit the memory.

use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use anyhow::Context;
use indicatif::ProgressBar;
use uvgraft::{Depth, Encoding, TexelFormat};
use uvgraft_io::image;

use super::Args;
use super::base::{Base, bytes_of};
use super::carrier::{Carrier, Outcome};
use super::plan::Job;
use crate::failure::{self, warn};
use crate::progress;
use crate::report::to_stdout;

/// How many textures were carried, and the exit code if some were not.
pub(super) struct Carried {
    pub(super) count: usize,
    pub(super) code: Option<u8>,
}

/// Carries all textures. What there is to say about them is said in their order.
pub(super) fn run(
    carrier: &Carrier<'_>,
    jobs: &[Job],
    base: &Base,
    args: &Args,
) -> anyhow::Result<Carried> {
    let threads = rayon::current_num_threads();
    let at_once = args.jobs.map_or(threads, usize::from).min(jobs.len());
    let mut report = Report::new(jobs);
    if at_once <= 1 {
        for (index, job) in jobs.iter().enumerate() {
            report.begin(job);
            report.add(index, carrier.carry(job, true))?;
        }
        return Ok(report.finish());
    }

    // Something is left in any case: one texture at a time is always carried.
    let memory = Memory::new(args.memory.saturating_sub(base.bytes()).max(1));
    let next = Mutex::new(0);
    let report = Mutex::new(report);
    let work = || -> anyhow::Result<()> {
        // What a texture is cut into is worked on by the thread that carries it, unless there are
        // threads to spare: textures are enough to do for all.
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads((threads / at_once).max(1))
            .use_current_thread()
            .build()
            .context("cannot start threads")?;
        loop {
            let mut place = lock(&next);
            let index = *place;
            let Some(job) = jobs.get(index) else { return Ok(()) };
            *place += 1;
            // Whoever waits for memory keeps the others from taking it: large textures get their turn.
            let taken = memory.take(bytes_needed(job, base, args));
            drop(place);
            lock(&report).begin(job);
            let outcome = pool.install(|| carrier.carry(job, false));
            drop(taken);
            lock(&report).add(index, outcome)?;
        }
    };
    thread::scope(|scope| {
        let workers: Vec<_> = (0..at_once).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| match worker.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    })?;
    Ok(report.into_inner().unwrap_or_else(PoisonError::into_inner).finish())
}

/// Bytes that carrying a texture takes at most, about. What cannot be read fails soon enough.
fn bytes_needed(job: &Job, base: &Base, args: &Args) -> u64 {
    /// Bands of rows, and what waits for being written.
    const BANDS: u64 = 24 << 20;
    // A pipe can be read only once.
    if !job.source.metadata().is_ok_and(|found| found.is_file()) {
        return BANDS;
    }
    let Ok(header) = image::read_header(&job.source) else { return BANDS };
    let target = base.size().texels() as u64;
    let depth = base.depth().unwrap_or(header.depth).max(header.depth);
    let value = if depth > Depth::U8 || args.linear_light { 4 } else { 1 };
    let format =
        TexelFormat { channels: header.channels, depth: header.depth, encoding: Encoding::Srgb };
    // As it is decoded, and as it is worked on: all channels of both, and floats where they differ.
    let source = bytes_of(header.size, format) + header.size.texels() as u64 * 4 * value;
    // Solving keeps at most five textures of floats on either side; formats other than PNG are gathered.
    let fit = if args.fit { (header.size.texels() as u64 + target) * 4 * 4 * 5 } else { 0 };
    let is_png = image::Format::from_path(&job.output) == Some(image::Format::Png);
    let gathered = if is_png { 0 } else { 2 * target * 4 * value };
    BANDS + source + fit + gathered
}

/// Memory that textures share.
struct Memory {
    most: u64,
    used: Mutex<u64>,
    freed: Condvar,
}

/// A part of it, given back when dropped.
struct Taken<'a> {
    memory: &'a Memory,
    bytes: u64,
}

impl Memory {
    fn new(most: u64) -> Self {
        Self { most, used: Mutex::new(0), freed: Condvar::new() }
    }

    /// Waits for so much of it. More than all of it is given to one alone.
    fn take(&self, bytes: u64) -> Taken<'_> {
        let bytes = bytes.min(self.most);
        let fits = |used: &mut u64| *used > 0 && *used + bytes > self.most;
        let used = self.freed.wait_while(lock(&self.used), fits);
        *used.unwrap_or_else(PoisonError::into_inner) += bytes;
        Taken { memory: self, bytes }
    }
}

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        *lock(&self.memory.used) -= self.bytes;
        self.memory.freed.notify_all();
    }
}

/// What happened to the textures, told in their order.
struct Report<'a> {
    jobs: &'a [Job],
    bar: ProgressBar,
    waiting: BTreeMap<usize, Outcome>,
    told: usize,
    failed: usize,
    worst: Option<u8>,
}

impl<'a> Report<'a> {
    fn new(jobs: &'a [Job]) -> Self {
        let bar = match jobs.len() {
            0 | 1 => ProgressBar::hidden(),
            count => progress::bar(count as u64, "{bar:32} {pos}/{len} {eta:>4} {wide_msg}"),
        };
        Self { jobs, bar, waiting: BTreeMap::new(), told: 0, failed: 0, worst: None }
    }

    fn begin(&self, job: &Job) {
        self.bar.set_message(job.source.display().to_string());
    }

    fn add(&mut self, index: usize, outcome: Outcome) -> anyhow::Result<()> {
        self.bar.inc(1);
        self.waiting.insert(index, outcome);
        while let Some(outcome) = self.waiting.remove(&self.told) {
            let job = &self.jobs[self.told];
            self.told += 1;
            let Outcome { result, warnings } = outcome;
            self.bar.suspend(|| {
                warnings.iter().for_each(warn);
                match &result {
                    Ok(Some(fit)) => to_stdout(&format!("{}: {fit}\n", job.output.display())),
                    Ok(None) => Ok(()),
                    Err(error) => {
                        failure::report(error);
                        Ok(())
                    }
                }
            })?;
            if let Err(error) = result {
                // A failure at work weighs more than a bad file.
                self.failed += 1;
                let code = failure::exit_code(&error);
                self.worst = Some(self.worst.map_or(code, |worst| worst.min(code)));
            }
        }
        Ok(())
    }

    fn finish(self) -> Carried {
        self.bar.finish_and_clear();
        let (all, count) = (self.jobs.len(), self.jobs.len() - self.failed);
        if self.failed > 0 && all > 1 {
            warn(format!("{count} of {all} textures were carried across"));
        }
        Carried { count, code: self.worst }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
