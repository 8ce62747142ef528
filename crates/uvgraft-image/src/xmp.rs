//! XMP packets: what they say about orientation, in files without EXIF. All else is never read.
//!
//! Source: XMP specification, part 1 (ISO 16684-1), for simple properties as attributes and as elements.

/// The property, by the prefix that all writers give to its namespace; Pillow and ExifTool rely on
/// it, too.
const NAME: &[u8] = b"tiff:Orientation";

/// The value of `tiff:Orientation`, as of the TIFF tag of this name.
pub(super) fn orientation(packet: &[u8]) -> Option<u64> {
    let at = packet.windows(NAME.len()).position(|part| part == NAME)?;
    // `="6"`, `='6'` or `>6<`, perhaps with blanks.
    let rest = packet[at + NAME.len()..].trim_ascii_start();
    let rest = match rest {
        [b'=', rest @ ..] => match rest.trim_ascii_start() {
            [b'"' | b'\'', rest @ ..] => rest,
            _ => return None,
        },
        [b'>', rest @ ..] => rest,
        _ => return None,
    };
    match rest.trim_ascii_start() {
        [digit @ b'1'..=b'8', next, ..] if !next.is_ascii_digit() => Some(u64::from(digit - b'0')),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_and_elements_are_found() {
        for (packet, wanted) in [
            (r#"<rdf:Description tiff:Orientation="6" x="1"/>"#, Some(6)),
            ("<rdf:Description tiff:Orientation = '8'/>", Some(8)),
            ("<tiff:Orientation>3</tiff:Orientation>", Some(3)),
            ("<tiff:Orientation>\n 3 </tiff:Orientation>", Some(3)),
            ("<tiff:Orientation>9</tiff:Orientation>", None),
            ("<tiff:Orientation>33</tiff:Orientation>", None),
            ("<tiff:OrientationOfSomething>3<", None),
            ("<tiff:Orientation>3", None),
            ("<tiff:Orientation", None),
            ("tiff:Orientation=6", None),
            ("", None),
        ] {
            assert_eq!(orientation(packet.as_bytes()), wanted, "{packet}");
        }
    }
}
