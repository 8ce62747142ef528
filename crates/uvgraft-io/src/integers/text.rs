//! Integers as text, separated by whitespace or commas.

use super::IntegersError;
use crate::obj::shown;

pub(super) fn parse(bytes: &[u8]) -> Result<Vec<i64>, IntegersError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut ids = Vec::new();
    let mut line = 1;
    let mut comma_may_follow = false;
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let rest = &bytes[at..];
        at += match byte {
            b'\n' | b'\r' => {
                line += 1;
                comma_may_follow = false;
                if rest.starts_with(b"\r\n") { 2 } else { 1 }
            }
            b' ' | b'\t' | b'\x0b' | b'\x0c' => 1,
            b',' if comma_may_follow => {
                comma_may_follow = false;
                1
            }
            b',' => return Err(IntegersError::MissingValue { line }),
            b'#' => length_until(rest, |byte| matches!(byte, b'\n' | b'\r')),
            _ => {
                let length =
                    length_until(rest, |byte| matches!(byte, b'\t'..=b'\r' | b' ' | b',' | b'#'));
                ids.push(integer(&rest[..length], line, ids.len() + 1)?);
                comma_may_follow = true;
                length
            }
        };
    }
    Ok(ids)
}

fn length_until(bytes: &[u8], is_end: impl Fn(u8) -> bool) -> usize {
    bytes.iter().position(|&byte| is_end(byte)).unwrap_or(bytes.len())
}

fn integer(word: &[u8], line: usize, entry: usize) -> Result<i64, IntegersError> {
    let text = std::str::from_utf8(word).unwrap_or_default();
    text.parse().map_err(|_| {
        let found = shown(word);
        let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
        if !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()) {
            IntegersError::OutOfRange { entry, found }
        } else if text.parse::<f64>().is_ok() {
            IntegersError::Float { line, found }
        } else {
            IntegersError::NotInteger { line, found }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_layout_of_integers_will_do() {
        for text in [
            "5\n-1\n+7\n",
            "5 -1 7",
            "5,-1,7",
            "\u{feff}# source vertices\r\n5,\t-1, # two\r\n\r\n 7,\r\n",
            "5 , -1\r7\r",
            "5#five\n-1,\n7,#",
        ] {
            assert_eq!(parse(text.as_bytes()), Ok(vec![5, -1, 7]), "{text:?}");
        }
        let extremes = parse(b"9223372036854775807 -9223372036854775808");
        assert_eq!(extremes, Ok(vec![i64::MAX, i64::MIN]));
    }

    #[test]
    fn errors_name_the_line_and_what_was_found() {
        for (text, wanted) in [
            ("1\r\n2\r\nthree", "line 3: must be an integer, got `three`"),
            ("[1, 2]", "line 1: must be an integer, got `[1`"),
            ("1\r2;3", "line 2: must be an integer, got `2;3`"),
            ("-", "line 1: must be an integer, got `-`"),
            ("1\n\u{e4}", "line 2: must be an integer, got `\\xc3\\xa4`"),
            (
                "# ids\n12.0",
                "line 2: must be an integer, got floating-point `12.0`; with numpy.savetxt, use fmt=\"%d\"",
            ),
            (
                "1 2\n9223372036854775808",
                "entry 3: must be a signed 64-bit integer, got 9223372036854775808",
            ),
            ("1,,2", "line 1: comma without an integer before it"),
            ("1,2\n,3", "line 2: comma without an integer before it"),
        ] {
            assert_eq!(parse(text.as_bytes()).unwrap_err().to_string(), wanted);
        }
        assert_eq!(
            parse(b"\xff\xfe1\0"),
            Err(IntegersError::NotInteger { line: 1, found: r"\xff\xfe1\x00".into() })
        );
    }
}
