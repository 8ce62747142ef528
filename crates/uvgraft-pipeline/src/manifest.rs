//! The manifest of a folder: a record of what each output was made from, to find out which outputs
//! are up to date.
//!
//! `.uvgraft-manifest.jsonl` in the output folder has one line of JSON for each output written: its
//! name, the fingerprint of everything it was made from, and the SHA-256 of the file. Each shard of
//! a batch appends to a file of its own, such as `.uvgraft-manifest-0003-of-0064.jsonl`: appends of
//! several machines to one file of a network file system may overwrite each other. All of these
//! files are read.
//!
//! A later line for a name replaces earlier ones in the same file, and malformed lines are skipped,
//! so that several processes of a machine may append to one file, and a killed process damages at
//! most its last line. Lines in several files do not contradict each other: any that matches both
//! the inputs and the output proves that the output is up to date. File times are ignored: they say
//! when a file was written, not what it contains.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{PoisonError, RwLock};

use serde::{Deserialize, Serialize};

use crate::failure::{Blame, Context, Failure, Result};
use crate::fingerprint::file_digest;
use crate::shard::Shard;

/// What the file names of manifests start and end with.
const START: &str = ".uvgraft-manifest";
const END: &str = ".jsonl";

/// A larger file is ignored: this is about ten million lines.
const MAX_BYTES: u64 = 2 << 30;

/// The records of the outputs in a folder. Several threads may use it at once.
#[derive(Debug)]
pub struct Manifest {
    folder: PathBuf,
    /// The file that new records are appended to.
    path: PathBuf,
    records: RwLock<HashMap<String, Vec<Record>>>,
    /// Whether the last line of the file was incomplete when it was read.
    is_cut: AtomicBool,
}

/// What an output was made from, and what it contained.
#[derive(Debug, Clone, Copy)]
struct Record {
    fingerprint: [u8; 32],
    sha256: [u8; 32],
    /// Which file it is from.
    file: u32,
}

/// A line of a file.
#[derive(Debug, Serialize, Deserialize)]
struct Line<'a> {
    #[serde(borrow)]
    output: Cow<'a, str>,
    #[serde(borrow, rename = "made_from")]
    fingerprint: Cow<'a, str>,
    #[serde(borrow)]
    sha256: Cow<'a, str>,
}

impl Manifest {
    /// Reads the records of a folder; there are none if it does not exist.
    ///
    /// - `shard`: appends to the file of this shard, and keeps the records of its outputs only.
    ///
    /// # Errors
    /// As bad input if a manifest cannot be read.
    pub fn open(folder: &Path, shard: Option<Shard>) -> Result<Self> {
        let path = folder.join(match shard {
            None => format!("{START}{END}"),
            Some(shard) => format!("{START}-{:04}-of-{:04}{END}", shard.index(), shard.count()),
        });
        let mut records = HashMap::new();
        let mut is_cut = false;
        for (index, file) in (0..).zip(files(folder)) {
            let what = format_args!("cannot read the manifest {}", file.display());
            let found = read(&file, index, shard, &mut records).or_input().context(what)?;
            is_cut |= found == End::Cut && file == path;
        }
        let (records, is_cut) = (RwLock::new(records), AtomicBool::new(is_cut));
        Ok(Self { folder: folder.to_path_buf(), path, records, is_cut })
    }

    /// Whether an output exists, is unchanged since it was recorded, and was made from certain
    /// inputs and options.
    ///
    /// - `output`: its path, which starts with that of the folder.
    /// - `fingerprint`: the fingerprint of the inputs and options, as
    ///   [`PreparedTransfer::fingerprint_of_bytes`](crate::PreparedTransfer::fingerprint_of_bytes)
    ///   returns it.
    pub fn is_up_to_date(&self, output: &Path, fingerprint: &str) -> bool {
        self.matches(output, || Some(fingerprint.to_owned()))
    }

    /// As [`Manifest::is_up_to_date`], with a fingerprint that is computed only if there are
    /// records.
    pub(crate) fn matches(
        &self,
        output: &Path,
        fingerprint: impl FnOnce() -> Option<String>,
    ) -> bool {
        let Some(name) = name_within(&self.folder, output) else { return false };
        let records = {
            let records = self.records.read().unwrap_or_else(PoisonError::into_inner);
            let Some(records) = records.get(&name) else { return false };
            records.clone()
        };
        // The source first: it is usually the smaller file.
        let fingerprint = fingerprint().and_then(|fingerprint| digest_of(&fingerprint));
        let mut matching = records.iter().filter(|record| Some(record.fingerprint) == fingerprint);
        let Some(first) = matching.next() else { return false };
        let found = file_digest(output).ok().and_then(|digest| digest_of(&digest));
        std::iter::once(first).chain(matching).any(|record| Some(record.sha256) == found)
    }

