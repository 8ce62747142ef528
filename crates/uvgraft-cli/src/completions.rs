//! `uvgraft completions`: scripts that complete the command line in a shell.

use std::process::ExitCode;

use clap::CommandFactory;
use uvgraft::{Choice, choices};

use crate::Cli;
use crate::choice::choice;
use crate::terminal;

/// Print a shell completion script
///
/// Write the script to where the shell looks for it, for example:
///
///   uvgraft completions bash > ~/.local/share/bash-completion/completions/uvgraft
///   uvgraft completions fish > ~/.config/fish/completions/uvgraft.fish
///   uvgraft completions zsh > ~/.zfunc/_uvgraft    # a folder in zsh's $fpath
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Args {
    /// Shell to complete for
    #[arg(value_parser = choice::<KnownShell>())]
    shell: KnownShell,
}

/// The shells of [`clap_complete`], with help.
#[derive(Clone, Copy, PartialEq, Eq)]
enum KnownShell {
    Bash,
    Elvish,
    Fish,
    PowerShell,
    Zsh,
}

choices!(KnownShell {
    Bash => "bash", "Bourne Again Shell";
    Elvish => "elvish", "Elvish";
    Fish => "fish", "Friendly Interactive Shell";
    PowerShell => "powershell", "PowerShell";
    Zsh => "zsh", "Z Shell";
});

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    // Into memory first: clap_complete panics if standard output is closed.
    let mut script = Vec::new();
    let mut command = Cli::command();
    let shell: clap_complete::Shell = args.shell.name().parse().map_err(anyhow::Error::msg)?;
    clap_complete::generate(shell, &mut command, "uvgraft", &mut script);
    terminal::print(&String::from_utf8(script)?)?;
    Ok(ExitCode::SUCCESS)
}
