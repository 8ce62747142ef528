//! What a command tells beside its errors: its report, what it wrote and how to look at that. As text, reports
//! go to standard output when they are made, and the rest to standard error; with --json all of it is one
//! document on standard output, at the end.

use std::borrow::Cow;
use std::ffi::OsStr;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use anyhow::Context;
use serde::Serialize;

use crate::terminal::{self, MessageKind};

/// The outcome of the command that this process runs.
static OUTCOME: LazyLock<Mutex<Outcome>> = LazyLock::new(Mutex::default);

/// More files than these are counted.
const MAX_LISTED: usize = 4;

#[derive(Default)]
struct Outcome {
    is_json: bool,
    is_quiet: bool,
    program: String,
    command: String,
    written: Vec<String>,
    look: Option<String>,
    /// The fields of the report as JSON, without the braces around them.
    report: String,
    /// Results that have no other form than text.
    text: String,
    warnings: Vec<String>,
    notes: Vec<String>,
    errors: Vec<String>,
}

/// What `uvgraft` of a document holds, whatever the command.
#[derive(Serialize)]
struct Envelope<'a> {
    version: &'static str,
    command: &'a str,
    ok: bool,
    errors: &'a [String],
    warnings: &'a [String],
    notes: &'a [String],
    written: &'a [String],
    /// What the command prints without --json, for those that have no report.
    #[serde(skip_serializing_if = "str::is_empty")]
    text: &'a str,
}

/// A document before the fields of the report.
#[derive(Serialize)]
struct Head<'a> {
    uvgraft: Envelope<'a>,
}

impl Outcome {
    fn document(&self) -> anyhow::Result<String> {
        let uvgraft = Envelope {
            version: env!("CARGO_PKG_VERSION"),
            command: &self.command,
            ok: self.errors.is_empty(),
            errors: &self.errors,
            warnings: &self.warnings,
            notes: &self.notes,
            written: &self.written,
            text: &self.text,
        };
        let head = terminal::json(&Head { uvgraft })?;
        let head = head.trim_end_matches(['\n', ' ', '}']);
        let separator = if self.report.is_empty() { "" } else { "," };
        Ok(format!("{head}\n  }}{separator}{}\n}}\n", self.report))
    }
}

fn outcome() -> MutexGuard<'static, Outcome> {
    OUTCOME.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Starts a command.
///
/// - `called`: how the program was called.
/// - `command`: the command's name, with that of its subcommand.
pub(crate) fn begin(called: &OsStr, command: String, is_json: bool, is_quiet: bool) {
    let program = program(called);
    *outcome() = Outcome { is_json, is_quiet, program, command, ..Outcome::default() };
}

/// Whether notes, progress and closing lines are left out.
pub(crate) fn is_quiet() -> bool {
    outcome().is_quiet
}

/// Whether there will be one document instead of text.
pub(crate) fn is_json() -> bool {
    outcome().is_json
}

/// Tells the result of a command, of whose two forms one is made.
///
/// - `document`: what serialises as an object.
///
/// # Errors
/// If it cannot be printed.
pub(crate) fn report<D: Serialize>(
    document: impl FnOnce() -> D,
    text: impl FnOnce() -> String,
) -> anyhow::Result<()> {
    if !is_json() {
        return terminal::print(&text());
    }
    // As it is written, not as values, in which a float of 32 bits would have the digits of 64.
    let json = terminal::json(&document())?;
    let fields = json.strip_prefix('{').and_then(|rest| rest.strip_suffix("}\n"));
    let fields = fields.context("a report must be an object")?;
    fields.trim_end().clone_into(&mut outcome().report);
    Ok(())
}

/// Keeps a result that has no other form than text for the document; `false` if it is to be printed.
pub(crate) fn keep_text(text: &str) -> bool {
    let mut outcome = outcome();
    if outcome.is_json {
        outcome.text += text;
    }
    outcome.is_json
}

/// Keeps a warning, a note or an error for the document.
pub(crate) fn keep_message(kind: MessageKind, text: &str) {
    let mut outcome = outcome();
    let kept = match kind {
        _ if !outcome.is_json => return,
        MessageKind::Warning => &mut outcome.warnings,
        MessageKind::Note => &mut outcome.notes,
        MessageKind::Error => &mut outcome.errors,
        MessageKind::Wrote | MessageKind::Look => return,
    };
    kept.push(text.to_owned());
}

/// Tells that a file or a folder was written.
pub(crate) fn wrote(path: &Path) {
    outcome().written.push(path.display().to_string());
}

/// Whether the command ends with lines on what it wrote.
pub(crate) fn has_closing_lines() -> bool {
    let outcome = outcome();
    !outcome.is_quiet && !outcome.is_json
}

/// Tells one way to look at what was written: a command of this program.
///
/// - `arguments`: see [`command`].
pub(crate) fn look_by(arguments: impl Display) {
    let command = command(arguments);
    outcome().look = Some(command);
}

