//! Publicly known meshes and layouts, and recognising them.
//!
//! A mesh is recognised by its [`Fingerprint`], where the table has one, or else by its counts, and
//! [`Recognition`] says which. The table holds names, counts, fingerprints, sources and licences, and
//! nothing of the meshes themselves.

mod pairing;
mod recognise;
mod table;

pub use self::pairing::{PairingWarning, pairing_warnings};
pub use self::recognise::{Certainty, LayoutMatch, MeshMatch, Recognition, recognise};
pub use self::table::MESHES;

use crate::connectivity::Fingerprint;

/// A mesh that is publicly known by a name.
#[derive(Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct KnownMesh {
    /// What it is called.
    pub name: &'static str,
    /// What it shows.
    pub what: &'static str,
    /// Its editions, the usual one first. At least one.
    pub editions: &'static [Edition],
    /// Its published layouts that can be recognised, the usual one first.
    pub layouts: &'static [KnownLayout],
    /// Address of the publisher.
    pub source: &'static str,
    /// The licence of the mesh, in a few words. Not legal advice: the publisher's text decides.
    pub licence: &'static str,
    /// Where the counts come from: "as published" where nobody has confirmed them on the files.
    pub counts_from: &'static str,
}

/// One of the forms in which a mesh is published.
#[derive(Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Edition {
    /// What distinguishes it; empty for the usual one.
    pub name: &'static str,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles after triangulation; `None` if unknown.
    pub triangles: Option<usize>,
    /// Number of polygons if some have more than three corners, where known.
    pub polygons: Option<usize>,
    /// The fingerprint of its surface, with the polygons as published; `None` if unknown.
    pub fingerprint: Option<Fingerprint>,
}

/// A published layout of a known mesh.
#[derive(Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct KnownLayout {
    /// What it is called. Layouts of one name take the same textures, also on different meshes.
    pub name: &'static str,
    /// Number of UV coordinates.
    pub uv_coordinates: usize,
    /// Number of triangles of the edition that it is published on; `None` if unknown.
    pub triangles: Option<usize>,
    /// The fingerprint of its UV faces; `None` if unknown.
    pub fingerprint: Option<Fingerprint>,
    /// What one should know before using it; may be empty.
    pub note: &'static str,
}

impl KnownMesh {
    /// The name of the mesh in one of its editions, such as "FLAME, mouth closed".
    pub fn title(&self, edition: &Edition) -> String {
        match edition.name {
            "" => self.name.to_owned(),
            name => format!("{}, {name}", self.name),
        }
    }
}
