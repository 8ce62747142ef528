//! Wavefront OBJ: polygons with texture coordinates, read and written.
//!
//! A texture transfer needs `v`, `vt` and `f`, with `o`, `g` and `usemtl` as the names of
//! [`MeshPart`](uvgraft::mesh::MeshPart)s. Everything else in a file, normals included, is skipped.
//! The parser accepts files as found in the wild: any line ending, any run of blanks, lines
//! continued by a backslash, a byte order mark, names in UTF-8 or Latin-1, relative indices, and
//! faces before their vertices.
//!
//! Source: Wavefront's "Object Files" specification, version 3.0.

mod build;
mod cursor;
#[cfg(test)]
mod tests;
mod write;

use uvgraft::mesh::{Mesh, MeshError};

use crate::textured::TexturedMesh;
use uvgraft_files::input::{Input, ReadError};

pub use self::write::{save, write};

/// Larger files are rejected by [`read`] before they are loaded.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Why the bytes of an OBJ file were rejected. Lines and corners count from 1; a line continued by
/// a backslash has the number of its first line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ObjError {
    /// The file is empty.
    #[error("the file is empty")]
    Empty,
    /// Text of 16-bit units.
    #[error("text must be UTF-8, ASCII or Latin-1, got UTF-16: save the file as UTF-8")]
    Utf16,
    /// A line starts with bytes that are not text.
    #[error("not an OBJ file: byte 0x{byte:02x} in a keyword on line {line}")]
    Binary {
        /// Which line.
        line: usize,
        /// The first control byte in it.
        byte: u8,
    },
    /// Text, but not OBJ.
    #[error("not an OBJ file: no line starts with `v`, `vt` or `f`")]
    NotObj,
    /// A point cloud, or only curves and surfaces.
    #[error("mesh must have faces, got {vertices} vertices and no `f` line")]
    NoFaces {
        /// Number of `v` lines.
        vertices: usize,
    },
    /// A word in place of a number is not one.
    #[error("line {line}: {what}: must be a number, got `{found}`")]
    Number {
        /// Which line.
        line: usize,
        /// `"vertex"` or `"texture coordinate"`.
        what: &'static str,
        /// What was found, shortened.
        found: String,
    },
    /// NaN, infinity, or a number beyond 32-bit floating point.
    #[error("line {line}: {what}: must be a finite 32-bit number, got `{found}`")]
    NotFinite {
        /// Which line.
        line: usize,
        /// `"vertex"` or `"texture coordinate"`.
        what: &'static str,
        /// What was found, shortened.
        found: String,
    },
    /// A vertex with fewer than three numbers, or a texture coordinate with fewer than two.
    #[error("line {line}: {what} must have {wanted} numbers, got {found}")]
    TooFewNumbers {
        /// Which line.
        line: usize,
        /// `"vertex"` or `"texture coordinate"`.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        wanted: usize,
    },
    /// A corner that is not written as `v/vt` or `v/vt/vn`.
    #[error("line {line}: corner {corner} must be `v/vt` or `v/vt/vn`, got `{found}`")]
    Corner {
        /// Which line.
        line: usize,
        /// Which corner of the face.
        corner: usize,
        /// What was found, shortened.
        found: String,
    },
    /// A corner without a texture coordinate.
    #[error("line {line}: corner {corner} must have a texture coordinate (`v/vt`)")]
    NoTextureCoordinate {
        /// Which line.
        line: usize,
        /// Which corner of the face.
        corner: usize,
    },
    /// Indices count from 1 upwards or from -1 downwards.
    #[error("line {line}: corner {corner}: {what} index must start at 1, got 0")]
    ZeroIndex {
        /// Which line.
        line: usize,
        /// Which corner of the face.
        corner: usize,
        /// `"vertex"` or `"texture coordinate"`.
        what: &'static str,
    },
    /// An index beyond the last element of the whole file.
    #[error("line {line}: corner {corner}: {what} index must be at most {count}, got {found}")]
    Index {
        /// Which line.
        line: usize,
        /// Which corner of the face.
        corner: usize,
        /// `"vertex"` or `"texture coordinate"`.
        what: &'static str,
        /// The index in the file.
        found: i64,
        /// How many there are.
        count: usize,
    },
    /// A relative index before the first element.
    #[error(
        "line {line}: corner {corner}: relative {what} index must be at least -{count}, got \
         {found}"
    )]
    RelativeIndex {
        /// Which line.
        line: usize,
        /// Which corner of the face.
        corner: usize,
        /// `"vertex"` or `"texture coordinate"`.
        what: &'static str,
        /// The index in the file.
        found: i64,
        /// How many there are so far.
        count: usize,
    },
    /// A point or a line written as a face.
    #[error("line {line}: face must have at least 3 corners, got {found}")]
    TooFewCorners {
        /// Which line.
        line: usize,
        /// How many corners it has.
        found: usize,
    },
    /// Each part stores its names, so long alternating names would exhaust memory.
    #[error(
        "line {line}: names of objects, groups and materials must take at most {max} bytes in \
         total"
    )]
    Names {
        /// Which line.
        line: usize,
        /// The limit in bytes, over all parts.
        max: usize,
    },
    /// The mesh as a whole was rejected.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// Reads a mesh from the bytes of an OBJ file.
