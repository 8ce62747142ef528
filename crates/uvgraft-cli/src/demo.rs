//! `uvgraft demo`: the whole road on an embedded example.

use std::process::ExitCode;

/// Runs the whole road on an embedded example.
#[derive(clap::Args)]
pub(crate) struct Args {}

pub(crate) fn run(_args: &Args) -> anyhow::Result<ExitCode> {
    anyhow::bail!("in the making")
}
