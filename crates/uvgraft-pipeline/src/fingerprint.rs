//! Fingerprints of what outputs are made from: the content of all inputs and all options.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use uvgraft_files::checksum::{hex, sha256};
use uvgraft_files::input::Input;

/// Increment when results change within a version of the program.
const REVISION: u32 = 1;

/// An incremental hash of what an output is made from.
#[derive(Clone)]
pub(crate) struct Fingerprint(Sha256);

impl Fingerprint {
    /// The hash of this version of the program alone.
    pub(crate) fn new() -> Self {
        let mut fingerprint = Self(Sha256::new());
        fingerprint.add(concat!("uvgraft ", env!("CARGO_PKG_VERSION")));
        fingerprint.add(&REVISION.to_string());
        fingerprint
    }

    /// Adds a string, delimited from what precedes and follows.
    pub(crate) fn add(&mut self, text: &str) {
        self.0.update((text.len() as u64).to_le_bytes());
        self.0.update(text.as_bytes());
    }

    /// Adds the content of a file or of bytes, to the same effect.
    pub(crate) fn add_input(&mut self, input: &Input) -> io::Result<()> {
        self.add(&input_digest(input)?);
        Ok(())
    }

    /// The fingerprint as hexadecimal digits.
    pub(crate) fn text(&self) -> String {
        hex(&self.0.clone().finalize())
    }

    /// The fingerprint with the content of one more file, as hexadecimal digits.
    pub(crate) fn with_file(&self, path: &Path) -> io::Result<String> {
        Ok(self.with_digest(&file_digest(path)?))
    }

    /// As [`Fingerprint::with_file`], for a file whose content is in memory.
    pub(crate) fn with_bytes(&self, bytes: &[u8]) -> String {
        self.with_digest(&sha256(bytes))
    }

    /// As [`Fingerprint::with_file`], also for bytes.
    pub(crate) fn with_input(&self, input: &Input) -> io::Result<String> {
        Ok(self.with_digest(&input_digest(input)?))
    }

    fn with_digest(&self, digest: &str) -> String {
        let mut fingerprint = self.clone();
        fingerprint.add(digest);
        fingerprint.text()
    }
}

/// Files that were read, and what tells whether they are still the same.
///
/// Their content is known only at the time of reading, and outputs are made later: a file that was
/// replaced meanwhile, even by one with the same content in the end, must not vouch for an output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Seen(Vec<(PathBuf, Option<Identity>)>);

/// The device, the number, the length and the times of a file; the times may be wrong, but do not
/// stay the same when it changes.
type Identity = (u64, u64, u64, [(i64, i64); 2]);

impl Seen {
    /// Files before they are read. Bytes do not change.
    pub(crate) fn before<'a>(inputs: impl IntoIterator<Item = &'a Input>) -> Self {
        let paths = inputs.into_iter().filter_map(Input::path);
        Self(paths.map(|path| (path.to_path_buf(), identity(path))).collect())
    }

    /// The first of the files that changed since, if any.
    pub(crate) fn changed(&self) -> Option<&Path> {
        let changed = |(path, before): &&(PathBuf, _)| identity(path) != *before;
        self.0.iter().find(changed).map(|(path, _)| path.as_path())
    }
}

#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    let found = path.metadata().ok()?;
    let times = [(found.mtime(), found.mtime_nsec()), (found.ctime(), found.ctime_nsec())];
    Some((found.dev(), found.ino(), found.len(), times))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<Identity> {
    let found = path.metadata().ok()?;
    let modified = found.modified().ok()?.duration_since(std::time::UNIX_EPOCH).ok()?;
    let time = (modified.as_secs() as i64, i64::from(modified.subsec_nanos()));
    Some((0, 0, found.len(), [time; 2]))
}

/// The SHA-256 of a regular file, as hexadecimal digits.
pub(crate) fn file_digest(path: &Path) -> io::Result<String> {
    // A pipe can be read only once.
    if !path.metadata()?.is_file() {
        return Err(io::Error::new(io::ErrorKind::Unsupported, "not a regular file"));
    }
    let mut file = File::open(path)?;
    let mut hasher = Sha256::new();
    let mut buffer = vec![0; 1 << 18];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hex(&hasher.finalize())),
            count => hasher.update(&buffer[..count]),
        }
    }
}

/// The SHA-256 of the content, as hexadecimal digits; of a file, only if it is a regular one.
pub(crate) fn input_digest(input: &Input) -> io::Result<String> {
    match input {
        Input::File(path) => file_digest(path),
        Input::Bytes { bytes, .. } => Ok(sha256(bytes)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_delimited() {
        let of = |texts: &[&str]| {
            let mut fingerprint = Fingerprint::new();
            texts.iter().for_each(|text| fingerprint.add(text));
            fingerprint.text()
        };
        assert_ne!(of(&["ab", "c"]), of(&["a", "bc"]));
        assert_ne!(of(&["ab"]), of(&["ab", ""]));
        assert_eq!(of(&["ab", "c"]), of(&["ab", "c"]));
    }

    #[test]
    fn only_regular_files_have_a_digest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, "abc").unwrap();
        let wanted = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(file_digest(&path).unwrap(), wanted);
        assert_eq!(input_digest(&Input::bytes("file", *b"abc")).unwrap(), wanted);
        assert!(file_digest(folder.path()).is_err());
    }
}