///
/// - Vertices and texture coordinates keep their order and count, used or not. `v` is flipped, to
///   `1 - v` in 64 bits before it is rounded to 32.
/// - Polygons keep their order and corners; [`Mesh`] triangulates them as fans.
/// - [`Mesh::parts`] names consecutive polygons of one object, group and material, and covers all
///   polygons; it is empty if the file names none.
/// - Weights, colours, a third texture coordinate, normals and unknown keywords are skipped. Normal
///   indices must be integers; they are not resolved.
///
/// # Errors
/// [`ObjError`] at the first malformed line, and for polygons without texture coordinates. Indices
/// beyond what has been defined so far are checked at the end of the file, as a face may precede its
/// vertices.
pub fn parse(bytes: &[u8]) -> Result<Mesh, ObjError> {
    let (found, first_without_uv) = parsed(bytes)?;
    first_without_uv.map_or(Ok(found.mesh), Err)
}

/// Reads the polygons that have texture coordinates from the bytes of an OBJ file; see [`parse`].
/// Those of which no corner has any are left out.
///
/// # Errors
/// As [`parse`]; also if no polygon has texture coordinates.
pub fn parse_textured(bytes: &[u8]) -> Result<TexturedMesh, ObjError> {
    parsed(bytes).map(|(found, _)| found)
}

/// The mesh, and the error of the first polygon that is left out.
fn parsed(bytes: &[u8]) -> Result<(TexturedMesh, Option<ObjError>), ObjError> {
    if bytes.is_empty() {
        return Err(ObjError::Empty);
    }
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(ObjError::Utf16);
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut cursor = cursor::Cursor::new(text);
    let mut builder = build::Builder::default();
    loop {
        builder.statement(&mut cursor)?;
        if !cursor.next_line() {
            return builder.finish();
        }
    }
}

/// Reads a mesh from an OBJ file; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(input: impl Into<Input>) -> Result<Mesh, ReadError<ObjError>> {
    input.into().parse(MAX_FILE_BYTES, parse)
}

/// Reads the polygons that have texture coordinates from an OBJ file; see [`parse_textured`].
///
/// # Errors
/// As [`read`].
pub fn read_textured(input: impl Into<Input>) -> Result<TexturedMesh, ReadError<ObjError>> {
    input.into().parse(MAX_FILE_BYTES, parse_textured)
}

/// A piece of input for a message: printable, and no longer than a line.
pub(crate) fn shown(found: &[u8]) -> String {
    const LONGEST: usize = 32;
    let mut text = String::new();
    for &byte in &found[..found.len().min(LONGEST)] {
        match byte {
            b' '..=b'~' => text.push(char::from(byte)),
            _ => text.extend(byte.escape_ascii().map(char::from)),
        }
    }
    if found.len() > LONGEST {
        text.push('…');
    }
    text
}
