//! Pair files (`*.uvpair`): a safetensors container with both meshes and the pieces that
//! correspond.
//!
//! - The header's `__metadata__` MUST hold the key `uvgraft` with a JSON object as its text:
//!   `version`, `checksum`, `generator`, `note`, and `source` and `target` with `name`,
//!   `fingerprint`, `parts`.
//! - For each side there MUST be the tensors `SIDE.positions` (f32, `[vertices, 3]`), `SIDE.uv`
//!   (f32, `[coordinates, 2]`, origin at the top left), `SIDE.corners` (u32, `[corners, 2]`: vertex
//!   and UV index, polygon after polygon) and `SIDE.sizes` (u32, `[polygons]`: corners of each).
//! - `pieces` (u32, `[pieces, 2]`: target face, source face, ascending by target face) and
//!   `pieces.corners` (u8, `[pieces, 3]`: the source face's corner for each of the target face's,
//!   or `3, 3, 3` for a part) MUST be present; faces count the triangles of the polygons' fans.
//! - If there are parts, `parts` (f64, `[parts, 18]`) MUST be present: for each, in the order of
//!   the pieces, the weights of the target face's corners at the part's three corners, then those
//!   of the source face's.
//! - If pieces lie in UDIM tiles other than the unit square, `tiles.pieces`, `tiles.pieces.corners`
//!   and, if there are parts, `tiles.parts` MUST be present: as the three above, for these pieces.
//! - Version 1 has `links` and `links.corners` instead: the same tensors, without parts.
//! - `checksum` MUST be the SHA-256 of the whole file with the checksum's 64 digits set to `0`.
//! - Other tensors and keys MAY be present; readers of this version ignore them.

use std::collections::HashMap;
use std::io::{self, Write as _};
use std::path::Path;
use std::sync::Arc;

use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use uvgraft::{Corner, Extent, Mesh, MeshError, MeshPart, Pair, PairError, Piece, Weights};

use crate::beginning;
use uvgraft_files::checksum::{hex, sha256};
use uvgraft_files::input::{Input, ReadError};
use uvgraft_files::output::write_atomically;

/// The newest version of the format, which is the one that is written.
pub const VERSION: u32 = 2;

/// Larger files are rejected: the largest accepted meshes fit several times.
pub const MAX_BYTES: u64 = 4 << 30;

const METADATA_KEY: &str = "uvgraft";
const CHECKSUM_DIGITS: usize = 64;

/// A pair and its provenance.
#[derive(Debug, Clone, PartialEq)]
pub struct PairFile {
    /// The meshes and their pieces.
    pub pair: Arc<Pair>,
    /// Name of the source mesh: usually its file name.
    pub source_name: String,
    /// Name of the target mesh.
    pub target_name: String,
    /// A note from the owners of the meshes to users of the file.
    pub note: String,
}

