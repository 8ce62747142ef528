//! Vertex lists: selections of vertices of a mesh.
//!
//! Read from NPY arrays, of indices or of one bool for each vertex, and from plain text.

use crate::integers::{self, IntegersError, List};
use uvgraft_files::input::{Input, ReadError};

/// Larger files are rejected by [`read`] before they are loaded.
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Why the bytes of a vertex list were rejected. Entries count from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum VertexListError {
    /// No vertex is selected.
    #[error("must have at least one vertex")]
    Empty,
    /// It is not a list of integers.
    #[error(transparent)]
    Integers(#[from] IntegersError),
    /// An integer is not a vertex of the mesh.
    #[error("entry {entry}: must be a vertex of the mesh, from 0 to {last}, got {found}")]
    NoSuchVertex {
        /// Which entry of the list.
        entry: usize,
        /// Its value.
        found: i64,
        /// The mesh's last vertex.
        last: usize,
    },
    /// A bool array whose length differs from the number of vertices.
    #[error("a mask must have {wanted} entries, one for each vertex, got {found}")]
    MaskLength {
        /// Bools in the mask.
        found: usize,
        /// Vertices of the mesh.
        wanted: usize,
    },
    /// As many integers as there are vertices, each 0 or 1: read as indices they would select only
    /// two vertices.
    #[error(
        "a mask must be an array of bools, got {found} integers that are 0 or 1; convert it with \
         .astype(\"bool\")"
    )]
    IntegerMask {
        /// How many.
        found: usize,
    },
}

/// Reads a vertex list, sorted and without duplicates, for a mesh with the given number of
/// `vertices`.
///
/// The format is detected from the content:
/// - NPY, by its magic: integers of 8 to 64 bits, which are 0-based indices, or bools, one for each
///   vertex; in either case at most one axis is longer than 1.
/// - Otherwise text: indices separated by whitespace or commas; `#` starts a comment.
///
/// # Errors
/// [`VertexListError`]; among others for an index that is negative or not below `vertices`, for
/// floating-point values, even integral ones, and for an empty selection.
pub fn parse(bytes: &[u8], vertices: usize) -> Result<Vec<u32>, VertexListError> {
    match integers::parse_or_mask(bytes)? {
        List::Integers(ids) => vertices_of(&ids, vertices),
        List::Mask(mask) if mask.len() != vertices => {
            Err(VertexListError::MaskLength { found: mask.len(), wanted: vertices })
        }
        List::Mask(mask) => {
            let ids: Vec<u32> =
                (0..).zip(mask).filter(|&(_, is_in)| is_in).map(|(id, _)| id).collect();
            if ids.is_empty() { Err(VertexListError::Empty) } else { Ok(ids) }
        }
    }
}

/// Reads a vertex list from a file, regardless of its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(
    input: impl Into<Input>,
    vertices: usize,
) -> Result<Vec<u32>, ReadError<VertexListError>> {
    input.into().parse(MAX_FILE_BYTES, |bytes| parse(bytes, vertices))
}

/// Indices, sorted and without duplicates, if all are vertices of the mesh.
pub(crate) fn vertices_of(ids: &[i64], vertices: usize) -> Result<Vec<u32>, VertexListError> {
    /// Meshes with fewer vertices may well list each of them.
    const FEW: usize = 2;
    let last = vertices.saturating_sub(1);
    let vertex = |(index, &found): (usize, &i64)| {
        let id = u32::try_from(found).ok().filter(|&id| (id as usize) < vertices);
        id.ok_or(VertexListError::NoSuchVertex { entry: index + 1, found, last })
    };
    let mut chosen = ids.iter().enumerate().map(vertex).collect::<Result<Vec<u32>, _>>()?;
    if chosen.is_empty() {
        return Err(VertexListError::Empty);
    }
    if chosen.len() == vertices && vertices > FEW && chosen.iter().all(|&id| id < 2) {
        return Err(VertexListError::IntegerMask { found: vertices });
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numpy::write_header;

    fn npy(descr: &str, shape: &[usize], values: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_header(descr, shape, &mut bytes).unwrap();
        bytes.extend(values);
        bytes
    }

    fn error(bytes: &[u8], vertices: usize) -> String {
        parse(bytes, vertices).unwrap_err().to_string()
    }

    #[test]
    fn ids_come_sorted_and_once() {
        assert_eq!(parse(b"7, 3 # two\n3\n0", 8), Ok(vec![0, 3, 7]));
        assert_eq!(parse(&npy("<i2", &[3], &[5, 0, 1, 0, 5, 0]), 6), Ok(vec![1, 5]));
        assert_eq!(parse(&npy(">u4", &[1, 1], &[0, 0, 1, 2]), 300), Ok(vec![258]));
        assert_eq!(parse(b"1 0", 2), Ok(vec![0, 1]));
    }

    #[test]
    fn bools_are_a_mask() {
        let mask = npy("|b1", &[5], &[0, 1, 0, 0, 1]);
        assert_eq!(parse(&mask, 5), Ok(vec![1, 4]));
        assert_eq!(error(&mask, 6), "a mask must have 6 entries, one for each vertex, got 5");
        assert_eq!(parse(&npy("|b1", &[2], &[0, 0]), 2), Err(VertexListError::Empty));
        let integers = npy("|u1", &[5], &[0, 1, 0, 0, 1]);
        let found = error(&integers, 5);
        assert!(found.starts_with("a mask must be an array of bools, got 5 integers"), "{found}");
        assert_eq!(parse(&integers, 6), Ok(vec![0, 1]));
    }

    #[test]
    fn refuses_what_is_no_vertex() {
        let wanted = "must be a vertex of the mesh, from 0 to 9";
        assert_eq!(error(b"3 -1 4", 10), format!("entry 2: {wanted}, got -1"));
        assert_eq!(error(b"3\n10\n", 10), format!("entry 2: {wanted}, got 10"));
        let large = 1_i64 << 32;
        assert_eq!(
            error(&npy("<i8", &[1], &large.to_le_bytes()), 10),
            format!("entry 1: {wanted}, got 4294967296")
        );
        for empty in [&b""[..], b"# nothing\n", &npy("<i8", &[0], b"")] {
            assert_eq!(parse(empty, 10), Err(VertexListError::Empty));
        }
        assert!(error(b"1.5", 10).contains("line 1: must be an integer, got floating-point `1.5`"));
        let floats = error(&npy("<f8", &[1], &[0; 8]), 10);
        assert!(floats.contains("NPY array must have dtype integers (i1 to i8"), "{floats}");
        assert!(error(b"PK\x03\x04", 10).contains("got an .npz archive"));
    }

    #[test]
    fn files_are_named_in_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("face.txt");
        std::fs::write(&path, "4 2\n").unwrap();
        assert_eq!(read(&path, 5).unwrap(), [2, 4]);
        let error = read(&path, 4).unwrap_err().to_string();
        assert!(error.contains("face.txt: entry 1: must be"), "{error}");
    }
}
