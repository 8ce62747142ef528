//! Vertex maps for meshes whose vertices a tool has split, or to which it has added some.
//!
//! Formats with one UV coordinate for each vertex, and programs that hold meshes so, split vertices at
//! UV seams: into copies after the others, or in an order of their own. Other tools append eyeballs and
//! teeth. A map counts the vertices before that. Which numbering it means is decided by the faces that
//! it links: a wrong one links next to none.

use std::{fmt, iter};

use super::places::{first_at_place, places};
use super::topology::{self, TopologyReport};
use super::vertex_map::{self, LinkError};
use crate::mesh::Mesh;
use crate::pair::Pair;
use crate::piece::Piece;

/// Smallest share of the faces which a map covers that it must link in another numbering than that
/// of the file. On FLAME and SMPL-X, the right one links 100 %, and one of another order 1.3 %; on a
/// regular grid, one that is off by a vertex links 75 %.
const LINKED_AT_LEAST: f64 = 0.9;
/// A map that links less than this share is of another order, see above.
const DISORDERED: f64 = 0.5;

/// How the vertices of a mesh are numbered in a vertex map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbering {
    /// As in the file.
    Stored,
    /// By the first vertices; later ones are copies of them, or not in the map: at most as many as there
    /// are in it, since tools append less than they keep.
    First {
        /// Number of vertices in the map.
        count: usize,
        /// Number of copies after them.
        copies: usize,
        /// Number of all others after them.
        others: usize,
    },
    /// By places, in the order of their first vertices.
    Places {
        /// Number of places.
        count: usize,
    },
}

/// How a vertex map linked two meshes.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum MapUse {
    /// Entry by entry, with this numbering of the source's vertices and of the target's.
    Numbered([Numbering; 2]),
    /// Not at all: no numbering is the map's, and the meshes were linked by their connectivity.
    Connectivity(TopologyReport),
}

/// Meshes linked by a vertex map.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct MapLinks {
    /// The pair.
    pub pair: Pair,
    /// How the map was used.
    pub used: MapUse,
}

impl MapUse {
    /// What was assumed about the map, for a message; `None` if it was used as it is.
    pub fn assumed(&self) -> Option<String> {
        match self {
            Self::Numbered([source, target]) => {
                let said: Vec<String> = [("source", source), ("target", target)]
                    .into_iter()
                    .filter(|(_, numbering)| **numbering != Numbering::Stored)
                    .map(|(mesh, numbering)| format!("{numbering} of the {mesh} mesh"))
                    .collect();
                (!said.is_empty()).then(|| format!("taken for a map of {}", said.join(" and ")))
            }
            Self::Connectivity(_) => Some(
                "not used, since it counts vertices before a tool split and reordered them; linked by \
                 connectivity instead"
                    .to_owned(),
            ),
        }
    }
}

impl fmt::Display for Numbering {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Stored => f.write_str("the vertices"),
            Self::First { count, copies, others } => {
                write!(f, "the first {count} vertices (")?;
                if copies > 0 {
                    write!(f, "{copies} after them are copies at the same places")?;
                }
                let and = if copies > 0 { ", " } else { "" };
                if others > 0 {
                    write!(f, "{and}{others} after them are left out")?;
                }
                f.write_str(")")
            }
            Self::Places { count } => write!(f, "the {count} different places of vertices"),
        }
    }
}

/// Links two meshes by a vertex map, which may count the vertices before a tool split them or added
/// some; see [`Pair::by_vertex_map`] for the map.
///
/// # Errors
/// Those of [`Pair::by_vertex_map`], if no numbering of the vertices fits and connectivity does not
/// link the meshes either.
pub fn link_by_vertex_map(
    source: &Mesh,
    target: &Mesh,
    vertex_map: &[i64],
) -> Result<MapLinks, LinkError> {
    let source_numbers = source_numberings(source, vertex_map.len());
    let vertices = target.positions().len();
    let is_stored = vertex_map.len() == source.positions().len();
    let entries = vertex_map::check_entries(vertex_map, vertices);
    if is_stored {
        entries?;
    } else if source_numbers.is_empty() || entries.is_err() {
        return Err(LinkError::length(vertex_map, source, target));
    }
    let mut best: Option<Attempt> = None;
    // Most maps need none of the others.
    let others = iter::once_with(|| other_target_numberings(target, vertex_map)).flatten();
    let mut target_numbers = 0;
    for target_number in iter::once(stored(vertices)).chain(others) {
        target_numbers += 1;
        for source_number in &source_numbers {
            let attempt =
                Attempt::new([source, target], [source_number, &target_number], vertex_map);
            let is_better =
                attempt.pieces.len() > best.as_ref().map_or(0, |best| best.pieces.len());
            let is_whole = attempt.share() >= 1.0;
            if is_better && (attempt.is_as_stored() || attempt.share() >= LINKED_AT_LEAST) {
                best = Some(attempt);
            }
            if is_whole {
                return finish(best, source, target, vertex_map);
            }
        }
    }
    // One that has the target's number of entries may also be one of swapped meshes.
    let is_split = target_numbers > 1 || !is_stored && vertex_map.len() != vertices;
    if is_split && best.as_ref().is_none_or(|best| best.share() < DISORDERED) {
        let (mut source, mut target) = (source.clone(), target.clone());
        if let Ok((pieces, report)) = topology::pieces(&mut source, &mut target) {
            let pair = Pair::of_found(source, target, pieces).ok_or(LinkError::Outside)?;
            return Ok(MapLinks { pair, used: MapUse::Connectivity(report) });
        }
    }
    finish(best, source, target, vertex_map)
}

