//! A tokenizer for words and lines of an OBJ file, on raw bytes.

/// A position in the text. Lines end at LF, CR LF or CR; a backslash before the end of a line
/// continues it.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, line: 1 }
    }

    /// Number of the current line, from 1.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// The next word on this line, never empty. Stays at the end of the line once reached.
    pub(super) fn word(&mut self) -> Option<&'a [u8]> {
        while let Some(length) = self.blank() {
            self.at += length;
        }
        let start = self.at;
        while let Some(&byte) = self.bytes.get(self.at) {
            // One test for almost every byte; the rest distinguishes the few candidates.
            let may_end = byte <= b' ' || byte == b'\\';
            if may_end && (is_blank(byte) || is_end(byte) || self.continuation().is_some()) {
                break;
            }
            self.at += 1;
        }
        (start < self.at).then(|| &self.bytes[start..self.at])
    }

    /// The next word, unless a comment starts there.
    pub(super) fn value(&mut self) -> Option<&'a [u8]> {
        self.word().filter(|word| word[0] != b'#')
    }

    /// The rest of this line, trimmed, as UTF-8 if valid and Latin-1 otherwise. A continuation
    /// becomes a space.
    pub(super) fn rest_of_line(&mut self) -> String {
        let mut rest = Vec::new();
        while let Some(&byte) = self.bytes.get(self.at) {
            if is_end(byte) {
                break;
            }
            match self.continuation() {
                Some(length) => {
                    rest.push(b' ');
                    self.at += length;
                    self.line += 1;
                }
                None => {
                    rest.push(byte);
                    self.at += 1;
                }
            }
        }
        let text = String::from_utf8(rest)
            .unwrap_or_else(|error| error.as_bytes().iter().copied().map(char::from).collect());
        text.trim_matches(|character| u8::try_from(character).is_ok_and(is_blank)).to_owned()
    }

    /// Moves to the end of the line even after a backslash: a comment that ends in the path of a
    /// folder must not swallow the next line.
    pub(super) fn skip_comment(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|&byte| is_end(byte)).unwrap_or(rest.len());
    }

    /// Skips the rest of this line and its continuations. False at the end of the text.
    pub(super) fn next_line(&mut self) -> bool {
        loop {
            // Only the skipped part counts: a backslash before it belongs to a comment.
            let start = self.at;
            self.skip_comment();
            let Some(length) = end_length(&self.bytes[self.at..]) else { return false };
            let continued = self.bytes[start..self.at].ends_with(b"\\");
            self.at += length;
            self.line += 1;
            if !continued {
                return true;
            }
        }
    }

    /// Length of the next blank or continuation; counts the line of a continuation.
    fn blank(&mut self) -> Option<usize> {
        if is_blank(*self.bytes.get(self.at)?) {
            return Some(1);
        }
        let length = self.continuation()?;
        self.line += 1;
        Some(length)
    }

    /// Length of a backslash and the following end of line, if present.
    fn continuation(&self) -> Option<usize> {
        let after = self.bytes[self.at..].strip_prefix(b"\\")?;
        Some(1 + end_length(after)?)
    }
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0b' | b'\x0c')
}

fn is_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// Length of the end of line at the start of `bytes`.
fn end_length(bytes: &[u8]) -> Option<usize> {
    match bytes {
        [b'\r', b'\n', ..] => Some(2),
        [b'\r' | b'\n', ..] => Some(1),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<(usize, Vec<&str>)> {
        let mut cursor = Cursor::new(text.as_bytes());
        let mut lines = Vec::new();
        loop {
            let line = cursor.line();
            let words = std::iter::from_fn(|| cursor.word());
            lines.push((line, words.map(|word| std::str::from_utf8(word).unwrap()).collect()));
            if !cursor.next_line() {
                return lines;
            }
        }
    }

    #[test]
    fn every_line_ending_counts_once() {
        let lines = words("a\r\nb\rc\n\nd");
        let wanted = [(1, vec!["a"]), (2, vec!["b"]), (3, vec!["c"]), (4, vec![]), (5, vec!["d"])];
        assert_eq!(lines, wanted);
    }

    #[test]
    fn a_backslash_continues_a_line_and_separates_words() {
        let lines = words(" a\t \\\r\n b\\\nc \\ d\\\n\ne\\");
        assert_eq!(lines, [(1, vec!["a", "b", "c", "\\", "d"]), (5, vec!["e\\"])]);
    }

    #[test]
    fn skipped_lines_take_their_continuations_along_but_comments_do_not() {
        let mut cursor = Cursor::new(b"curv 1\\\n2 \\\n3\n# C:\\\nv");
        assert!(cursor.next_line());
        assert_eq!((cursor.line(), cursor.value()), (4, None));
        cursor.skip_comment();
        assert!(cursor.next_line());
        assert_eq!((cursor.line(), cursor.value()), (5, Some(&b"v"[..])));
        assert!(!cursor.next_line());
    }

    #[test]
    fn names_are_utf8_or_latin1() {
        let rest = |bytes: &[u8]| Cursor::new(bytes).rest_of_line();
        assert_eq!(rest("  head  skin\t\n".as_bytes()), "head  skin");
        assert_eq!(rest("Kopf ä\r\n".as_bytes()), "Kopf ä");
        assert_eq!(rest(b"Kopf \xe4"), "Kopf ä");
        assert_eq!(rest(b"left\\\nright\\"), "left right\\");
    }
}
