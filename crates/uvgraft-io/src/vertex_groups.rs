//! Vertex groups: named parts of a mesh, such as `face` or `left_ear`, as lists of vertices.
//!
//! Supported are the formats published with body models: FLAME's masks are a pickle of a dict with
//! an array for each name, SMPL-X's segmentation is a JSON object with a list for each name.
//!
//! Pickles are parsed, never run; see [`crate::pickle`].

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserializer as _;
use serde::de::{self, MapAccess, Visitor};
use uvgraft::listing::listed;

use crate::numpy::NumberKind;
use crate::pickle::{self, PickleError, Value};
use crate::vertex_list::{VertexListError, vertices_of};
use uvgraft_files::input::{Input, ReadError};

/// Larger files are rejected by [`read`] before they are loaded; published ones have a megabyte at
/// most.
pub const MAX_FILE_BYTES: u64 = 64 << 20;

/// Maximum number of groups in a file; body models have some dozens.
pub const MAX_GROUPS: usize = 4096;

/// Maximum total number of indices. A pickle may contain one list under many names, so the size of
/// the file does not limit it.
pub const MAX_IDS: usize = 1 << 24;

/// Maximum length of a name in bytes.
const LONGEST_NAME: usize = 256;

/// Why vertex groups were rejected. Entries count from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum VertexGroupsError {
    /// The file has another format.
    #[error("must be a pickle or a JSON object of vertex indices by name, got {found}")]
    Foreign {
        /// What it appears to be.
        found: &'static str,
    },
    /// The pickle is damaged, or not plain data.
    #[error(transparent)]
    Pickle(#[from] PickleError),
    /// The JSON is damaged, or has another structure.
    #[error("invalid JSON: {problem}")]
    Json {
        /// What is wrong, and where.
        problem: String,
    },
    /// The pickle does not hold a dict.
    #[error("the pickle must hold a dict of vertex indices by name, got {found}")]
    NotADict {
        /// What it holds.
        found: &'static str,
    },
    /// A key is not a valid name.
    #[error("group {group}: name must be a string of at most {LONGEST_NAME} bytes, got {found}")]
    Name {
        /// Which group, from 1.
        group: usize,
        /// What it is.
        found: &'static str,
    },
    /// A value is not a list of integers.
    #[error("group `{name}`: must be a list of integers, got {found}")]
    Ids {
        /// Which group.
        name: String,
        /// What it is.
        found: String,
    },
    /// More than any mesh has.
    #[error("must have at most {most} {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The limit.
        most: usize,
    },
    /// The file has no groups.
    #[error("must have at least one vertex group")]
    Empty,
    /// No group has the name.
    #[error("no group `{name}`; the file has {}", known(names))]
    Unknown {
        /// The requested name.
        name: String,
        /// The names in the file, sorted.
        names: Vec<String>,
    },
    /// A group does not fit the mesh.
    #[error("group `{name}`: {reason}")]
    Vertices {
        /// Which group.
        name: String,
        /// Why.
        reason: VertexListError,
    },
}

/// Named lists of vertices.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct VertexGroups {
    groups: BTreeMap<String, Vec<i64>>,
    ids: usize,
}

impl VertexGroups {
    /// The names, sorted.
    pub fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.groups.keys().map(String::as_str)
    }

    /// The vertices of a group, for a mesh with the given number: sorted indices without
    /// duplicates, at least one.
    ///
    /// # Errors
    /// [`VertexGroupsError::Unknown`] with the known names, and [`VertexGroupsError::Vertices`] if
    /// the group is empty or an index is not a vertex of the mesh.
    pub fn vertices(&self, name: &str, vertices: usize) -> Result<Vec<u32>, VertexGroupsError> {
        let name = || name.to_owned();
        let ids = self.groups.get(&name()).ok_or_else(|| VertexGroupsError::Unknown {
            name: name(),
            names: self.names().map(str::to_owned).collect(),
        })?;
        vertices_of(ids, vertices)
            .map_err(|reason| VertexGroupsError::Vertices { name: name(), reason })
    }

    /// Adds a group with a number of indices; of several with one name the last is kept, as in
    /// Python.
    fn add(
        &mut self,
        name: &str,
        count: usize,
        ids: impl FnOnce() -> Result<Vec<i64>, String>,
    ) -> Result<(), VertexGroupsError> {
        self.ids = self.ids.saturating_add(count);
        if self.ids > MAX_IDS {
            return Err(VertexGroupsError::TooMany { what: "vertex indices", most: MAX_IDS });
        }
        let name = name.to_owned();
        let ids = ids().map_err(|found| VertexGroupsError::Ids { name: name.clone(), found })?;
        self.groups.insert(name, ids);
        Ok(())
    }
}

