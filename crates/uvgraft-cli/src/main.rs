//! The command `uvgraft`: see the library.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    uvgraft_cli::run(std::env::args_os())
}
