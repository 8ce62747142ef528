//! The command `uvgraft`.
//!
//! Exit codes: 0 for success, 2 for bad input or usage, 1 for a failure at work, 130 where it was
//! told to stop (Ctrl-C, SIGTERM, SIGHUP). Results and
//! reports go to standard output, errors, warnings and progress to standard error.

mod avatar;
mod bench;
mod blending;
mod compare;
mod demo;
mod failure;
mod filters;
mod fitting;
mod heatmap;
mod inspect;
mod interruption;
mod map;
mod opacity;
mod pair;
mod picture;
mod preference;
mod preview;
mod progress;
mod region;
mod render;
mod report;
mod role_file;
mod roundtrip;
mod scores;
mod seams;
mod table;
mod transfer;
mod view;
mod weights;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Carries textures between meshes with different UV layouts.
#[derive(Parser)]
#[command(name = "uvgraft", version, propagate_version = true, max_term_width = 100)]
struct Cli {
    /// Threads to use; 0 for one on each processor
    #[arg(long, global = true, default_value_t = 0, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Pair(pair::Args),
    Inspect(inspect::Args),
    Transfer(Box<transfer::Args>),
    Map(map::Args),
    Compare(compare::Args),
    Seams(seams::Args),
    Roundtrip(roundtrip::Args),
    View(view::Args),
    Avatar(Box<avatar::Args>),
    Bench(bench::Args),
    Render(Box<render::Args>),
    Demo(demo::Args),
    Weights(weights::Args),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    interruption::handle();
    let code = match run(&cli) {
        Ok(code) => code,
        Err(error) => failure::report(&error),
    };
    interruption::wait_if_interrupted();
    code
}

fn run(cli: &Cli) -> anyhow::Result<ExitCode> {
    rayon::ThreadPoolBuilder::new().num_threads(usize::from(cli.threads)).build_global()?;
    match &cli.command {
        Command::Pair(args) => pair::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Transfer(args) => transfer::run(args),
        Command::Map(args) => map::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Seams(args) => seams::run(args),
        Command::Roundtrip(args) => roundtrip::run(args),
        Command::View(args) => view::run(args),
        Command::Avatar(args) => avatar::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Render(args) => render::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Weights(args) => weights::run(args),
    }
}
