//! `uvgraft completions`: scripts that complete the command line in a shell.

use std::process::ExitCode;

use clap::{CommandFactory, ValueEnum};
use clap_complete::Shell;

use crate::Cli;
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
    #[arg(value_enum)]
    shell: ShellName,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ShellName {
    /// Bourne Again Shell
    Bash,
    /// Elvish
    Elvish,
    /// Friendly Interactive Shell
    Fish,
    /// PowerShell
    #[value(name = "powershell")]
    PowerShell,
    /// Z Shell
    Zsh,
}

impl From<ShellName> for Shell {
    fn from(name: ShellName) -> Self {
        match name {
            ShellName::Bash => Self::Bash,
            ShellName::Elvish => Self::Elvish,
            ShellName::Fish => Self::Fish,
            ShellName::PowerShell => Self::PowerShell,
            ShellName::Zsh => Self::Zsh,
        }
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    // Into memory first: clap_complete panics if standard output is closed.
    let mut script = Vec::new();
    let mut command = Cli::command();
    clap_complete::generate(Shell::from(args.shell), &mut command, "uvgraft", &mut script);
    terminal::print(&String::from_utf8(script)?)?;
    Ok(ExitCode::SUCCESS)
}
