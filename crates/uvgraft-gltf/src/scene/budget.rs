//! What a file may ask for: the limits of reading scenes, and a bound on the memory that one takes.
//!
//! A small file can ask for much: arrays without data are zeros, nodes show the same mesh, images of one
//! colour have kilobytes. So what a file asks for is added up ([`Demand`]), from its JSON and the
//! headers of its images, and compared with all of these limits before anything is unpacked.

use std::fmt;

use uvgraft_image::MAX_RATIO;

use super::error::SceneError;

/// Size limit of a file, and of each external file, in bytes; also of what is decompressed.
pub(super) const MAX_BYTES: u64 = 1 << 30;
/// Size limit of all external files together, in bytes: each is read once, and stays in memory.
pub(super) const MAX_EXTERNAL_BYTES: u64 = 2 * MAX_BYTES;
/// Size limit of the JSON, in bytes: files with embedded buffers have hundreds of megabytes.
pub(super) const MAX_JSON_BYTES: u64 = 1 << 29;
/// Limit of objects in the JSON, each of which takes up to two kilobytes with what is made of it.
pub(super) const MAX_OBJECTS: u64 = 1 << 20;
/// Limit of numbers decoded from one file: 1 GiB of floats. Arrays may be referenced many times, so it
/// bounds the time, too.
pub(super) const MAX_NUMBERS: u64 = 1 << 28;
/// Limit of the rest weights of all nodes' morph targets.
pub(super) const MAX_WEIGHTS: u64 = 1 << 24;
/// Limits for all meshes together, each counted once for every node, and every instance, that shows
/// it, and once if none does.
pub(super) const MAX_PRIMITIVES: u64 = 1 << 20;
pub(super) const MAX_VERTICES: u64 = 1 << 24;
pub(super) const MAX_TRIANGLES: u64 = 1 << 25;
/// Limit of the numbers of vertices that morph targets and joints move, one after the other, to pose
/// a scene: those of 300 targets that move all of 1.7 million vertices and their normals.
pub(super) const MAX_MOVES: u64 = 1 << 30;
/// Limit of the instances of all nodes together. With 16 vertices each they reach the limit of
/// vertices, too.
pub(super) const MAX_INSTANCES: u64 = 1 << 20;
/// Limit of the morph targets that expressions move, each counted for every node that shows its mesh: a
/// hundred expressions may move ten thousand each.
pub(super) const MAX_BINDS: u64 = 1 << 20;
/// Limit of texels in all images together, each as often as it is decoded.
pub(super) const MAX_TEXELS: u64 = 1 << 28;
/// Limit of the names of all parts, in bytes: those of meshes and materials are repeated.
pub(super) const MAX_NAME_BYTES: u64 = 1 << 25;

/// What a file may take of memory, however small it is: by our estimates, a person of 100,000 triangles with
/// four textures of 4096² takes 700 MiB when drawn, however well all of it is compressed.
const ANY_FILE: u64 = 1 << 30;

/// A bound on the memory that reading and drawing a scene takes.
///
/// By default a gibibyte, and 200 times the size of the file: no more is believed of a small file,
/// which could ask for hundreds of gigabytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Budget {
    bytes: Option<u64>,
}

impl Budget {
    /// A bound in bytes, whatever the file's size is.
    pub const fn bytes(bytes: u64) -> Self {
        Self { bytes: Some(bytes) }
    }

    /// - `stored`: bytes of the file and its external files.
    fn max(self, stored: u64) -> u64 {
        self.bytes.unwrap_or_else(|| ANY_FILE.saturating_add(MAX_RATIO.saturating_mul(stored)))
    }
}

/// What takes memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Purpose {
    #[default]
    /// The file, its external files and its JSON.
    Structure,
    /// Vertices and triangles, as read and as drawn.
    Geometry,
    /// Images, as decoded and as drawn.
    Images,
    /// Animations, skins and expressions.
    Motion,
}

impl Purpose {
    const ALL: [Self; 4] = [Self::Structure, Self::Geometry, Self::Images, Self::Motion];

    const fn name(self) -> &'static str {
        match self {
            Self::Structure => "the file itself",
            Self::Geometry => "geometry",
            Self::Images => "images",
            Self::Motion => "motion",
        }
    }
}