/// Why a pair file was rejected. Each message states what must be and what is.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PairFileError {
    /// Not a pair file.
    #[error("not a pair file: {}", beginning(found))]
    Magic {
        /// The first bytes.
        found: Vec<u8>,
    },
    /// A safetensors file of another program.
    #[error("not a pair file: must be a safetensors file with `{METADATA_KEY}` in its metadata")]
    Foreign,
    /// Written by a later version of this program.
    #[error("pair file must be of version {VERSION} or older, got {found}; update uvgraft")]
    Version {
        /// The version that the file states.
        found: u32,
    },
    /// Checked before anything is allocated, so that a bad header cannot request gigabytes.
    #[error("truncated pair file: must have {needed} bytes, got {actual}")]
    Truncated {
        /// Size according to the header.
        needed: u64,
        /// Size of the file.
        actual: u64,
    },
    /// The file changed after it was written.
    #[error("damaged pair file: SHA-256 must be {stated} as the file states, got {found}")]
    Checksum {
        /// Computed from the bytes.
        found: String,
        /// Stated in the file.
        stated: String,
    },
    /// The header is malformed.
    #[error("damaged pair file: {0}")]
    Header(String),
    /// A tensor is missing or has the wrong type or shape.
    #[error("damaged pair file: tensor `{name}` {problem}")]
    Tensor {
        /// Which one.
        name: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The tensors do not form a mesh.
    #[error("damaged pair file: {side}: {reason}")]
    Mesh {
        /// `"source"` or `"target"`.
        side: &'static str,
        /// Why.
        reason: MeshError,
    },
    /// The pieces do not fit the meshes.
    #[error("damaged pair file: {0}")]
    Pieces(#[from] PairError),
}

#[derive(Serialize, Deserialize)]
struct Header {
    version: u32,
    checksum: String,
    generator: String,
    note: String,
    source: Side,
    target: Side,
}

#[derive(Serialize, Deserialize)]
struct Side {
    name: String,
    fingerprint: String,
    parts: Vec<SavedPart>,
}

#[derive(Serialize, Deserialize)]
struct SavedPart {
    object: String,
    group: String,
    material: String,
    /// Missing where the format of the mesh does not say, and in files of earlier versions of uvgraft.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    image: Option<String>,
    first: u32,
    end: u32,
}

/// Only the version, so that a later format can change everything else.
#[derive(Deserialize)]
struct VersionOnly {
    version: u32,
}

/// A fingerprint of a UV layout: the first 16 bytes of the SHA-256 of its coordinates and corners,
/// in hexadecimal. Positions are not included.
pub fn layout_fingerprint(mesh: &Mesh) -> String {
    let mut hasher = Sha256::new();
    hasher.update((mesh.uv().len() as u64).to_le_bytes());
    for coordinate in mesh.uv().as_flattened() {
        hasher.update(coordinate.to_le_bytes());
    }
    for polygon in 0..mesh.polygon_count() {
        let corners = mesh.polygon_corners(polygon);
        hasher.update((corners.len() as u32).to_le_bytes());
        for corner in corners {
            hasher.update(corner.uv.to_le_bytes());
        }
    }
    hex(&hasher.finalize()[..16])
}

/// The bytes of a pair file; equal pairs give equal bytes.
///
/// # Errors
/// [`PairFileError::Header`] if names or the note are too long for a header.
pub fn encode(file: &PairFile) -> Result<Vec<u8>, PairFileError> {
    let side = |mesh: &Mesh, name: &str| Side {
        name: name.to_owned(),
        fingerprint: layout_fingerprint(mesh),
        parts: mesh.parts().iter().map(SavedPart::from).collect(),
    };
    let header = Header {
        version: VERSION,
        checksum: "0".repeat(CHECKSUM_DIGITS),
        generator: concat!("uvgraft ", env!("CARGO_PKG_VERSION")).to_owned(),
        note: file.note.clone(),
        source: side(file.pair.source(), &file.source_name),
        target: side(file.pair.target(), &file.target_name),
    };
    let header = serde_json::to_string(&header).map_err(|error| bad_header(&error))?;
    let mut tensors = Vec::new();
    for (side, mesh) in [("source", file.pair.source()), ("target", file.pair.target())] {
        let polygons: Vec<Vec<Corner>> =
            (0..mesh.polygon_count()).map(|polygon| mesh.polygon_corners(polygon)).collect();
        let corners = polygons.iter().flatten().flat_map(|corner| [corner.vertex, corner.uv]);
        let sizes = polygons.iter().map(|polygon| polygon.len() as u32);
        tensors.extend([
            Saved::f32(format!("{side}.positions"), 3, mesh.positions().as_flattened()),
            Saved::f32(format!("{side}.uv"), 2, mesh.uv().as_flattened()),
            Saved::u32(format!("{side}.corners"), Some(2), corners),
            Saved::u32(format!("{side}.sizes"), None, sizes),
        ]);
    }
    save_pieces(&mut tensors, file.pair.pieces(), PIECE_TENSORS);
    if file.pair.pieces_in_other_tiles().len() > 0 {
        save_pieces(&mut tensors, file.pair.pieces_in_other_tiles(), TILE_TENSORS);
    }
    let views = tensors
        .iter()
        .map(|saved| {
            let view = TensorView::new(saved.dtype, saved.shape.clone(), &saved.bytes)?;
            Ok((saved.name.as_str(), view))
        })
        .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()
        .map_err(|error| bad_header(&error))?;
    let metadata = HashMap::from([(METADATA_KEY.to_owned(), header)]);
    let mut bytes =
        safetensors::serialize(views, Some(metadata)).map_err(|error| bad_header(&error))?;
    let place = checksum_place(&bytes, &"0".repeat(CHECKSUM_DIGITS))
        .ok_or_else(|| PairFileError::Header("no place for the checksum".to_owned()))?;
    let checksum = sha256(&bytes);
    bytes[place..place + CHECKSUM_DIGITS].copy_from_slice(checksum.as_bytes());
    Ok(bytes)
}

/// Whether a file may be a pair file, by its first nine bytes: those of a safetensors file.
pub fn is_pair_file(start: &[u8]) -> bool {
    // The length of the header in 64 bits, little-endian, and its first brace. None has four gigabytes.
    matches!(start, [_, _, _, _, 0, 0, 0, 0, b'{', ..])
}

/// Parses the bytes of a pair file.
///
/// # Errors
/// [`PairFileError`], for any change to the bytes since writing.
pub fn decode(bytes: &[u8]) -> Result<PairFile, PairFileError> {
    check_length(bytes)?;
    let tensors = SafeTensors::deserialize(bytes).map_err(|error| bad_header(&error))?;
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|error| bad_header(&error))?;
    let header = metadata.metadata().as_ref().and_then(|metadata| metadata.get(METADATA_KEY));
    let header = header.ok_or(PairFileError::Foreign)?;
    let VersionOnly { version } =
        serde_json::from_str(header).map_err(|error| bad_header(&error))?;
    if version > VERSION {
        return Err(PairFileError::Version { found: version });
    }
    let header: Header = serde_json::from_str(header).map_err(|error| bad_header(&error))?;
    verify_checksum(bytes, &header.checksum)?;

    let source = read_mesh(&tensors, "source", &header.source)?;
    let target = read_mesh(&tensors, "target", &header.target)?;
    let names = if version == 1 { FIRST_TENSORS } else { PIECE_TENSORS };
    let pieces = read_pieces(&tensors, names)?;
    let has_tiles = version > 1 && tensors.tensor(TILE_TENSORS.faces).is_ok();
    let in_tiles = has_tiles.then(|| read_pieces(&tensors, TILE_TENSORS)).transpose()?;
    let pieces = pieces.chain(in_tiles.into_iter().flatten());
    Ok(PairFile {
        pair: Arc::new(Pair::from_pieces(source, target, pieces)?),
        source_name: header.source.name,
        target_name: header.target.name,
        note: header.note,
    })
}

