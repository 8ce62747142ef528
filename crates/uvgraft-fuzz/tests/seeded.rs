//! Every target on inputs that were once a problem, on thousands of mutated seeds, and on thousands of
//! files built by structure.

#![allow(clippy::print_stdout, reason = "counts of a long run are worth knowing")]

#[path = "seeded/nesting.rs"]
mod nesting;
#[path = "seeded/structured.rs"]
mod structured;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use uvgraft_fuzz::{Allocator, Mutator, TARGETS, Target};

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

/// Inputs of each target, unless the environment variable `UVGRAFT_FUZZ_INPUTS` has another number.
const INPUTS: usize = 2_000;

/// An input of 64 KiB that takes longer hangs, however slow the machine is.
const PATIENCE: Duration = Duration::from_secs(60);

/// More than any of the inputs needs, of which each has less than a megabyte.
const MAX_MEMORY: usize = 1 << 30;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/regressions")
}

/// Runs a target, and stops the test if the input is a problem, with the input in a file.
fn check(target: Target, inputs: impl Iterator<Item = Vec<u8>> + Send + 'static) -> usize {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        for input in inputs {
            // Nobody receives after a find.
            let Ok(()) = sender.send(Err(input.clone())) else { return };
            let run = AssertUnwindSafe(|| (target.run)(&input));
            let Ok(()) = sender.send(Ok(catch_unwind(run).is_ok())) else { return };
        }
    });
    let (mut count, mut last) = (0, Vec::new());
    let find = |input: &[u8], what: &str| {
        let path = std::env::temp_dir().join(format!("uvgraft-fuzz-{}", target.name));
        let _ = std::fs::write(&path, input);
        panic!("{}: an input {what}; it is in {}", target.name, path.display());
    };
    loop {
        let start = Instant::now();
        match receiver.recv_timeout(PATIENCE) {
            Ok(Err(input)) => last = input,
            Ok(Ok(true)) => count += 1,
            Ok(Ok(false)) => find(&last, "panics"),
            Err(RecvTimeoutError::Timeout) => find(&last, "hangs"),
            Err(RecvTimeoutError::Disconnected) => return count,
        }
        if start.elapsed() > PATIENCE / 6 {
            find(&last, "takes very long");
        }
    }
}

/// The right to use memory, which is that of the process: whoever measures how much is taken must be alone.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Inputs of each target.
fn inputs() -> usize {
    let inputs = std::env::var("UVGRAFT_FUZZ_INPUTS").ok().and_then(|text| text.parse().ok());
    inputs.unwrap_or(INPUTS)
}

/// What a generator for a target starts from, by the target's number.
fn seed(target: usize) -> u64 {
    let seed = std::env::var("UVGRAFT_FUZZ_SEED").ok().and_then(|text| text.parse::<u64>().ok());
    target as u64 + 1000 * seed.unwrap_or(1)
}

#[test]
fn what_was_once_a_problem_is_none() {
    let _alone = alone();
    for &target in TARGETS {
        let entries = folder().join(target.name).read_dir().into_iter().flatten().flatten();
        let inputs: Vec<Vec<u8>> =
            entries.map(|entry| std::fs::read(entry.path()).unwrap()).collect();
        check(target, inputs.into_iter());
    }
}

/// Seeds are what readers accept, or mutations of them would test little.
#[test]
fn seeds_are_no_problem() {
    let _alone = alone();
    for &target in TARGETS {
        check(target, (target.seeds)().into_iter());
    }
}

#[test]
fn mutated_seeds_are_no_problem() {
    let _alone = alone();
    let (inputs, before) = (inputs(), ALLOCATOR.current_usage());
    ALLOCATOR.reset_peak_usage();
    let peak = || ALLOCATOR.peak_usage().saturating_sub(before);
    let targets = || TARGETS.iter().enumerate().filter(|(_, target)| target.file.is_none());
    // Side by side, which only the sum of their memory is affected by.
    let workers = thread::available_parallelism().map_or(1, |count| count.get().min(4));
    let next = AtomicUsize::new(0);
    let work = || {
        let mut count = 0;
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some((number, &target)) = targets().nth(index) else { return count };
            let start = Instant::now();
            let mut mutator = Mutator::new((target.seeds)(), seed(number));
            count += check(target, (0..inputs).map(move |_| mutator.next_input()));
            println!("{:24} {inputs} inputs, {:.1} s", target.name, start.elapsed().as_secs_f64());
            assert!(peak() < MAX_MEMORY, "{}: took {} MiB", target.name, peak() >> 20);
        }
    };
    let all: usize = thread::scope(|scope| {
        let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|it| it.join().unwrap_or_else(|why| resume_unwind(why))).sum()
    });
    println!("{all} inputs, {} MiB at most", peak() >> 20);
    assert_eq!(all, inputs * targets().count());
}
