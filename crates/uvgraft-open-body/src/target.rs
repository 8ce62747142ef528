//! MakeHuman's targets: offsets of some vertices of the base mesh, as text.
//!
//! Each line is an index and three numbers in decimetres. Lines that start with `#` are comments.
//! Files that end in `.gz` are compressed.

use flate2::read::GzDecoder;

use crate::ImportError;
use crate::wheel::{Wheel, bounded};

/// Limit of an uncompressed target; the largest has 0.6 MB.
const MAX_BYTES: u64 = 8 << 20;

/// Vertices and their offsets, in metres.
pub(crate) type Target = Vec<(u32, [f32; 3])>;

/// Metres in a decimetre.
pub(crate) const METRES: f32 = 0.1;

/// Reads a target.
///
/// - `path`: ends in `.target` or `.target.gz`.
/// - `vertices`: number of vertices of the base mesh.
pub(crate) fn read(
    wheel: &mut Wheel<'_>,
    path: &str,
    vertices: usize,
) -> Result<Target, ImportError> {
    let mut bytes = wheel.read(path)?;
    if path.ends_with(".gz") {
        let unpacked = bounded(GzDecoder::new(&bytes[..]), MAX_BYTES);
        bytes = unpacked.map_err(|problem| ImportError::content(path, problem))?;
    }
    parse(&bytes, vertices).map_err(|problem| ImportError::content(path, problem))
}

/// Parses a target.
///
/// # Errors
/// The line and what is wrong with it.
pub(crate) fn parse(bytes: &[u8], vertices: usize) -> Result<Target, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| error.to_string())?;
    let mut target = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        if line.starts_with('#') || line.trim_ascii().is_empty() {
            continue;
        }
        let offset = row(line)
            .filter(|(vertex, offset)| {
                (*vertex as usize) < vertices && offset.iter().all(|value| value.is_finite())
            })
            .ok_or_else(|| {
                format!(
                    "line {number}: must be an index below {vertices} and three numbers, got \
                     `{}`",
                    line.chars().take(40).collect::<String>()
                )
            })?;
        target.push(offset);
    }
    Ok(target)
}

fn row(line: &str) -> Option<(u32, [f32; 3])> {
    let mut words = line.split_ascii_whitespace();
    let vertex = words.next()?.parse().ok()?;
    let mut offset = [0.0; 3];
    for value in &mut offset {
        *value = words.next()?.parse::<f32>().ok()? * METRES;
    }
    words.next().is_none().then_some((vertex, offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_offsets() {
        let target = parse(b"# CC0\n3 0 .5 -1\r\n\n7 -.001 1e-1 0\n", 8).unwrap();
        assert_eq!(target.len(), 2);
        assert_eq!(target[0], (3, [0.0, 0.05, -0.1]));
        assert_eq!((target[1].0, target[1].1[1]), (7, 0.010_000_001));
    }

    #[test]
    fn malformed_lines_are_named() {
        for bad in ["8 0 0 0", "-1 0 0 0", "1 0 0", "1 0 0 0 0", "1 0 0 nan", "1 0 0 x", "x"] {
            let error = parse(format!("0 0 0 0\n{bad}\n").as_bytes(), 8).unwrap_err();
            let wanted = format!("line 2: must be an index below 8 and three numbers, got `{bad}`");
            assert_eq!(error, wanted);
        }
        parse(b"0 0 0 \xff", 8).unwrap_err();
    }
}
