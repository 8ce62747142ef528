//! Interruption by Ctrl-C, SIGTERM or SIGHUP, and the system's ways to say that a limit is reached.
//!
//! Unfinished outputs are removed, so that every file is either the old or the new one, without
//! temporary files next to it.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::terminal;

/// 128 plus the number of SIGINT, as in shells, for all of the signals.
const EXIT_CODE: i32 = 130;

static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Handles each signal that is not ignored on behalf of the parent: `nohup` ignores SIGHUP, and
/// scripts ignore SIGINT for programs in the background. Where the system rejects handlers, signals
/// end the program without cleaning up, which leaves at most temporary files to a later run.
pub(crate) fn handle() {
    signals::handle(end);
}

fn end() -> ! {
    IS_INTERRUPTED.store(true, Ordering::SeqCst);
    uvgraft_files::output::abandon_unfinished();
    terminal::interrupted();
    std::process::exit(EXIT_CODE);
}

/// Waits for the end of an interrupted program: errors caused by the interruption, such as an
/// abandoned output, should not be shown.
pub(crate) fn wait_if_interrupted() {
    while IS_INTERRUPTED.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

#[cfg(unix)]
mod signals {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::sync::mpsc::sync_channel;
    use std::thread;

    use signal_hook::consts::signal::{SIGABRT, SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::flag;
    use signal_hook::iterator::Signals;

    pub(super) fn handle(end: fn() -> !) {
        // Memory that cannot be allocated aborts, after a message of the standard library: a failure like others.
        let _ = flag::register_conditional_shutdown(SIGABRT, 1, Arc::new(AtomicBool::new(true)));
        // Handled, it makes writing beyond the largest file allowed an error like others.
        let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
        let ignored = ignored();
        let handled = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !ignored(signal));
        let handled: Vec<i32> = handled.collect();
        // Handlers are installed by the thread that waits for them: without it, nothing would end
        // the program.
        let (sender, receiver) = sync_channel(1);
        let waiting = thread::Builder::new().name("signals".to_owned()).spawn(move || {
            let signals = Signals::new(handled);
            let _ = sender.send(());
            if signals.is_ok_and(|mut signals| signals.forever().next().is_some()) {
                end();
            }
        });
        if waiting.is_ok() {
            let _ = receiver.recv();
        }
    }

    /// Which signals this process ignores. Only Linux tells; elsewhere none is known to be ignored.
    fn ignored() -> impl Fn(i32) -> bool {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
        move |signal| mask >> (signal - 1) & 1 == 1
    }
}

#[cfg(not(unix))]
mod signals {
    pub(super) fn handle(end: fn() -> !) {
        let _ = ctrlc::try_set_handler(move || end());
    }
}