/// Stands for the corners of a piece that covers only a part of its faces.
const PART: [u8; 3] = [3; 3];

/// Weights of a part: of three corners in each of two faces.
const PART_VALUES: usize = 18;

/// The names of the tensors of pieces.
#[derive(Clone, Copy)]
struct PieceTensors {
    faces: &'static str,
    corners: &'static str,
    /// `None` where there are no parts.
    parts: Option<&'static str>,
}

const PIECE_TENSORS: PieceTensors =
    PieceTensors { faces: "pieces", corners: "pieces.corners", parts: Some("parts") };
/// Of the pieces in other tiles than the unit square.
const TILE_TENSORS: PieceTensors = PieceTensors {
    faces: "tiles.pieces",
    corners: "tiles.pieces.corners",
    parts: Some("tiles.parts"),
};
/// Of version 1.
const FIRST_TENSORS: PieceTensors =
    PieceTensors { faces: "links", corners: "links.corners", parts: None };

/// Adds the tensors of pieces.
fn save_pieces(
    tensors: &mut Vec<Saved>,
    pieces: impl ExactSizeIterator<Item = Piece> + Clone,
    names: PieceTensors,
) {
    let count = pieces.len();
    let faces = pieces.clone().flat_map(|piece| [piece.target, piece.source]);
    tensors.push(Saved::u32(names.faces.to_owned(), Some(2), faces));
    let mut parts = Vec::new();
    let corners = pieces.flat_map(|piece| match piece.extent {
        Extent::Whole(corners) => corners,
        Extent::Part { target, source } => {
            parts.extend([target, source]);
            PART
        }
    });
    tensors.push(Saved {
        name: names.corners.to_owned(),
        dtype: Dtype::U8,
        shape: vec![count, 3],
        bytes: corners.collect(),
    });
    if let (Some(name), false) = (names.parts, parts.is_empty()) {
        tensors.push(Saved {
            name: name.to_owned(),
            dtype: Dtype::F64,
            shape: vec![parts.len() / 2, PART_VALUES],
            bytes: parts
                .as_flattened()
                .as_flattened()
                .iter()
                .flat_map(|weight| weight.to_le_bytes())
                .collect(),
        });
    }
}

