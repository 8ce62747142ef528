//! Files as other programs write them: each gives what the plain file gives, or is refused in words.
//!
//! A case is a name, files, and what must become of them. Nothing may be read wrongly in silence.

mod arrays;
mod images;
mod meshes;
mod obj;
mod ply;
mod scenes;

use crate::bench::Bench;

/// What must become of a file.
#[derive(Clone, Copy)]
enum Expected {
    /// The same as of the plain file, without a word.
    Same,
    /// The same within a tolerance, without a word.
    Near(f32),
    /// The same as of the plain file, with this in a note or warning.
    Warned(&'static str),
    /// Exit code 2 and one message with this.
    Refused(&'static str),
}

use Expected::{Near, Refused, Same, Warned};

/// A file, perhaps with others beside it.
struct Case {
    name: &'static str,
    /// The first one is given to the program.
    files: Vec<(&'static str, Vec<u8>)>,
    expected: Expected,
}

fn case(
    name: &'static str,
    file: &'static str,
    content: impl Into<Vec<u8>>,
    expected: Expected,
) -> Case {
    Case { name, files: vec![(file, content.into())], expected }
}

/// Runs the program on each case, and compares what came of it.
///
/// - `command`: arguments, with `FILE` for the file of the case; it must write `out`.
/// - `compare`: the largest difference between the output and that of the plain file; an error if
///   they cannot be compared.
fn check(
    bench: &Bench,
    cases: Vec<Case>,
    (command, out): (&str, &str),
    compare: impl Fn(&Bench) -> Result<f32, String>,
) {
    // Of rounding in single precision, of coordinates up to 3.
    const SAME: f32 = 1e-6;
    let mut wrong = Vec::new();
    for Case { name, files, expected } in cases {
        for (file, content) in &files {
            bench.write(file.split('#').next().unwrap_or(file), content);
        }
        let _ = std::fs::remove_file(bench.path(out));
        let run = bench.run(&command.replace("FILE", files[0].0));
        let difference = || match run.code {
            Some(0) => compare(bench),
            code => Err(format!("exit code {code:?}")),
        };
        let problem = match expected {
            Refused(wanted) => {
                let is_refused = run.code == Some(2) && run.stderr.starts_with("error: ");
                (!is_refused || !run.stderr.contains(wanted) || bench.exists(out))
                    .then(|| format!("must be refused with {wanted:?}, got {:?}", run.code))
            }
            Same | Near(_) if !run.stderr.is_empty() => {
                Some("must be read without a word".to_owned())
            }
            Warned(wanted) if !run.stderr.contains(wanted) => Some(format!("must say {wanted:?}")),
            Same | Near(_) | Warned(_) => {
                let tolerance = if let Near(tolerance) = expected { tolerance } else { SAME };
                match difference() {
                    Ok(found) if found <= tolerance => None,
                    Ok(found) => Some(format!("differs by {found}, must be at most {tolerance}")),
                    Err(why) => Some(why),
                }
            }
        };
        wrong.extend(problem.map(|problem| format!("{name}: {problem}\n  {}", run.stderr)));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
