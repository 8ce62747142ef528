//! PLY, the polygon file format of scanners, MeshLab and Blender: polygons with texture
//! coordinates, in text or binary of either byte order.
//!
//! A texture transfer needs the positions of the element `vertex`, the corners of the element
//! `face`, and texture coordinates, which are either at the vertices or at the corners of the faces.
//! All other elements and properties are skipped.
//!
//! Source: Greg Turk, "The PLY Polygon File Format", 1994; for texture coordinates, which it does
//! not define, the names that Blender (`s`, `t`), pbrt (`u`, `v`) and MeshLab (`texture_u`,
//! `texture_v`, and the lists `texcoord` of faces with `texnumber`) write.

mod build;
mod header;
#[cfg(test)]
mod tests;
mod values;

use uvgraft::mesh::MeshError;

use crate::beginning;
use crate::textured::TexturedMesh;
use uvgraft_files::input::{Input, ReadError};

/// Larger files are rejected by [`read`] before they are loaded.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Why the bytes of a PLY file were rejected. Lines count from 1, rows of elements from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlyError {
    /// The file has another format.
    #[error("not a PLY file: must start with \"ply\", {}", beginning(start))]
    NotPly {
        /// The first bytes, at most 8.
        start: Vec<u8>,
    },
    /// A line of the header is malformed, or contradicts another one.
    #[error("line {line}: {problem}")]
    Header {
        /// Which line.
        line: usize,
        /// What it must be, and what it is.
        problem: String,
    },
    /// The header does not end, or is larger than any.
    #[error("header must end with `end_header` within {max} bytes")]
    Endless {
        /// The limit in bytes.
        max: usize,
    },
    /// An element or a property that a mesh needs is missing.
    #[error("must have {wanted}; the file has {found}")]
    Missing {
        /// What is needed.
        wanted: &'static str,
        /// The names in the file.
        found: String,
    },
    /// Neither vertices nor faces have texture coordinates.
    #[error(
        "no UV coordinates: vertices must have the properties `s` and `t`, `u` and `v`, or \
         `texture_u` and `texture_v`, or faces the list `texcoord`"
    )]
    NoTextureCoordinates,
    /// The file ends early: found before anything is allocated for a claimed count.
    #[error(
        "truncated: element `{element}` of {count} rows needs at least {needed} bytes, but only \
         {left} are left"
    )]
    Claim {
        /// Name of the element.
        element: String,
        /// Its count in the header.
        count: u64,
        /// Minimum number of bytes.
        needed: u64,
        /// Number of bytes left in the file.
        left: u64,
    },
    /// The file ends within a row.
    #[error("truncated in row {row} of element `{element}`")]
    Truncated {
        /// Name of the element.
        element: String,
        /// Which row.
        row: u64,
    },
    /// A value is malformed or out of range.
    #[error("row {row} of element `{element}`: {problem}")]
    Value {
        /// Name of the element.
        element: String,
        /// Which row.
        row: u64,
        /// What it must be, and what it is.
        problem: String,
    },
    /// Text follows the last row, so that the header does not describe the rows.
    #[error("line {line}: more values than the header declares")]
    Surplus {
        /// Which line.
        line: usize,
    },
    /// Each part stores its name, so faces whose textures alternate would exhaust memory.
    #[error("texture changes between consecutive faces must take at most {max} bytes of memory")]
    TextureChanges {
        /// The limit in bytes, over all parts.
        max: usize,
    },
    /// The mesh as a whole was rejected.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// Reads a mesh from the bytes of a PLY file.
///
/// - Vertices keep their order and count, used or not; polygons keep their order and corners.
/// - Texture coordinates of faces come before those of vertices, if a file has both; faces without
///   any, among others with, are left out. Those of
///   vertices keep their order; those of faces are stored once for each vertex and value, in order
///   of first use. `v` is flipped, to `1 - v` in 64 bits before it is rounded to 32.
/// - [`Mesh::parts`](uvgraft::Mesh::parts) has the texture of consecutive polygons as material if the file names textures
///   (`comment TextureFile`) or numbers them (`texnumber`).
///
/// # Errors
/// [`PlyError`] for anything truncated, malformed or without texture coordinates.
pub fn parse(bytes: &[u8]) -> Result<TexturedMesh, PlyError> {
    let (header, body) = header::parse(bytes)?;
    build::mesh(&header, body)
}

/// Reads a mesh from a PLY file; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(input: impl Into<Input>) -> Result<TexturedMesh, ReadError<PlyError>> {
    input.into().parse(MAX_FILE_BYTES, parse)
}

/// Whether a file that starts with these bytes is a PLY file.
pub fn is_ply(start: &[u8]) -> bool {
    matches!(start, [b'p', b'l', b'y', b'\r' | b'\n' | b' ' | b'\t', ..])
}
