//! Completion scripts, through the program.

use std::process::Stdio;

use crate::bench::Bench;

#[test]
fn a_script_for_each_shell() {
    let bench = Bench::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = bench.succeed(&format!("completions {shell}"));
        for wanted in ["uvgraft", "transfer", "skip-existing"] {
            assert!(script.contains(wanted), "{wanted} for {shell}");
        }
        // clap_complete completes no values in these two.
        let has_values = !matches!(shell, "elvish" | "powershell");
        assert_eq!(script.contains("catmull-rom"), has_values, "{shell}");
    }
    bench.refuse("completions tcsh", &["'tcsh'", "bash", "zsh"]);
    bench.refuse("completions", &["<SHELL>"]);
}

/// A reader that closes the pipe, like `head`, must not cause a panic.
#[test]
fn a_closed_standard_output_is_no_failure() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let bench = Bench::new();
    let mut command = bench.command();
    let output = command.args(["completions", "bash"]).stdout(writer).stderr(Stdio::piped());
    let output = output.spawn().unwrap().wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}
