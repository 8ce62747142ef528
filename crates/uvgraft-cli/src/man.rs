//! `uvgraft man`: man pages of the command and its subcommands.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Command, CommandFactory};
use clap_mangen::Man;
use uvgraft_files::output::write_atomically;
use uvgraft_pipeline::Outputs;

use crate::Cli;
use crate::files::{OrCannotWrite, create_folder};

/// Write man pages for the command and its subcommands
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Output folder, created if missing
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let folder = &args.folder;
    create_folder(folder)?;
    let mut command = Cli::command().disable_help_subcommand(true);
    // Gives subcommands their full names and the global options.
    command.build();
    write(&command, folder, &mut Outputs::new([]))?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the page of a command, and those of its subcommands.
fn write(command: &Command, folder: &Path, outputs: &mut Outputs) -> anyhow::Result<()> {
    let page = Man::new(command.clone());
    let path = folder.join(page.get_filename());
    outputs.check(&path)?;
    write_atomically::<io::Error>(&path, |out| page.render(out)).or_cannot_write(&path)?;
    command.get_subcommands().try_for_each(|subcommand| write(subcommand, folder, outputs))
}