    /// Records that an output was written.
    ///
    /// - `output`: its path, which starts with that of the folder.
    /// - `fingerprint`: the fingerprint of the inputs and options, computed before the work: see
    ///   [`Manifest::is_up_to_date`].
    ///
    /// # Errors
    /// As bad input if the output is not in the folder or the fingerprint is not one; as a failure
    /// of the work if the output cannot be read or the manifest not be written.
    pub fn record(&self, output: &Path, fingerprint: &str) -> Result<()> {
        let what = format_args!("cannot record {} in the manifest", output.display());
        self.try_record(output, fingerprint).context(what)
    }

    fn try_record(&self, output: &Path, fingerprint: &str) -> Result<()> {
        let name = name_within(&self.folder, output).ok_or_else(|| {
            Failure::input(format!("must be in the folder {}", self.folder.display()))
        })?;
        let digest = digest_of(fingerprint).ok_or_else(|| {
            let wanted = "the fingerprint must be 64 lower-case hexadecimal digits";
            Failure::input(format!("{wanted}, got {fingerprint:?}"))
        })?;
        let sha256 = file_digest(output).or_work()?;
        let record =
            digest_of(&sha256).map(|sha256| Record { fingerprint: digest, sha256, file: u32::MAX });
        let line = Line {
            output: Cow::Borrowed(&name),
            fingerprint: Cow::Borrowed(fingerprint),
            sha256: Cow::Owned(sha256),
        };
        self.append(&serde_json::to_string(&line).or_work()?)?;
        let mut records = self.records.write().unwrap_or_else(PoisonError::into_inner);
        record.into_iter().for_each(|record| add(&mut records, &name, record));
        Ok(())
    }

    fn append(&self, line: &str) -> Result<()> {
        let start = if self.is_cut.swap(false, Ordering::Relaxed) { "\n" } else { "" };
        // A single write, so that lines of concurrent processes stay intact.
        let line = format!("{start}{line}\n");
        let file = OpenOptions::new().append(true).create(true).open(&self.path);
        file.and_then(|mut file| file.write_all(line.as_bytes())).or_work()
    }
}

/// How a file ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Whole,
    /// Within a line.
    Cut,
}

/// The manifests of a folder, sorted; none if it cannot be read.
fn files(folder: &Path) -> Vec<PathBuf> {
    let at = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let names = at.read_dir().into_iter().flatten().flatten().map(|entry| entry.file_name());
    let is_manifest = |name: &std::ffi::OsString| {
        let name = name.as_encoded_bytes();
        name.starts_with(START.as_bytes()) && name.ends_with(END.as_bytes())
    };
    let mut files: Vec<PathBuf> = names.filter(is_manifest).map(|name| folder.join(name)).collect();
    files.retain(|file| file.metadata().is_ok_and(|it| it.is_file() && it.len() <= MAX_BYTES));
    files.sort();
    files
}

/// Adds the records of a file.
///
/// - `index`: which of the files it is.
fn read(
    path: &Path,
    index: u32,
    shard: Option<Shard>,
    records: &mut HashMap<String, Vec<Record>>,
) -> io::Result<End> {
    let mut reader = BufReader::new(File::open(path)?);
    let mut line = Vec::new();
    loop {
        line.clear();
        if reader.read_until(b'\n', &mut line)? == 0 {
            return Ok(End::Whole);
        }
        if let Ok(line) = serde_json::from_slice::<Line<'_>>(&line)
            && shard.is_none_or(|shard| shard.has(&line.output))
            && let (Some(fingerprint), Some(sha256)) =
                (digest_of(&line.fingerprint), digest_of(&line.sha256))
        {
            add(records, &line.output, Record { fingerprint, sha256, file: index });
        }
        if line.last() != Some(&b'\n') {
            return Ok(End::Cut);
        }
    }
}

/// Adds a record, in place of an earlier one from the same file.
fn add(records: &mut HashMap<String, Vec<Record>>, name: &str, record: Record) {
    let Some(of_name) = records.get_mut(name) else {
        records.insert(name.to_owned(), vec![record]);
        return;
    };
    match of_name.iter_mut().find(|other| other.file == record.file) {
        Some(other) => *other = record,
        None => of_name.push(record),
    }
}

/// An output's name: its path within the output folder, with `/` between its parts; `None` if it is
/// elsewhere.
pub(crate) fn name_within(folder: &Path, output: &Path) -> Option<String> {
    let mut name = String::new();
    for part in output.strip_prefix(folder).ok()?.components() {
        let Component::Normal(part) = part else { return None };
        if !name.is_empty() {
            name.push('/');
        }
        name.push_str(&part.to_string_lossy());
    }
    (!name.is_empty()).then_some(name)
}

/// The bytes of a SHA-256 in hexadecimal digits, in lower case.
fn digest_of(text: &str) -> Option<[u8; 32]> {
    let digit = |digit: u8| match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        _ => None,
    };
    let mut digest = [0; 32];
    if text.len() != 2 * digest.len() {
        return None;
    }
    for (byte, digits) in digest.iter_mut().zip(text.as_bytes().chunks(2)) {
        *byte = digit(digits[0])? << 4 | digit(digits[1])?;
    }
    Some(digest)
}
