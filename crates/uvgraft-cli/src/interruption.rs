//! Interruption by Ctrl-C, SIGTERM or SIGHUP.
//!
//! Unfinished outputs are removed, so that every file is either the old or the new one, without
//! temporary files next to it.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// 128 plus the number of SIGINT, as in shells. The other signals use the same code, because
/// `ctrlc` does not distinguish them.
const EXIT_CODE: i32 = 130;

static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler. Signals ignored on behalf of the parent, as by `nohup`, stay ignored;
/// then, and if the system rejects a handler, nothing is cleaned up.
pub(crate) fn handle() {
    let _ = ctrlc::try_set_handler(|| {
        IS_INTERRUPTED.store(true, Ordering::SeqCst);
        uvgraft_io::output::abandon_unfinished();
        let mut stderr = std::io::stderr();
        // After a progress bar and the terminal's ^C.
        let start = if stderr.is_terminal() { "\n" } else { "" };
        // After SIGHUP the terminal may be gone.
        let _ = writeln!(stderr, "{start}interrupted; unfinished outputs left unchanged");
        std::process::exit(EXIT_CODE);
    });
}

/// Waits for the end of an interrupted program: errors caused by the interruption, such as an
/// abandoned output, should not be shown.
pub(crate) fn wait_if_interrupted() {
    while IS_INTERRUPTED.load(Ordering::SeqCst) {
        std::thread::park();
    }
}
