//! Vertex groups: named parts of a mesh, such as `face` or `left_ear`, as lists of vertices.
//!
//! They come as they are published with body models: FLAME's masks are a pickle of a dict that holds
//! an array for each name, SMPL-X's segmentation is a JSON object that holds a list for each.
//!
//! Pickles are read, never run; see [`crate::pickle`].

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use serde::Deserializer as _;
use serde::de::{self, MapAccess, Visitor};

use crate::input::{ReadError, read_file};
use crate::numpy::NumberKind;
use crate::pickle::{self, PickleError, Value};
use crate::vertex_list::{VertexListError, vertices_of};

/// A larger file is refused by [`read`] before it is loaded; published ones take a megabyte at most.
pub const MAX_FILE_BYTES: u64 = 64 << 20;

/// As many groups as a file may have; body models have some dozens.
pub const MOST_GROUPS: usize = 4096;

/// As many ids as all groups may have together. A pickle holds one list for any number of names, so
/// the bytes of the file are no bound.
pub const MOST_IDS: usize = 1 << 24;

/// Bytes of the longest name.
const LONGEST_NAME: usize = 256;

/// Names in an error that lists them.
const MOST_LISTED: usize = 64;

/// Why vertex groups were refused. Entries count from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum VertexGroupsError {
    /// Another kind of file.
    #[error("must be a pickle or a JSON object of vertex indices by name, got {found}")]
    Foreign {
        /// What it looks like.
        found: &'static str,
    },
    /// A pickle that is not plain data, or damaged.
    #[error(transparent)]
    Pickle(#[from] PickleError),
    /// JSON of something else, or damaged.
    #[error("JSON: {problem}")]
    Json {
        /// What was found and what was wanted, and where.
        problem: String,
    },
    /// A pickle of something else.
    #[error("the pickle must hold a dict of vertex indices by name, got {found}")]
    NoDict {
        /// What was pickled.
        found: &'static str,
    },
    /// A key that is no name.
    #[error("group {group}: name must be a string of at most {LONGEST_NAME} bytes, got {found}")]
    Name {
        /// Which group, from 1.
        group: usize,
        /// What was found.
        found: &'static str,
    },
    /// What a name stands for is no list of integers.
    #[error("group `{name}`: must be a list of integers, got {found}")]
    Ids {
        /// Which group.
        name: String,
        /// What was found.
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
    /// A file without groups.
    #[error("must have at least one vertex group")]
    Empty,
    /// There is no group of that name.
    #[error("no group `{name}`; the file has {}", listed(names))]
    Unknown {
        /// The name that was asked for.
        name: String,
        /// The names that there are, sorted.
        names: Vec<String>,
    },
    /// The vertices of a group are not those of the mesh.
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
    /// The names that there are, sorted.
    pub fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.groups.keys().map(String::as_str)
    }

    /// The vertices of a group of a mesh that has so many: sorted ids, each once, at least one.
    ///
    /// # Errors
    /// [`VertexGroupsError::Unknown`], which lists the names there are, and
    /// [`VertexGroupsError::Vertices`] if the group is empty or an id is no vertex of the mesh.
    pub fn vertices(&self, name: &str, vertices: usize) -> Result<Vec<u32>, VertexGroupsError> {
        let name = || name.to_owned();
        let ids = self.groups.get(&name()).ok_or_else(|| VertexGroupsError::Unknown {
            name: name(),
            names: self.names().map(str::to_owned).collect(),
        })?;
        vertices_of(ids, vertices)
            .map_err(|reason| VertexGroupsError::Vertices { name: name(), reason })
    }

    /// Adds a group that has so many ids; of several with one name the last counts, as in Python.
    fn add(
        &mut self,
        name: &str,
        count: usize,
        ids: impl FnOnce() -> Result<Vec<i64>, String>,
    ) -> Result<(), VertexGroupsError> {
        self.ids = self.ids.saturating_add(count);
        if self.ids > MOST_IDS {
            return Err(VertexGroupsError::TooMany { what: "vertex indices", most: MOST_IDS });
        }
        let name = name.to_owned();
        let ids = ids().map_err(|found| VertexGroupsError::Ids { name: name.clone(), found })?;
        self.groups.insert(name, ids);
        Ok(())
    }
}

/// Reads vertex groups. The bytes tell the format:
/// - JSON, where they begin with a brace: an object of lists of integers, `{"face": [0, 7]}`.
/// - A pickle of any protocol, otherwise: a dict that holds NumPy arrays of integers, of which at
///   most one axis is longer than 1, or lists of integers.
///
/// Whether the ids exist is asked by [`VertexGroups::vertices`].
///
/// # Errors
/// [`VertexGroupsError`]; a pickle that asks for anything but plain data is refused, with the name
/// of what it asked for.
pub fn parse(bytes: &[u8]) -> Result<VertexGroups, VertexGroupsError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let groups = match text {
        // Neither begins a pickle.
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

/// Reads vertex groups from a file, whatever its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is refused by
/// [`parse`]. Each names the file.
pub fn read(path: &Path) -> Result<VertexGroups, ReadError<VertexGroupsError>> {
    read_file(path, MAX_FILE_BYTES, parse)
}

/// Reads one group of a file, of a mesh that has so many `vertices`; see [`VertexGroups::vertices`].
///
/// # Errors
/// As [`read`], and for a group that is not there or is not of the mesh. Each names the file.
pub fn read_group(
    path: &Path,
    name: &str,
    vertices: usize,
) -> Result<Vec<u32>, ReadError<VertexGroupsError>> {
    read_file(path, MAX_FILE_BYTES, |bytes| parse(bytes)?.vertices(name, vertices))
}

fn from_pickle(bytes: &[u8]) -> Result<VertexGroups, VertexGroupsError> {
    let pickle = pickle::parse(bytes)?;
    let root = pickle.root();
    let entries = root.entries().ok_or(VertexGroupsError::NoDict { found: root.kind() })?;
    if entries.len() > MOST_GROUPS {
        return Err(VertexGroupsError::TooMany { what: "groups", most: MOST_GROUPS });
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

/// The integers of an array or a list; or what was found instead.
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
    // A list of NumPy's numbers has arrays without axes in it.
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

/// Groups are counted as they come, so that a file cannot make more of itself.
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
            } else if group > MOST_GROUPS {
                Err(VertexGroupsError::TooMany { what: "groups", most: MOST_GROUPS })
            } else {
                groups.add(&name, ids.len(), || Ok(ids))
            };
            added.map_err(de::Error::custom)?;
        }
        Ok(groups)
    }
}

/// Names for a message: printable, and not more than one can read.
fn listed(names: &[String]) -> String {
    let mut text: Vec<String> =
        names.iter().take(MOST_LISTED).map(|name| format!("`{}`", name.escape_debug())).collect();
    if names.len() > MOST_LISTED {
        text.push(format!("{} more", names.len() - MOST_LISTED));
    }
    text.join(", ")
}

#[cfg(test)]
mod tests;