/// Pieces in the tensors of these names.
fn read_pieces<'a>(
    tensors: &SafeTensors<'a>,
    names: PieceTensors,
) -> Result<impl Iterator<Item = Piece> + 'a, PairFileError> {
    let PieceTensors { faces: pieces_name, corners: corners_name, parts: parts_name } = names;
    let faces = rows::<2>(tensors, pieces_name, Dtype::U32)?;
    let corners = tensor(tensors, corners_name, Dtype::U8, Some(3))?;
    let (corners, _) = corners.as_chunks::<3>();
    let count = faces.len();
    if corners.len() != count {
        let found = corners.len();
        let problem = format!("must have {count} rows as `{pieces_name}`, got {found}");
        return Err(PairFileError::Tensor { name: corners_name.to_owned(), problem });
    }
    let is_part = move |corners: [u8; 3]| parts_name.is_some() && corners == PART;
    let wanted = corners.iter().filter(|&&corners| is_part(corners)).count();
    let parts: &[u8] = match parts_name {
        Some(name) if wanted > 0 => tensor(tensors, name, Dtype::F64, Some(PART_VALUES))?,
        _ => &[],
    };
    let (parts, _) = parts.as_chunks::<8>().0.as_chunks::<3>().0.as_chunks::<6>();
    if parts.len() != wanted {
        let problem =
            format!("must have {wanted} rows as `{corners_name}` states, got {}", parts.len());
        return Err(PairFileError::Tensor {
            name: parts_name.unwrap_or("parts").to_owned(),
            problem,
        });
    }
    let mut parts = parts.iter();
    Ok(faces.zip(corners).map(move |(faces, &corners)| {
        let [target, source] = faces.map(u32::from_le_bytes);
        let part = if is_part(corners) { parts.next() } else { None };
        match part {
            None => Piece::whole(target, source, corners),
            Some(part) => {
                let [a, b, c, d, e, f]: [Weights; 6] =
                    part.map(|weights| weights.map(f64::from_le_bytes));
                Piece::part((target, [a, b, c]), (source, [d, e, f]))
            }
        }
    }))
}

/// Reads a pair file.
///
/// # Errors
/// [`ReadError`] with the path and what is wrong.
pub fn read(input: impl Into<Input>) -> Result<PairFile, ReadError<PairFileError>> {
    input.into().parse(MAX_BYTES, decode)
}

/// Writes a pair file; after a crash, an existing file is unchanged.
///
/// # Errors
/// Those of encoding or writing.
pub fn write(file: &PairFile, path: impl AsRef<Path>) -> io::Result<()> {
    let bytes = encode(file).map_err(io::Error::other)?;
    write_atomically(path.as_ref(), |out| out.write_all(&bytes))
}