/// Tells that a mesh, or a texture on it, is looked at by a picture.
///
/// - `mesh`: a path, perhaps with the selector of a part.
/// - `is_head`: whether its head is what one looks at.
pub(crate) fn look_by_picture(mesh: &Path, texture: Option<&Path>, is_head: bool) {
    let texture = texture.map_or_else(String::new, |it| format!(" --texture {}", argument(it)));
    let camera = if is_head { " --camera head" } else { "" };
    let picture = free(PathBuf::from("look.png"));
    look_by(format_args!("render {}{texture}{camera} -o {}", argument(mesh), argument(&picture)));
}

/// A command of this program as one types it in the same folder and with the same path.
///
/// - `arguments`: in which each path is an [`argument`].
pub(crate) fn command(arguments: impl Display) -> String {
    let program = outcome().program.clone();
    format!("{} {arguments}", shell_word(&program))
}

/// How this program is called: by its name if that is what the path finds, or as it was called.
fn program(called: &OsStr) -> String {
    let path = Path::new(called);
    let is_same = |folder: PathBuf| {
        path.file_name().is_some_and(|name| {
            let found = folder.join(name).canonicalize();
            found.is_ok_and(|found| path.canonicalize().is_ok_and(|called| called == found))
        })
    };
    let variable = std::env::var_os("PATH").unwrap_or_default();
    match std::env::split_paths(&variable).any(is_same) {
        true => path.file_name().unwrap_or(called).display().to_string(),
        false => called.display().to_string(),
    }
}

/// A name beside others, for a file that a command is to write: with a number if that is taken.
pub(crate) fn free(path: PathBuf) -> PathBuf {
    let numbered = |number: u32| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        path.with_file_name(format!("{stem}_{number}.{extension}"))
    };
    if !path.exists() {
        return path;
    }
    (2..100).map(numbered).find(|path| !path.exists()).unwrap_or(path)
}

/// A path as an argument of a command in a shell, which does not begin as an option does.
pub(crate) fn argument(path: &Path) -> String {
    let text = path.display().to_string();
    let text = if text.starts_with('-') { format!("./{text}") } else { text };
    shell_word(&text).into_owned()
}

/// A word as shells read it.
fn shell_word(word: &str) -> Cow<'_, str> {
    let is_plain =
        |character: char| character.is_alphanumeric() || "_-./,:=+@%".contains(character);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.into(),
        false => format!("'{}'", word.replace('\'', r"'\''")).into(),
    }
}

/// Ends a command: prints what was written and how to look at it, or the document.
///
/// # Errors
/// If the document cannot be printed.
pub(crate) fn end() -> anyhow::Result<()> {
    let mut outcome = outcome();
    if outcome.is_json {
        let document = outcome.document()?;
        drop(outcome);
        return terminal::to_stdout(&document);
    }
    let (written, look) = (std::mem::take(&mut outcome.written), outcome.look.take());
    let is_silent = outcome.is_quiet || written.is_empty() || !outcome.errors.is_empty();
    drop(outcome);
    if is_silent {
        return Ok(());
    }
    let listed = match written.len() {
        0..=MAX_LISTED => written.join(", "),
        count => format!("{} and {} more files", written[0], count - 1),
    };
    terminal::message(MessageKind::Wrote, listed);
    if let Some(look) = look {
        terminal::message(MessageKind::Look, look);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_of_hints_are_new_and_no_options() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("look.png");
        assert_eq!(free(path.clone()), path);
        std::fs::write(&path, "mine").unwrap();
        assert_eq!(free(path), folder.path().join("look_2.png"));
        assert_eq!(argument(Path::new("-p.uvpair")), "./-p.uvpair");
        assert_eq!(argument(Path::new("a/-p.uvpair")), "a/-p.uvpair");
        assert_eq!(argument(Path::new("-a b")), "'./-a b'");
    }

    #[test]
    fn words_are_quoted_where_shells_need_it() {
        let words =
            ["me.glb", "a b.png", "it's", "", "me.glb#Head", "gesicht_ä.png"].map(shell_word);
        let wanted = ["me.glb", "'a b.png'", r"'it'\''s'", "''", "'me.glb#Head'", "gesicht_ä.png"];
        assert_eq!(words, wanted);
    }

    #[test]
    fn documents_have_one_envelope() {
        let mut outcome = Outcome {
            command: "compare".to_owned(),
            warnings: vec!["a".to_owned()],
            written: vec!["h.png".to_owned()],
            text: "1 of 2\n".to_owned(),
            ..Outcome::default()
        };
        outcome.report = "\n  \"regions\": 3".to_owned();
        let document = |outcome: &Outcome| -> serde_json::Value {
            serde_json::from_str(&outcome.document().unwrap()).unwrap()
        };
        let wanted = serde_json::json!({
            "regions": 3,
            "uvgraft": {
                "version": env!("CARGO_PKG_VERSION"), "command": "compare", "ok": true, "errors": [],
                "warnings": ["a"], "notes": [], "written": ["h.png"], "text": "1 of 2\n",
            },
        });
        assert_eq!(document(&outcome), wanted);
        outcome.errors.push("b".to_owned());
        outcome.report.clear();
        assert_eq!(document(&outcome)["uvgraft"]["ok"], false);
    }
}
