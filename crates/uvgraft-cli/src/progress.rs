//! Progress on standard error, shown only if that is a terminal and the command is not to be quiet.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::outcome;

/// A bar of `count` steps with the given template.
pub(crate) fn bar(count: u64, template: &str) -> ProgressBar {
    if outcome::is_quiet() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(count);
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// What takes less says nothing: a line that appears and disappears at once is noise.
const SILENCE: Duration = Duration::from_secs(2);

/// The step that a command is at, and the line that shows it.
static CURRENT: Mutex<Current> = Mutex::new(Current { step: String::new(), line: None });

struct Current {
    step: String,
    line: Option<ProgressBar>,
}

fn current() -> MutexGuard<'static, Current> {
    CURRENT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Names the step that the command is at.
pub(crate) fn step(name: &str) {
    let mut current = current();
    name.clone_into(&mut current.step);
    if let Some(line) = &current.line {
        line.set_message(current.step.clone());
    }
}

/// Prints while the line is out of the way.
pub(crate) fn suspended<T>(print: impl FnOnce() -> T) -> T {
    // A handle of the same line: what prints may name a step.
    let line = current().line.clone();
    match line {
        Some(line) => line.suspend(print),
        None => print(),
    }
}

/// A line with the current step and the time since the start, for as long as this is kept.
pub(crate) struct Activity {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Activity {
    /// - `name`: of the first step.
    pub(crate) fn start(name: &str) -> Self {
        step(name);
        if outcome::is_quiet() || ProgressDrawTarget::stderr().is_hidden() {
            return Self { end: None, thread: None };
        }
        let (end, ended) = channel::<()>();
        let thread = std::thread::Builder::new().name("activity".to_owned()).spawn(move || {
            if ended.recv_timeout(SILENCE) != Err(RecvTimeoutError::Timeout) {
                return;
            }
            let line = ProgressBar::new_spinner().with_elapsed(SILENCE);
            let line = match ProgressStyle::with_template("{spinner} {wide_msg} {elapsed}") {
                Ok(style) => line.with_style(style),
                Err(_) => line,
            };
            {
                let mut current = current();
                line.set_message(current.step.clone());
                current.line = Some(line.clone());
            }
            line.enable_steady_tick(Duration::from_millis(120));
            let _ = ended.recv();
            current().line = None;
            line.finish_and_clear();
        });
        Self { end: Some(end), thread: thread.ok() }
    }
}

impl Drop for Activity {
    fn drop(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
