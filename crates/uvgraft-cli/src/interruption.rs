//! Being told to stop: by Ctrl-C, or by SIGTERM or SIGHUP.
//!
//! Outputs that are not finished are removed, so that every file is the old one or the new one and
//! nothing lies beside them.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// 128 and the number of SIGINT, as shells have it. The other signals end alike, because `ctrlc`
/// does not tell them apart.
const EXIT_CODE: i32 = 130;

static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Tidies up from now on. Signals that whoever started the program lets it ignore, as `nohup` does,
/// stay ignored; then, and where the system refuses a handler, nothing is tidied up.
pub(crate) fn handle() {
    let _ = ctrlc::try_set_handler(|| {
        IS_INTERRUPTED.store(true, Ordering::SeqCst);
        uvgraft_io::output::abandon_unfinished();
        let mut stderr = std::io::stderr();
        // Behind a progress bar and the terminal's ^C.
        let start = if stderr.is_terminal() { "\n" } else { "" };
        // After SIGHUP the terminal may be gone.
        let _ = writeln!(stderr, "{start}interrupted; unfinished outputs left unchanged");
        std::process::exit(EXIT_CODE);
    });
}

/// Waits for the end of a program that was told to stop, because errors that come of that, such as
/// an output that was given up, are nobody's business.
pub(crate) fn wait_if_interrupted() {
    while IS_INTERRUPTED.load(Ordering::SeqCst) {
        std::thread::park();
    }
}
