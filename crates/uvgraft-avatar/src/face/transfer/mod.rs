//! Named expressions of one head, transferred to another.
//!
//! The skin deforms by [`DeformationTransfer`]. What is no skin moves otherwise: eyeballs turn, teeth
//! and tongue move rigidly, lashes and hair follow the skin beside them (`parts.rs`). Afterwards lids
//! meet and lips close where they do on the source (`contacts.rs`), and lids slide over the eyeballs
//! (`eyelids.rs`).

mod contacts;
mod eyelids;
mod heads;
mod parts;

use uvgraft::correspond::FindError;
use uvgraft::deform::{DeformError, DeformationTransfer};
use uvgraft::{Mesh, Pair, threads};

use self::contacts::Contacts;
pub use self::contacts::{Contact, ContactKind};
pub use self::heads::pair_heads;
use self::parts::Parts;
use super::FaceError;
use crate::rig::Morph;

/// Why expressions cannot be transferred.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// A morph has an offset for a vertex that the source does not have.
    #[error("morph `{morph}` moves vertex {vertex}, but the source mesh has only {vertices}")]
    Vertex {
        /// Name of the morph.
        morph: String,
        /// The vertex.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// The meshes or their pieces do not allow it.
    #[error("expressions cannot be transferred: {0}")]
    Deform(#[from] DeformError),
    /// The heads cannot be paired.
    #[error("expressions cannot be transferred: {0}")]
    Pair(#[from] FindError),
}

/// Expressions on another head.
#[derive(Debug, Clone)]
pub struct Transferred {
    /// In the source's order and with its names, in the target's space and unit.
    pub morphs: Vec<Morph>,
    /// Expressions that move nothing that the target has, such as a tongue; not among the morphs.
    pub unmoved: Vec<String>,
    /// Lids and lips that touch in an expression.
    pub contacts: Vec<Contact>,
    /// Why lids and lips could not be found, so that none was made to touch: the target's reason, or
    /// else the source's.
    pub unmeasured: Option<FaceError>,
}

/// Carries expressions from a pair's source to its target.
///
/// - `morphs`: of the source's vertices, in the source's unit; names are kept. Names of ARKit's
///   blend shapes tell which lids and lips must touch, and where eyes look if the source has no
///   eyeballs.
///
/// The target's unit and orientation may be others. Vertices far from what an expression moves get no
/// offset. Results don't depend on the number of threads.
///
/// # Errors
/// [`TransferError`] if a morph does not fit the source, or nothing that moves is paired.
pub fn transfer(pair: &Pair, morphs: &[Morph]) -> Result<Transferred, TransferError> {
    let (source, target) = (pair.source(), pair.target());
    let vertices = source.positions().len();
    let mut moves = vec![false; vertices];
    for morph in morphs {
        for &(vertex, offset) in &morph.offsets {
            let Some(moves) = moves.get_mut(vertex as usize) else {
                return Err(TransferError::Vertex { morph: morph.name.clone(), vertex, vertices });
            };
            *moves |= offset != [0.0; 3];
        }
    }
    let deform = DeformationTransfer::new(pair, &moves)?;
    let parts = Parts::new(source, target, &deform);
    let offsets = threads::map_indices(morphs.len(), |index| {
        let from = dense(&morphs[index], vertices);
        let mut to = deform.transfer(&from)?;
        parts.place(&morphs[index].name, &from, &mut to);
        Ok(to)
    });
    let mut offsets = offsets.into_iter().collect::<Result<Vec<_>, DeformError>>()?;
    let named: Vec<&str> = morphs.iter().map(|morph| morph.name.as_str()).collect();
    let (contacts, unmeasured) = match Contacts::new(source, target, &deform, &parts) {
        Ok(contacts) => {
            let from = |index: usize| dense(&morphs[index], vertices);
            (contacts.close(&named, from, &mut offsets), None)
        }
        Err(error) => (Vec::new(), Some(error)),
    };
    let least = (1e-5 * deform.size()) as f32;
    let (mut transferred, mut unmoved) = (Vec::new(), Vec::new());
    for (morph, offsets) in morphs.iter().zip(offsets) {
        let sparse = sparse(&morph.name, &offsets, least);
        if sparse.offsets.is_empty() {
            unmoved.push(sparse.name);
        } else {
            transferred.push(sparse);
        }
    }
    Ok(Transferred { morphs: transferred, unmoved, contacts, unmeasured })
}

/// Carries expressions between two meshes that are not paired yet: see [`pair_heads`] and [`transfer`].
///
/// # Errors
/// [`TransferError`] if the heads cannot be paired, or if [`transfer`] refuses them.
pub fn transfer_between(
    source: &Mesh,
    morphs: &[Morph],
    target: &Mesh,
) -> Result<Transferred, TransferError> {
    transfer(&pair_heads(source, target)?, morphs)
}

/// An offset for each vertex.
fn dense(morph: &Morph, vertices: usize) -> Vec<[f32; 3]> {
    let mut offsets = vec![[0.0; 3]; vertices];
    for &(vertex, offset) in &morph.offsets {
        offsets[vertex as usize] = offset;
    }
    offsets
}

/// The offsets longer than `least`.
fn sparse(name: &str, offsets: &[[f32; 3]], least: f32) -> Morph {
    let moves = |offset: &[f32; 3]| offset.iter().map(|d| d * d).sum::<f32>() > least * least;
    let offsets = (0..).zip(offsets.iter().copied()).filter(|(_, offset)| moves(offset)).collect();
    Morph { name: name.to_owned(), offsets }
}