/// The memory that a file asks for, as an upper bound.
#[derive(Debug, Clone, Default)]
pub(super) struct Demand {
    budget: Budget,
    stored: u64,
    bytes: [u64; 4],
    /// What takes most for a while, and how much.
    passing: (Purpose, u64),
}

impl Demand {
    pub fn new(budget: Budget) -> Self {
        Self { budget, ..Self::default() }
    }

    /// Adds bytes that are stored, of the file or of an external one: they allow for more, too.
    pub fn store(&mut self, bytes: u64) {
        self.stored = self.stored.saturating_add(bytes);
        self.add(Purpose::Structure, bytes, 1);
    }

    /// - `each`: bytes of one.
    pub fn add(&mut self, purpose: Purpose, count: u64, each: u64) {
        let bytes = &mut self.bytes[purpose as usize];
        *bytes = bytes.saturating_add(count.saturating_mul(each));
    }

    /// Adds bytes that are needed for a while, one after the other.
    pub fn pass(&mut self, purpose: Purpose, bytes: u64) {
        if bytes > self.passing.1 {
            self.passing = (purpose, bytes);
        }
    }

    /// # Errors
    /// [`SceneError::Memory`] for more than the budget.
    pub fn check(&self) -> Result<(), SceneError> {
        let mut bytes = self.bytes;
        let passing = &mut bytes[self.passing.0 as usize];
        *passing = passing.saturating_add(self.passing.1);
        let needed = bytes.iter().fold(0, |sum: u64, bytes| sum.saturating_add(*bytes));
        let max = self.budget.max(self.stored);
        if needed <= max {
            return Ok(());
        }
        let is_by_size = self.budget.bytes.is_none();
        let parts = Purpose::ALL.map(|purpose| (purpose.name(), bytes[purpose as usize]));
        let shares = MemoryShares { needed, max, is_by_size, parts };
        Err(SceneError::Memory { shares: Box::new(shares) })
    }
}

/// Memory that a file asks for, by what takes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryShares {
    needed: u64,
    max: u64,
    is_by_size: bool,
    parts: [(&'static str, u64); 4],
}

impl MemoryShares {
    /// An upper bound of what the file needs, in bytes.
    pub const fn needed(&self) -> u64 {
        self.needed
    }

    /// What it may take, in bytes.
    pub const fn max(&self) -> u64 {
        self.max
    }

    /// What needs it, for messages: "60 for geometry, 4 for images".
    pub fn by_purpose(&self) -> String {
        let parts = self.parts.into_iter().filter(|part| part.1 >= 1 << 20);
        let shares = parts.map(|(name, bytes)| format!("{} for {name}", mib(bytes)));
        shares.collect::<Vec<_>>().join(", ")
    }
}

/// Mebibytes, rounded up.
const fn mib(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

impl fmt::Display for MemoryShares {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "must need at most {} MiB of memory", self.max >> 20)?;
        if self.is_by_size {
            write!(f, " (1024 MiB and {MAX_RATIO} times its size)")?;
        }
        write!(f, ", got {} MiB: {}", mib(self.needed), self.by_purpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_files_may_ask_for_less() {
        let refused = |budget, stored, asked| {
            let mut demand = Demand::new(budget);
            demand.store(stored);
            demand.add(Purpose::Geometry, asked, 1 << 20);
            demand.check().err().map(|error| error.to_string())
        };
        let by_size = Budget::default();
        assert_eq!(refused(by_size, 1 << 20, 1223), None);
        let wanted = "must need at most 1224 MiB of memory (1024 MiB and 200 times its size), got 1225 MiB: \
                      1 for the file itself, 1224 for geometry";
        assert_eq!(refused(by_size, 1 << 20, 1224).as_deref(), Some(wanted));
        assert_eq!(refused(Budget::bytes(3 << 30), 0, 3 << 10), None);
        let wanted = "must need at most 50 MiB of memory, got 60 MiB: 60 for geometry";
        assert_eq!(refused(Budget::bytes(50 << 20), 0, 60).as_deref(), Some(wanted));
        assert!(refused(by_size, u64::MAX, u64::MAX).is_none(), "nothing overflows");
        assert!(refused(Budget::bytes(1 << 30), u64::MAX, u64::MAX).is_some());
    }
}
