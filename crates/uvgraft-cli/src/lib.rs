//! The command `uvgraft`, as a library: the binary and the Python package run it with [`run`].
//!
//! Exit codes: 0 for success, 1 for a failure during the work, 2 for bad input or usage, 130 if
//! interrupted (Ctrl-C, SIGTERM, SIGHUP). Results and reports go to standard output; errors,
//! warnings and progress to standard error.

#![forbid(unsafe_code)]

mod avatar;
mod bench;
mod blending;
mod body;
mod choice;
mod compare;
mod completions;
mod demo;
mod doctor;
mod failure;
mod files;
mod fitting;
mod heading;
mod heatmap;
#[cfg(test)]
mod help_tests;
mod inspect;
mod interruption;
mod layouts;
mod man;
mod map;
mod memory;
mod number;
mod opacity;
mod outcome;
mod pair;
mod progress;
mod region;
mod render;
mod report;
mod role_file;
mod roundtrip;
mod scores;
mod seams;
mod selfie;
mod table;
mod terminal;
mod transfer;
mod version;
mod view;
mod weights;

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};
use uvgraft::Choice;
use uvgraft_image::Format;
use uvgraft_pipeline::Unit;

use crate::progress::Activity;

/// Transfer textures between meshes with different UV layouts
///
/// Link two meshes once with `uvgraft pair`, then transfer any number of textures between them with
/// `uvgraft transfer`, or build an animated avatar with `uvgraft avatar`. `uvgraft demo` runs the
/// whole workflow on a built-in example.
#[derive(Parser)]
#[command(name = "uvgraft", version, propagate_version = true, max_term_width = 100)]
#[command(disable_help_flag = true, disable_version_flag = true, after_long_help = EXIT_STATUS)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print one JSON document instead of text: report, warnings, errors and written files
    ///
    /// `uvgraft` in it holds version, command, ok, errors, warnings, notes and written (a list of files); the
    /// other fields are the report, and those of each command are in the book. Errors of usage have none.
    #[arg(long, global = true, help_heading = heading::GLOBAL)]
    json: bool,
    /// Print no notes, progress or closing lines; warnings and errors remain
    #[arg(short, long, global = true, help_heading = heading::GLOBAL)]
    quiet: bool,
    /// Number of threads, 0 for one per processor
    #[arg(long, global = true, default_value_t = 0, value_name = "N", help_heading = heading::GLOBAL)]
    #[arg(value_parser = number::whole_number::<u16>(0..=MAX_THREADS.into()), allow_negative_numbers = true)]
    threads: u16,
    /// Print help: a summary with -h, details with --help
    #[arg(short, long, global = true, action = ArgAction::Help, help_heading = heading::GLOBAL)]
    help: Option<bool>,
    /// Print version; with --verbose also the commit and what it was built with
    #[arg(short = 'V', long, global = true, action = ArgAction::Version, help_heading = heading::GLOBAL)]
    version: Option<bool>,
}

const EXIT_STATUS: &str = "\
Exit status: 0 on success, 1 on failure, 2 on invalid input or usage, 130 if interrupted.";

/// In typical order of use.
#[derive(Subcommand)]
enum Command {
    Demo(demo::Args),
    Layouts(layouts::Args),
    Pair(pair::Args),
    Inspect(inspect::Args),
    Transfer(Box<transfer::Args>),
    Seams(seams::Args),
    Roundtrip(roundtrip::Args),
    Compare(compare::Args),
    Map(map::Args),
    Body(body::Args),
    Selfie(Box<selfie::Args>),
    Avatar(Box<avatar::Args>),
    Render(Box<render::Args>),
    View(view::Args),
    Bench(bench::Args),
    Weights(weights::Args),
    Doctor(doctor::Args),
    Completions(completions::Args),
    Man(man::Args),
}

impl Command {
    /// What it does first that may take seconds; `None` if it takes none, or shows bars.
    fn activity(&self) -> Option<&'static str> {
        match self {
            Self::Demo(_) => Some("making the figure"),
            Self::Pair(_) => Some("reading the meshes"),
            Self::Inspect(_) => Some("inspecting"),
            Self::Seams(_) | Self::Compare(_) => Some("measuring"),
            Self::Map(_) => Some("making the map"),
            Self::Body(_) => Some("making the body"),
            Self::Selfie(_) => Some("reading the photographs"),
            Self::Avatar(_) => Some("reading"),
            Self::View(_) => Some("making the page"),
            Self::Weights(_) => Some("importing"),
            Self::Layouts(_) | Self::Transfer(_) | Self::Roundtrip(_) | Self::Render(_) => None,
            Self::Bench(_) | Self::Doctor(_) | Self::Completions(_) | Self::Man(_) => None,
        }
    }
}

/// Runs the command with the arguments of a process, of which the first is the program's name.
///
/// To be called once in a process, which it takes over: it handles signals, prints, and ends the
/// process itself after an interruption.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    // The stack of the thread that calls is whatever `ulimit -s` or the caller left.
    let working = std::thread::Builder::new().stack_size(STACK).spawn(move || work(&arguments));
    match working.map(std::thread::JoinHandle::join) {
        Ok(Ok(code)) => code,
        // Its message is printed already.
        Ok(Err(panic)) => std::panic::resume_unwind(panic),
        Err(error) => failure::report(&anyhow::Error::new(error).context("cannot start a thread")),
    }
}

/// The size of the stack that a command runs on, in bytes: what Linux and macOS give to a program.
const STACK: usize = 8 << 20;

