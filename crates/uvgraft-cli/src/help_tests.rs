//! Requirements on the help of every command.

use clap::{Arg, Command, CommandFactory};

use crate::Cli;

/// Fits on one line of a terminal next to the option in most cases.
const LONGEST: usize = 90;
/// More options than this need headings.
const MAX_UNGROUPED: usize = 12;

/// All commands with their paths.
fn commands() -> Vec<(String, Command)> {
    fn collect(path: &str, command: &Command, all: &mut Vec<(String, Command)>) {
        let path = format!("{path} {}", command.get_name()).trim().to_owned();
        command.get_subcommands().for_each(|subcommand| collect(&path, subcommand, all));
        all.push((path, command.clone()));
    }
    let mut root = Cli::command().disable_help_subcommand(true);
    root.build();
    let mut all = Vec::new();
    collect("", &root, &mut all);
    all
}

/// What is wrong with a short help, if anything.
fn flaw(help: Option<String>) -> Option<String> {
    match help {
        None => Some("has no help".to_owned()),
        Some(help) if help.is_empty() || help.contains('\n') => {
            Some(format!("{help:?}: not one line"))
        }
        Some(help) if help.chars().count() > LONGEST => Some(format!("{help:?}: too long")),
        Some(help) if help.ends_with('.') && !help.ends_with("...") => {
            Some(format!("{help:?}: ends with a full stop"))
        }
        Some(_) => None,
    }
}

#[test]
fn every_command_argument_and_value_has_one_line_of_help() {
    let mut flaws = Vec::new();
    for (path, command) in commands() {
        let mut check = |what: String, help: Option<String>| {
            flaws.extend(flaw(help).map(|flaw| format!("{path}{what}: {flaw}")));
        };
        check(String::new(), command.get_about().map(ToString::to_string));
        for argument in command.get_arguments() {
            let name = argument.get_id();
            check(format!(" {name}"), argument.get_help().map(ToString::to_string));
            for value in argument.get_possible_values() {
                let help = value.get_help().map(ToString::to_string);
                check(format!(" {name} {}", value.get_name()), help);
            }
        }
    }
    assert!(flaws.is_empty(), "{}", flaws.join("\n"));
}

#[test]
fn many_options_are_grouped() {
    for (path, command) in commands() {
        let is_own = |option: &&Arg| !option.is_positional() && !option.is_global_set();
        let options = || command.get_arguments().filter(is_own);
        if options().count() > MAX_UNGROUPED {
            let ungrouped: Vec<_> = options()
                .filter(|option| option.get_help_heading().is_none())
                .map(|option| option.get_id().to_string())
                .collect();
            assert!(ungrouped.is_empty(), "{path}: no heading for {}", ungrouped.join(", "));
        }
    }
}

#[test]
fn the_definitions_are_sound() {
    Cli::command().debug_assert();
}