fn finish(
    best: Option<Attempt>,
    source: &Mesh,
    target: &Mesh,
    vertex_map: &[i64],
) -> Result<MapLinks, LinkError> {
    let Some(best) = best else {
        return Err(if vertex_map.len() == source.positions().len() {
            LinkError::Nothing { source_faces: source.faces().len() }
        } else {
            LinkError::length(vertex_map, source, target)
        });
    };
    let [source, target] = best.meshes;
    let pair = Pair::of_found(source, target, best.pieces).ok_or(LinkError::Outside)?;
    Ok(MapLinks { pair, used: MapUse::Numbered(best.numbered) })
}

/// A numbering, and each vertex's number in it; `u32::MAX` for none.
type Numbered = (Numbering, Vec<u32>);

/// The links of one numbering of each mesh.
struct Attempt {
    numbered: [Numbering; 2],
    meshes: [Mesh; 2],
    pieces: Vec<Piece>,
    /// Number of source faces whose vertices all have a counterpart.
    covered: usize,
}

impl Attempt {
    fn new(meshes: [&Mesh; 2], numbers: [&Numbered; 2], vertex_map: &[i64]) -> Self {
        let [mut source, mut target] = meshes.map(Mesh::clone);
        let [(source_numbering, of_source), (target_numbering, of_target)] = numbers;
        let common = |vertex: u32| {
            let entry = vertex_map.get(of_source[vertex as usize] as usize);
            entry.and_then(|&entry| u32::try_from(entry).ok()).unwrap_or(u32::MAX)
        };
        let pieces =
            vertex_map::link_faces(&mut source, &mut target, common, |v| of_target[v as usize]);
        let is_covered = |face: &&[u32; 3]| face.iter().all(|&vertex| common(vertex) != u32::MAX);
        let covered = source.faces().iter().filter(is_covered).count();
        let numbered = [*source_numbering, *target_numbering];
        Self { numbered, meshes: [source, target], pieces, covered }
    }

    fn is_as_stored(&self) -> bool {
        self.numbered == [Numbering::Stored; 2]
    }

    /// Links of each face that the map covers.
    fn share(&self) -> f64 {
        self.pieces.len() as f64 / self.covered.max(1) as f64
    }
}

/// The numberings in which the source may have this many vertices.
fn source_numberings(mesh: &Mesh, count: usize) -> Vec<Numbered> {
    let vertices = mesh.positions().len();
    if count == vertices {
        return vec![stored(vertices)];
    }
    if count > vertices || count == 0 {
        return Vec::new();
    }
    let first = first_at_place(mesh);
    let mut numbers: Vec<u32> = first.clone();
    let (mut copies, mut others) = (0, 0);
    for (vertex, number) in numbers.iter_mut().enumerate() {
        if vertex < count {
            *number = vertex as u32;
        } else if (*number as usize) < count {
            copies += 1;
        } else {
            *number = u32::MAX;
            others += 1;
        }
    }
    let mut found = Vec::new();
    if others <= count {
        found.push((Numbering::First { count, copies, others }, numbers));
    }
    let (places, numbers) = places(&first);
    if places == count {
        found.push((Numbering::Places { count }, numbers));
    }
    found
}

/// The numberings other than that of the file that the map's entries may be of.
fn other_target_numberings(mesh: &Mesh, vertex_map: &[i64]) -> Vec<Numbered> {
    let vertices = mesh.positions().len();
    let first = first_at_place(mesh);
    let copies =
        first.iter().enumerate().filter(|&(vertex, &first)| vertex as u32 != first).count();
    let mut found = Vec::new();
    if copies > 0 {
        let count = vertices - copies;
        let (_, numbers) = places(&first);
        found.push((Numbering::First { count, copies, others: 0 }, first));
        if vertex_map.iter().all(|&entry| entry < count as i64) {
            found.push((Numbering::Places { count }, numbers));
        }
    }
    found
}

fn stored(vertices: usize) -> Numbered {
    (Numbering::Stored, (0..vertices as u32).collect())
}