struct Saved {
    name: String,
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl Saved {
    fn f32(name: String, columns: usize, values: &[f32]) -> Self {
        Self {
            name,
            dtype: Dtype::F32,
            shape: vec![values.len() / columns, columns],
            bytes: values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }

    fn u32(name: String, columns: Option<usize>, values: impl Iterator<Item = u32>) -> Self {
        let bytes: Vec<u8> = values.flat_map(u32::to_le_bytes).collect();
        let count = bytes.len() / 4;
        let shape = columns.map_or(vec![count], |columns| vec![count / columns, columns]);
        Self { name, dtype: Dtype::U32, shape, bytes }
    }
}

impl From<&MeshPart> for SavedPart {
    fn from(part: &MeshPart) -> Self {
        Self {
            object: part.object.clone(),
            group: part.group.clone(),
            material: part.material.clone(),
            image: part.image.clone(),
            first: part.polygons.start,
            end: part.polygons.end,
        }
    }
}

/// Distinguishes a foreign file from a truncated one, which the container's reader does not.
fn check_length(bytes: &[u8]) -> Result<(), PairFileError> {
    let actual = bytes.len() as u64;
    if bytes.len() < 9 || bytes[8] != b'{' {
        let found = bytes[..bytes.len().min(9)].to_vec();
        return Err(PairFileError::Magic { found });
    }
    let header = bytes[..8].iter().rev().fold(0u64, |value, &byte| value << 8 | u64::from(byte));
    let start = header.saturating_add(8);
    if start > actual {
        return Err(PairFileError::Truncated { needed: start, actual });
    }
    #[derive(Deserialize)]
    struct Offsets {
        data_offsets: Option<(u64, u64)>,
    }
    let header: HashMap<String, Offsets> =
        serde_json::from_slice(&bytes[8..start as usize]).map_err(|error| bad_header(&error))?;
    let data = header.values().filter_map(|entry| entry.data_offsets).map(|(_, end)| end).max();
    let needed = start.saturating_add(data.unwrap_or(0));
    if needed > actual { Err(PairFileError::Truncated { needed, actual }) } else { Ok(()) }
}

fn verify_checksum(bytes: &[u8], stated: &str) -> Result<(), PairFileError> {
    let place = checksum_place(bytes, stated).ok_or_else(|| {
        PairFileError::Header(format!("checksum must be a SHA-256, got {stated:?}"))
    })?;
    let mut hasher = Sha256::new();
    hasher.update(&bytes[..place]);
    hasher.update([b'0'; CHECKSUM_DIGITS]);
    hasher.update(&bytes[place + CHECKSUM_DIGITS..]);
    let found = hex(&hasher.finalize());
    if found == stated {
        Ok(())
    } else {
        Err(PairFileError::Checksum { found, stated: stated.to_owned() })
    }
}

/// The position of the checksum's digits: after the first mention of the key. The header's fields
/// are in a fixed order, so no user-defined name can precede it.
fn checksum_place(bytes: &[u8], digits: &str) -> Option<usize> {
    if digits.len() != CHECKSUM_DIGITS {
        return None;
    }
    // Inside the container's JSON text, the object's own quotes are escaped.
    let wanted = format!(r#"\"checksum\":\"{digits}\""#);
    bytes
        .windows(wanted.len())
        .position(|window| window == wanted.as_bytes())
        .map(|place| place + wanted.len() - CHECKSUM_DIGITS - r#"\""#.len())
}

fn read_mesh(
    tensors: &SafeTensors<'_>,
    side: &'static str,
    header: &Side,
) -> Result<Mesh, PairFileError> {
    let positions = rows::<3>(tensors, &format!("{side}.positions"), Dtype::F32)?;
    let uv = rows::<2>(tensors, &format!("{side}.uv"), Dtype::F32)?;
    let corners = rows::<2>(tensors, &format!("{side}.corners"), Dtype::U32)?;
    let corners: Vec<Corner> = corners
        .map(|corner| corner.map(u32::from_le_bytes))
        .map(|[vertex, uv]| Corner { vertex, uv })
        .collect();
    let sizes = tensor(tensors, &format!("{side}.sizes"), Dtype::U32, None)?;
    let (sizes, _) = sizes.as_chunks::<4>();
    let sizes: Vec<u32> = sizes.iter().map(|&size| u32::from_le_bytes(size)).collect();
    if sizes.iter().map(|&size| u64::from(size)).sum::<u64>() != corners.len() as u64 {
        let problem = format!("must add up to {} corners", corners.len());
        return Err(PairFileError::Tensor { name: format!("{side}.sizes"), problem });
    }
    let parts = header.parts.iter().map(|part| MeshPart {
        object: part.object.clone(),
        group: part.group.clone(),
        material: part.material.clone(),
        image: part.image.clone(),
        polygons: part.first..part.end,
    });
    let mesh = Mesh::from_polygons(
        positions.map(|row| row.map(f32::from_le_bytes)).collect(),
        uv.map(|row| row.map(f32::from_le_bytes)).collect(),
        &corners,
        &sizes,
    );
    mesh.map(|mesh| mesh.with_parts(parts.collect()))
        .map_err(|reason| PairFileError::Mesh { side, reason })
}

/// The bytes of a tensor, after checking its type and shape: `[n, columns]`, or `[n]`.
fn tensor<'a>(
    tensors: &SafeTensors<'a>,
    name: &str,
    dtype: Dtype,
    columns: Option<usize>,
) -> Result<&'a [u8], PairFileError> {
    let bad = |problem: String| PairFileError::Tensor { name: name.to_owned(), problem };
    let view = tensors.tensor(name).map_err(|_| bad("is missing".to_owned()))?;
    let fits = match (view.shape(), columns) {
        ([_], None) => true,
        ([_, found], Some(wanted)) => *found == wanted,
        _ => false,
    };
    if view.dtype() != dtype || !fits {
        let wanted = columns.map_or("[n]".to_owned(), |columns| format!("[n, {columns}]"));
        let (found, shape) = (view.dtype(), view.shape());
        return Err(bad(format!("must be {dtype:?} {wanted}, got {found:?} {shape:?}")));
    }
    Ok(view.data())
}

/// The rows of a tensor of `N` columns of four bytes each.
fn rows<'a, const N: usize>(
    tensors: &SafeTensors<'a>,
    name: &str,
    dtype: Dtype,
) -> Result<impl ExactSizeIterator<Item = [[u8; 4]; N]> + 'a, PairFileError> {
    let bytes = tensor(tensors, name, dtype, Some(N))?;
    Ok(bytes.as_chunks::<4>().0.as_chunks::<N>().0.iter().copied())
}