fn work(arguments: &[OsString]) -> ExitCode {
    // Only together, and whatever else there is.
    let has = |names: &[&str]| arguments.iter().any(|it| names.iter().any(|name| it == name));
    if has(&["--version", "-V"]) && has(&["--verbose"]) {
        return terminal::print(&version::verbose())
            .map_or_else(|error| failure::report(&error), |()| ExitCode::SUCCESS);
    }
    let Parsed { cli, name, options } = match parse(arguments) {
        Ok(parsed) => parsed,
        Err(answer) => return terminal::answer(&answer),
    };
    failure::spell_options(options);
    interruption::handle();
    let called = arguments.first().map_or(OsStr::new("uvgraft"), |called| called);
    outcome::begin(called, name, cli.json, cli.quiet);
    let code = match dispatch(&cli) {
        Ok(code) => code,
        Err(error) => failure::report(&error),
    };
    let code = outcome::end().map_or_else(|error| failure::report(&error), |()| code);
    interruption::wait_if_interrupted();
    code
}

/// The arguments of a process.
struct Parsed {
    cli: Cli,
    /// The command, with its subcommand.
    name: String,
    /// The options of the innermost subcommand: what libraries call each, and how it is spelled.
    options: Vec<(String, String)>,
}

fn parse(arguments: &[OsString]) -> Result<Parsed, clap::Error> {
    let mut command = Cli::command();
    let matches =
        command.try_get_matches_from_mut(arguments).map_err(|error| explained(error, arguments))?;
    let cli = Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
    let (mut named, mut matches) = (&command, &matches);
    let mut names = Vec::new();
    while let Some((name, inner)) = matches.subcommand() {
        let Some(subcommand) = named.find_subcommand(name) else { break };
        (named, matches) = (subcommand, inner);
        names.push(name);
    }
    let spelled = |option: &Arg| {
        let name = option.get_id().as_str();
        Some((name.to_owned(), format!("--{}", option.get_long()?)))
    };
    let options = named.get_arguments().filter_map(spelled).collect();
    Ok(Parsed { cli, name: names.join(" "), options })
}

/// An error with a tip if an argument too many is a unit, as in `--distance 3 mm`, or an image beside what is shown.
fn explained(mut error: clap::Error, arguments: &[OsString]) -> clap::Error {
    let found = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(found)) if error.kind() == ErrorKind::UnknownArgument => found,
        _ => return error,
    };
    let shows = |command: &OsString| command == "render" || command == "view";
    let tip = if let Some(unit) = Unit::named(found) {
        format!("a unit follows its number without a space, as in 3{}", unit.name())
    } else if Format::from_path(Path::new(found)).is_some() && arguments.get(1).is_some_and(shows) {
        "a texture is given by --texture".to_owned()
    } else {
        return error;
    };
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    error
}

/// More would only take longer to start.
const MAX_THREADS: u16 = 1024;

/// The number of threads to start.
///
/// - `asked`: by the option, 0 for one per processor.
/// - `variable`: the environment variable `RAYON_NUM_THREADS`, which counts if there is no option.
fn threads(asked: u16, variable: Option<&str>) -> usize {
    let asked = match asked {
        0 => variable.and_then(|text| text.trim().parse().ok()).unwrap_or(0),
        asked => usize::from(asked),
    };
    match asked {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        asked => asked.min(usize::from(MAX_THREADS)),
    }
}

fn dispatch(cli: &Cli) -> anyhow::Result<ExitCode> {
    let threads = threads(cli.threads, std::env::var("RAYON_NUM_THREADS").ok().as_deref());
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .with_context(|| format!("cannot start {threads} threads"))?;
    let _activity = cli.command.activity().map(Activity::start);
    match &cli.command {
        Command::Demo(args) => demo::run(args),
        Command::Layouts(args) => layouts::run(args),
        Command::Pair(args) => pair::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Transfer(args) => transfer::run(args),
        Command::Seams(args) => seams::run(args),
        Command::Roundtrip(args) => roundtrip::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Map(args) => map::run(args),
        Command::Body(args) => body::run(args),
        Command::Selfie(args) => selfie::run(args),
        Command::Avatar(args) => avatar::run(args),
        Command::Render(args) => render::run(args),
        Command::View(args) => view::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Weights(args) => weights::run(args),
        Command::Doctor(args) => doctor::run(args),
        Command::Completions(args) => completions::run(args),
        Command::Man(args) => man::run(args),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_those_of_the_innermost_subcommand() {
        let options = |words: &[&str]| -> Vec<String> {
            let words: Vec<OsString> = words.iter().map(OsString::from).collect();
            let Parsed { options, .. } = parse(&words).unwrap();
            options.into_iter().map(|(name, spelled)| format!("{name} {spelled}")).collect()
        };
        let of_transfer = options(&["uvgraft", "transfer", "a.uvpair", "b.png", "-o", "c.png"]);
        for option in [
            "onto --onto",
            "source_mask --source-mask",
            "map --map",
            "match_skin --match",
            "threads --threads",
        ] {
            assert!(of_transfer.iter().any(|it| it == option), "{option}: {of_transfer:?}");
        }
        let of_shape =
            options(&["uvgraft", "body", "shape", "a.npz", "--shape", "tall=1", "-o", "b.npz"]);
        assert!(of_shape.iter().any(|it| it == "shape --shape"), "{of_shape:?}");
        assert!(!of_shape.iter().any(|it| it == "onto --onto"), "{of_shape:?}");
    }

    #[test]
    fn threads_are_bounded_however_they_are_asked_for() {
        let processors = threads(0, None);
        assert!(processors >= 1);
        assert_eq!(threads(3, Some("5")), 3);
        assert_eq!(threads(0, Some("5")), 5);
        assert_eq!(threads(0, Some("3000")), 1024);
        for unusable in ["", "0", "-1", "many", "99999999999999999999999"] {
            assert_eq!(threads(0, Some(unusable)), processors, "{unusable:?}");
        }
    }
}
