//! Lists of textures: text files with a texture in each line.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read as _};
use std::path::{Component, Path, PathBuf};

use crate::failure::{Failure, Result};

/// No path is nearly as long.
const MAX_LINE_BYTES: usize = 1 << 16;

/// A text file (UTF-8) that lists textures, one in each line.
///
/// A line is the path of an image, and optionally a tab and the path of the output within the
/// output folder, whose subfolders are created; without it, the output is named after the source.
/// Relative paths of images are relative to the current directory. Blank lines, and lines that
/// start with `#`, are skipped.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum TextureList {
    /// A file.
    File(PathBuf),
    /// The standard input of the process.
    StandardInput,
}

/// A line of a list.
pub(crate) struct Listed {
    pub(crate) source: PathBuf,
    /// Within the output folder; by default named after the source.
    pub(crate) output: Option<PathBuf>,
}

impl TextureList {
    /// The path of the file.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::StandardInput => None,
        }
    }

    /// What messages call it.
    fn name(&self) -> String {
        self.path().map_or_else(|| "standard input".to_owned(), |path| path.display().to_string())
    }

    /// Passes on the textures, one by one.
    ///
    /// - `add`: its failures get the file and the line.
    pub(crate) fn for_each(&self, add: impl FnMut(Listed) -> Result<()>) -> Result<()> {
        let cannot_read =
            |error: io::Error| Failure::input(format!("cannot read {}: {error}", self.name()));
        match self {
            Self::File(path) if path.is_dir() => Err(Failure::input(format!(
                "{}: must be a text file that lists textures, but is a folder",
                path.display()
            ))),
            Self::File(path) => {
                let file = File::open(path).map_err(cannot_read)?;
                self.read(BufReader::with_capacity(1 << 18, file), add)
            }
            Self::StandardInput => self.read(io::stdin().lock(), add),
        }
    }

    fn read(
        &self,
        mut reader: impl BufRead,
        mut add: impl FnMut(Listed) -> Result<()>,
    ) -> Result<()> {
        let (mut line, mut any) = (Vec::new(), false);
        for number in 1u64.. {
            line.clear();
            let mut limited = reader.by_ref().take(MAX_LINE_BYTES as u64 + 1);
            let read = limited.read_until(b'\n', &mut line);
            let of_line =
                |failure: Failure| failure.context(format_args!("{}: line {number}", self.name()));
            if read.map_err(|error| of_line(Failure::input(error)))? == 0 {
                break;
            }
            if let Some(listed) = parse(&line, number == 1).map_err(of_line)? {
                any = true;
                add(listed).map_err(of_line)?;
            }
        }
        if any {
            return Ok(());
        }
        Err(Failure::input(format!("{}: must list at least one texture", self.name())))
    }
}

/// A line with a texture; `None` if it is blank or a comment.
fn parse(line: &[u8], is_first: bool) -> Result<Option<Listed>> {
    if line.len() > MAX_LINE_BYTES {
        let wanted = format!("must have at most {MAX_LINE_BYTES} bytes");
        return Err(Failure::input(format!("{wanted}; this is not a list of textures")));
    }
    let line = str::from_utf8(line).map_err(|_| Failure::input("must be UTF-8 text"))?;
    // Some editors start files with a byte order mark.
    let line = if is_first { line.strip_prefix('\u{feff}').unwrap_or(line) } else { line };
    let line = line.trim_end_matches(['\n', '\r']);
    if line.trim().is_empty() || line.trim_start().starts_with('#') {
        return Ok(None);
    }
    let mut columns = line.split('\t');
    let source = columns.next().unwrap_or_default();
    let output = columns.next();
    let more = columns.count();
    if more > 0 {
        return Err(Failure::input(format!(
            "must be an image, or an image, a tab and an output, got {} columns",
            more + 2
        )));
    }
    if source.trim().is_empty() {
        return Err(Failure::input("the path of the image is missing"));
    }
    let output = output.map(within_folder).transpose()?;
    Ok(Some(Listed { source: PathBuf::from(source), output }))
}

/// Checks that an output stays in the output folder.
fn within_folder(output: &str) -> Result<PathBuf> {
    let parts = || Path::new(output).components();
    let is_inside = parts().all(|part| matches!(part, Component::Normal(_)));
    if is_inside && parts().next().is_some() && !output.ends_with('/') {
        // Without repeated separators, so that equal outputs are equal paths.
        return Ok(parts().collect());
    }
    Err(Failure::input(format!(
        "the output must be the path of a file within the output folder, got {output:?}"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Result<Vec<(String, Option<String>)>> {
        let mut all = Vec::new();
        let text_of = |path: PathBuf| path.to_string_lossy().into_owned();
        TextureList::File("list.txt".into()).read(text, |Listed { source, output }| {
            all.push((text_of(source), output.map(text_of)));
            Ok(())
        })?;
        Ok(all)
    }

    #[test]
    fn lines_are_textures() {
        let text = "\u{feff}# faces\na b.png\r\n\n  \n/x/ä.jpg\tsub//c.png\n  # no\nlast.png";
        let found = read(text.as_bytes()).unwrap();
        let wanted = [("a b.png", None), ("/x/ä.jpg", Some("sub/c.png")), ("last.png", None)];
        let wanted = wanted.map(|(source, output)| (source.to_owned(), output.map(str::to_owned)));
        assert_eq!(found, wanted);
    }

    #[test]
    fn failures_name_the_line() {
        let long = [b'a'; 70_000];
        let cases: [(&[u8], &str); 9] = [
            (b"", "list.txt: must list at least one texture"),
            (b"# nothing\n\n", "list.txt: must list at least one texture"),
            (b"a.png\nb.png\tc.png\td.png\n", "list.txt: line 2: must be an image, or"),
            (b"a.png\n\tc.png\n", "list.txt: line 2: the path of the image is missing"),
            (b"a.png\t../b.png", "list.txt: line 1: the output must be the path of a file within"),
            (b"a.png\t/b.png", "got \"/b.png\""),
            (b"a.png\t", "got \"\""),
            (b"\xff\xfea.png", "list.txt: line 1: must be UTF-8 text"),
            (&long, "list.txt: line 1: must have at most 65536 bytes"),
        ];
        for (text, wanted) in cases {
            let failure = read(text).unwrap_err().to_string();
            assert!(failure.contains(wanted), "{failure}");
        }
    }
}