fn bad_header(error: &dyn std::error::Error) -> PairFileError {
    PairFileError::Header(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> PairFile {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.25, 0.75]];
        let corners = [[0, 0], [1, 1], [2, 2], [3, 3], [0, 4], [1, 1], [2, 2]]
            .map(|[vertex, uv]| Corner { vertex, uv });
        let part = MeshPart {
            object: "Körper".to_owned(),
            group: "\"checksum\":\"".to_owned(),
            image: Some("face.png".to_owned()),
            polygons: 0..2,
            ..MeshPart::default()
        };
        let mesh =
            Mesh::from_polygons(positions, uv, &corners, &[4, 3]).unwrap().with_parts(vec![part]);
        PairFile {
            pair: Arc::new(Pair::by_vertex_map(mesh.clone(), mesh, &[0, 1, 2, 3]).unwrap()),
            source_name: "head.obj".to_owned(),
            target_name: "body.obj".to_owned(),
            note: "research only".to_owned(),
        }
    }

    #[test]
    fn what_is_written_is_read_and_always_the_same() {
        let bytes = encode(&file()).unwrap();
        assert_eq!(decode(&bytes).unwrap(), file());
        assert_eq!(bytes, encode(&file()).unwrap());
    }

    /// The file, with its second face in two parts.
    fn with_parts() -> PairFile {
        let file = file();
        let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let half = [0.5, 0.5, 0.0];
        let pieces = [
            Piece::whole(0, 0, [0, 1, 2]),
            Piece::part((1, [a, half, c]), (1, [a, half, c])),
            Piece::part((1, [half, b, c]), (2, [b, c, [0.25, 0.25, 0.5]])),
            Piece::whole(2, 2, [1, 2, 0]),
        ];
        let (source, target) = (file.pair.source().clone(), file.pair.target().clone());
        let pair = Pair::from_pieces(source, target, pieces).unwrap();
        PairFile { pair: Arc::new(pair), ..file }
    }

    #[test]
    fn parts_are_kept() {
        let bytes = encode(&with_parts()).unwrap();
        assert_eq!(decode(&bytes).unwrap(), with_parts());
        for place in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[place] ^= 0x10;
            assert!(decode(&flipped).is_err(), "byte {place} flipped");
        }
    }

    #[test]
    fn pieces_in_other_tiles_are_kept() {
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [3.0, 0.0], [2.0, 0.0], [3.0, 1.0]];
        let positions = vec![[0.0; 3]; 6];
        let faces = [[0, 1, 2], [3, 4, 5]];
        let mesh = Mesh::from_triangles(positions, uv, &faces, &faces).unwrap();
        let half = [0.5, 0.5, 0.0];
        let whole = Piece::whole(0, 0, [0, 1, 2]);
        let across = Piece::part(
            (1, [[1.0, 0.0, 0.0], half, [0.0, 0.0, 1.0]]),
            (0, [half, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        );
        let pair = Pair::from_pieces(mesh.clone(), mesh, [across, whole]).unwrap();
        assert_eq!(pair.pieces().collect::<Vec<_>>(), [whole]);
        assert_eq!(pair.pieces_in_other_tiles().collect::<Vec<_>>(), [across]);
        let file = PairFile { pair: Arc::new(pair), ..file() };
        let bytes = encode(&file).unwrap();
        assert_eq!(decode(&bytes).unwrap(), file);
        let names = ["tiles.pieces", "tiles.parts"];
        let has = |bytes: &[u8], name: &str| {
            bytes.windows(name.len()).any(|found| found == name.as_bytes())
        };
        assert!(names.iter().all(|name| has(&bytes, name)));
        // Pairs of unit squares are written as before.
        let plain = encode(&with_parts()).unwrap();
        assert!(names.iter().all(|name| !has(&plain, name)));
    }

    #[test]
    fn reads_version_1() {
        let bytes = include_bytes!("../tests/pair_samples/version1.uvpair");
        let file = decode(bytes).unwrap();
        assert_eq!([&*file.source_name, &*file.target_name], ["head.obj", "body.obj"]);
        let wanted = [Piece::whole(0, 1, [0, 1, 2]), Piece::whole(1, 0, [2, 0, 1])];
        assert_eq!(file.pair.pieces().collect::<Vec<_>>(), wanted);
        // When written again, the same pair is in the newest version.
        assert_eq!(decode(&encode(&file).unwrap()).unwrap(), file);
    }

    #[test]
    fn every_flipped_byte_and_every_cut_is_found() {
        let bytes = encode(&file()).unwrap();
        for place in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[place] ^= 0x10;
            assert!(decode(&flipped).is_err(), "byte {place} flipped");
            assert!(decode(&bytes[..place]).is_err(), "cut at {place}");
        }
        let cut = decode(&bytes[..bytes.len() - 1]).unwrap_err();
        assert!(matches!(cut, PairFileError::Truncated { .. }), "{cut}");
        let more = [&bytes[..], b"x"].concat();
        assert!(decode(&more).is_err());
    }

    #[test]
    fn tells_foreign_and_newer_files() {
        let error = |bytes: &[u8]| decode(bytes).unwrap_err().to_string();
        assert!(
            error(b"\x89PNG\r\n\x1a\n....").contains(r#"not a pair file: starts with "\x89PNG"#)
        );
        assert!(error(b"").contains("not a pair file"));
        let huge = [&u64::MAX.to_le_bytes()[..], b"{}"].concat();
        assert!(error(&huge).contains("truncated"));
        let foreign = safetensors::serialize(Vec::<(&str, TensorView<'_>)>::new(), None).unwrap();
        assert!(error(&foreign).contains("with `uvgraft` in its metadata"));
        let bytes = encode(&file()).unwrap();
        let old: &[u8] = br#"\"version\":2"#;
        let place = bytes.windows(old.len()).position(|window| window == old).unwrap();
        let mut newer = bytes;
        newer[place + old.len() - 1] = b'7';
        assert_eq!(error(&newer), "pair file must be of version 2 or older, got 7; update uvgraft");
    }

    #[test]
    fn fingerprints_follow_the_layout_alone() {
        let pair = file().pair;
        let mesh = pair.source();
        let corners: Vec<Corner> =
            (0..mesh.polygon_count()).flat_map(|polygon| mesh.polygon_corners(polygon)).collect();
        let moved = |positions: Vec<[f32; 3]>, uv: Vec<[f32; 2]>| {
            layout_fingerprint(&Mesh::from_polygons(positions, uv, &corners, &[4, 3]).unwrap())
        };
        let own = layout_fingerprint(mesh);
        assert_eq!(own.len(), 32);
        assert_eq!(own, moved(vec![[9.0; 3]; 4], mesh.uv().to_vec()));
        let mut uv = mesh.uv().to_vec();
        uv[4][0] += 0.01;
        assert_ne!(own, moved(mesh.positions().to_vec(), uv));
    }
}