/// Reads vertex groups. The format is detected from the content:
/// - JSON, if it starts with a brace: an object of lists of integers, `{"face": [0, 7]}`.
/// - Otherwise a pickle of any protocol: a dict of NumPy arrays of integers, of which at most one
///   axis is longer than 1, or of lists of integers.
///
/// Whether the vertices exist is checked by [`VertexGroups::vertices`].
///
/// # Errors
/// [`VertexGroupsError`]; a pickle that is not plain data is rejected, with the name that it
/// imports.
pub fn parse(bytes: &[u8]) -> Result<VertexGroups, VertexGroupsError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let groups = match text {
        // No pickle starts with these.
        [b'{' | b'[', ..] => from_json(text)?,
        _ if bytes.starts_with(crate::numpy::MAGIC) => {
            return Err(VertexGroupsError::Foreign { found: "an NPY array" });
        }
        _ if bytes.starts_with(b"PK\x03\x04") => {
            return Err(VertexGroupsError::Foreign { found: "an archive such as .npz" });
        }
        [] => return Err(VertexGroupsError::Foreign { found: "an empty file" }),
        _ => from_pickle(bytes)?,
    };
    if groups.groups.is_empty() { Err(VertexGroupsError::Empty) } else { Ok(groups) }
}

/// Reads vertex groups from a file, regardless of its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(input: impl Into<Input>) -> Result<VertexGroups, ReadError<VertexGroupsError>> {
    input.into().parse(MAX_FILE_BYTES, parse)
}

fn from_pickle(bytes: &[u8]) -> Result<VertexGroups, VertexGroupsError> {
    let pickle = pickle::parse(bytes)?;
    let root = pickle.root();
    let entries = root.entries().ok_or(VertexGroupsError::NotADict { found: root.kind() })?;
    if entries.len() > MAX_GROUPS {
        return Err(VertexGroupsError::TooMany { what: "groups", most: MAX_GROUPS });
    }
    let mut groups = VertexGroups::default();
    for (index, (name, ids)) in entries.enumerate() {
        let group = index + 1;
        let Some(text) = name.as_str() else {
            return Err(VertexGroupsError::Name { group, found: name.kind() });
        };
        if text.len() > LONGEST_NAME {
            return Err(VertexGroupsError::Name { group, found: "a longer one" });
        }
        let count = match (ids.as_array(), ids.items()) {
            (Some(array), _) => array.count(),
            (None, Some(items)) => items.len(),
            (None, None) => 0,
        };
        groups.add(text, count, || ids_of(ids))?;
    }
    Ok(groups)
}

/// The integers of an array or a list; or what it is instead.
fn ids_of(value: Value<'_>) -> Result<Vec<i64>, String> {
    if let Some(array) = value.as_array() {
        let long_axes = array.shape().iter().filter(|&&length| length != 1).count();
        if long_axes > 1 {
            return Err(format!("an array of shape {:?}", array.shape()));
        }
        return array.integers().ok_or_else(|| {
            let what = match array.dtype().kind {
                NumberKind::Bool => "bools",
                NumberKind::Float => "floating-point numbers",
                NumberKind::Signed | NumberKind::Unsigned => "integers beyond 63 bits",
            };
            format!("an array of {what}")
        });
    }
    let Some(items) = value.items() else { return Err(value.kind().to_owned()) };
    // A list of NumPy scalars contains arrays without axes.
    let integer = |item: Value<'_>| {
        let single = || item.as_array()?.integers().filter(|ids| ids.len() == 1)?.pop();
        item.as_int().or_else(single).ok_or_else(|| format!("{} in a list", item.kind()))
    };
    items.map(integer).collect()
}

fn from_json(text: &[u8]) -> Result<VertexGroups, VertexGroupsError> {
    let mut reader = serde_json::Deserializer::from_slice(text);
    let groups =
        reader.deserialize_map(JsonGroups).and_then(|groups| reader.end().map(|()| groups));
    groups.map_err(|error| VertexGroupsError::Json { problem: error.to_string() })
}

/// Groups are counted while parsing, so that a file cannot expand beyond the limits.
struct JsonGroups;

impl<'de> Visitor<'de> for JsonGroups {
    type Value = VertexGroups;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of lists of integers")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<VertexGroups, A::Error> {
        let mut groups = VertexGroups::default();
        while let Some((name, ids)) = map.next_entry::<String, Vec<i64>>()? {
            let group = groups.groups.len() + 1;
            let added = if name.len() > LONGEST_NAME {
                Err(VertexGroupsError::Name { group, found: "a longer one" })
            } else if group > MAX_GROUPS {
                Err(VertexGroupsError::TooMany { what: "groups", most: MAX_GROUPS })
            } else {
                groups.add(&name, ids.len(), || Ok(ids))
            };
            added.map_err(de::Error::custom)?;
        }
        Ok(groups)
    }
}

/// Names for a message, printable.
fn known(names: &[String]) -> String {
    listed(names.iter().map(|name| format!("`{}`", name.escape_debug())))
}

#[cfg(test)]
mod tests;
