//! The header of a PLY file: its format, elements and properties.

use super::PlyError;
use crate::numpy::Dtype;
use crate::obj::shown;

/// Maximum size of a header. Those of scanners with many comments have a few kilobytes.
const MAX_HEADER: usize = 1 << 20;

/// How the rows after the header are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number, of either byte order.
fn scalar(name: &[u8]) -> Option<Dtype> {
    Dtype::from_text(match name {
        b"char" | b"int8" => "i1",
        b"uchar" | b"uint8" => "u1",
        b"short" | b"int16" => "i2",
        b"ushort" | b"uint16" => "u2",
        b"int" | b"int32" => "i4",
        b"uint" | b"uint32" => "u4",
        b"float" | b"float32" => "f4",
        b"double" | b"float64" => "f8",
        _ => return None,
    })
}

#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    /// Type of the count of a list.
    pub list: Option<Dtype>,
    /// Type of the value, or of a list's items.
    pub scalar: Dtype,
}

#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// Index of the first property with one of the names.
    pub(super) fn find(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|property| names.contains(&&*property.name))
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Files of textures, from comments, in order.
    pub textures: Vec<String>,
    /// Number of lines.
    pub lines: usize,
}

/// Lines that end as the first one does: in a binary file the byte after the header may be a line
/// feed by chance.
struct Lines<'a> {
    rest: &'a [u8],
    ending: &'static [u8],
    line: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let limited = &self.rest[..self.rest.len().min(MAX_HEADER)];
        let end = limited.windows(self.ending.len()).position(|window| window == self.ending)?;
        let line = &self.rest[..end];
        self.rest = &self.rest[end + self.ending.len()..];
        self.line += 1;
        Some(line)
    }
}

/// The header, and the bytes after it.
pub(super) fn parse(bytes: &[u8]) -> Result<(Header, &[u8]), PlyError> {
    let not_ply = || PlyError::NotPly { start: bytes[..bytes.len().min(8)].to_vec() };
    if !super::is_ply(bytes) {
        return Err(not_ply());
    }
    let first = bytes.iter().position(|&byte| byte == b'\r' || byte == b'\n').unwrap_or(3);
    let ending: &[u8] = match bytes[first..] {
        [b'\r', b'\n', ..] => b"\r\n",
        [b'\r', ..] => b"\r",
        _ => b"\n",
    };
    let mut lines = Lines { rest: bytes, ending, line: 0 };
    let mut encoding = None;
    let (mut elements, mut textures) = (Vec::<Element>::new(), Vec::new());
    while let Some(line) = lines.next() {
        if bytes.len() - lines.rest.len() > MAX_HEADER {
            break;
        }
        let words: Vec<&[u8]> =
            line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
        let wrong = |problem: String| PlyError::Header { line: lines.line, problem };
        match words[..] {
            [b"ply"] if lines.line == 1 => {}
            _ if lines.line == 1 => return Err(not_ply()),
            [] | [b"obj_info", ..] => {}
            [b"comment", b"TextureFile", ..] => textures.push(texture_name(line)),
            [b"comment", ..] => {}
            [b"format", name, _version] if encoding.is_none() => {
                encoding = Some(format(name).map_err(wrong)?);
            }
            [b"element", name, count] => {
                let element = element(name, count).map_err(wrong)?;
                if elements.iter().any(|known| known.name == element.name) {
                    return Err(wrong(format!("duplicate element `{}`", shown(name))));
                }
                elements.push(element);
            }
            [b"property", ref words @ ..] => {
                let element = elements.last_mut();
                let element = element.ok_or_else(|| wrong("property without element".into()))?;
                element.properties.push(property(words).map_err(wrong)?);
            }
            [b"end_header"] => {
                let encoding = encoding.ok_or_else(|| wrong("header without `format`".into()))?;
                let header = Header { encoding, elements, textures, lines: lines.line };
                return Ok((header, lines.rest));
            }
            _ => return Err(wrong(format!("not a line of a PLY header: `{}`", shown(line)))),
        }
    }
    Err(PlyError::Endless { max: MAX_HEADER })
}

fn format(name: &[u8]) -> Result<Encoding, String> {
    match name {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(format!(
            "format must be ascii, binary_little_endian or binary_big_endian, got `{}`",
            shown(name)
        )),
    }
}

fn element(name: &[u8], count: &[u8]) -> Result<Element, String> {
    let number = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
    let count = number.ok_or_else(|| {
        format!("count of an element must be a whole number, got `{}`", shown(count))
    })?;
    Ok(Element { name: text(name), count, properties: Vec::new() })
}

fn property(words: &[&[u8]]) -> Result<Property, String> {
    let scalar = |name: &[u8]| {
        scalar(name).ok_or_else(|| {
            format!(
                "type of a property must be one such as uchar, int or float, got `{}`",
                shown(name)
            )
        })
    };
    match *words {
        [b"list", count, item, name] => {
            let count = scalar(count)?;
            if !count.is_integer() {
                return Err("count of a list must be an integer type, got a float".to_owned());
            }
            Ok(Property { name: text(name), list: Some(count), scalar: scalar(item)? })
        }
        [kind, name] => Ok(Property { name: text(name), list: None, scalar: scalar(kind)? }),
        _ => Err("must be `property TYPE NAME` or `property list TYPE TYPE NAME`".to_owned()),
    }
}

fn text(name: &[u8]) -> String {
    String::from_utf8_lossy(name).into_owned()
}

/// The rest of the line, as names of files may contain blanks.
fn texture_name(line: &[u8]) -> String {
    let line = String::from_utf8_lossy(line);
    line.split_once("TextureFile").map_or("", |(_, name)| name.trim()).to_owned()
}
